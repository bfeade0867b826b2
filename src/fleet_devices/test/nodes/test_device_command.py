"""The command `device`: its lists, its requests, and its texts about the answers."""
from __future__ import annotations

import json
import re

import pytest
from genpy import Time

from fleet_core.supervision.machine_view import MachineState
from fleet_devices.commands import device
from fleet_devices.commands.machines import (
    ListedMachine,
    listed_machines,
    machine_of_topic,
    machine_table,
    machine_values,
)
from graph_fleet_manager.commands.command_line import CommandProblem
from graph_fleet_manager.commands.tables import WIDTH, as_json
from itrci_nav_msgs.msg import FleetMachine, FleetState, StepState, StepStates
from route_protocol.devices import (
    UNKNOWN_REQUESTER,
    DeviceFault,
    DeviceMode,
    DeviceReport,
    DeviceRequest,
    DeviceUse,
)

NOW = 10_000.0
ANNA = DeviceUse('anna@desk (device)', DeviceMode.OPEN, 7, NOW - 90)
GONE = DeviceUse('fleet', DeviceMode.CLOSED, 9, NOW - 30)
UNKNOWN = DeviceUse(UNKNOWN_REQUESTER, DeviceMode.OPEN, 0, 0.0)


def report(*obeyed: DeviceUse, mode: DeviceMode = DeviceMode.OPEN,
           **fields: object) -> DeviceReport:
    return DeviceReport('gate', mode, NOW - 4000, NOW - 0.2, obeyed, **fields)


def asked(mode: DeviceMode, requester: str = ANNA.requester, number: int = 7) -> DeviceRequest:
    return DeviceRequest(requester, 'gate', mode, number)


def test_devices_are_listed_with_their_holders_and_the_fault_below():
    late = report(mode=DeviceMode.UNKNOWN, fault=DeviceFault.TIMED_OUT, reason='it does not open')
    never = DeviceReport('shutter', DeviceMode.OFFLINE, NOW - 3, None, (UNKNOWN,))
    lines = device.listed([report(ANNA, GONE), late, never], NOW).splitlines()
    assert lines[0].split() == ['device', 'shows', 'for', 'read', 'held', 'by', '(for)']
    assert lines[1].split() == ['gate', 'OPEN', '67', 'min', '0', 's', 'anna@desk', '(device)',
                                '(90', 's)']
    assert lines[3].strip() == 'it does not open'
    assert lines[4].split() == ['shutter', 'OFFLINE', '3', 's', 'never', 'unknown']


def test_a_list_fits_a_terminal_whatever_the_names():
    holders = tuple(DeviceUse('x' * 100, DeviceMode.OPEN, k, NOW) for k in range(5))
    assert max(map(len, device.listed([report(*holders)], NOW).splitlines())) <= WIDTH


def test_programs_get_all_as_json():
    assert json.loads(as_json(device.values(report(ANNA, UNKNOWN)))) == {
        'device': 'gate', 'shows': 'OPEN', 'since': NOW - 4000, 'read': NOW - 0.2,
        'fault': 'NONE', 'reason': None, 'obeyed': [
            {'requester': ANNA.requester, 'mode': 'OPEN', 'number': 7, 'since': NOW - 90},
            {'requester': UNKNOWN_REQUESTER, 'mode': 'OPEN', 'number': 0, 'since': None}]}


def machine(state: int, *, robot: str = '', key: int = 1005, stamp: float = NOW - 0.4,
            ) -> ListedMachine:
    steps = StepStates(run=1, number=3, last=1005, steps=[
        StepState(1004, StepState.DONE, 0, ''), StepState(1005, state, 0, 'no pallet')])
    steps.header.stamp = Time.from_sec(stamp)
    fleet = FleetState(machines=[FleetMachine(
        name='press_1', state=FleetMachine.WORKING, key=key, robot=robot, serial=42),
        FleetMachine(name='oven')])
    oven, press = listed_machines({'press_1': steps}, fleet)
    assert (oven.name, press.name) == ('oven', 'press_1')
    return press


def test_machines_are_listed_with_their_step_and_the_robot_for_which_they_work():
    head, oven, press = machine_table(
        [ListedMachine('oven'), machine(StepState.RUNNING, robot='ld90_2')], NOW).splitlines()
    assert head.split() == ['machine', 'does', 'read', 'step', 'which', 'is', 'works', 'for']
    assert oven.split() == ['oven', 'SILENT', 'never', '-', '-', '-']
    assert press.split() == ['press_1', 'WORKING', '0', 's', '1005', 'RUNNING', 'ld90_2', '(M42)']


def test_below_a_machine_is_why_its_last_step_was_not_done():
    _, press, why = machine_table([machine(StepState.FAILED)], NOW).splitlines()
    assert press.split()[1:] == ['FREE', '0', 's', '1005', 'FAILED', '-']
    assert why.strip() == 'no pallet'


def test_a_machine_works_for_nobody_by_an_older_word_of_the_fleet_manager():
    assert machine(StepState.RUNNING, robot='ld90_2', key=1004).serves == '-'


def test_a_machine_whose_reports_are_old_is_silent():
    assert machine(StepState.RUNNING, stamp=NOW - 4.0).state(NOW) is MachineState.SILENT


def test_programs_get_all_of_a_machine_as_json():
    assert json.loads(as_json(machine_values(machine(StepState.RUNNING, robot='a'), NOW))) == {
        'machine': 'press_1', 'state': 'WORKING', 'read': NOW - 0.4, 'key': 1005, 'robot': 'a',
        'mission_serial': 42, 'steps': [
            {'key': 1004, 'state': 'DONE', 'code': None, 'text': None},
            {'key': 1005, 'state': 'RUNNING', 'code': None, 'text': 'no pallet'}]}


@pytest.mark.parametrize('topic, name', [
    ('/devices/press_1/step_states', 'press_1'), ('/devices/a/b/step_states', ''),
    ('/a/step_states', ''), ('/devices/step_states', '')])
def test_the_topic_of_a_machine_has_its_name(topic, name):
    assert machine_of_topic(topic) == name


def test_a_number_is_above_the_last_one_also_if_that_is_of_a_clock_ahead():
    ahead = 2 ** 60
    assert device.number_after(DeviceUse('a', DeviceMode.OPEN, ahead, 0.0)) == ahead + 1
    assert 10 ** 12 < device.number_after(None) < ahead
    assert device.number_after(ANNA) > 10 ** 12


@pytest.mark.parametrize('request_, obeyed, is_taken', [
    (asked(DeviceMode.OPEN), (ANNA,), True), (asked(DeviceMode.OPEN, number=8), (ANNA,), False),
    (asked(DeviceMode.CLOSED), (), False),
    (asked(DeviceMode.CLOSED, UNKNOWN_REQUESTER), (ANNA, UNKNOWN), False),
    (asked(DeviceMode.CLOSED, UNKNOWN_REQUESTER), (ANNA,), True)])
def test_a_request_is_taken_when_a_report_shows_it(request_, obeyed, is_taken):
    assert device.is_taken(report(*obeyed), request_) is is_taken


@pytest.mark.parametrize('request_, obeyed, mode, told', [
    (asked(DeviceMode.OPEN), (ANNA,), DeviceMode.MOVING,
     'Device gate is held open for anna@desk (device); it is MOVING.'),
    (asked(DeviceMode.CLOSED, 'fleet', 9), (ANNA, GONE), DeviceMode.OPEN,
     'Device gate is given back. It stays open for anna@desk (device).'),
    (asked(DeviceMode.CLOSED, 'fleet', 9), (GONE,), DeviceMode.MOVING,
     'Device gate is given back, and closes. It is MOVING.')])
def test_a_person_is_told_what_has_come_of_a_request(request_, obeyed, mode, told):
    assert device.answer(report(*obeyed, mode=mode), request_) == told


@pytest.mark.parametrize('obeyed, told', [
    ((ANNA, GONE), 'nobody does not hold device gate, so nothing is given back. It is held for '
                   'anna@desk (device): name one with --of.'),
    ((GONE,), 'nobody does not hold device gate, so nothing is given back. It has no holder.'),
    ((), 'nobody does not hold device gate, so nothing is given back. It has no holder.')])
def test_what_nobody_holds_is_not_given_back(monkeypatch, obeyed, told):
    monkeypatch.setattr(device, 'first_message', lambda *_: 'a message')
    monkeypatch.setattr(device, '_report', lambda _: report(*obeyed))
    monkeypatch.setattr(device, 'first_answer', lambda *_: pytest.fail('a request is sent'))
    with pytest.raises(CommandProblem, match=re.escape(told)) as problem:
        device._ask(None, 'gate', 'nobody', DeviceMode.CLOSED)
    assert problem.value.status != 0


@pytest.mark.parametrize('arguments', [[], ['open'], ['shut', 'gate'], ['list', 'gate']])
def test_wrong_words_are_refused_before_anything_is_sent(arguments):
    with pytest.raises(SystemExit) as ended:
        device.main(arguments)
    assert ended.value.code == 1
