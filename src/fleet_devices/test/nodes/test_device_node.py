"""The parts of the node: files, parameters, answers of robots, and texts for people."""
from __future__ import annotations

from pathlib import Path

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from fleet_core.work.devices import Device, DeviceKind, ModbusAddress, StepDevice
from fleet_devices.core.device import DeviceLimits, DeviceMemory, Reading
from fleet_devices.core.devices import Devices, Periods, StoredDevices
from fleet_devices.core.hand_over import HandOverMemory, HandOverPhase
from fleet_devices.core.hand_overs import HandOvers, StoredHandOvers
from fleet_devices.drivers.driver import Silent
from fleet_devices.drivers.simulated import FaultKind, ScriptedFault
from fleet_devices.nodes import memory_file
from fleet_devices.nodes.diagnostics import device_task, memory_task
from fleet_devices.nodes.fleet_devices import message_of
from fleet_devices.nodes.memory_file import HOLDERS_LOST, STEPS_LOST, MemoryFile
from fleet_devices.nodes.robot_signals import is_on
from fleet_devices.nodes.settings import scripted_faults
from node_lifecycle import ConfigurationError
from route_protocol.device_messages import device_report_of
from route_protocol.devices import DeviceMode, DeviceReport, DeviceRequest, DeviceUse
from route_protocol.steps import ShownStep, StepCode, Word

USE = DeviceUse('fleet', DeviceMode.OPEN, 2 ** 60, 1.5)
MEMORY = StoredDevices(7, {'gate': DeviceMemory((USE,)), 'lamp': DeviceMemory(is_lost=True)})
OVEN = StepDevice('oven', 5.0)
LAMP = Device('lamp', DeviceKind.LIGHT, (1,), 5.0)
GATE = Device('gate', DeviceKind.DOOR, (2,), 5.0, address=ModbusAddress('10.0.0.40', 1, 2))


# -- the memory ------------------------------------------------------------------------------------


def memory_at(path: Path) -> MemoryFile:
    return MemoryFile(str(path), '~memory_file', StoredDevices(), HOLDERS_LOST)


def test_the_steps_of_a_machine_come_back(tmp_path):
    file = MemoryFile(str(tmp_path / 'steps.json'), '~steps_file', StoredHandOvers(), STEPS_LOST)
    stored = StoredHandOvers({'press': HandOverMemory(
        2 ** 52, 3, 9, (ShownStep(8, Word.FAILED, StepCode.NOT_READY, 'why'), ShownStep(9)),
        HandOverPhase.WORKING, 9)})
    file.write(stored)
    assert file.read() == stored


def test_a_memory_comes_back(tmp_path):
    file = memory_at(tmp_path / 'new' / 'memory.json')
    assert file.read() == StoredDevices()
    file.write(MEMORY)
    assert file.read() == MEMORY


@pytest.mark.parametrize('content', ['', '{', '[]', '{"run": "x", "devices": {}}', '\x00',
                                     '{"run": 1, "devices": {"gate": 3}}'])
def test_a_memory_that_cannot_be_read_is_lost(tmp_path, monkeypatch, content):
    told = []
    monkeypatch.setattr(memory_file.rospy, 'logwarn', lambda *words: told.append(words))
    path = tmp_path / 'memory.json'
    path.write_text(content)
    assert memory_at(path).read() == StoredDevices()
    assert 'device release NAME --of unknown' in told[0][0] % told[0][1:]


def test_a_memory_that_cannot_be_written_raises(tmp_path):
    folder = tmp_path / 'file'
    folder.write_text('')
    with pytest.raises(OSError):
        memory_at(folder / 'memory.json').write(MEMORY)


# -- parameters ------------------------------------------------------------------------------------


def fault(**changed: object) -> dict:
    return {'device': 'lamp', 'fault': 'slow', 'begin': 1, 'end': 2.5, **changed}


def test_scripted_faults_are_read_by_device():
    assert scripted_faults([fault(), fault(fault='lying', begin=3, end=4)],
                           {'lamp': LAMP, 'gate': GATE}, {}) == {
        'lamp': [ScriptedFault(FaultKind.SLOW, 1, 2.5), ScriptedFault(FaultKind.LYING, 3, 4)]}


@pytest.mark.parametrize('entry, told', [
    ('slow', 'must have device, fault, begin and end'),
    ({'device': 'lamp'}, 'must have device, fault, begin and end'),
    (fault(device='gate'), 'no simulated device'), (fault(device='gat'), 'no simulated device'),
    (fault(device=3), 'no simulated device'), (fault(fault='slwo'), 'there are: slow, stuck'),
    (fault(begin=3), 'the first one smaller'), (fault(begin=-1), 'the first one smaller'),
    (fault(end=True), 'two numbers'), (fault(end='x'), 'two numbers'),
    (fault(end=float('nan')), 'two numbers'),
    (fault(fault='failing'), 'only: slow, stuck, silent, lying, shut.'),
    (fault(device='oven', fault='shut'), 'only: slow, stuck, silent, lying, failing.')])
def test_a_wrong_fault_is_refused(entry, told):
    with pytest.raises(ConfigurationError, match=told):
        scripted_faults([entry], {'lamp': LAMP, 'gate': GATE}, {'oven': OVEN})


# -- robots ----------------------------------------------------------------------------------------


@pytest.mark.parametrize('lines, output, is_set', [
    (['Output: Out_1 on'], True, True), (['Output: Out_1 off'], True, False),
    (['Input: Out_1 on'], False, True), (['Something', 'Input: Out_1 off'], False, False)])
def test_a_robot_says_whether_a_signal_is_on(lines, output, is_set):
    assert is_on(lines, 'Out_1', output) is is_set


@pytest.mark.parametrize('lines', [
    [], ['Output: Out_2 on'], ['Input: Out_1 on'], ['Output: Out_1 broken'], ['Output: Out_1'],
    ['CommandError: outputQuery Out_1'], ['\x00']])
def test_any_other_answer_is_no_reading(lines):
    with pytest.raises(Silent):
        is_on(lines, 'Out_1', True)


# -- messages and diagnostics ----------------------------------------------------------------------


def test_the_times_of_a_report_become_those_of_ros():
    use = DeviceUse('fleet', DeviceMode.OPEN, 3, 1000.5)
    report = DeviceReport('gate', DeviceMode.OPEN, 4.0, 5.0, (use,), run=2, count=9)
    assert device_report_of(message_of(report, 100.0)) == report.at(104.0, 105.0)
    never = DeviceReport('gate', DeviceMode.UNKNOWN, 4.0, None)
    assert device_report_of(message_of(never, 100.0)) == never.at(104.0, None)


NOBODY = StoredDevices(1, {'gate': DeviceMemory()})


def devices(memory: StoredDevices = NOBODY) -> Devices:
    return Devices({'gate': DeviceLimits(10.0, 2.0)}, memory, lambda memory: None, 1, Periods(0.1),
                   0.0)


def read(one: Devices, reading: Reading) -> None:
    for now in (0.0, 0.1):
        one.begin_due(now)
        one.ended('gate', reading, '', now)


def shown(one: Devices) -> DiagnosticStatusWrapper:
    status = DiagnosticStatusWrapper()
    device_task('gate', one)(status)
    return status


def test_a_device_that_is_held_is_shown_with_its_holder():
    one = devices()
    one.receive(DeviceRequest('fleet', 'gate', DeviceMode.OPEN, 1), 0.0, 0.0)
    read(one, Reading(True, True))
    status = shown(one)
    assert (status.level, status.message) == (DiagnosticStatus.OK, 'open')
    assert [(value.key, value.value) for value in status.values] == [('held by', 'fleet')]


def test_a_person_is_told_what_to_do_about_each_state():
    one = devices()
    read(one, Reading(True, True))
    assert (shown(one).level, shown(one).message) == (
        DiagnosticStatus.WARN, 'open, without a holder. To close it: device release gate')
    one.tick(5.0)
    assert shown(one).level == DiagnosticStatus.ERROR and 'offline' in shown(one).message
    lost = devices(StoredDevices())
    read(lost, Reading(True, True))
    assert shown(lost).level == DiagnosticStatus.WARN
    assert 'device release gate --of unknown' in shown(lost).message


def test_a_memory_that_cannot_be_stored_is_an_error():
    one, status = devices(), DiagnosticStatusWrapper()
    machines = HandOvers({}, StoredHandOvers(), lambda _: None, 0, 0.1, 0.0)
    memory_task(one, machines)(status)
    assert status.level == DiagnosticStatus.OK
    one.problem = 'No space left on device'
    memory_task(one, machines)(status)
    assert status.level == DiagnosticStatus.ERROR and 'No space left' in status.message


def test_the_example_of_the_page_is_a_work_file(tmp_path: Path):
    """The devices on the page of the documentation can be read as a work file."""
    from fleet_core.files.work_file import load_work
    from trajectory_graph import Edge, Graph, Vertex
    page = Path(__file__).resolve().parents[4] / 'docs/reference/fleet_devices.md'
    text = page.read_text(encoding='utf-8').split('```yaml\n')[1].split('```')[0]
    (tmp_path / 'work.yaml').write_text(text)
    vertices = [Vertex(k, float(k), 0.0, 0.0) for k in range(1, 30)]
    edges = [Edge(k, k, k + 1) for k in range(1, 29)]
    found = load_work(tmp_path / 'work.yaml', Graph(vertices, edges)).devices
    assert list(found) == ['gate_north', 'shutter', 'lamp']
