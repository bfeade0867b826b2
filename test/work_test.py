#!/usr/bin/env python3
"""Missions with steps under a ROS master: a person's commands send, answer and cancel them.

Two simulated AGVs carry out the steps. The fleet manager is restarted while a step waits for an
answer.
"""
from __future__ import annotations

import os
import subprocess
import tempfile
import unittest
from pathlib import Path
from typing import Tuple

import rosnode
import rospy
from fleet_support import Simulators

from itrci_nav_msgs.msg import FleetRobot, FleetState, MissionStatus
from system_support import Recorder, program, run_cases, wait_until

PALLET = '''
stops:
- {at: 18, kind: pickup, steps: [{type: engage, timeout: 60, load: takes}]}
- at: 39
  kind: dropoff
  steps:
  - {type: handshake, actor: outside, timeout: 600}
  - {type: disengage, timeout: 60, load: gives}
on_cancel:
- {if: loaded, at: 6, kind: dropoff, steps: [{type: disengage, timeout: 60, load: gives}]}
'''


class WorkTest(unittest.TestCase):
    """All tests use the same fleet. Each test has its own mission."""

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node('work_test')
        cls.statuses = Recorder('/mission_status', MissionStatus)
        cls.states = Recorder('/fleet_state', FleetState)
        cls.simulators = Simulators([int(os.environ.get('LD90_ARCL_PORT', '17171'))])
        cls.file = Path(tempfile.mkdtemp()) / 'pallet.yaml'
        cls.file.write_text(PALLET)
        cls.states.wait_for(lambda state: all(robot.state == FleetRobot.IDLE
                                              for robot in state.robots), 60, 'all robots')

    def command(self, name: str, *words: str) -> Tuple[int, str]:
        done = subprocess.run([program('graph_fleet_manager', name), *words], text=True,
                              capture_output=True, timeout=60, check=False)
        return done.returncode, done.stdout + done.stderr

    def status(self, mission: int, state: int, words: str = '') -> MissionStatus:
        return self.statuses.wait_for(
            lambda status: status.request_id == mission and status.state == state
            and words in status.reason, 90, f'mission {mission} in state {state} {words}')

    def send(self, mission: int) -> None:
        self.assertEqual(0, self.command('mission', '--stops', str(self.file), '--id',
                                         str(mission))[0])

    def test_a_pallet_is_taken_and_given_when_a_program_says_so(self) -> None:
        self.send(1)
        status = self.status(1, MissionStatus.ACTIVE, 'handshake')
        self.assertEqual(1, status.destinations_reached)
        self.assertTrue(status.asks)
        self.assertEqual(0, self.command('mission', 'answer', '1', 'done')[0])
        self.status(1, MissionStatus.SUCCEEDED)

    def test_a_mission_is_sent_by_the_name_of_a_template(self) -> None:
        self.assertIn('pallet', self.command('mission', 'templates')[1])
        status, said = self.command('mission', 'run', 'pallet', 'from:=press', 'to:=39', '--id',
                                    '5', '--wait')
        self.assertEqual((0, True), (status, 'Mission 5 has succeeded' in said), said)
        self.assertEqual(['press', '39'], [one.value for one in self.status(
            5, MissionStatus.SUCCEEDED).arguments])
        status, said = self.command('mission', 'run', 'pallet', 'from:=press', 'too:=39')
        self.assertEqual(2, status)
        self.assertIn("'too' is no parameter: template pallet has the parameters from, to", said)

    def test_a_person_answers_a_step_of_unknown_outcome_after_a_restart(self) -> None:
        for robot in ('agv_1', 'agv_2'):
            self.simulators.fault(robot, 'step_unknown')
        self.send(2)
        asks = self.status(2, MissionStatus.NEEDS_PERSON).asks
        rosnode.kill_nodes(['/path_supervisor'])
        wait_until(lambda: self.statuses.messages and self.statuses.messages[-1].asks == asks
                   and '2' in self.command('mission', 'list')[1], 60, 'the fleet manager again')
        self.assertEqual(0, self.command('mission', 'answer', '2', 'done')[0])
        self.status(2, MissionStatus.ACTIVE, 'handshake')
        robot = self.statuses.messages[-1].robot
        code, words = self.command('mission', 'cancel', '2')
        self.assertEqual((0, True), (code, 'CANCELLING' in words), words)
        self.status(2, MissionStatus.CANCELLED, 'cancelled on request')
        code, words = self.command('fleet', 'load', robot, 'empty')
        self.assertEqual((0, f'{robot} carries nothing.\n'), (code, words))

    def test_a_press_hands_the_load_over(self) -> None:
        handed = self.file.with_name('handed.yaml')
        handed.write_text('stops: [{at: 18, steps: [{type: handshake, actor: device, '
                          'device: press_1, timeout: 60}]}]\n')
        status, said = self.command('mission', '--stops', str(handed), '--id', '8', '--wait')
        self.assertEqual((0, True), (status, 'Mission 8 has succeeded' in said), said)
        handed.write_text(handed.read_text().replace('press_1', 'pres_1'))
        status, said = self.command('mission', '--stops', str(handed), '--id', '9')
        self.assertIn("no machine 'pres_1' among the devices; there are: press_1", said)

    def test_a_wrong_file_is_refused_with_its_line(self) -> None:
        wrong = self.file.with_name('wrong.yaml')
        wrong.write_text(PALLET.replace('timeout: 600', 'timeout: 0'))
        code, words = self.command('mission', '--stops', str(wrong))
        self.assertEqual(1, code)
        self.assertIn('line 7: step handshake needs a timeout', words)


if __name__ == '__main__':
    run_cases(__file__)
