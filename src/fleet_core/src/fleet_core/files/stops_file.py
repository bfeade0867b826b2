"""The file of a mission with steps, as `mission --stops` reads it.

    stops:
    - at: 18
      kind: pickup
      steps:
      - {type: engage, timeout: 60, load: takes}
    - group: shelves               # in place of `at`: a group of the work file
      kind: dropoff
      steps:
      - {type: handshake, actor: outside, timeout: 120}
      - {type: disengage, timeout: 60, load: gives}
    on_cancel:
    - {if: loaded, at: shelf_3, kind: dropoff, steps: [{type: disengage, timeout: 60, load: gives}]}
"""
from __future__ import annotations

import os
from typing import Callable, Dict, NamedTuple, Sequence, Tuple, TypeVar, Union

import yaml

from fleet_core.files.errors import FileError
from fleet_core.files.strict_fields import known_fields, optional_items, word
from fleet_core.work.stops import (
    Actor,
    Condition,
    LoadEffect,
    Policy,
    StepBlocking,
    StopKind,
    When,
    WorkStep,
    WorkStop,
    problem_of,
)
from trajectory_graph import strict_yaml
from trajectory_graph.strict_yaml import Field, WrongYaml

Place = TypeVar('Place')
VertexOf = Callable[[str], int]
"""Returns the id of the vertex with this label or id. Raises ValueError with a clause."""

_FILE = ('stops', 'on_cancel')
_GROUP = 'group'
STOP = ('at', 'kind', 'steps')
STOP_ON_CANCEL = ('if', *STOP)
_STEP = ('type', 'parameters', 'when', 'actor', 'blocking', 'timeout', 'on_failure', 'retries',
         'harmless', 'breakable', 'load', 'load_type', 'device')


class StopsFile(NamedTuple):
    """The stops of a mission, and the stops that may follow its cancellation."""

    stops: Tuple[WorkStop, ...]
    on_cancel: Tuple[WorkStop, ...] = ()


def load_stops(path: Union[str, os.PathLike], vertex: VertexOf) -> StopsFile:
    """Returns the stops in a file. Raises FileError."""
    try:
        root = strict_yaml.compose(path)
        fields = known_fields(root, 'the file', _FILE)
        found = StopsFile(
            tuple(_stop(node, STOP, vertex)
                  for node in strict_yaml.items(strict_yaml.field(fields, 'stops', root))),
            tuple(_stop(node, STOP_ON_CANCEL, vertex)
                  for node in optional_items(fields, 'on_cancel')))
        if not found.stops:
            raise WrongYaml('stops is empty; describe at least one', fields['stops'])
        return found
    except WrongYaml as wrong:
        raise FileError.of(path, wrong) from None


def _stop(node: yaml.Node, known: Sequence[str], vertex: VertexOf) -> WorkStop:
    """Returns the stop that a mapping describes, at a vertex or at any place of a group."""
    fields = known_fields(node, 'a stop', (*known, _GROUP))
    if _GROUP not in fields:
        return WorkStop(*stop_of(node, known, vertex))
    group = strict_yaml.text((_GROUP, fields[_GROUP]))
    if 'at' in fields or not group:
        raise WrongYaml('a stop needs either at or group, not both, and no empty one',
                        fields[_GROUP])
    return WorkStop(0, *_rest_of(fields), group)


def stop_of(node: yaml.Node, known: Sequence[str], place: Callable[[str], Place],
            ) -> Tuple[Place, StopKind, Tuple[WorkStep, ...], Condition]:
    """Returns the place, kind, steps and condition that a mapping with `known` keys describes.

    place -- returns the place that a word names; raises ValueError with a clause

    Raises WrongYaml.
    """
    fields = known_fields(node, 'a stop', known)
    at = strict_yaml.field(fields, 'at', node)
    try:
        where = place(strict_yaml.text(at))
    except ValueError as error:
        raise WrongYaml(str(error), at[1]) from None
    return (where, *_rest_of(fields))


def _rest_of(fields: Dict[str, yaml.Node]) -> Tuple[StopKind, Tuple[WorkStep, ...], Condition]:
    """Returns the kind, steps and condition of a stop."""
    return (word(fields, 'kind', StopKind, StopKind.VISIT),
            tuple(map(step_of, optional_items(fields, 'steps'))),
            word(fields, 'if', Condition, Condition.ALWAYS))


def step_of(node: yaml.Node) -> WorkStep:
    """Returns the step that a mapping describes. Raises WrongYaml."""
    fields = known_fields(node, 'a step', _STEP)
    step = WorkStep(
        strict_yaml.text(strict_yaml.field(fields, 'type', node)),
        strict_yaml.real(strict_yaml.field(fields, 'timeout', node)),
        strict_yaml.optional(fields, 'parameters', _parameters, ()),
        word(fields, 'when', When, When.AT),
        word(fields, 'actor', Actor, Actor.ROBOT),
        word(fields, 'blocking', StepBlocking, StepBlocking.HARD),
        word(fields, 'on_failure', Policy, Policy.ASK),
        strict_yaml.optional(fields, 'retries', strict_yaml.whole, 0),
        strict_yaml.optional(fields, 'harmless', strict_yaml.truth, False),
        strict_yaml.optional(fields, 'breakable', strict_yaml.truth, False),
        word(fields, 'load', LoadEffect, LoadEffect.NONE),
        strict_yaml.optional(fields, 'device', strict_yaml.text, ''),
        strict_yaml.optional(fields, 'load_type', strict_yaml.text, ''))
    problem = problem_of(step)
    if problem:
        raise WrongYaml(f'step {step.type[:40]} {problem}', node)
    return step


def _parameters(field: Field) -> Tuple[Tuple[str, str], ...]:
    fields = strict_yaml.mapping(field[1], 'parameters')
    return tuple((name, strict_yaml.text((name, node))) for name, node in fields.items())
