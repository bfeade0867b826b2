#!/usr/bin/env python3
"""The controller drives a simulated robot to goals and poses, stops it, refuses wrong commands."""
from __future__ import annotations

import math
import os
import shutil
import subprocess
import tempfile
import threading
import unittest
from contextlib import contextmanager
from pathlib import Path
from typing import Iterator, List, Set

import actionlib
import rospy
from actionlib_msgs.msg import GoalID, GoalStatus, GoalStatusArray
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, PoseWithCovariance, PoseWithCovarianceStamped
from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal
from std_msgs.msg import String

from itrci_nav_msgs.msg import FleetRobot, FleetState
from omron_arcl import parse_line
from omron_arcl.replies import GoingToPoint, Location, OneLineStatus
from omron_ld90_msgs.msg import (
    CommandRefused,
    ExecuteCommandAction,
    ExecuteCommandActionGoal,
    ExecuteCommandActionResult,
    ExecuteCommandGoal,
    ExecuteCommandResult,
    LinkState,
)
from ports import free_port
from system_support import Recorder, connected_publisher, run_cases, wait_until

SOON = 10.0  # s
DRIVE = 60.0  # s; the simulated robot's clock is eight times as fast as real time


def pose_in_map(x: float, y: float, yaw: float, frame: str = 'map') -> PoseStamped:
    pose = PoseStamped()
    pose.header.frame_id = frame
    pose.pose.position.x, pose.pose.position.y = x, y
    pose.pose.orientation.z, pose.pose.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
    return pose


@contextmanager
def running(*command: str) -> Iterator[None]:
    """Runs a program of the workspace in the namespace /replayed, and ends it afterwards."""
    process = subprocess.Popen(['rosrun', *command],
                               env={**os.environ, 'ROS_NAMESPACE': '/replayed'})
    try:
        yield
    finally:
        process.terminate()
        process.wait(SOON)


class ControllerTest(unittest.TestCase):
    """All tests use the same robot and controller. At the end of each test the robot stands."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.responses = Recorder('/omron_ld90/arcl_response', String)
        cls.refusals = Recorder('/omron_ld90/command_refused', CommandRefused)
        cls.links = Recorder('/omron_ld90/link_state', LinkState)
        cls.diagnostics = Recorder('/diagnostics', DiagnosticArray)
        cls.commands = connected_publisher('/omron_ld90/send_command', String,
                                           to='omron_controller')
        # a queue for 10 messages could lose most of a burst
        rospy.set_param('actionlib_client_pub_queue_size', 200)
        cls.execute = actionlib.ActionClient('/omron_ld90/execute_command', ExecuteCommandAction)
        cls.move_base = actionlib.ActionClient('/omron_ld90/move_base', MoveBaseAction)
        for client in (cls.execute, cls.move_base):
            assert client.wait_for_server(rospy.Duration(30.0)), 'the controller has no actions'
        cls.links.wait_for(lambda link: link.state == LinkState.CONNECTED, 30.0, 'login')
        # The controller asks for the goals just after its login. While it asks, it refuses a goto.
        cls.diagnostics.wait_for(cls.goals_compared, 30.0, 'comparison of goals')

    @staticmethod
    def goals_compared(message: DiagnosticArray) -> bool:
        return any(status.name.endswith(': goals') and 'same' in status.message
                   for status in message.status)

    def run_command(self, text: str, timeout: float = 0.0) -> actionlib.ClientGoalHandle:
        return self.execute.send_goal(ExecuteCommandGoal(command=text, timeout=timeout))

    def result_of(self, handle: actionlib.ClientGoalHandle, within: float = DRIVE):
        wait_until(lambda: handle.get_comm_state() == actionlib.CommState.DONE, within,
                   'the end of the action')
        return handle.get_result()

    def wait_for_line(self, text: str, after: int, within: float = DRIVE) -> None:
        self.responses.wait_for(lambda line: line.data == text, within, f'line "{text}"', after)

    def location(self) -> Location:
        result = self.result_of(self.run_command('oneLineStatus'), SOON)
        status = parse_line(result.lines[0])
        assert isinstance(status, OneLineStatus)
        return status.location

    def test_a_command_on_the_topic_drives_the_robot_to_its_goal(self):
        before = len(self.responses.messages)
        self.commands.publish(String('goto 20'))
        self.wait_for_line('Going to 20', before)
        self.wait_for_line('Arrived at 20', before)

    def test_an_action_ends_when_the_robot_has_arrived(self):
        handle = self.run_command('goto 8')
        result = self.result_of(handle)
        self.assertEqual(ExecuteCommandResult.SUCCEEDED, result.outcome, result.message)
        self.assertEqual(GoalStatus.SUCCEEDED, handle.get_goal_status())
        self.assertEqual('Going to 8', [line for line in result.lines if 'Dock' not in line][0])
        self.assertEqual('Arrived at 8', result.lines[-1])

    def test_a_cancelled_action_stops_the_robot(self):
        before = len(self.responses.messages)
        self.result_of(self.run_command('goto 20'))
        handle = self.run_command('goto 8')
        self.wait_for_line('Going to 8', before)
        handle.cancel()
        result = self.result_of(handle, SOON)
        self.assertEqual(ExecuteCommandResult.CANCELLED, result.outcome, result.message)
        self.assertEqual(GoalStatus.PREEMPTED, handle.get_goal_status())
        self.wait_for_line('Stopped', before)
        self.assertEqual(self.location(), self.location(), 'the robot still moves')

    def test_a_cancellation_holds_back_no_later_stop_or_drive(self):
        """actionlib refuses a goal if its stamp is older than the last cancellation, and clients'
        clocks can differ.
        """
        cancels = connected_publisher('/omron_ld90/execute_command/cancel', GoalID,
                                      to='omron_controller')
        before = len(self.responses.messages)
        driving = self.run_command('goto 20')
        # a cancellation that arrives before its goal has no effect
        self.wait_for_line('Going to 20', before)
        cancels.publish(GoalID(stamp=rospy.Time.now() + rospy.Duration(3600)))
        self.assertEqual(self.result_of(driving).outcome, ExecuteCommandResult.CANCELLED)
        before = len(self.responses.messages)
        stop = self.run_command('stop')
        self.assertEqual(self.result_of(stop, SOON).message, 'Stopped')
        self.wait_for_line('Stopped', before, SOON)
        query = self.run_command('oneLineStatus')
        self.assertEqual(len(self.result_of(query, SOON).lines), 1)

    def test_a_storm_of_goals_and_cancels_leaves_nothing_hanging(self):
        # Uses topics, because actionlib's client can miss a result that comes while it cancels.
        results = Recorder('/omron_ld90/execute_command/result', ExecuteCommandActionResult)
        goals, cancels = (
            rospy.Publisher(f'/omron_ld90/execute_command/{name}', kind, queue_size=100)
            for name, kind in (('goal', ExecuteCommandActionGoal), ('cancel', GoalID)))
        wait_until(lambda: results.is_connected() and goals.get_num_connections()
                   and cancels.get_num_connections(), SOON, 'connections to the action')
        storm = [ExecuteCommandActionGoal(goal_id=GoalID(id=f'storm {i} {text}'),
                                          goal=ExecuteCommandGoal(command=text))
                 for i in range(25) for text in ('goto 8', 'odometer', 'getGoals', 'goto 20')]
        for goal in storm:
            goals.publish(goal)
        for goal in storm:
            cancels.publish(goal.goal_id)
        given = {goal.goal_id.id for goal in storm}
        wait_until(lambda: {result.status.goal_id.id for result in results.messages} >= given,
                   SOON, 'a result of every goal')
        answer = self.result_of(self.run_command('odometer'), SOON)
        self.assertEqual(ExecuteCommandResult.SUCCEEDED, answer.outcome, answer.message)
        stop = self.result_of(self.run_command('stop'), SOON)
        self.assertEqual(ExecuteCommandResult.SUCCEEDED, stop.outcome, stop.message)

    def test_many_clients_that_ask_at_once_are_all_answered(self):
        def ask(clients: actionlib.ActionClient) -> None:
            for _ in range(20):
                handle = clients.send_goal(ExecuteCommandGoal(command='odometer'))
                outcomes.append(self.result_of(handle, SOON).outcome)

        outcomes: List[int] = []
        threads = [threading.Thread(target=ask, args=(self.execute,)) for _ in range(8)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(DRIVE)
        self.assertEqual([ExecuteCommandResult.SUCCEEDED] * 160, outcomes)

    def test_a_newer_drive_interrupts_the_older_one_and_arrives(self):
        # for a moment after another client has stopped the robot, the controller does not drive
        def is_at_8() -> bool:
            return (self.result_of(self.run_command('goto 8')).outcome
                    == ExecuteCommandResult.SUCCEEDED)

        wait_until(is_at_8, DRIVE, 'the robot at 8')
        older = self.run_command('goto 20')
        newer = self.run_command('goto 8')
        self.assertEqual(ExecuteCommandResult.INTERRUPTED, self.result_of(older).outcome)
        self.assertEqual(ExecuteCommandResult.SUCCEEDED, self.result_of(newer).outcome)

    def test_queries_run_side_by_side_and_each_gets_its_own_answer(self):
        handles = [self.run_command(text) for text in ('getGoals', 'odometer', 'getGoals')]
        results = [self.result_of(handle, SOON) for handle in handles]
        self.assertEqual(results[0].lines, results[2].lines)
        self.assertEqual('End of goals', results[0].lines[-1])
        self.assertEqual(1, len(results[1].lines))

    def test_move_base_drives_to_the_pose(self):
        goal = MoveBaseGoal(target_pose=pose_in_map(1.0, 0.0, math.pi / 2))
        feedback = []
        handle = self.move_base.send_goal(
            goal, feedback_cb=lambda _, message: feedback.append(message))
        self.result_of(handle)
        self.assertEqual(GoalStatus.SUCCEEDED, handle.get_goal_status(),
                         handle.get_goal_status_text())
        location = self.location()
        self.assertLess(math.hypot(location.x - 1000.0, location.y), 100.0, location)
        self.assertLess(abs(location.heading - 90.0), 5.0, location)
        self.assertTrue(feedback, 'no feedback came')
        self.assertEqual('map', feedback[0].base_position.header.frame_id)

    def test_a_simple_goal_drives_and_the_wrong_frame_is_refused(self):
        publisher = connected_publisher('/omron_ld90/move_base_simple/goal', PoseStamped)
        before, refused = len(self.responses.messages), len(self.refusals.messages)
        publisher.publish(pose_in_map(0.0, 0.0, 0.0))
        self.responses.wait_for(lambda line: parse_line(line.data) == GoingToPoint(), SOON,
                                'drive to the point', before)
        publisher.publish(pose_in_map(0.0, 0.0, 0.0, frame='odom'))
        refusal = self.refusals.wait_for(lambda _: True, SOON, 'refusal', refused)
        self.assertIn('"odom"', refusal.reason)
        self.result_of(self.run_command('stop'))

    def test_rvizs_goal_and_pose_tools_are_refused_while_a_fleet_manager_drives_the_robot(self):
        fleet = connected_publisher('/fleet_state', FleetState, to='omron_controller')
        goals = connected_publisher('/omron_ld90/move_base_simple/goal', PoseStamped)
        poses = connected_publisher('/omron_ld90/initialpose', PoseWithCovarianceStamped)
        nowhere, here = pose_in_map(0.0, 0.0, 0.0, frame='odom'), pose_in_map(0.0, 0.0, 0.0)
        robot = FleetRobot(name='omron_ld90', state=FleetRobot.BUSY)
        said = len(self.responses.messages)

        def wait_for_refusal(command: str, words: str, robots: List[FleetRobot], told: int) -> None:
            """Sends a goal that moves nothing, to see which giver the controller assumes.

            told -- number of earlier refusals: the goal can arrive before /fleet_state
            """
            def is_refused() -> bool:
                fleet.publish(FleetState(robots=robots))  # the fleet manager repeats it, too
                goals.publish(nowhere)
                return any(refusal.command == command and words in refusal.reason
                           for refusal in self.refusals.messages[told:])
            wait_until(is_refused, SOON, f'refusal of {command} with the words {words}')

        wait_for_refusal('move_base_simple/goal', '"fleet out omron_ld90" first', [robot],
                         len(self.refusals.messages))
        told = len(self.refusals.messages)  # the pose may be refused at once
        goals.publish(here)
        poses.publish(PoseWithCovarianceStamped(here.header, PoseWithCovariance(pose=here.pose)))
        wait_for_refusal('initialpose', '"fleet out omron_ld90" first', [robot], told)
        wait_for_refusal('gotoPoint', '"odom"', [], len(self.refusals.messages))
        moved = [line.data for line in self.responses.messages[said:]
                 if line.data.startswith(('Going', 'Localized'))]
        self.assertEqual([], moved)
        goals.publish(here)
        self.responses.wait_for(lambda line: parse_line(line.data) == GoingToPoint(), SOON,
                                'drive once no fleet manages the robot', said)
        self.result_of(self.run_command('stop'))

    def test_a_simple_goal_is_a_new_goal_of_the_action(self):
        """Some clients, such as Open-RMF's adapter, wait for the goal in the action's status."""
        statuses = Recorder('/omron_ld90/move_base/status', GoalStatusArray)
        publisher = connected_publisher('/omron_ld90/move_base_simple/goal', PoseStamped)
        publisher.publish(pose_in_map(0.0, 0.0, 0.0))

        def ids_of(array: GoalStatusArray, status: int) -> Set[str]:
            return {goal.goal_id.id for goal in array.status_list
                    if goal.status == status and '-simple-' in goal.goal_id.id}
        active = statuses.wait_for(lambda array: ids_of(array, GoalStatus.ACTIVE), SOON, 'new goal')
        publisher.publish(pose_in_map(0.5, 0.0, 0.0))
        statuses.wait_for(lambda array: ids_of(array, GoalStatus.ACTIVE)
                          - ids_of(active, GoalStatus.ACTIVE), SOON, 'the goal after it')
        statuses.wait_for(lambda array: ids_of(array, GoalStatus.PREEMPTED)
                          & ids_of(active, GoalStatus.ACTIVE), SOON, 'end of the first')
        self.result_of(self.run_command('stop'))
        refused = len(self.refusals.messages)
        publisher.publish(pose_in_map(900.0, 0.0, 0.0))
        refusal = self.refusals.wait_for(lambda _: True, SOON, 'failure of the goal', refused)
        self.assertIn('Command \'gotoPoint 900000 0 0\'', refusal.reason)
        self.assertEqual(rospy.get_name(), refusal.caller)

    def test_what_was_published_before_a_controller_started_is_not_carried_out_late(self):
        commands = rospy.Publisher('/replayed/send_command', String, queue_size=1, latch=True)
        commands.publish('goto 8')
        refusals = Recorder('/replayed/command_refused', CommandRefused)
        links = Recorder('/replayed/link_state', LinkState)
        said = len(self.responses.messages)
        with self.second_controller():
            refusal = refusals.wait_for(lambda _: True, 30.0, 'refusal')
            self.assertIn('before this node started', refusal.reason)
            links.wait_for(lambda link: link.state == LinkState.CONNECTED, SOON, 'login')
            commands.publish('goto 20')  # the same publisher; the message is new
            self.wait_for_line('Going to 20', said, SOON)
        commands.unregister()
        self.assertNotIn('Going to 8', [line.data for line in self.responses.messages[said:]])
        self.result_of(self.run_command('stop'), SOON)

    def test_a_controller_that_ends_stops_the_robot_only_if_it_is_told_to(self):
        links = Recorder('/replayed/link_state', LinkState)
        for stops in (False, True):
            self.result_of(self.run_command('goto 8'))
            known, said = len(links.messages), len(self.responses.messages)
            with self.second_controller(f'_stop_on_shutdown:={stops}'):
                links.wait_for(lambda link: link.state == LinkState.CONNECTED, 30.0, 'login', known)
                handle = self.run_command('goto 20')
                self.wait_for_line('Going to 20', said)
            result = self.result_of(handle)
            expected = (ExecuteCommandResult.INTERRUPTED if stops
                        else ExecuteCommandResult.SUCCEEDED)
            self.assertEqual(expected, result.outcome, result.message)

    @contextmanager
    def second_controller(self, *parameters: str) -> Iterator[None]:
        """Runs a second controller of the same robot, in the namespace /replayed."""
        port = rospy.get_param('/omron_ld90/omron_controller/port')
        with running('omron_ld90', 'omron_controller', '_robot_ip:=127.0.0.1', f'_port:={port}',
                     '_password_file:=' + rospy.get_param('~password_file'), *parameters):
            yield

    def test_an_initial_pose_relocalises_the_robot(self):
        publisher = connected_publisher('/omron_ld90/initialpose', PoseWithCovarianceStamped)
        before = len(self.responses.messages)
        here = self.location()
        message = PoseWithCovarianceStamped()
        stamped = pose_in_map(here.x / 1000.0, here.y / 1000.0, math.radians(here.heading))
        message.header, message.pose.pose = stamped.header, stamped.pose
        publisher.publish(message)
        self.wait_for_line('Localized to point', before, SOON)

    def test_what_must_not_be_sent_is_refused_with_a_reason(self):
        for text, reason in (
                ('', 'empty'), ('goto 8\nshutdown', 'control character'), ('goto', 'goto <goal>'),
                ('shutdown', 'dangerous'), ('configStart', 'configuration'),
                ('goto nowhere', 'no goal "nowhere"'), ('x' * 6000, '6000'),
                ('queueModifyLocal a b c', 'refused by the robot: Unknown command queue')):
            before = len(self.refusals.messages)
            self.commands.publish(String(text))
            refusal = self.refusals.wait_for(lambda _: True, SOON, f'refusal of {text[:20]!r}',
                                             before)
            self.assertIn(reason, refusal.reason)
            self.assertEqual(rospy.get_name(), refusal.caller)
            self.assertLessEqual(len(refusal.command), 200)

    def test_a_refused_action_is_rejected_with_the_reason(self):
        handle = self.run_command('shutdown')
        result = self.result_of(handle, SOON)
        self.assertEqual(ExecuteCommandResult.REFUSED, result.outcome)
        self.assertEqual(GoalStatus.REJECTED, handle.get_goal_status())
        self.assertIn('dangerous', result.message)

    def test_the_session_log_holds_both_sides_and_no_password(self):
        self.result_of(self.run_command('odometer'), SOON)
        with open(rospy.get_param('~session_log'), encoding='ascii') as file:
            log = file.read()
        for piece in ('S> Enter password:', 'C> ********', 'C> odometer', 'S> Odometer: '):
            self.assertIn(piece, log)
        self.assertNotIn('adept', log)

    def test_a_replayed_session_log_stands_in_for_the_robot(self):
        self.result_of(self.run_command('odometer'), SOON)
        port = free_port()
        with tempfile.TemporaryDirectory() as folder:
            log = Path(folder) / 'session.log'
            shutil.copy(rospy.get_param('~session_log'), log)
            recorded = next(line.partition('S> ')[2] for line in log.read_text().splitlines()
                            if 'S> Odometer' in line)
            # At a heartbeat, the replay would skip to the next recorded heartbeat.
            with running('omron_ld90_sim', 'ld90_sim', '--replay', str(log), '--port', str(port)), \
                    running('omron_ld90', 'omron_controller', '_robot_ip:=127.0.0.1',
                            f'_port:={port}', '_heartbeat:=50', '_silence:=100',
                            '_password_file:=' + rospy.get_param('~password_file')):
                self.assert_replays(recorded)

    def assert_replays(self, odometer: str) -> None:
        links = Recorder('/replayed/link_state', LinkState)
        execute = actionlib.ActionClient('/replayed/execute_command', ExecuteCommandAction)
        self.assertTrue(execute.wait_for_server(rospy.Duration(30.0)), 'no second controller')
        links.wait_for(lambda link: link.state == LinkState.CONNECTED, SOON, 'login')
        result = self.result_of(execute.send_goal(ExecuteCommandGoal(command='odometer')), SOON)
        self.assertEqual([odometer], result.lines, result.message)


if __name__ == '__main__':
    rospy.init_node('controller_test')
    run_cases(__file__)
