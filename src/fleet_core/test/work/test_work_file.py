"""The work file is read strictly: for each mistake the refusal is one sentence with the line."""
from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest
from fleet_builders import corridor, with_docks

from fleet_core.files.errors import FileError
from fleet_core.files.work_file import load_work
from fleet_core.fleet import Fleet, RobotType
from fleet_core.work.chargers import Charger
from fleet_core.work.devices import (
    Device,
    DeviceDriver,
    DeviceKind,
    HandOverAddress,
    ModbusAddress,
    RobotAddress,
    StepDevice,
)
from fleet_core.work.loads import LoadType
from fleet_core.work.site_work import SiteWork
from fleet_core.work.stations import Station, StationKind
from fleet_core.work.stops import (
    Actor,
    Condition,
    LoadEffect,
    StopKind,
    WorkStep,
    WorkStop,
)
from fleet_core.work.templates import filled
from fleet_core.work.timetables import Timetable
from fleet_core.work.zones import Zone
from trajectory_graph import Graph, split_edges

FILE = '''step_types: [engage, disengage]
stations:
- {name: press, places: [3], queue: [2, 1]}
- {name: shelves, places: [5, 6], kind: group}
- {name: table, places: [7, 8]}
devices:
- {name: gate, kind: door, edges: [2, 3], driver: modbus, host: 10.0.0.40, \
open_coil: 3, is_open: 11, timeout: 30}
- {name: lamp, kind: light, edges: [4], driver: simulated, timeout: 5}
templates:
- name: pallet
  parameters: [from, to, cart]
  stops:
  - {at: $from, kind: pickup, steps: [{type: engage, timeout: 60, load: takes, \
parameters: {cart: $cart}}]}
  - {at: $to, kind: dropoff, steps: [{type: disengage, timeout: 60, load: gives}]}
  on_cancel:
  - {if: loaded, at: 4, kind: dropoff, steps: [{type: disengage, timeout: 60, load: gives}]}
timetables:
- {template: pallet, arguments: {from: press, to: shelves, cart: a}, every: 30 min, \
from: "06:00", to: 18:00, days: mon-fri}
- {name: night, template: pallet, arguments: {from: 7, to: 8, cart: b}, every: 2 h, \
from: "22:00", to: "04:00", days: 'fri-mon, wed', priority: 2}
job_steps:
- {kind: pickup, steps: [{type: engage, timeout: 60}]}
- {kind: pickup, at: [press, 7]}
- {kind: dropoff, at: [shelves], steps: [{type: disengage, timeout: 60}]}
'''


PRESS = '{name: press_1, kind: machine, driver: modbus, host: 10.0.0.41, start_coil: 5, ' \
    'key_register: 100, done: 12, failed: 13, timeout: 10}'
HANDED = f'''devices:
- {PRESS}
- {{name: oven, kind: machine, driver: simulated, timeout: 5}}
- {{name: lamp, kind: light, edges: [4], driver: simulated, timeout: 5}}
templates:
- name: hand
  stops: [{{at: 3, steps: [{{type: handshake, actor: device, device: press_1, timeout: 60}}]}}]
'''
SHUTTER = '{name: shutter, kind: door, edges: [5], driver: ld90, robot: a, output: Out_1, ' \
    'input: In-2, timeout: 5}'


def read(tmp_path: Path, text: str) -> SiteWork:
    path = tmp_path / 'work.yaml'
    path.write_text(text)
    return load_work(path, corridor(9))


def test_a_file_gives_all_values(tmp_path):
    found = read(tmp_path, FILE)
    assert found.stations == {
        'press': Station('press', (3,), (2, 1), 1),
        'shelves': Station('shelves', (5, 6), (), 2, StationKind.GROUP),
        'table': Station('table', (7, 8), (), 1)}
    assert found.devices == {
        'gate': Device('gate', DeviceKind.DOOR, (2, 3), 30.0, DeviceDriver.MODBUS,
                       ModbusAddress('10.0.0.40', 3, 11)),
        'lamp': Device('lamp', DeviceKind.LIGHT, (4,), 5.0)}
    arguments = (('from', 'press'), ('to', 'shelves'), ('cart', 'a'))
    assert found.timetables == {
        'pallet': Timetable('pallet', 'pallet', 30, arguments, 360, 1080, frozenset(range(5))),
        'night': Timetable('night', 'pallet', 120, (('from', '7'), ('to', '8'), ('cart', 'b')),
                           22 * 60, 28 * 60, frozenset({0, 2, 4, 5, 6}), 2)}
    assert found.templates['pallet'].parameters == ('from', 'to', 'cart')


def test_a_template_is_filled_with_arguments(tmp_path):
    template = read(tmp_path, FILE).templates['pallet']
    arguments = {'from': 'press', 'to': '7', 'cart': 'a'}
    places = {'press': 3, '7': 7, '4': 4}
    assert filled(template.stops, arguments, places.__getitem__) == (
        WorkStop(3, StopKind.PICKUP, (
            WorkStep('engage', 60.0, (('cart', 'a'),), load=LoadEffect.TAKES),)),
        WorkStop(7, StopKind.DROPOFF, (WorkStep('disengage', 60.0, load=LoadEffect.GIVES),)))
    on_cancel, = filled(template.on_cancel, arguments, places.__getitem__)
    assert (on_cancel.place, on_cancel.condition) == (4, Condition.LOADED)


@pytest.mark.parametrize('place, kind, types', [
    (4, StopKind.PICKUP, ['engage']), (3, StopKind.PICKUP, []), (7, StopKind.PICKUP, []),
    (6, StopKind.DROPOFF, ['disengage']), (4, StopKind.DROPOFF, [])])
def test_a_goal_of_a_job_has_the_steps_of_its_own_entry_or_those_of_its_kind(
        tmp_path, place, kind, types):
    steps = read(tmp_path, FILE).steps_of_job(place, kind)
    assert [step.type for step in steps] == types


def test_a_device_has_the_address_that_its_driver_needs(tmp_path):
    other = FILE.replace('is_open: 11', 'is_open: 11, port: 1502, unit: 4')
    assert read(tmp_path, other).devices['gate'].address == ModbusAddress(
        '10.0.0.40', 3, 11, 1502, 4)
    assert read(tmp_path, f'devices: [{SHUTTER}]').devices['shutter'] == Device(
        'shutter', DeviceKind.DOOR, (5,), 5.0, DeviceDriver.LD90,
        RobotAddress('a', 'Out_1', 'In-2'))


def test_a_machine_is_no_device_on_the_way(tmp_path):
    found = read(tmp_path, HANDED)
    assert found.step_devices == {
        'press_1': StepDevice('press_1', 10.0, HandOverAddress('10.0.0.41', 5, 100, 12, 13)),
        'oven': StepDevice('oven', 5.0)}
    assert list(found.devices) == ['lamp']
    step, = found.templates['hand'].stops[0].steps
    assert (step.actor, step.device) == (Actor.DEVICE, 'press_1')


@pytest.mark.parametrize('right, wrong, line, told', [
    ('device: press_1', 'device: pres_1', 7, "no device 'pres_1'; did you mean press_1?"),
    ('device: press_1', 'device: lamp', 7, 'lamp carries out no steps: its kind is not machine'),
    ('device: press_1, ', '', 7, 'needs the name of a device'),
    ('type: handshake', 'type: engage', 7, 'its type must be handshake'),
    ('start_coil: 5, ', '', 2, 'start_coil is missing'),
    ('key_register: 100, ', '', 2, 'key_register is missing'),
    ('failed: 13', 'failed: 12', 2, 'done and failed are both 12'),
    ('key_register: 100', 'key_register: 65533', 2, 'a number from 0 to 65532'),
    ('driver: modbus', 'driver: ld90', 2, 'its driver must be simulated or modbus'),
    ('driver: modbus', 'driver: simulated', 2, 'has host, but its driver is simulated'),
    ('start_coil: 5', 'start_coil: 5, edges: [1]', 2, 'has edges, but its kind is machine'),
    ('start_coil: 5', 'start_coil: 5, open_coil: 1', 2, 'has open_coil, but its kind is machine'),
    ('edges: [4]', 'edges: [4], done: 3', 4, 'has done, but its kind is light'),
    ('name: oven', 'name: press_1', 3, 'press_1 occurs twice'),
    ('name: oven', 'name: o ven', 3, 'needs a name of letters, digits and _')])
def test_a_wrong_machine_is_refused_with_its_line(tmp_path, right, wrong, line, told):
    assert right in HANDED
    with pytest.raises(FileError, match=f'line {line}: .*{told}'):
        read(tmp_path, HANDED.replace(right, wrong, 1))


def test_a_machine_stands_at_the_places_that_its_file_names(tmp_path):
    oven = '{name: oven, kind: machine, at: [press, 9], driver: simulated, timeout: 5}'
    found = read(tmp_path, f'stations: [{{name: press, places: [3]}}]\ndevices: [{oven}]')
    assert found.step_devices['oven'] == StepDevice('oven', 5.0, at=(3, 9))
    with pytest.raises(FileError, match="line 1: no station and no vertex is named 'pres'"):
        read(tmp_path, 'devices: [' + oven.replace('press', 'pres') + ']')
    with pytest.raises(FileError, match='line 1: device lamp has at, but its kind is light'):
        read(tmp_path, 'devices: [{name: lamp, kind: light, at: [3], edges: [4], '
                       'driver: simulated, timeout: 5}]')


def labelled(id: int, label: str) -> Graph:
    graph = corridor(9)
    return Graph((replace(one, label=label) if one.id == id else one
                  for one in graph.vertices.values()), graph.edges.values())


@pytest.mark.parametrize('name, told', [
    ("'18'", "station '18' needs a name that is no number"),
    ('-press', "station '-press' needs a name that is no number and does not begin with -"),
    ('ramp', 'station ramp has the label of vertex 7 as its name, but that vertex is none of its')])
def test_a_station_cannot_be_mistaken_for_a_vertex(tmp_path, name, told):
    path = tmp_path / 'work.yaml'
    path.write_text(f'stations: [{{name: {name}, places: [3]}}]')
    with pytest.raises(FileError, match=f'line 1: {re.escape(told)}'):
        load_work(path, labelled(7, 'ramp'))


def test_a_station_may_be_called_as_its_own_place_is_labelled(tmp_path):
    path = tmp_path / 'work.yaml'
    path.write_text('stations: [{name: press, places: [3]}]')
    assert load_work(path, labelled(3, 'press')).stations['press'].places == (3,)


def test_a_device_is_on_all_sections_of_an_edge_that_was_cut(tmp_path):
    (tmp_path / 'work.yaml').write_text(FILE)
    graph = split_edges(corridor(9), 1.0)
    gate = load_work(tmp_path / 'work.yaml', graph).devices['gate']
    assert set(gate.edges) == {*graph.sections[2], *graph.sections[3]} and len(gate.edges) > 2


# -- loads -----------------------------------------------------------------------------------------

LOADS = '''loads:
- {name: pallet, footprint: {radius: 0.7}, speed: 0.6, closed_edges: [2, 3]}
- {name: box, speed: 0.9}
templates:
- name: bring
  stops:
  - {at: 3, steps: [{type: engage, timeout: 60, load: takes, load_type: pallet}]}
  - {at: 5, steps: [{type: disengage, timeout: 60, load: gives}]}
job_steps:
- {kind: pickup, steps: [{type: lift, timeout: 60, load: takes, load_type: box}]}
'''
CARRIERS = Fleet((RobotType('cart', 0.4, 1.0), RobotType('truck', 0.6, 1.0)), ())


def read_loads(tmp_path, text):
    (tmp_path / 'work.yaml').write_text(text)
    return load_work(tmp_path / 'work.yaml', corridor(9), CARRIERS)


def test_a_load_has_a_footprint_a_speed_and_closed_edges(tmp_path):
    work = read_loads(tmp_path, LOADS)
    assert work.loads == {'pallet': LoadType('pallet', 0.7, 0.6, frozenset({2, 3})),
                          'box': LoadType('box', None, 0.9)}
    assert [step.load_type for step in work.templates['bring'].stops[0].steps] == ['pallet']


@pytest.mark.parametrize('right, wrong, line, told', [
    ('load_type: pallet', 'load_type: palet', 7,
     "step engage takes 'palet', but the loads of the work file are: pallet, box"),
    (', load_type: pallet', '', 7, 'step engage takes a load, so it needs a load_type'),
    (', load_type: box', '', 10, 'step lift takes a load, so it needs a load_type'),
    ('load: gives', 'load: gives, load_type: pallet', 8, 'has a load_type, but does not take'),
    ('[2, 3]', '[2, 77]', 2, 'the graph has no edge 77'),
    ('[2, 3]', '[2, 2]', 2, '2 occurs twice in closed_edges'),
    ('speed: 0.6', 'speed: 0', 2, 'speed is 0.0, but must be above 0'),
    ('speed: 0.6', 'speed: -1', 2, 'speed is -1.0, but must be above 0'),
    ('radius: 0.7', 'radius: 0', 2, 'radius is 0.0, but must be above 0'),
    ('radius: 0.7', 'radius: 0.5', 2,
     'radius of load pallet is 0.5, but robots of type truck alone have 0.6'),
    ('{radius: 0.7}', '{}', 2, 'radius is missing'),
    ('radius: 0.7', 'radius: 0.7, length: 2', 2, "a footprint has an unknown key 'length'"),
    ('speed: 0.9', 'sped: 0.9', 3, "a load has an unknown key 'sped'; did you mean speed"),
    (', speed: 0.9', '', 3, 'load box changes nothing'),
    ('name: box', 'name: pallet', 3, 'load pallet occurs twice'),
    ('name: box', "name: ''", 3, 'needs a name that can be read')])
def test_a_wrong_load_is_refused_with_its_line(tmp_path, right, wrong, line, told):
    assert right in LOADS
    with pytest.raises(FileError, match=f'line {line}: .*{re.escape(told)}'):
        read_loads(tmp_path, LOADS.replace(right, wrong, 1))


def test_a_step_names_no_type_of_load_that_a_file_without_loads_lacks(tmp_path):
    with pytest.raises(FileError, match="line 4: step engage takes 'pallet', but the loads of the "
                                        'work file are: none'):
        read_loads(tmp_path, LOADS.split('\n', 3)[3])


# -- chargers --------------------------------------------------------------------------------------

CHARGERS = '''stations:
- {name: press, places: [3]}
devices:
- {name: gate, kind: door, edges: [2], driver: simulated, timeout: 30}
chargers:
- {name: bay, places: [7, 8], capacity: 1}
- {name: corner, places: [1]}
'''


def read_with_docks(tmp_path, text):
    (tmp_path / 'work.yaml').write_text(text)
    return load_work(tmp_path / 'work.yaml', with_docks(corridor(9), 1, 7, 8))


def test_a_charger_has_room_at_all_its_places_unless_its_capacity_is_less(tmp_path):
    assert read_with_docks(tmp_path, CHARGERS).chargers == {
        'bay': Charger('bay', (7, 8), 1), 'corner': Charger('corner', (1,))}
    both = CHARGERS.replace(', capacity: 1', '')
    assert read_with_docks(tmp_path, both).chargers['bay'].capacity == 2


# -- zones -----------------------------------------------------------------------------------------

ZONES = '''stations:
- {name: press, places: [3]}
zones:
- {name: hall, edges: [4, 5], vertices: [7], capacity: 2}
- {name: bridge, edges: [1]}
'''


def test_a_zone_is_for_one_robot_unless_it_says_more(tmp_path):
    found = read(tmp_path, ZONES)
    assert found.zones == {'hall': Zone('hall', (4, 5), (7,), 2), 'bridge': Zone('bridge', (1,))}
    assert {'hall', 'bridge', 'press'} == found.names


# -- chargers and zones that are wrong -------------------------------------------------------------


@pytest.mark.parametrize('text, right, wrong, line, told', [
    (CHARGERS, 'places: [1]', 'places: [2]', 7, 'vertex 2 is no dock in the graph'),
    (CHARGERS, 'places: [1]', 'places: [8]', 7, 'dock 8 belongs to charger bay already'),
    (CHARGERS, 'places: [1]', 'places: []', 7, 'places is empty'),
    (CHARGERS, 'places: [1]', 'capacity: 1', 7, 'places is missing'),
    (CHARGERS, 'capacity: 1', 'capacity: 3', 6,
     'capacity of charger bay is 3, but it has 2 places'),
    (CHARGERS, 'capacity: 1', 'capacity: 0', 6, 'capacity of charger bay is 0'),
    (CHARGERS, 'capacity: 1', 'queue: [2]', 6, "a charger has an unknown key 'queue'"),
    (CHARGERS, 'name: corner', 'name: press', 7, 'a station or device is called press already'),
    (CHARGERS, 'name: corner', 'name: gate', 7, 'a station or device is called gate already'),
    (CHARGERS, 'name: corner', 'name: bay', 7, 'charger bay occurs twice'),
    (ZONES, 'edges: [1]', 'edges: [44]', 5, 'the graph has no edge 44'),
    (ZONES, 'edges: [1]', 'edges: [1, 1]', 5, '1 occurs twice in edges'),
    (ZONES, 'edges: [1]', 'vertices: [99]', 5, 'the graph has no vertex 99'),
    (ZONES, 'edges: [1]', 'capacity: 1', 5, 'zone bridge has neither edges nor vertices'),
    (ZONES, 'edges: [1]', 'edges: []', 5, 'zone bridge has neither edges nor vertices'),
    (ZONES, 'edges: [1]', 'edge: [1]', 5, "a zone has an unknown key 'edge'; did you mean edges"),
    (ZONES, 'capacity: 2', 'capacity: 0', 4, 'capacity of zone hall is 0, but must be 1 or more'),
    (ZONES, 'name: bridge', 'name: press', 5,
     'a station, device or charger is called press already'),
    (ZONES, 'name: bridge', 'name: hall', 5, 'zone hall occurs twice, first in line 4')])
def test_a_wrong_charger_or_zone_is_refused_with_its_line(tmp_path, text, right, wrong, line, told):
    with pytest.raises(FileError, match=f'line {line}: .*{told}'):
        read_with_docks(tmp_path, text.replace(right, wrong, 1))


# -- the whole file --------------------------------------------------------------------------------


@pytest.mark.parametrize('text', ['stations: []', 'templates: []\ntimetables: []', '{}'])
def test_each_part_may_be_missing_or_empty(tmp_path, text):
    assert read(tmp_path, text) == SiteWork()


@pytest.mark.parametrize('right, wrong, line, told', [
    # words that do not exist, missing fields, and a name that occurs twice
    ('type: engage', 'type: engaeg', 13, "no step type 'engaeg'; did you mean engage?"),
    ('at: $from', 'at: pres', 13, "no station and no vertex is named 'pres'"),
    ('at: 4', 'at: 99', 16, 'the graph has no vertex 99'),
    ('edges: [4]', 'edges: [44]', 8, 'the graph has no edge 44'),
    ('at: $from', 'at: $form', 13, "no parameter 'form'; did you mean from?"),
    ('cart: $cart', 'cart: $crt', 13, "no parameter 'crt'; did you mean cart?"),
    ('{type: engage, timeout: 60,', '{type: engage,', 13, 'timeout is missing'),
    (', timeout: 30', '', 7, 'timeout is missing'),
    ('kind: group', 'kind: group, capacity: 3', 4,
     'capacity of station shelves is 3, but it has 2 places'),
    ('queue: [2, 1]', 'capacity: 2', 3, 'it has one place: leave it out'),
    ('name: lamp', 'name: gate', 8, 'device gate occurs twice, first in line 7'),
    # stations
    ('places: [7, 8]', 'places: [7, 3]', 5, 'vertex 3 belongs to station press already'),
    ('queue: [2, 1]', 'queue: [2, 3]', 3, 'vertex 3 belongs to station press already'),
    ('queue: [2, 1]', 'queue: [2, 2]', 3, '2 occurs twice in queue'),
    ('places: [7, 8]', 'places: []', 5, 'places is empty'),
    ('at: $from', 'at: table', 13, 'station table is no group; give one of its places: 7, 8'),
    # devices
    ('driver: modbus', 'driver: mobdus', 7, "driver is 'mobdus'; did you mean modbus?"),
    ('driver: modbus', 'driver: simulated', 7, 'has host, but its driver is simulated'),
    ('open_coil: 3, ', '', 7, 'open_coil is missing'),
    ('is_open: 11', 'is_open: 65536', 7, 'must be a number from 0 to 65535'),
    ('timeout: 5}', 'timeout: .inf}', 8, 'must be above 0'),
    ('edges: [4]', 'edges: []', 8, 'device lamp has no edges'),
    ('name: lamp', 'name: press', 8, 'a station is called press already'),
    ('is_open: 11', 'is_open: 11, unit: 256', 7, 'unit is 256, but must be a number from 0 to 255'),
    ('is_open: 11', 'is_open: 11, robot: a', 7, 'has robot, but its driver is modbus'),
    ('driver: simulated', 'driver: ld90, robot: a, output: b', 8, 'input is missing'),
    ('driver: simulated', "driver: ld90, robot: a, output: 'b c', input: d", 8,
     "output is 'b c', but must have 1 to 40 letters"),
    # templates
    ('parameters: [from, to, cart]', 'parameters: [from, to, cart, gone]', 11,
     "'gone' of template pallet is used nowhere"),
    ('parameters: [from, to, cart]', 'parameters: [from, to, cart, to]', 11,
     "parameter 'to' of template pallet needs a name of its own"),
    ('- name: pallet', '- name: pal let', 10, 'needs a name of letters'),
    # timetables
    ('{template: pallet', '{template: palet', 18, "no template 'palet'; did you mean pallet?"),
    ('cart: a}', 'cart: a, x: b}', 18,
     "'x' is no parameter: template pallet has the parameters from, to, cart"),
    (', cart: a}', '}', 18, "'cart' is not given"),
    ('from: press, to', 'from: pres, to', 18, "no station and no vertex is named 'pres'"),
    ('every: 30 min', 'every: 30', 18, "every is '30', but must be a time from 1 min to 24 h"),
    ('every: 30 min', 'every: 0 min', 18, 'must be a time from 1 min'),
    ('"06:00"', '"24:00"', 18, 'is no time of day'),
    ('days: mon-fri', 'days: mon-frei', 18, "days has 'mon-frei'"),
    ('{name: night, ', '{', 19, 'timetable pallet occurs twice, first in line 18'),
    # steps of jobs
    ('{kind: pickup, at: [press, 7]}', '{kind: park}', 22, 'kind is park, but jobs have pickups'),
    ('{kind: pickup, at: [press, 7]}', '{at: [press]}', 22, 'kind is missing'),
    ('{kind: pickup, at: [press, 7]}', '{kind: pickup}', 22,
     'an entry without at occurs twice for pickup'),
    ('at: [press, 7]', 'at: []', 22, 'at is empty'),
    ('at: [press, 7]', 'at: [pres]', 22, "no station and no vertex is named 'pres'"),
    ('{kind: pickup, at: [press, 7]}', '{kind: dropoff, at: [5]}', 23,
     'vertex 5 occurs twice for dropoff'),
    ('{kind: pickup, steps: [{type: engage', '{kind: pickup, steps: [{type: engaeg', 21,
     "no step type 'engaeg'"),
    ('timetables:', 'timetable:', 18, "unknown key 'timetable'; did you mean timetables?")])
def test_what_is_wrong_is_refused_with_its_line(tmp_path, right, wrong, line, told):
    assert FILE.count(right) >= 1
    with pytest.raises(FileError) as error:
        read(tmp_path, FILE.replace(right, wrong, 1))
    assert told in str(error.value) and error.value.line == line
    assert str(error.value).count('\n') == 0
