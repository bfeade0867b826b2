#!/usr/bin/env python3
"""The dissertation's main example, as a user drives it: at the end the LD-90 is docked at 16."""
from __future__ import annotations

import re
import subprocess
import unittest
from typing import List

import rospkg
import rospy
from geometry_msgs.msg import Point, PointStamped
from std_msgs.msg import Header, String

from itrci_nav_msgs.msg import (
    EdgeState,
    ExecutionRouteStates,
    FleetRobot,
    FleetState,
    MissionStatus,
    TargetRoute,
)
from omron_ld90_msgs.msg import RobotStatus
from omron_map import MapDocument
from system_support import (
    CommandRecorder,
    Recorder,
    connected_publisher,
    kill_node,
    run_cases,
    wait_until,
)

LAB = rospkg.RosPack().get_path('omron_ld90') + '/../../maps/lab.map'
DESTINATIONS = [18, 39, 52, 6, 16]
TYPE = 'omron_ld90'


def command(*words: object, timeout: float = 100.0) -> subprocess.CompletedProcess:
    """Runs the words that a user types after `rosrun graph_fleet_manager`."""
    return subprocess.run(['rosrun', 'graph_fleet_manager', *map(str, words)], text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=timeout,
                          check=False)


class FleetMission(unittest.TestCase):

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node('fleet_mission_test')
        cls.reports = Recorder('/omron_ld90/execution_route_states', ExecutionRouteStates)
        cls.routes = Recorder('/omron_ld90/target_route', TargetRoute)
        cls.status = Recorder('/omron_ld90/robot_status', RobotStatus)
        cls.statuses = Recorder('/mission_status', MissionStatus)
        cls.fleet = Recorder('/fleet_state', FleetState)
        cls.commands = CommandRecorder('omron_ld90')
        cls.lines = Recorder('/omron_ld90/arcl_response', String)
        cls.fleet.wait_for(lambda state: state.robots and state.robots[0].seen
                           and state.robots[0].pose.edge_id, 60, 'robot on the graph')

    def test_1_the_mission_ends_docked_with_every_edge_complete(self) -> None:
        begin = len(self.reports.messages)
        done = command('mission', *DESTINATIONS, '--type', TYPE, '--wait')
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertIn('has succeeded', done.stdout)
        self.assertRegex(done.stdout, r'omron_ld90 to 39 \(2 of 5\)')
        last = self.reports.messages[-1]
        self.assertEqual([edge.state for edge in last.edge_states],
                         [EdgeState.COMPLETE] * len(last.edge_states), last.reason)
        # edge 1 - 16, with the dock, in lab_graph.yaml
        self.assertEqual(last.edge_states[-1].edge_id, 13)
        self.assertEqual(self.status.messages[-1].docking_state, 'Docked')
        failed = [report for report in self.reports.messages[begin:]
                  if any(edge.state == EdgeState.FAILED for edge in report.edge_states)]
        self.assertEqual(failed, [])
        self.check_no_order_was_taken_back(self.routes.messages)
        self.assertEqual(self.commands.texts.count('dock'), 1, self.commands.texts)

    def check_no_order_was_taken_back(self, routes: List[TargetRoute]) -> None:
        """Checks that a route with one id only becomes longer. Driven edges are left out."""
        for before, after in zip(routes, routes[1:]):
            if before.route_id == after.route_id:
                kept = before.edges[after.first - before.first:]
                self.assertEqual(after.edges[:len(kept)], kept)

    def test_2_a_bad_mission_is_refused_in_a_sentence(self) -> None:
        refused = command('mission', 99)
        self.assertEqual(refused.returncode, 2, refused.stdout)
        self.assertIn('the graph has no vertex 99', refused.stdout)

    def test_3_stop_and_resume_from_the_command_line(self) -> None:
        sent = command('mission', 18)
        mission = re.search(r'Mission (\d+)', sent.stdout).group(1)
        self.wait_until_on_its_way()
        self.assertEqual(command('fleet', 'stop').returncode, 0)
        wait_until(lambda: self.commands.texts[-1] == 'stop', 10, 'a stop to the robot')
        self.fleet.wait_for(lambda state: 'stopped' in state.robots[0].waits_for, 10, 'stop',
                            after=len(self.fleet.messages))
        resumed = command('fleet', 'resume')
        self.assertEqual(resumed.returncode, 0, resumed.stdout)
        self.fleet.wait_for(lambda state: not state.robots[0].has_mission, 120, 'end of mission',
                            after=len(self.fleet.messages))
        history = command('mission', 'history', '--csv', '--journal', rospy.get_param(
            '/path_supervisor/journal'))
        self.assertIn(f'{mission},18,,0,SUCCEEDED,omron_ld90', history.stdout)

    def wait_until_on_its_way(self) -> None:
        """Waits until the robot has passed an edge of its route, and is not in its dock."""
        self.reports.wait_for(lambda report: any(
            edge.state == EdgeState.COMPLETE for edge in report.edge_states)
            and any(edge.state == EdgeState.PROCESSING for edge in report.edge_states)
            and report.symbolic_pose.edge_id not in (0, 13), 60, 'robot on its way',
            after=len(self.reports.messages))

    def test_4_killed_nodes_lose_no_mission_and_repeat_no_motion(self) -> None:
        given = len(self.commands.texts)
        sent = subprocess.Popen(['rosrun', 'graph_fleet_manager', 'mission', '39', '6', '18',
                                 '--wait'], text=True, stdout=subprocess.PIPE,
                                stderr=subprocess.STDOUT)
        for reached, node in enumerate(('/path_supervisor', '/path_planner', '/graph_server')):
            self.statuses.wait_for(lambda status, count=reached: status.state == status.ACTIVE
                                   and status.destinations_reached == min(count, 2)
                                   and status.request_id != 0, 100, f'{reached} reached',
                                   after=max(len(self.statuses.messages) - 1, 0))
            kill_node(node)
        output, _ = sent.communicate(timeout=150)
        self.assertEqual(sent.returncode, 0, output)
        drives = [text for text in self.commands.texts[given:] if text.startswith('goto')]
        repeated = [one for one, other in zip(drives, drives[1:]) if one == other]
        self.assertEqual(repeated, [], drives)

    def test_5_a_click_takes_the_robot_over_and_fleet_in_gives_it_back(self) -> None:
        click = connected_publisher('/clicked_point', PointStamped, to='goal_sender')
        goal = next(goal for goal in MapDocument.load(LAB).goals if goal.name == '39')
        sent = command('mission', 52)
        mission = int(re.search(r'Mission (\d+)', sent.stdout).group(1))
        self.wait_until_on_its_way()
        said = len(self.lines.messages)
        click.publish(Header(frame_id='map'), Point(goal.x / 1000.0, goal.y / 1000.0, 0.0))
        taken = self.fleet.wait_for(lambda state: state.robots[0].state == FleetRobot.TAKEN_OVER,
                                    30, 'robot taken over', after=len(self.fleet.messages))
        self.assertIn('taken over', taken.robots[0].waits_for)
        self.lines.wait_for(lambda line: line.data == 'Arrived at 39', 60, 'end of the drive to 39',
                            after=said)
        lines = [line.data for line in self.lines.messages[said:]]
        after = lines[lines.index('Going to 39') + 1:lines.index('Arrived at 39')]
        # A goal of the bridge may come before the person's goal, but none may come after it.
        self.assertEqual([], [line for line in after if line.startswith('Going to')], lines)
        wait_until(lambda: command('fleet', 'in', 'omron_ld90').returncode == 0, 30, 'fleet in')
        end = self.statuses.wait_for(
            lambda status: status.request_id == mission and status.state not in (
                MissionStatus.PENDING, MissionStatus.ACTIVE), 120, 'end of the mission')
        self.assertEqual(MissionStatus.SUCCEEDED, end.state, end.reason)


if __name__ == '__main__':
    run_cases(__file__)
