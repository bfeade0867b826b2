#!/usr/bin/env python3
"""A door and a station under a ROS master: robots enter only claimed places, and only open doors.

A robot waits before the closed door. The door opens for the robot and closes behind it. Then the
state of the door cannot be read, so no robot enters. Then fleet_devices ends while a robot is in
the door: an alarm comes, and the robot may leave. Two robots want the same station. Throughout the
test, no robot is in the door unless the door is open.
"""
from __future__ import annotations

import json
import subprocess
import tempfile
import unittest
from pathlib import Path
from typing import Any, Dict, List, Optional, Tuple

import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from std_srvs.srv import Trigger

from itrci_nav_msgs.msg import DeviceState, FleetRobot, FleetState, MissionStatus
from system_support import Recorder, program, run_cases, wait_until

FILES = Path(__file__).resolve().parent
GRAPH = FILES.parent / 'maps/lab_graph.yaml'
DOOR_EDGE = 17      # from vertex 20 to the station at vertex 18
SOON = 60.0         # s
ALONE = 'agv_1'
SILENT = 'silent'   # a fault of simulated devices


class DoorWatch:
    """Notes each robot in the door while the newest report does not say that the door is open."""

    def __init__(self) -> None:
        self.wrong: List[str] = []
        self.inside = ''
        self.is_over = False
        """Whether the watch has ended, because the robot in the door may leave it now."""
        self._mode = DeviceState.UNKNOWN
        self._subscribers = [
            rospy.Subscriber('/device_states', DeviceState, self._on_device),
            rospy.Subscriber('/fleet_state', FleetState, self._on_fleet)]

    def _on_device(self, message: DeviceState) -> None:
        self._mode = message.current_mode

    def _on_fleet(self, message: FleetState) -> None:
        inside = [robot.name for robot in message.robots if abs(robot.pose.edge_id) == DOOR_EDGE
                  and 2.0 < robot.pose.percentage < 98.0]
        self.inside = inside[0] if inside else ''
        if inside and self._mode != DeviceState.OPEN and not self.is_over:
            self.wrong.append(f'{inside} in the door, which shows {self._mode}')


class DoorsTest(unittest.TestCase):
    """All tests use the same fleet, in the order of their names. Each test has its own missions."""

    devices: Optional[subprocess.Popen] = None

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node('doors_test')
        cls.memory = Path(tempfile.mkdtemp()) / 'memory.json'
        cls.statuses = Recorder('/mission_status', MissionStatus)
        cls.states = Recorder('/fleet_state', FleetState)
        cls.doors = Recorder('/device_states', DeviceState)
        cls.diagnostics = Recorder('/diagnostics', DiagnosticArray)
        cls.watch = DoorWatch()
        cls.states.wait_for(lambda state: len(state.robots) == 2 and all(
            robot.state == FleetRobot.IDLE for robot in state.robots), SOON, 'all robots')

    @classmethod
    def tearDownClass(cls) -> None:
        cls.end_devices()

    def setUp(self) -> None:
        self.begun = len(self.states.messages)

    def tearDown(self) -> None:
        self.assertEqual([], self.watch.wrong)
        for state in self.states.messages:
            for one in state.resources:
                self.assertLessEqual(len(one.claims), one.capacity, one)

    @classmethod
    def end_devices(cls) -> None:
        if cls.devices is not None:
            cls.devices.terminate()
            cls.devices.wait(SOON)
            cls.devices = None

    def start_devices(self, *faults: Dict[str, Any]) -> None:
        """Starts fleet_devices. It knows the holders of the door from its file."""
        self.end_devices()
        type(self).devices = subprocess.Popen([
            program('fleet_devices', 'fleet_devices'),
            f'_work_file:={FILES / "vectors/doors_work.yaml"}', f'_graph_file:={GRAPH}',
            f'_memory_file:={self.memory}', '_simulated_travel:=5.0',
            f'_simulated_faults:={json.dumps(list(faults))}'])

    def command(self, name: str, *words: str,
                package: str = 'graph_fleet_manager') -> Tuple[int, str]:
        done = subprocess.run([program(package, name), *words], text=True,
                              capture_output=True, timeout=60, check=False)
        return done.returncode, done.stdout + done.stderr

    def send(self, mission: int, vertex: int, robot: str = ALONE, *more: str) -> None:
        status, said = self.command('mission', str(vertex), '--robot', robot, '--id',
                                    str(mission), *more)
        self.assertEqual(0, status, said)

    def ends(self, mission: int) -> None:
        self.statuses.wait_for(lambda one: (one.request_id, one.state) == (
            mission, MissionStatus.SUCCEEDED), SOON, f'the end of mission {mission}')

    def waits(self, words: str, robot: str = ALONE) -> None:
        self.states.wait_for(
            lambda state: any(one.name == robot and words in one.waits_for
                              for one in state.robots), SOON, f'{robot} waits for {words}',
            after=self.begun)

    def shows(self, mode: int, times: int = 1) -> None:
        """Waits until the door has shown this mode `times` times from now on."""
        begun = len(self.doors.messages)
        wait_until(lambda: sum(one.current_mode == mode for one in self.doors.messages[begun:])
                   >= times, SOON, f'the door in mode {mode}, {times} times')

    def test_1_a_robot_waits_before_the_door_passes_it_and_it_closes(self) -> None:
        self.start_devices()
        self.shows(DeviceState.CLOSED)
        self.send(1, 18)
        self.waits('door gate (MOVING)')
        self.ends(1)
        self.shows(DeviceState.CLOSED)
        self.assertIn('press', self.command('station', 'list')[1])

    def test_2_nobody_enters_a_door_that_cannot_be_read(self) -> None:
        self.start_devices({'device': 'gate', 'fault': SILENT, 'begin': 3.0, 'end': 600.0})
        self.shows(DeviceState.OFFLINE)
        self.send(2, 8)
        self.waits('door gate (OFFLINE')
        self.shows(DeviceState.OFFLINE, times=10)
        self.assertEqual('', self.watch.inside)
        self.assertIn('OFFLINE', self.command('station', 'list')[1])
        self.assertIn('door gate (OFFLINE', self.command('mission', 'why', '2')[1])
        self.start_devices()
        self.ends(2)

    def test_3_two_robots_want_one_station(self) -> None:
        self.start_devices()
        self.send(3, 18, ALONE, '--dwell', '3')
        self.send(4, 18, 'agv_2')
        self.waits(ALONE, 'agv_2')
        self.ends(3)
        self.ends(4)
        self.send(5, 27, 'agv_2')
        self.ends(5)

    def test_4_a_robot_in_a_door_that_falls_silent_is_an_alarm_and_may_leave(self) -> None:
        self.start_devices()
        stop = rospy.ServiceProxy('/stop_fleet', Trigger)
        stop.wait_for_service(SOON)
        self.send(6, 18)
        wait_until(lambda: self.watch.inside, SOON, 'a robot in the door')
        self.assertTrue(stop().success)
        self.watch.is_over = True
        self.end_devices()
        self.diagnostics.wait_for(
            lambda message: any(one.level == DiagnosticStatus.ERROR and 'door gate' in one.message
                                for one in message.status), SOON, 'the alarm')
        status, said = self.command('station', 'list')
        self.assertEqual((0, True), (status, f'ALARM: {ALONE} is there' in said), said)
        self.assertEqual(0, self.command('fleet', 'resume')[0])
        self.ends(6)


if __name__ == '__main__':
    run_cases(__file__)
