"""Reads the parts `steps` and `devices` of a demand file: how long steps and devices take.

If a step takes longer than its timeout, a person must decide, but in the simulation no person
answers. So a duration above the timeout is an error.
"""
from __future__ import annotations

import math
from typing import Callable, Dict, Iterator, Tuple

import yaml

from fleet_core.files.strict_fields import known_fields, meant, optional_items
from fleet_core.work.site_work import SiteWork
from fleet_core.work.stations import places_of
from fleet_core.work.stops import WorkStep
from fleet_simulation.step_times import Duration, WorkTimes
from trajectory_graph import Graph, strict_yaml
from trajectory_graph.strict_yaml import Field, WrongYaml

_NEEDED = {'steps': 'templates', 'devices': 'devices'}
_STEP = ('type', 'at', 'seconds', 'scatter')
Steps = Dict[Tuple[str, str], Duration]


def number_to(most: float) -> Callable[[Field], float]:
    """Returns a reader of numbers from 0 to `most`. The reader raises WrongYaml for any other
    value.
    """
    def read(one: Field) -> float:
        value = strict_yaml.real(one)
        if not (math.isfinite(value) and 0.0 <= value <= most):
            raise WrongYaml(f'{one[0]} is {value:g}, but must be a number from 0 to {most:g}',
                            one[1])
        return value
    return read


def read_times(fields: Dict[str, yaml.Node], work: SiteWork, graph: Graph) -> WorkTimes:
    """Returns the durations that a demand file gives. Raises WrongYaml."""
    for key, known in (('steps', work.templates), ('devices', work.devices)):
        if key in fields and not known:
            raise WrongYaml(f'{key} need a work file with {_NEEDED[key]}: name it with --work',
                            fields[key])
    found: Steps = {}
    for node in optional_items(fields, 'steps'):
        step, duration = _step(node, work, graph)
        if step in found:
            raise WrongYaml(f'steps of type {step[0]} have two durations at the same place', node)
        found[step] = duration
    return WorkTimes(found, _devices(fields, work))


def _steps_of(work: SiteWork) -> Iterator[Tuple[str, WorkStep]]:
    """Yields all steps of the templates, each with the name of its template."""
    for template in work.templates.values():
        for stop in template.stops:
            yield from ((template.name, step) for step in stop.steps)


def _step(node: yaml.Node, work: SiteWork,
          graph: Graph) -> Tuple[Tuple[str, str], Duration]:
    fields = known_fields(node, 'an entry of steps', _STEP)
    type = strict_yaml.text(strict_yaml.field(fields, 'type', node))
    known = {step.type for _, step in _steps_of(work)}
    if type not in known:
        raise WrongYaml(f'no template has a step of type {type!r}; {meant(type, sorted(known))}',
                        fields['type'])
    duration = Duration(number_to(1e6)(strict_yaml.field(fields, 'seconds', node)),
                        strict_yaml.optional(fields, 'scatter', number_to(1.0), 0.0))
    for name, step in _steps_of(work):
        if step.type == type and duration.longest >= step.timeout:
            raise WrongYaml(
                f'a step of type {type} takes up to {duration.longest:g} s, but template {name} '
                f'gives it {step.timeout:g} s: let it take less, or give it a longer timeout there',
                node)
    at = strict_yaml.optional(fields, 'at', strict_yaml.text, '')
    try:
        if at not in work.stations and at:
            at = str(places_of(at, work.stations, graph)[0])
    except ValueError as error:
        raise WrongYaml(str(error), fields['at']) from None
    return (type, at), duration


def _devices(fields: Dict[str, yaml.Node], work: SiteWork) -> Dict[str, float]:
    found: Dict[str, float] = {}
    if 'devices' not in fields:
        return found
    for name, node in strict_yaml.mapping(fields['devices'], 'devices').items():
        if name not in work.devices:
            raise WrongYaml(f'there is no device {name!r}; {meant(name, work.devices)}', node)
        found[name] = number_to(work.devices[name].timeout)((f'the time of device {name}', node))
        if not found[name]:
            raise WrongYaml(f'the time of device {name} is 0 s, but must be above 0', node)
    return found
