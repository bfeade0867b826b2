"""The work file: stations, chargers, devices, zones, templates of missions, and timetables.

    stations:
    - {name: press, places: [18], queue: [20, 22], capacity: 1}
    - {name: shelves, places: [39, 42], kind: group}
    chargers:
    - {name: bay, places: [16, 24], capacity: 1}
    devices:
    - {name: gate_north, kind: door, edges: [17, 18], driver: modbus, host: 10.0.0.40, open_coil: 3,
       is_open: 11, timeout: 30}
    - {name: press_1, kind: machine, at: [press], driver: modbus, host: 10.0.0.41, start_coil: 5,
       key_register: 100, done: 12, failed: 13, timeout: 10}
    zones:
    - {name: crossing, edges: [4, 5], vertices: [7], capacity: 1}
    templates:
    - name: pallet
      parameters: [from, to]
      stops:
      - {at: $from, kind: pickup, steps: [{type: engage, timeout: 60, load: takes}]}
      - {at: $to, kind: dropoff, steps: [{type: disengage, timeout: 60, load: gives}]}
      on_cancel:
      - {if: loaded, at: 6, kind: dropoff, steps: [{type: disengage, timeout: 60, load: gives}]}
    timetables:
    - {template: pallet, arguments: {from: press, to: shelves}, every: 30 min, from: "06:00",
       to: "18:00", days: mon-fri}
    loads:
    - {name: pallet, footprint: {radius: 0.7}, speed: 0.6, closed_edges: [12, 13]}
    job_steps:
    - {kind: pickup, steps: [{type: engage, timeout: 60, load: takes}]}
    - {kind: dropoff, at: [press], steps: [{type: disengage, timeout: 60, load: gives}]}

`step_types` lists the types of steps that the actors of the site know. A step of another type is an
error.
"""
from __future__ import annotations

import math
import os
import re
from functools import partial
from typing import (
    Callable,
    Container,
    Dict,
    FrozenSet,
    List,
    Mapping,
    Optional,
    Sequence,
    Set,
    Tuple,
    Union,
)

import yaml

from fleet_core.files.errors import FileError
from fleet_core.files.stops_file import STOP, STOP_ON_CANCEL, step_of, stop_of
from fleet_core.files.strict_fields import (
    Entry,
    ReadEntry,
    known_fields,
    meant,
    named,
    optional_items,
    word,
)
from fleet_core.fleet import Fleet
from fleet_core.work.chargers import Charger
from fleet_core.work.devices import (
    KEY_REGISTERS,
    LAST_ADDRESS,
    LAST_UNIT,
    Device,
    DeviceDriver,
    DeviceKind,
    HandOverAddress,
    ModbusAddress,
    RobotAddress,
    StepDevice,
)
from fleet_core.work.loads import LoadType, fault_of_load
from fleet_core.work.site_work import JobSteps, SiteWork
from fleet_core.work.stations import Station, StationKind, places_of
from fleet_core.work.stops import LONGEST_TIMEOUT, StopKind, WorkStep
from fleet_core.work.templates import (
    PARAMETER,
    Template,
    TemplateStop,
    check_arguments,
    filled,
    parameters_in,
)
from fleet_core.work.timetables import DAY, DAYS, WEEK, Timetable, minute_of_day
from fleet_core.work.zones import Zone
from trajectory_graph import Graph, strict_yaml
from trajectory_graph.strict_yaml import Field, WrongYaml

_FILE = ('step_types', 'stations', 'chargers', 'devices', 'zones', 'templates', 'timetables',
         'job_steps', 'loads')
_STATION = ('name', 'places', 'queue', 'capacity', 'kind')
_CHARGER = ('name', 'places', 'capacity')
_ZONE = ('name', 'edges', 'vertices', 'capacity')
_ADDRESS = {DeviceDriver.MODBUS: ('host', 'port', 'unit', 'open_coil', 'is_open'),
            DeviceDriver.LD90: ('robot', 'output', 'input')}
_HAND_OVER = ('host', 'port', 'unit', 'start_coil', 'key_register', 'done', 'failed')
_MACHINE = ('at', *_HAND_OVER[3:])  # keys of machines only
_DEVICE = ('name', 'kind', 'edges', 'timeout', 'driver', *(
    key for keys in _ADDRESS.values() for key in keys), *_MACHINE)
_LOAD = ('name', 'footprint', 'speed', 'closed_edges')
_TEMPLATE = ('name', 'parameters', 'stops', 'on_cancel')
_TIMETABLE = ('name', 'template', 'arguments', 'every', 'from', 'to', 'days', 'priority',
              'deadline')
_JOB_STEPS = ('kind', 'at', 'steps')
_MINUTES = {'min': 1, 'h': 60}
_NAME = re.compile(r'[A-Za-z]\w*', re.ASCII)
_ROBOTS_NAME = re.compile('[A-Za-z0-9_-]{1,40}')
_LARGEST = 1e4  # m and m/s: a larger number is a mistake
CheckStep = Callable[[WorkStep, yaml.Node], None]
"""Raises WrongYaml for a step that the site does not have."""


def load_work(path: Union[str, os.PathLike], graph: Graph,
              fleet: Optional[Fleet] = None) -> SiteWork:
    """Reads the work file of the site that a graph describes. Raises FileError.

    fleet -- the robots that carry the loads; None: the loads are not checked against the robots
    """
    try:
        root = strict_yaml.compose(path)
        fields = known_fields(root, 'the file', _FILE)
        types = _step_types(fields)
        stations = _stations(fields, graph)
        found = _entries(fields, 'devices', 'device', partial(_device, stations, graph))
        devices = {name: one for name, one in found.items() if isinstance(one, Device)}
        machines = {name: one for name, one in found.items() if isinstance(one, StepDevice)}
        chargers = _chargers(fields, (*stations, *found), graph)
        zones = _entries(fields, 'zones', 'zone',
                         partial(_zone, (*stations, *found, *chargers), graph))
        loads = _entries(fields, 'loads', 'load', partial(_load, graph, fleet))
        check = partial(_check_step, types, devices, machines, loads)
        templates = _entries(fields, 'templates', 'template',
                             partial(_template, stations, check, graph))
        timetables = _entries(fields, 'timetables', 'timetable',
                              partial(_timetable, templates, stations, graph), 'template')
        return SiteWork(stations, devices, machines, templates, timetables, types,
                        _job_steps(stations, check, graph, optional_items(fields, 'job_steps')),
                        chargers, zones, loads)
    except WrongYaml as wrong:
        raise FileError.of(path, wrong) from None


def _entries(fields: Dict[str, yaml.Node], key: str, what: str, read: ReadEntry[Entry],
             name_of: str = 'name') -> Dict[str, Entry]:
    return named((key, fields[key]), what, read, name_of) if key in fields else {}


def _texts(fields: Dict[str, yaml.Node], key: str) -> Tuple[str, ...]:
    return tuple(strict_yaml.text((f'an entry of {key}', node))
                 for node in optional_items(fields, key))


def _step_types(fields: Dict[str, yaml.Node]) -> FrozenSet[str]:
    types = frozenset(_texts(fields, 'step_types'))
    if 'step_types' in fields and not types:
        raise WrongYaml('step_types is empty; leave it out if each type is right',
                        fields['step_types'])
    return types


# -- stations -------------------------------------------------------------------------------------


def _stations(fields: Dict[str, yaml.Node], graph: Graph) -> Dict[str, Station]:
    owners: Dict[int, str] = {}

    def station(name: str, node: yaml.Node, fields: Dict[str, yaml.Node]) -> Station:
        known_fields(node, 'a station', _STATION)
        places = _vertices(strict_yaml.field(fields, 'places', node), graph)
        queue = _vertices(('queue', fields['queue']), graph) if 'queue' in fields else ()
        for place in (*places, *queue):
            if owners.get(place, name) != name or place in places and place in queue:
                raise WrongYaml(f'vertex {place} belongs to station {owners.get(place, name)} '
                                'already', node)
        owners.update((place, name) for place in (*places, *queue))
        _check_station_name(name, places, graph, node)
        kind = word(fields, 'kind', StationKind, StationKind.STATION)
        capacity = _capacity(f'station {name}', fields, places,
                             len(places) if kind is StationKind.GROUP else 1)
        return Station(name, places, queue, capacity, kind)
    return _entries(fields, 'stations', 'station', station)


def _capacity(whose: str, fields: Dict[str, yaml.Node], places: Sequence[int],
              default: int) -> int:
    capacity = strict_yaml.optional(fields, 'capacity', strict_yaml.whole, default)
    if not 0 < capacity <= len(places):
        given = 'one place: leave it out' if len(places) == 1 else (
            f'{len(places)} places: give a number from 1 to {len(places)}')
        raise WrongYaml(f'capacity of {whose} is {capacity}, but it has {given}',
                        fields['capacity'])
    return capacity


def _chargers(fields: Dict[str, yaml.Node], names: Container[str],
              graph: Graph) -> Dict[str, Charger]:
    """Returns the chargers; `names` has the names of the stations and devices."""
    owners: Dict[int, str] = {}

    def charger(name: str, node: yaml.Node, fields: Dict[str, yaml.Node]) -> Charger:
        known_fields(node, 'a charger', _CHARGER)
        if name in names:
            raise WrongYaml(f'a station or device is called {name} already; give the charger '
                            'another name', node)
        places = _vertices(strict_yaml.field(fields, 'places', node), graph)
        for place in places:
            if not graph.vertices[place].dock:
                raise WrongYaml(f'vertex {place} is no dock in the graph: robots cannot charge '
                                'there; set Dock: true at the vertex, or name another',
                                fields['places'])
            if place in owners:
                raise WrongYaml(f'dock {place} belongs to charger {owners[place]} already', node)
            owners[place] = name
        return Charger(name, places, _capacity(f'charger {name}', fields, places, len(places)))
    return _entries(fields, 'chargers', 'charger', charger)


def _check_station_name(name: str, places: Sequence[int], graph: Graph, node: yaml.Node) -> None:
    """Raises WrongYaml for a name that could be mistaken for a vertex, or for an option.

    A command may have the name of a station in place of a vertex (`stations.places_of`).
    """
    if name.isdecimal() or name.startswith('-'):
        raise WrongYaml(f'station {name!r} needs a name that is no number and does not begin with '
                        '-: it stands where the id of a vertex may stand', node)
    for vertex in graph.vertices.values():
        if vertex.label == name and vertex.id not in places:
            raise WrongYaml(f'station {name} has the label of vertex {vertex.id} as its name, but '
                            'that vertex is none of its places: rename one of them', node)


def _vertices(field: Field, graph: Graph) -> Tuple[int, ...]:
    found = _distinct(field, lambda text: places_of(text, {}, graph)[0])
    if not found:
        raise WrongYaml(f'{field[0]} is empty', field[1])
    return found


def _edges(field: Field, graph: Graph) -> Tuple[int, ...]:
    """Returns the edges of a list, each with all its sections if it was cut."""
    def edge(text: str) -> int:
        if not text.isdecimal() or not graph.edges.keys() >= graph.whole_edges((int(text),)):
            shown = text if text.isdecimal() else repr(text)
            raise ValueError(f'the graph has no edge {shown}')
        return int(text)
    return tuple(sorted(graph.whole_edges(_distinct(field, edge))))


def _distinct(field: Field, read: Callable[[str], int]) -> Tuple[int, ...]:
    """Returns the numbers of a list. Raises WrongYaml also for a number that occurs twice."""
    found: List[int] = []
    for node in strict_yaml.items(field):
        try:
            number = read(strict_yaml.text((f'an entry of {field[0]}', node)))
        except ValueError as error:
            raise WrongYaml(str(error), node) from None
        if number in found:
            raise WrongYaml(f'{number} occurs twice in {field[0]}', node)
        found.append(number)
    return tuple(found)


# -- zones ----------------------------------------------------------------------------------------


def _zone(names: Container[str], graph: Graph, name: str, node: yaml.Node,
          fields: Dict[str, yaml.Node]) -> Zone:
    """Returns a zone; `names` has the names of the stations, devices and chargers."""
    known_fields(node, 'a zone', _ZONE)
    if name in names:
        raise WrongYaml(f'a station, device or charger is called {name} already; give the zone '
                        'another name', node)
    edges = _edges(('edges', fields['edges']), graph) if 'edges' in fields else ()
    vertices = _vertices(('vertices', fields['vertices']), graph) if 'vertices' in fields else ()
    if not (edges or vertices):
        raise WrongYaml(f'zone {name} has neither edges nor vertices; give at least one', node)
    capacity = strict_yaml.optional(fields, 'capacity', strict_yaml.whole, 1)
    if capacity < 1:
        raise WrongYaml(f'capacity of zone {name} is {capacity}, but must be 1 or more',
                        fields['capacity'])
    return Zone(name, edges, vertices, capacity)


# -- loads ----------------------------------------------------------------------------------------


def _load(graph: Graph, fleet: Optional[Fleet], name: str, node: yaml.Node,
          fields: Dict[str, yaml.Node]) -> LoadType:
    known_fields(node, 'a load', _LOAD)
    if len(fields) == 1:
        raise WrongYaml(f'load {name} changes nothing: give footprint, speed or closed_edges',
                        node)
    radius: Optional[float] = None
    speed: Optional[float] = None
    if 'footprint' in fields:
        footprint = known_fields(fields['footprint'], 'a footprint', ('radius',))
        radius = _above_zero(strict_yaml.field(footprint, 'radius', fields['footprint']))
    if 'speed' in fields:
        speed = _above_zero(('speed', fields['speed']))
    closed = _edges(('closed_edges', fields['closed_edges']), graph) if (
        'closed_edges' in fields) else ()
    for kind in () if fleet is None else fleet.types:
        if radius is not None and radius < kind.radius:
            raise WrongYaml(f'radius of load {name} is {radius}, but robots of type {kind.name} '
                            f'alone have {kind.radius}: give that of the disc around robot and '
                            'load', fields['footprint'])
    return LoadType(name, radius, speed, frozenset(closed))


def _above_zero(field: Field) -> float:
    value = strict_yaml.real(field)
    if not (math.isfinite(value) and 0.0 < value <= _LARGEST):
        raise WrongYaml(f'{field[0]} is {value}, but must be above 0 and up to {_LARGEST:.0f}',
                        field[1])
    return value


# -- devices --------------------------------------------------------------------------------------


def _device(stations: Mapping[str, Station], graph: Graph, name: str, node: yaml.Node,
            fields: Dict[str, yaml.Node]) -> Union[Device, StepDevice]:
    known_fields(node, 'a device', _DEVICE)
    if name in stations:
        raise WrongYaml(f'a station is called {name} already; give the device another name', node)
    strict_yaml.require(fields, ('kind', 'timeout', 'driver'), node)
    kind = word(fields, 'kind', DeviceKind, DeviceKind.DOOR)
    if kind is DeviceKind.MACHINE:
        return _machine(stations, graph, name, node, fields)
    _refuse_keys(name, kind, _MACHINE, fields)
    edges = _edges(strict_yaml.field(fields, 'edges', node), graph)
    if not edges:
        raise WrongYaml(f'device {name} has no edges', fields['edges'])
    driver = word(fields, 'driver', DeviceDriver, DeviceDriver.SIMULATED)
    return Device(name, kind, edges, _timeout(('timeout', fields['timeout'])), driver,
                  _device_address(name, driver, node, fields))


def _refuse_keys(name: str, kind: DeviceKind, keys: Sequence[str],
                 fields: Dict[str, yaml.Node]) -> None:
    """Raises WrongYaml for a key that no device of this kind has."""
    for key in keys:
        if key in fields:
            raise WrongYaml(f'device {name} has {key}, but its kind is {kind.value}', fields[key])


def _machine(stations: Mapping[str, Station], graph: Graph, name: str, node: yaml.Node,
             fields: Dict[str, yaml.Node]) -> StepDevice:
    """Returns a device that carries out steps. Its name becomes part of the names of topics."""
    if not _NAME.fullmatch(name):
        raise WrongYaml(f'machine {name!r} needs a name of letters, digits and _', node)
    _refuse_keys(name, DeviceKind.MACHINE, [
        key for key in _DEVICE
        if key not in ('name', 'kind', 'timeout', 'driver', 'at', *_HAND_OVER)], fields)
    at = _places('at', stations, graph, optional_items(fields, 'at'))
    timeout = _timeout(('timeout', fields['timeout']))
    driver = word(fields, 'driver', DeviceDriver, DeviceDriver.SIMULATED)
    if driver is DeviceDriver.LD90:
        raise WrongYaml(f'device {name} is a machine: its driver must be simulated or modbus',
                        fields['driver'])
    if driver is DeviceDriver.MODBUS:
        return StepDevice(name, timeout, _hand_over_address(node, fields), at)
    for key in _HAND_OVER:
        if key in fields:
            raise WrongYaml(f'device {name} has {key}, but its driver is simulated', fields[key])
    return StepDevice(name, timeout, at=at)


def _hand_over_address(node: yaml.Node, fields: Dict[str, yaml.Node]) -> HandOverAddress:
    strict_yaml.require(fields, ('host', 'start_coil', 'key_register', 'done', 'failed'), node)
    done, failed = _number(fields, 'done', 0), _number(fields, 'failed', 0)
    if done == failed:
        raise WrongYaml(f'done and failed are both {done}, but must be two inputs',
                        fields['failed'])
    return HandOverAddress(
        _host(fields), _number(fields, 'start_coil', 0),
        _number(fields, 'key_register', 0, LAST_ADDRESS + 1 - KEY_REGISTERS), done, failed,
        *_port_and_unit(fields))


def _device_address(name: str, driver: DeviceDriver, node: yaml.Node,
                    fields: Dict[str, yaml.Node]) -> Union[ModbusAddress, RobotAddress, None]:
    """Returns the address of a device. Raises WrongYaml for a key of another driver."""
    for other, keys in _ADDRESS.items():
        for key in keys:
            if key in fields and other is not driver:
                raise WrongYaml(f'device {name} has {key}, but its driver is '
                                f'{driver.name.lower()}', fields[key])
    if driver is DeviceDriver.MODBUS:
        return _modbus_address(node, fields)
    if driver is DeviceDriver.LD90:
        return _robot_address(node, fields)
    return None


def _modbus_address(node: yaml.Node, fields: Dict[str, yaml.Node]) -> ModbusAddress:
    strict_yaml.require(fields, ('host', 'open_coil', 'is_open'), node)
    return ModbusAddress(_host(fields), _number(fields, 'open_coil', 0),
                         _number(fields, 'is_open', 0), *_port_and_unit(fields))


def _host(fields: Dict[str, yaml.Node]) -> str:
    host = strict_yaml.text(('host', fields['host']))
    if not host.strip() or not host.isprintable():
        raise WrongYaml(f'host is {host!r}, but must be the name or address of a computer',
                        fields['host'])
    return host


def _port_and_unit(fields: Dict[str, yaml.Node]) -> Tuple[int, int]:
    return (_number(fields, 'port', 1) if 'port' in fields else ModbusAddress.port,
            _number(fields, 'unit', 0, LAST_UNIT) if 'unit' in fields else ModbusAddress.unit)


def _robot_address(node: yaml.Node, fields: Dict[str, yaml.Node]) -> RobotAddress:
    """Returns the names of a robot, an output and an input. They become part of a command."""
    strict_yaml.require(fields, ('robot', 'output', 'input'), node)

    def name(key: str) -> str:
        text = strict_yaml.text((key, fields[key]))
        if not _ROBOTS_NAME.fullmatch(text):
            raise WrongYaml(f'{key} is {text!r}, but must have 1 to 40 letters, digits, _ and -',
                            fields[key])
        return text
    return RobotAddress(name('robot'), name('output'), name('input'))


def _number(fields: Dict[str, yaml.Node], key: str, least: int, most: int = LAST_ADDRESS) -> int:
    value = strict_yaml.whole((key, fields[key]))
    if not least <= value <= most:
        raise WrongYaml(f'{key} is {value}, but must be a number from {least} to {most}',
                        fields[key])
    return value


def _timeout(field: Field) -> float:
    value = strict_yaml.real(field)
    if not (math.isfinite(value) and 0.0 < value <= LONGEST_TIMEOUT):
        raise WrongYaml(f'timeout is {value}, but must be above 0 and up to {LONGEST_TIMEOUT:.0f} '
                        's', field[1])
    return value


# -- templates ------------------------------------------------------------------------------------


def _template(stations: Mapping[str, Station], check: CheckStep, graph: Graph, name: str,
              node: yaml.Node, fields: Dict[str, yaml.Node]) -> Template:
    known_fields(node, 'a template', _TEMPLATE)
    if not _NAME.fullmatch(name):
        raise WrongYaml(f'template {name!r} needs a name of letters, digits and _', node)
    parameters = _texts(fields, 'parameters')
    for one in parameters:
        if not _NAME.fullmatch(one) or parameters.count(one) > 1:
            raise WrongYaml(f'parameter {one!r} of template {name} needs a name of its own, of '
                            'letters, digits and _', fields['parameters'])

    def place(text: str) -> str:
        if not text.startswith(PARAMETER):
            places_of(text, stations, graph)
        return text

    def stop(node: yaml.Node, known: Sequence[str]) -> TemplateStop:
        found = TemplateStop(*stop_of(node, known, place))
        for used in parameters_in(found):
            if used not in parameters:
                raise WrongYaml(f'template {name} has no parameter {used!r}; '
                                f'{meant(used, parameters)}', node)
        for step in found.steps:
            check(step, node)
        return found
    template = Template(
        name, parameters,
        tuple(stop(one, STOP)
              for one in strict_yaml.items(strict_yaml.field(fields, 'stops', node))),
        tuple(stop(one, STOP_ON_CANCEL) for one in optional_items(fields, 'on_cancel')))
    if not template.stops:
        raise WrongYaml(f'template {name} has no stops', fields['stops'])
    used = {one for stop in (*template.stops, *template.on_cancel) for one in parameters_in(stop)}
    for one in parameters:
        if one not in used:
            raise WrongYaml(f'parameter {one!r} of template {name} is used nowhere',
                            fields['parameters'])
    return template


def _check_step(types: FrozenSet[str], devices: Container[str],
                machines: Mapping[str, StepDevice], loads: Mapping[str, LoadType],
                step: WorkStep, node: yaml.Node) -> None:
    """Raises WrongYaml for a type, a load or a device that the site does not have."""
    _check_device(step.device, devices, machines, node)
    fault = fault_of_load(step, loads)
    if fault:
        raise WrongYaml(f'step {step.type[:40]} {fault}', node)
    if types and step.type not in types:
        raise WrongYaml(f'there is no step type {step.type!r}; {meant(step.type, sorted(types))}',
                        node)


def _check_device(name: str, devices: Container[str], machines: Mapping[str, StepDevice],
                  node: yaml.Node) -> None:
    """Raises WrongYaml for a device that the site does not have, or that carries out no steps."""
    if not name or name in machines:
        return
    if name in devices:
        raise WrongYaml(f'device {name} carries out no steps: its kind is not machine', node)
    raise WrongYaml(f'there is no device {name!r}; {meant(name, list(machines))}', node)


# -- jobs -----------------------------------------------------------------------------------------


def _job_steps(stations: Mapping[str, Station], check: CheckStep, graph: Graph,
               nodes: Sequence[yaml.Node]) -> Tuple[JobSteps, ...]:
    found: List[JobSteps] = []
    for node in nodes:
        one = _steps_of_kind(stations, check, graph, node)
        others = [place for other in found if other.kind is one.kind
                  for place in other.places or ('',)]
        for place in one.places or ('',):
            if place in others:
                raise WrongYaml(f'{f"vertex {place}" if place else "an entry without at"} occurs '
                                f'twice for {one.kind.name.lower()}', node)
        found.append(one)
    return tuple(found)


def _steps_of_kind(stations: Mapping[str, Station], check: CheckStep, graph: Graph,
                   node: yaml.Node) -> JobSteps:
    fields = known_fields(node, 'an entry of job_steps', _JOB_STEPS)
    strict_yaml.require(fields, ('kind',), node)
    kind = word(fields, 'kind', StopKind, StopKind.VISIT)
    if kind not in (StopKind.PICKUP, StopKind.DROPOFF):
        raise WrongYaml(f'kind is {kind.name.lower()}, but jobs have pickups and drop-offs: say '
                        'pickup or dropoff', fields['kind'])
    steps = tuple(map(step_of, optional_items(fields, 'steps')))
    for step in steps:
        check(step, node)
    places = _places('at', stations, graph, optional_items(fields, 'at'))
    if 'at' in fields and not places:
        raise WrongYaml('at is empty; leave it out for all goals', fields['at'])
    return JobSteps(kind, steps, places)


def _places(key: str, stations: Mapping[str, Station], graph: Graph,
            nodes: Sequence[yaml.Node]) -> Tuple[int, ...]:
    """Returns the vertices of the places in a list of words."""
    places: List[int] = []
    for node in nodes:
        try:
            places += places_of(strict_yaml.text((f'an entry of {key}', node)), stations, graph)
        except ValueError as error:
            raise WrongYaml(str(error), node) from None
    return tuple(places)


# -- timetables -----------------------------------------------------------------------------------


def _timetable(templates: Mapping[str, Template], stations: Mapping[str, Station], graph: Graph,
               name: str, node: yaml.Node, fields: Dict[str, yaml.Node]) -> Timetable:
    known_fields(node, 'a timetable', _TIMETABLE)
    template = strict_yaml.text(strict_yaml.field(fields, 'template', node))
    if template not in templates:
        raise WrongYaml(f'timetable {name}: there is no template {template!r}; '
                        f'{meant(template, templates)}', fields['template'])
    arguments = _arguments(fields)
    try:
        check_arguments(templates[template], [one for one, _ in arguments])
        for stops in (templates[template].stops, templates[template].on_cancel):
            filled(stops, dict(arguments), lambda text: places_of(text, stations, graph)[0])
    except ValueError as error:
        raise WrongYaml(f'timetable {name}: {error}', fields.get('arguments', node)) from None
    begin = strict_yaml.optional(fields, 'from', _time_of_day, 0)
    end = strict_yaml.optional(fields, 'to', _time_of_day, DAY - 1)
    return Timetable(name, template, _period(strict_yaml.field(fields, 'every', node)), arguments,
                     begin, end if end >= begin else end + DAY,
                     strict_yaml.optional(fields, 'days', _days, WEEK),
                     strict_yaml.optional(fields, 'priority', strict_yaml.whole, 0),
                     strict_yaml.optional(fields, 'deadline', _period, 0))


def _arguments(fields: Dict[str, yaml.Node]) -> Tuple[Tuple[str, str], ...]:
    if 'arguments' not in fields:
        return ()
    return tuple((name, strict_yaml.text((name, node)))
                 for name, node in strict_yaml.mapping(fields['arguments'], 'arguments').items())


def _period(field: Field) -> int:
    """Returns the minutes, from `30 min` or `2 h`."""
    text = strict_yaml.text(field)
    found = re.fullmatch(r'(\d{1,4}) ?(min|h)', text, re.ASCII)
    minutes = int(found[1]) * _MINUTES[found[2]] if found else 0
    if not 0 < minutes <= DAY:
        raise WrongYaml(f'{field[0]} is {text!r}, but must be a time from 1 min to 24 h, such as '
                        '30 min', field[1])
    return minutes


def _time_of_day(field: Field) -> int:
    try:
        return minute_of_day(strict_yaml.text(field))
    except ValueError as error:
        raise WrongYaml(f'{field[0]}: {error}', field[1]) from None


def _days(field: Field) -> FrozenSet[int]:
    """Returns the days of the week, from `mon-fri` or `mon, wed, fri`; 0 is Monday."""
    found: Set[int] = set()
    for part in strict_yaml.text(field).split(','):
        ends = [DAYS.index(day) if day in DAYS else None for day in part.strip().split('-')]
        first, last = ends[0], ends[-1]
        if len(ends) > 2 or first is None or last is None:
            raise WrongYaml(f'days has {part.strip()!r}, but must be days such as mon-fri, or '
                            f'mon, wed; the days are: {", ".join(DAYS)}', field[1])
        found.update((first + k) % 7 for k in range((last - first) % 7 + 1))
    return frozenset(found)
