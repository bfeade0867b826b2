#!/usr/bin/env python3
"""Reboot, emergency stop, second client and wrong map: each has its own outcome and message."""
from __future__ import annotations

import contextlib
import math
import os
import subprocess
import unittest
from typing import Iterator

import actionlib
import rosgraph
import rospy
from actionlib_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal
from std_msgs.msg import String

from omron_ld90_msgs.msg import (
    CommandRefused,
    ExecuteCommandAction,
    ExecuteCommandFeedback,
    ExecuteCommandGoal,
    ExecuteCommandResult,
    LinkState,
    RobotStatus,
)
from omron_ld90_sim import Simulator
from ports import free_port
from system_support import Recorder, connected_publisher, run_cases, wait_until

SOON = 15.0  # s
ENDED = 40.0  # s; roscore waits 15 s for the end of rosout, then kills rosout
DRIVE = 60.0  # s; the simulated robot's clock is four times as fast as real time


@contextlib.contextmanager
def program(*command: str, stderr: int = subprocess.DEVNULL,
            **environment: str) -> Iterator[subprocess.Popen]:
    """Runs a program during the `with` block."""
    process = subprocess.Popen(command, env={**os.environ, **environment},
                               stdout=subprocess.DEVNULL, stderr=stderr)
    try:
        yield process
    finally:
        process.terminate()
        process.wait(ENDED)


class ArclFaultsTest(unittest.TestCase):
    """All tests use the same robot."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.links = Recorder('/omron_ld90/link_state', LinkState)
        cls.responses = Recorder('/omron_ld90/arcl_response', String)
        cls.refusals = Recorder('/omron_ld90/command_refused', CommandRefused)
        cls.statuses = Recorder('/omron_ld90/robot_status', RobotStatus)
        cls.diagnostics = Recorder('/diagnostics', DiagnosticArray)
        cls.commands = connected_publisher('/omron_ld90/send_command', String)
        cls.execute = actionlib.ActionClient('/omron_ld90/execute_command', ExecuteCommandAction)
        cls.move_base = actionlib.ActionClient('/omron_ld90/move_base', MoveBaseAction)
        for client in (cls.execute, cls.move_base):
            assert client.wait_for_server(rospy.Duration(30.0)), 'the controller has no actions'
        # The nodes start before the robot.
        cls.wait_for_link(LinkState.COMMANDS, LinkState.DISCONNECTED, 0)
        cls.robot = Simulator(rospy.get_param('~map_file'), rospy.get_param('~port'), speed=4.0,
                              outgoing=('127.0.0.1', rospy.get_param('~outgoing_port')))
        cls.robot.start()
        cls.wait_for_link(LinkState.COMMANDS, LinkState.CONNECTED, 0)
        cls.wait_for_link(LinkState.OUTGOING, LinkState.CONNECTED, 0)

    @classmethod
    def tearDownClass(cls) -> None:
        cls.robot.stop()

    @classmethod
    def wait_for_link(cls, link: str, state: int, after: int) -> LinkState:
        return cls.links.wait_for(lambda m: (m.link, m.state) == (link, state), SOON,
                                  f'state {state} of link {link}', after)

    def wait_for_diagnostic(self, name: str, level: int, words: str, after: int) -> None:
        self.diagnostics.wait_for(lambda array: any(
            status.name.endswith(f': {name}') and status.level == level and words in status.message
            for status in array.status), SOON, f'"{words}" of {name}', after)

    def drive(self, goal: str) -> actionlib.ClientGoalHandle:
        """Begins a drive, and returns its handle when the robot drives."""
        before = len(self.responses.messages)
        handles = []

        # for a moment after another client's command, the controller refuses drives
        def has_begun() -> bool:
            if not handles or handles[-1].get_goal_status() == GoalStatus.REJECTED:
                handles.append(self.execute.send_goal(ExecuteCommandGoal(command=f'goto {goal}')))
            return any(line.data == f'Going to {goal}'
                       for line in self.responses.messages[before:])

        wait_until(has_begun, DRIVE, 'the drive')
        return handles[-1]

    def ended(self, handle: actionlib.ClientGoalHandle):
        wait_until(lambda: handle.get_comm_state() == actionlib.CommState.DONE, DRIVE,
                   'the end of the action')
        return handle.get_result()

    def test_a_reboot_in_the_middle_of_a_drive(self):
        handle = self.drive('20')
        before = len(self.links.messages)
        self.robot.inject('reboot 8')
        self.assertEqual(ExecuteCommandResult.LOST, self.ended(handle).outcome)
        self.assertEqual(GoalStatus.ABORTED, handle.get_goal_status())
        self.assertIn('lost', handle.get_goal_status_text())
        lost = self.wait_for_link(LinkState.COMMANDS, LinkState.DISCONNECTED, before)
        self.assertTrue(lost.reason)
        self.wait_for_link(LinkState.OUTGOING, LinkState.DISCONNECTED, before)
        self.wait_for_link(LinkState.COMMANDS, LinkState.CONNECTED, before)
        self.wait_for_link(LinkState.OUTGOING, LinkState.CONNECTED, before)
        said = len(self.responses.messages)
        self.ended(self.execute.send_goal(ExecuteCommandGoal(command='odometer')))
        self.assertFalse([line.data for line in self.responses.messages[said:]
                          if line.data.startswith('Going')], 'the drive was sent again')

    def test_an_emergency_stop(self):
        handle = self.drive('20')
        before = len(self.diagnostics.messages)
        self.robot.inject('estop press')
        result = self.ended(handle)
        self.assertEqual(ExecuteCommandResult.EMERGENCY_STOPPED, result.outcome)
        self.assertIn('estop', result.message.lower())
        self.statuses.wait_for(lambda status: status.emergency_stop, SOON, 'emergency stop')
        self.wait_for_diagnostic('robot', DiagnosticStatus.ERROR, 'emergency stop', before)
        self.robot.inject('estop release')
        self.ended(self.execute.send_goal(ExecuteCommandGoal(command='enableMotors')))
        before = len(self.diagnostics.messages)
        self.wait_for_diagnostic('robot', DiagnosticStatus.OK, '', before)

    def test_a_stop_that_was_not_ours_interrupts(self):
        handle = self.drive('20')
        self.robot.inject('other stop')
        result = self.ended(handle)
        self.assertEqual(ExecuteCommandResult.INTERRUPTED, result.outcome)
        self.assertEqual(GoalStatus.PREEMPTED, handle.get_goal_status())

    def test_a_stop_that_another_clients_drive_overtakes_ends_at_once_and_is_no_success(self):
        driving = self.drive('8')
        x, y, _ = self.robot.pose
        wait_until(lambda: math.hypot(self.robot.pose[0] - x, self.robot.pose[1] - y) > 500.0,
                   DRIVE, 'half a metre')

        def overtake(_: actionlib.ClientGoalHandle, feedback: ExecuteCommandFeedback) -> None:
            if feedback.line == 'Stopping':  # the robot brakes
                self.robot.inject('other goto 20')

        result = self.ended(self.execute.send_goal(ExecuteCommandGoal(command='stop'),
                                                   feedback_cb=overtake))
        self.assertEqual(ExecuteCommandResult.INTERRUPTED, result.outcome, result.message)
        self.assertEqual('taken over: Going to 20', result.message)
        self.assertEqual('Interrupted: Going to 8', self.ended(driving).message)
        self.ended(self.execute.send_goal(ExecuteCommandGoal(command='stop')))

    def test_a_pose_that_cannot_be_reached_aborts_with_the_robots_words(self):
        goal = MoveBaseGoal()
        goal.target_pose.header.frame_id = 'map'
        goal.target_pose.pose.position.x = 900.0
        goal.target_pose.pose.orientation.w = 1.0
        handle = self.move_base.send_goal(goal)
        self.ended(handle)
        self.assertEqual(GoalStatus.ABORTED, handle.get_goal_status())
        self.assertTrue(handle.get_goal_status_text())

    def test_a_node_waits_for_its_master_and_registers_anew_with_one_that_was_restarted(self):
        """Starts a ROS master twice, and looks only at two of the node's registrations."""
        port = free_port()
        uri = f'http://127.0.0.1:{port}'
        master = rosgraph.Master('/arcl_faults_test', master_uri=uri)

        def is_known() -> bool:
            with contextlib.suppress(OSError):
                published, subscribed, _ = master.getSystemState()
                return (['/robot_status', ['/omron_connection_receiver']] in published
                        and ['/link_state', ['/omron_connection_receiver']] in published)
            return False

        with program('rosrun', 'omron_ld90', 'omron_connection_receiver', '_robot_ip:=127.0.0.1',
                     f'_port:={free_port()}', stderr=subprocess.PIPE, ROS_MASTER_URI=uri) as node:
            self.assertIn(f'There is no ROS master at {uri} yet', node.stderr.readline().decode())
            for what in ('the node registers', 'the node registers with the new master'):
                with program('roscore', '-p', str(port), ROS_MASTER_URI=uri):
                    wait_until(is_known, DRIVE, what)
                self.assertFalse(is_known())

    def test_a_node_with_a_wrong_configuration_says_so_on_its_link(self):
        links = Recorder('/misconfigured/link_state', LinkState)
        for name in (LinkState.COMMANDS, LinkState.OUTGOING):
            link = links.wait_for(lambda m, name=name: m.link == name, SOON, f'link {name}')
            self.assertEqual(LinkState.MISCONFIGURED, link.state)
            self.assertIn('robot_ip is missing', link.reason)

    def test_goals_that_robot_and_map_file_do_not_share_are_named_and_refused(self):
        self.wait_for_diagnostic('goals', DiagnosticStatus.WARN, 'only the robot has', 0)
        before = len(self.refusals.messages)
        self.commands.publish(String('goto reception'))
        refusal = self.refusals.wait_for(lambda _: True, SOON, 'refusal', before)
        self.assertIn('no goal "reception"', refusal.reason)


if __name__ == '__main__':
    rospy.init_node('arcl_faults_test')
    run_cases(__file__)
