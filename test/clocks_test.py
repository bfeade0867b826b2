#!/usr/bin/env python3
"""A clock that jumps by an hour in either direction changes no drive.

Nothing ends early, and nothing happens twice. The clock of all Python processes on one computer
jumps, or the clocks on both computers (jumping_clock).
"""
from __future__ import annotations

import os
import unittest
from pathlib import Path
from typing import List, Sequence

import rospy

from itrci_nav_msgs.msg import (
    EdgeState,
    ExecutionRouteStates,
    FleetRobot,
    FleetState,
    MissionRequest,
    MissionStatus,
)
from system_support import (
    CommandRecorder,
    Recorder,
    connected_publisher,
    run_cases,
    wait_until,
)

ROBOT = 'omron_ld90'
HOUR = 3600
LONG = bool(os.environ.get('LD90_LONG_TESTS'))


class Clocks(unittest.TestCase):

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node('clocks_test')
        cls.folder = Path(rospy.get_param('~clocks'))
        cls.reports = Recorder(f'/{ROBOT}/execution_route_states', ExecutionRouteStates)
        cls.statuses = Recorder('/mission_status', MissionStatus)
        cls.fleet = Recorder('/fleet_state', FleetState)
        cls.commands = CommandRecorder(ROBOT)
        cls.requests = connected_publisher('/mission_request', MissionRequest, to='path_supervisor')
        cls.fleet.wait_for(lambda state: state.robots and state.robots[0].seen
                           and state.robots[0].pose.edge_id, 60, 'robot on the graph')
        wait_until(cls.statuses.is_connected, 30, 'connection to /mission_status')

    def setUp(self) -> None:
        self.given = len(self.commands.texts)

    def tearDown(self) -> None:
        self.set_clocks(robot=0, fleet=0)

    def set_clocks(self, **seconds: int) -> None:
        """Sets how far (s) the clock of each computer is ahead. Readers never see half a line."""
        for computer, ahead in seconds.items():
            new = self.folder / f'{computer}_clock.new'
            new.write_text(f'{ahead:+d}\n')
            os.replace(new, self.folder / f'{computer}_clock')

    def offsets(self) -> float:
        """Returns how far (s) the robot's newest report is ahead of this process's clock."""
        return (self.reports.messages[-1].header.stamp - rospy.Time.now()).to_sec()

    def send(self, id: int, *vertices: int) -> None:
        self.requests.publish(request_id=id, destination_vertices_id=vertices)

    def wait_for_the_robots_clock(self, ahead: int) -> None:
        wait_until(lambda: abs(self.offsets() - ahead) < 60.0, 20, f'a robot {ahead} s ahead')

    def wait_for_another_edge(self) -> None:
        """Waits until the robot drives on another edge."""
        heard = len(self.reports.messages)
        here = self.reports.messages[-1].symbolic_pose.edge_id
        self.reports.wait_for(lambda report: report.symbolic_pose.edge_id not in (0, here), 60,
                              f'the robot on another edge than {here}', after=heard)

    def check_success(self, id: int) -> None:
        end = self.statuses.wait_for(
            lambda status: status.request_id == id and status.state in (
                MissionStatus.SUCCEEDED, MissionStatus.FAILED, MissionStatus.REFUSED), 120,
            f'end of mission {id}')
        self.assertEqual(MissionStatus.SUCCEEDED, end.state, end.reason)
        drives = [text for text in self.commands.texts[self.given:] if text != 'stop']
        repeated: List[str] = [one for one, other in zip(drives, drives[1:]) if one == other]
        self.assertEqual([], repeated, drives)

    def states_since(self, index: int) -> List[int]:
        return [state.robots[0].state for state in self.fleet.messages[index:]]

    def test_1_both_clocks_jump_together_an_hour_on_and_two_back(self) -> None:
        heard = len(self.reports.messages)
        self.send(1, 39, 6, 18)
        for ahead in (HOUR, -HOUR):
            self.wait_for_another_edge()
            self.set_clocks(robot=ahead, fleet=ahead)
            self.wait_for_the_robots_clock(ahead)
        self.check_success(1)
        failed = [report for report in self.reports.messages[heard:]
                  if any(edge.state == EdgeState.FAILED for edge in report.edge_states)]
        self.assertEqual([], failed)

    def test_2_a_robot_whose_clock_alone_jumps_waits_and_is_named(self) -> None:
        self.only_one_jumps(2, 'robot', (HOUR, -HOUR) if LONG else (HOUR,))

    def test_3_the_robots_of_a_fleet_manager_whose_clock_jumps_wait(self) -> None:
        self.only_one_jumps(3, 'fleet', (HOUR, -HOUR) if LONG else (-HOUR,))

    def only_one_jumps(self, id: int, computer: str, jumps: Sequence[int]) -> None:
        """Makes one computer's clock jump. Checks that the robot still drives its route, and that
        the mission ends.
        """
        self.send(id, 39, 18)
        for ahead in jumps:
            self.wait_for_another_edge()
            begun = len(self.fleet.messages)
            self.set_clocks(**{computer: ahead})
            told = self.fleet.wait_for(
                lambda state: state.robots[0].outage_code == FleetRobot.OUTAGE_CLOCK
                or 'clock' in state.robots[0].waits_for, 30, 'report about clocks', after=begun)
            self.assertIn('clock', told.robots[0].waits_for)
            self.set_clocks(**{computer: 0})
            self.fleet.wait_for(
                lambda state: state.robots[0].state == FleetRobot.BUSY
                and 'clock' not in state.robots[0].waits_for, 30, 'a robot at work again',
                after=len(self.fleet.messages))
            self.assertNotIn(FleetRobot.FAILED, self.states_since(begun))
        self.check_success(id)


if __name__ == '__main__':
    run_cases(__file__)
