#!/usr/bin/env python3
"""fleet_devices under a ROS master: a person and a fleet manager hold a door behind a PLC.

The door opens for both, and closes when both have given it back. The node is killed while the door
is held. The PLC is killed, starts again, and reports a wrong state. An output and an input of a
simulated LD-90 drive another door. A press behind the same PLC hands a load over in a step.
"""
from __future__ import annotations

import json
import os
import signal
import subprocess
import tempfile
import unittest
from pathlib import Path
from typing import Any, Dict, List, Optional, Tuple

import pytest
import rospy
from std_msgs.msg import Header

from itrci_nav_msgs.msg import DeviceRequest, DeviceState, StepCommand, StepStates
from route_protocol.device_messages import device_report_of
from route_protocol.devices import DeviceMode, DeviceReport
from route_protocol.step_messages import step_report_of
from route_protocol.steps import ShownStep, StepCode, Word
from system_support import Recorder, connected_publisher, process_of, program, run_cases, wait_until

plc = pytest.importorskip(
    'plc', reason='pymodbus 3, or the module serial_asyncio that it needs, is not installed')

GRAPH = Path(__file__).resolve().parents[1] / 'maps/lab_graph.yaml'
WORK = '''devices:
- {{name: gate, kind: door, edges: [17], timeout: 5, driver: modbus, host: 127.0.0.1, \
port: {port}, unit: {unit}, open_coil: {coil}, is_open: {input}}}
- {{name: shutter, kind: door, edges: [18], timeout: 2, driver: ld90, robot: omron_ld90, \
output: Output_1, input: Input_1}}
- {{name: lamp, kind: light, edges: [5], timeout: 5, driver: simulated}}
- {{name: press_1, kind: machine, timeout: 5, driver: modbus, host: 127.0.0.1, \
port: {port}, unit: {unit}, start_coil: {start}, key_register: {key}, done: {done}, \
failed: {failed}}}
'''
FLEET = 'fleet manager'
SOON = 20.0  # s


class DevicesTest(unittest.TestCase):
    """All tests use the same node and the same PLC, and give back everything that they hold."""

    node: Optional[subprocess.Popen] = None

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node('devices_test')
        cls.plc = plc.Plc()
        cls.plc.start()
        cls.folder = Path(tempfile.mkdtemp())
        (cls.folder / 'work.yaml').write_text(WORK.format(
            port=cls.plc.port, unit=plc.UNIT, coil=plc.COIL, input=plc.INPUT, start=plc.START,
            key=plc.KEY, done=plc.DONE, failed=plc.FAILED))
        cls.states = Recorder('/device_states', DeviceState)
        cls.start_node()
        cls.steps = Recorder('/devices/press_1/step_states', StepStates)
        cls.commands = connected_publisher('/devices/press_1/step_command', StepCommand)
        cls.requests = connected_publisher('/device_request', DeviceRequest)
        cls.number = 0

    @classmethod
    def tearDownClass(cls) -> None:
        if cls.node is not None:
            cls.node.terminate()
            cls.node.wait(SOON)
        cls.plc.kill()

    @classmethod
    def start_node(cls) -> None:
        cls.node = subprocess.Popen([
            program('fleet_devices', 'fleet_devices'), f'_work_file:={cls.folder / "work.yaml"}',
            f'_graph_file:={GRAPH}', f'_memory_file:={cls.folder / "memory.json"}',
            f'_steps_file:={cls.folder / "steps.json"}', '_simulated_travel:=0.2'])

    def command(self, *words: str) -> Tuple[int, str]:
        done = subprocess.run([program('fleet_devices', 'device'), *words], text=True,
                              capture_output=True, timeout=60, check=False)
        return done.returncode, done.stdout + done.stderr

    def ask(self, mode: DeviceMode) -> None:
        """Requests a mode like the fleet manager: repeats the request until the door shows it."""
        type(self).number += 1
        message = DeviceRequest(rospy.Time.now(), FLEET, 'gate', int(mode), self.number)

        def is_shown() -> bool:
            self.requests.publish(message)
            use = self.report('gate').use_of(FLEET)
            return use is not None and use.number == self.number
        wait_until(is_shown, SOON, 'the request in a report')

    def report(self, name: str) -> DeviceReport:
        """Returns the newest report of a device. Fails if a report is older than the previous
        report.
        """
        reports = [device_report_of(message) for message in list(self.states.messages)
                   if message.device_name == name]
        for before, after in zip(reports, reports[1:]):
            self.assertTrue(after.is_newer_than(before), (before, after))
        return reports[-1] if reports else DeviceReport(name, DeviceMode.UNKNOWN, 0.0, None)

    def wait_for_mode(self, mode: DeviceMode, name: str = 'gate') -> DeviceReport:
        wait_until(lambda: self.report(name).mode is mode, SOON, f'{name} {mode.name}')
        return self.report(name)

    def listed(self) -> Dict[str, Any]:
        status, output = self.command('list', '--json')
        self.assertEqual(0, status, output)
        return {one['device']: one for one in json.loads(output)['devices']}

    def holders(self) -> List[str]:
        return [use['requester'] for use in self.listed()['gate']['obeyed']
                if use['mode'] == 'OPEN']

    def test_a_door_closes_when_the_last_one_gives_it_back(self) -> None:
        self.wait_for_mode(DeviceMode.CLOSED)
        self.ask(DeviceMode.OPEN)
        wait_until(lambda: self.report('gate').is_open_for(FLEET, self.number), SOON, 'the door')
        status, output = self.command('open', 'gate')
        self.assertEqual(0, status, output)
        self.assertIn('held open for', output)
        self.assertEqual(2, len(self.holders()))
        self.ask(DeviceMode.CLOSED)
        self.wait_for_mode(DeviceMode.OPEN)
        self.assertTrue(self.plc.coils[plc.COIL])
        status, output = self.command('release', 'gate')
        self.assertEqual(0, status, output)
        self.wait_for_mode(DeviceMode.CLOSED)
        self.assertFalse(self.plc.coils[plc.COIL])

    def test_a_killed_node_keeps_the_door_open_and_knows_its_holders(self) -> None:
        self.ask(DeviceMode.OPEN)
        run = self.wait_for_mode(DeviceMode.OPEN).run
        os.kill(process_of('/fleet_devices'), signal.SIGKILL)
        self.node.wait(SOON)
        self.assertTrue(self.plc.coils[plc.COIL])
        self.start_node()
        wait_until(lambda: self.report('gate').run > run, SOON, 'the next run')
        self.wait_for_mode(DeviceMode.OPEN)
        self.assertTrue(self.report('gate').is_open_for(FLEET, self.number))
        self.assertEqual([FLEET], self.holders())
        status, output = self.command('release', 'gate', '--of', FLEET)
        self.assertEqual(0, status, output)
        self.wait_for_mode(DeviceMode.CLOSED)
        type(self).number = max(self.number, self.report('gate').use_of(FLEET).number)

    def test_a_plc_that_dies_and_lies_opens_nothing_by_what_was_read_before(self) -> None:
        self.ask(DeviceMode.OPEN)
        self.wait_for_mode(DeviceMode.OPEN)
        self.plc.kill()
        self.assertIn('does not answer', self.wait_for_mode(DeviceMode.OFFLINE).reason)
        self.assertIn('OFFLINE', self.command('list')[1])
        self.plc.start()  # its coils are off again, so the node opens the door once more
        self.wait_for_mode(DeviceMode.OPEN)
        self.assertTrue(self.plc.coils[plc.COIL])
        self.plc.lies = True
        report = self.wait_for_mode(DeviceMode.UNKNOWN)
        self.assertIn('does not open within 5 s', report.reason)
        self.plc.lies = False
        self.wait_for_mode(DeviceMode.OPEN)
        self.ask(DeviceMode.CLOSED)
        self.wait_for_mode(DeviceMode.CLOSED)

    def test_an_output_of_a_robot_is_set_and_its_input_is_read(self) -> None:
        self.wait_for_mode(DeviceMode.CLOSED, 'shutter')
        self.assertEqual(0, self.command('open', 'shutter')[0])
        report = self.wait_for_mode(DeviceMode.UNKNOWN, 'shutter')  # its input never changes
        self.assertIn('its output is on', report.reason)
        self.assertEqual(0, self.command('release', 'shutter')[0])
        self.wait_for_mode(DeviceMode.CLOSED, 'shutter')

    def shown_step(self, key: int, word: Word) -> ShownStep:
        """Waits until the press shows the step with this key in the state `word`. Returns it."""
        def is_shown(message: StepStates) -> bool:
            step = step_report_of(message).find(key)
            return step is not None and step.word is word
        found = step_report_of(self.steps.wait_for(is_shown, SOON, f'step {key}')).find(key)
        assert found is not None
        return found

    def order(self, key: int) -> None:
        """Repeats a command as the fleet manager does. The press must obey it once."""
        run = self.steps.wait_for(lambda _: True, SOON, 'the steps of the press').run
        wait_until(self.commands.get_num_connections, SOON, 'the connection to the press')
        for _ in range(3):
            self.commands.publish(StepCommand(
                Header(), key, StepCommand.DO, run, 'handshake', [], 60.0))

    def test_a_press_hands_over_once_and_is_asked_again_after_a_restart(self) -> None:
        starts = self.plc.starts
        self.order(1)
        wait_until(lambda: self.plc.coils.get(plc.START), SOON, 'the start')
        os.kill(process_of('/fleet_devices'), signal.SIGKILL)
        self.node.wait(SOON)
        self.steps.messages.clear()
        self.start_node()
        self.order(1)
        self.plc.is_done = True
        self.shown_step(1, Word.DONE)
        wait_until(lambda: not self.plc.coils[plc.START], SOON, 'the end of the hand-over')
        self.assertEqual(starts + 1, self.plc.starts)
        self.plc.is_done = False
        self.order(2)
        wait_until(lambda: self.plc.coils[plc.START], SOON, 'the second start')
        self.plc.kill()
        step = self.shown_step(2, Word.UNKNOWN)
        self.assertEqual(StepCode.LOST_LINK, step.code)
        self.plc.start()
        self.wait_for_mode(DeviceMode.CLOSED)
        self.assertEqual(starts + 2, self.plc.starts)

    def test_an_unknown_device_is_refused_in_one_sentence(self) -> None:
        status, output = self.command('open', 'gaet')
        self.assertEqual((1, 1), (status, output.count('\n')))
        self.assertIn('No device gaet is reported', output)


if __name__ == '__main__':
    run_cases(__file__)
