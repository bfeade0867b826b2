"""The file of a mission with steps, as `mission --stops` reads it.

    stops:
    - at: 18
      kind: pickup
      steps:
      - {type: engage, timeout: 60, load: takes}
    - at: shelf_3                  # a label that only one vertex has
      kind: dropoff
      steps:
      - {type: handshake, actor: outside, timeout: 120}
      - {type: disengage, timeout: 60, load: gives}
    on_cancel:
    - {if: loaded, at: 39, kind: dropoff, steps: [{type: disengage, timeout: 60, load: gives}]}
"""
from __future__ import annotations

import difflib
import os
from enum import IntEnum
from typing import Callable, Dict, NamedTuple, Sequence, Tuple, Type, TypeVar, Union

import yaml

from fleet_core.files.errors import FileError
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

Word = TypeVar('Word', bound=IntEnum)
VertexOf = Callable[[str], int]
"""Returns the id of the vertex with this label or id. Raises ValueError with a clause."""

_FILE = ('stops', 'on_cancel')
_STOP = ('at', 'kind', 'steps')
_STEP = ('type', 'parameters', 'when', 'actor', 'blocking', 'timeout', 'on_failure', 'retries',
         'harmless', 'breakable', 'load')


class StopsFile(NamedTuple):
    """The stops of a mission, and those that may follow a cancellation."""

    stops: Tuple[WorkStop, ...]
    on_cancel: Tuple[WorkStop, ...] = ()


def load_stops(path: Union[str, os.PathLike], vertex: VertexOf) -> StopsFile:
    """The stops in a file. Raises FileError."""
    try:
        root = strict_yaml.compose(path)
        fields = _fields(root, 'the file', _FILE)
        found = StopsFile(
            tuple(_stop(node, vertex, _STOP)
                  for node in strict_yaml.items(strict_yaml.field(fields, 'stops', root))),
            tuple(_stop(node, vertex, ('if', *_STOP))
                  for node in _optional_items(fields, 'on_cancel')))
        if not found.stops:
            raise WrongYaml('stops is empty; describe at least one', fields['stops'])
        return found
    except WrongYaml as wrong:
        raise FileError.of(path, wrong) from None


def _optional_items(fields: Dict[str, yaml.Node], name: str) -> Sequence[yaml.Node]:
    return strict_yaml.items((name, fields[name])) if name in fields else ()


def _fields(node: yaml.Node, what: str, known: Sequence[str]) -> Dict[str, yaml.Node]:
    fields = strict_yaml.mapping(node, what)
    for key in fields:
        if key not in known:
            near = difflib.get_close_matches(key, known, 1)
            meant = f'did you mean {near[0]}?' if near else f'there are: {", ".join(known)}'
            raise WrongYaml(f'{what} has an unknown key {key!r}; {meant}', fields[key])
    return fields


def _stop(node: yaml.Node, vertex: VertexOf, known: Sequence[str]) -> WorkStop:
    fields = _fields(node, 'a stop', known)
    at = strict_yaml.field(fields, 'at', node)
    try:
        place = vertex(strict_yaml.text(at))
    except ValueError as error:
        raise WrongYaml(str(error), at[1]) from None
    return WorkStop(place, _word(fields, 'kind', StopKind, StopKind.VISIT),
                    tuple(map(_step, _optional_items(fields, 'steps'))),
                    _word(fields, 'if', Condition, Condition.ALWAYS))


def _step(node: yaml.Node) -> WorkStep:
    fields = _fields(node, 'a step', _STEP)
    step = WorkStep(
        strict_yaml.text(strict_yaml.field(fields, 'type', node)),
        strict_yaml.real(strict_yaml.field(fields, 'timeout', node)),
        strict_yaml.optional(fields, 'parameters', _parameters, ()),
        _word(fields, 'when', When, When.AT),
        _word(fields, 'actor', Actor, Actor.ROBOT),
        _word(fields, 'blocking', StepBlocking, StepBlocking.HARD),
        _word(fields, 'on_failure', Policy, Policy.ASK),
        strict_yaml.optional(fields, 'retries', strict_yaml.whole, 0),
        strict_yaml.optional(fields, 'harmless', strict_yaml.truth, False),
        strict_yaml.optional(fields, 'breakable', strict_yaml.truth, False),
        _word(fields, 'load', LoadEffect, LoadEffect.NONE))
    problem = problem_of(step)
    if problem:
        raise WrongYaml(f'step {step.type[:40]} {problem}', node)
    return step


def _parameters(field: Field) -> Tuple[Tuple[str, str], ...]:
    fields = strict_yaml.mapping(field[1], 'parameters')
    return tuple((name, strict_yaml.text((name, node))) for name, node in fields.items())


def _word(fields: Dict[str, yaml.Node], name: str, kind: Type[Word], default: Word) -> Word:
    if name not in fields:
        return default
    text = strict_yaml.text((name, fields[name]))
    words = {word.name.lower(): word for word in kind}
    if text not in words:
        near = difflib.get_close_matches(text, words, 1)
        meant = f'did you mean {near[0]}?' if near else f'there are: {", ".join(words)}'
        raise WrongYaml(f'{name} is {text!r}; {meant}', fields[name])
    return words[text]
