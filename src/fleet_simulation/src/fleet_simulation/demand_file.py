"""Reads the demand file: the missions that a site needs, in YAML.

    groups: {stations: [6, 18, 27]}
    delays: {slower: 1.1, stall: {every: 3600, seconds: 20}, people: {every: 900, seconds: 5}}
    flows:
    - {name: supply, from: 16, to: stations, per_hour: 40, priority: 1, stay: 10, scatter: 0.3}
    - {to: stations, timetable: [{begin: 0, end: 2, per_hour: 20}]}  # hours
    - {to: stations, saturated: 1.0, deadline: 600}
    - {template: pallet, arguments: {from: press, to: stations}, per_hour: 20}
    steps: [{type: handshake, at: press, seconds: 40, scatter: 0.3}]
    devices: {gate_north: 5}
    csv: day.csv

`template`, `steps` and `devices` need a work file. A flow with `template` has missions of this
template. `steps` gives the durations of steps; `devices` gives the seconds that a device takes to
open or to close. `csv` names a file beside the demand file. Its columns are `time` (s from the
beginning) and `destinations` (vertex ids, separated by blanks); `priority` and `stay` (s) are
optional.
"""
from __future__ import annotations

import csv
import difflib
import math
import os
from pathlib import Path
from typing import Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple, Union

import yaml

from fleet_core.files.errors import FileError
from fleet_core.files.strict_fields import meant
from fleet_core.work.site_work import SiteWork
from fleet_core.work.stations import places_of
from fleet_core.work.templates import PARAMETER, TemplateStop, check_arguments
from fleet_simulation.demand import AnyFlow, Demand, Flow, Recorded, Saturated, Shift, WorkFlow
from fleet_simulation.driven_robot import Delays, RandomStops
from fleet_simulation.step_times import WorkTimes
from fleet_simulation.work_times_file import number_to, read_times
from trajectory_graph import Graph, strict_yaml
from trajectory_graph.strict_yaml import Field, WrongYaml

_FILE = ('groups', 'delays', 'flows', 'csv', 'steps', 'devices')
_EVERY_FLOW = ('name', 'per_hour', 'timetable', 'saturated', 'priority', 'deadline')
_FLOW = (*_EVERY_FLOW, 'from', 'to', 'stay', 'scatter')
_WORK_FLOW = (*_EVERY_FLOW, 'template', 'arguments')
_COLUMNS = ('time', 'destinations', 'priority', 'stay')
_LONGEST_DAY = 1e4  # hours
NO_WORK = SiteWork()
Groups = Dict[str, Tuple[int, ...]]
Line = Tuple[str, int]
"""The path of a file, and a line number in it."""


class Wanted(NamedTuple):
    """The content of a demand file, and the lines that an error message names.

    places -- for each vertex: the first file and line that name it
    pairs  -- for each two vertices that a mission visits one after the other: the file and line
    work   -- the content of the work file
    times  -- how long steps and devices take
    """

    demand: Demand
    delays: Delays
    places: Dict[int, Line]
    pairs: Dict[Tuple[int, int], Line]
    work: SiteWork = NO_WORK
    times: WorkTimes = WorkTimes()


def load_demand(path: Union[str, os.PathLike], graph: Graph,
                work: SiteWork = NO_WORK) -> Wanted:
    """Reads a demand file and checks it against the graph and the work file; raises FileError."""
    try:
        root = strict_yaml.compose(path)
        fields = _known(root, 'the file', _FILE)
        groups = _groups(fields, graph)
        places: Dict[int, Line] = {}
        pairs: Dict[Tuple[int, int], Line] = {}

        def note(part: Demand, file: Union[str, os.PathLike], line: int) -> None:
            for place in part.places():
                places.setdefault(place, (os.fspath(file), line))
            for pair in part.pairs():
                pairs.setdefault(pair, (os.fspath(file), line))
        flows: List[AnyFlow] = []
        for number, node in enumerate(strict_yaml.items(('flows', fields['flows']))
                                      if 'flows' in fields else (), 1):
            flows.append(_any_flow(node, number, groups, graph, work))
            note(Demand((flows[-1],)), path, strict_yaml.line_of(node))
        recorded: Tuple[Recorded, ...] = ()
        if 'csv' in fields:
            name = Path(path).parent / strict_yaml.text(('csv', fields['csv']))
            rows = _recorded(name, graph)
            recorded = tuple(rows.values())
            for line, mission in rows.items():
                note(Demand((), (mission,)), name, line)
        if not (flows or recorded or work.timetables):
            raise WrongYaml('the demand has no missions: give flows or csv', root)
        return Wanted(Demand(tuple(flows), recorded), _delays(fields), places, pairs, work,
                      read_times(fields, work, graph))
    except WrongYaml as wrong:
        raise FileError.of(path, wrong) from None


def _known(node: yaml.Node, what: str, known: Sequence[str]) -> Dict[str, yaml.Node]:
    fields = strict_yaml.mapping(node, what, known)
    for key in fields:
        if key not in known:
            line = next(name for name, _ in node.value if name.value == key)
            near = difflib.get_close_matches(key, known, 1)
            meant = f'did you mean {near[0]}?' if near else f'known keys: {", ".join(known)}'
            raise WrongYaml(f'{what} has the unknown key {key!r}; {meant}', line)
    return fields


def _groups(fields: Dict[str, yaml.Node], graph: Graph) -> Groups:
    if 'groups' not in fields:
        return {}
    found: Groups = {}
    for name, node in strict_yaml.mapping(fields['groups'], 'groups').items():
        vertices = tuple(_vertex((f'an entry of group {name}', item), graph)
                         for item in strict_yaml.items((f'group {name}', node)))
        if not vertices:
            raise WrongYaml(f'group {name} is empty: list at least one vertex', node)
        found[name] = vertices
    return found


def _vertex(one: Field, graph: Graph) -> int:
    id = strict_yaml.whole(one)
    if id not in graph.vertices:
        raise WrongYaml(f'{one[0]} is {id}, but the graph has no vertex {id}', one[1])
    return id


def _any_flow(node: yaml.Node, number: int, groups: Groups, graph: Graph,
              work: SiteWork) -> AnyFlow:
    if 'template' in strict_yaml.mapping(node, 'a flow'):
        return _work_flow(node, number, groups, graph, work)
    return _flow(node, number, groups, graph)


def _work_flow(node: yaml.Node, number: int, groups: Groups, graph: Graph,
               work: SiteWork) -> WorkFlow:
    fields = _known(node, 'a flow', _WORK_FLOW)
    name = strict_yaml.text(('template', fields['template']))
    if name not in work.templates:
        raise WrongYaml(f'there is no template {name!r}; {meant(name, work.templates)}'
                        if work.templates else f'template {name!r} needs a work file that has it: '
                        'name the file with --work', fields['template'])
    given = (strict_yaml.mapping(fields['arguments'], 'arguments')
             if 'arguments' in fields else {})
    arguments = tuple((one, _values((one, value), groups)) for one, value in given.items())
    try:
        check_arguments(work.templates[name], [one for one, _ in arguments])
        visits = tuple(_visited(stop, dict(arguments), work, graph)
                       for stop in work.templates[name].stops)
    except ValueError as error:
        raise WrongYaml(str(error), fields.get('arguments', node)) from None
    return WorkFlow(strict_yaml.optional(fields, 'name', strict_yaml.text, f'flow {number}'),
                    name, arguments, visits, _arrivals(fields, node),
                    strict_yaml.optional(fields, 'priority', strict_yaml.whole, 0),
                    _deadline(fields))


def _values(one: Field, groups: Groups) -> Tuple[str, ...]:
    """Returns the possible values of an argument: the vertices of a group, or the word itself."""
    word = strict_yaml.text(one)
    return tuple(map(str, groups[word])) if word in groups else (word,)


def _visited(stop: TemplateStop, arguments: Dict[str, Tuple[str, ...]], work: SiteWork,
             graph: Graph) -> Tuple[int, ...]:
    """Returns the vertices to which a stop may lead. Raises UnknownPlace."""
    parameter = stop.at[len(PARAMETER):] if stop.at.startswith(PARAMETER) else ''
    words = arguments[parameter] if parameter else (stop.at,)
    return tuple(dict.fromkeys(place for word in words
                               for place in places_of(word, work.stations, graph)))


def _deadline(fields: Dict[str, yaml.Node]) -> float:
    return strict_yaml.optional(fields, 'deadline', number_to(1e6), 0.0)


def _flow(node: yaml.Node, number: int, groups: Groups, graph: Graph) -> Flow:
    fields = _known(node, 'a flow', _FLOW)

    def places(key: str) -> Tuple[int, ...]:
        value = strict_yaml.text((key, fields[key]))
        if value in groups:
            return groups[value]
        if not value.lstrip('-').isdigit():
            told = f'groups: {", ".join(groups)}' if groups else 'there are no groups'
            raise WrongYaml(f'{key} is {value!r}, which is neither a vertex nor a group; {told}',
                            fields[key])
        return (_vertex((key, fields[key]), graph),)
    strict_yaml.field(fields, 'to', node)
    sources = places('from') if 'from' in fields else ()
    targets = places('to')
    if sources and any(set(targets) == {source} for source in sources):
        raise WrongYaml(f'a flow leads from vertex {sources[0]} to itself', node)
    scatter = strict_yaml.optional(fields, 'scatter', number_to(1.0), 0.0)
    return Flow(strict_yaml.optional(fields, 'name', strict_yaml.text, f'flow {number}'),
                sources, targets, _arrivals(fields, node),
                strict_yaml.optional(fields, 'priority', strict_yaml.whole, 0),
                strict_yaml.optional(fields, 'stay', number_to(1e6), 0.0), scatter,
                _deadline(fields))


def _arrivals(fields: Dict[str, yaml.Node],
              node: yaml.Node) -> Union[Tuple[Shift, ...], Saturated]:
    given = [key for key in ('per_hour', 'timetable', 'saturated') if key in fields]
    if len(given) != 1:
        raise WrongYaml('a flow needs exactly one of per_hour, timetable and saturated'
                        + (f', but has {" and ".join(given)}' if given else ''), node)
    one = given[0], fields[given[0]]
    if given == ['per_hour']:
        return (Shift(0.0, _LONGEST_DAY, number_to(1e5)(one)),)
    if given == ['saturated']:
        return Saturated(number_to(100.0)(one))
    shifts = []
    for item in strict_yaml.items(one):
        shift = _known(item, 'a shift', ('begin', 'end', 'per_hour'))
        begin, end = (number_to(_LONGEST_DAY)(strict_yaml.field(shift, key, item))
                      for key in ('begin', 'end'))
        if end <= begin:
            raise WrongYaml(f'a shift ends at {end:g} h, which is not after its begin at '
                            f'{begin:g} h', item)
        shifts.append(Shift(begin, end,
                            number_to(1e5)(strict_yaml.field(shift, 'per_hour', item))))
    return tuple(shifts)


def _delays(fields: Dict[str, yaml.Node]) -> Delays:
    if 'delays' not in fields:
        return Delays()
    known = _known(fields['delays'], 'delays', ('slower', 'stall', 'people'))
    usual = Delays()

    def standstill(one: Field) -> RandomStops:
        entry = _known(one[1], one[0], ('every', 'seconds'))
        return RandomStops(*(number_to(1e6)(strict_yaml.field(entry, key, one[1]))
                             for key in ('every', 'seconds')))
    slower = strict_yaml.optional(known, 'slower', number_to(100.0), usual.slower)
    if slower < 1.0:
        raise WrongYaml(f'slower is {slower:g}, but must be 1 or more', known['slower'])
    return Delays(slower, strict_yaml.optional(known, 'stall', standstill, usual.stall),
                  strict_yaml.optional(known, 'people', standstill, usual.people))


def _recorded(path: Path, graph: Graph) -> Dict[int, Recorded]:
    """Returns the missions of a CSV file by line number; raises FileError."""
    try:
        text = strict_yaml.read_file(path).decode()
    except WrongYaml as wrong:
        raise FileError.of(path, wrong) from None
    except UnicodeDecodeError:
        raise FileError(path, 'this is not UTF-8 text: save it as UTF-8') from None
    rows = csv.DictReader(text.splitlines())
    unknown = [name for name in rows.fieldnames or () if name not in _COLUMNS]
    missing = [name for name in _COLUMNS[:2] if name not in (rows.fieldnames or ())]
    if unknown or missing:
        raise FileError(path, f'the columns are {", ".join(rows.fieldnames or ())}, but must be '
                              f'{", ".join(_COLUMNS)}, the last two of them optional', 1)
    found: Dict[int, Recorded] = {}
    for row in rows:
        found[rows.line_num] = _recorded_mission(row, path, rows.line_num, graph)
    return found


def _recorded_mission(row: Mapping[str, Optional[str]], path: Path, line: int,
                      graph: Graph) -> Recorded:
    places = (row['destinations'] or '').split()
    for place in places:
        if not place.isdigit() or int(place) not in graph.vertices:
            raise FileError(path, f'the graph has no vertex {place}', line)
    if not places:
        raise FileError(path, 'the mission has no destinations: give vertex ids', line)

    def number(name: str) -> float:
        value = row.get(name) or '0'
        try:
            parsed = float(value)
        except ValueError:
            parsed = math.nan
        if not 0.0 <= parsed < 1e8:
            raise FileError(path, f'{name} is {value!r}, but must be a number from 0 to 1e8', line)
        return parsed
    return Recorded(number('time'), tuple(map(int, places)), int(number('priority')),
                    number('stay'))
