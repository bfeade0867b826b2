#!/usr/bin/env python3
"""Clicks and handles: a hit is sent once. A miss, another map or a route under way sends nothing.
"""
from __future__ import annotations

import math
import subprocess
import threading
import unittest

import actionlib
import rospkg
import rospy
import tf2_ros
from geometry_msgs.msg import PointStamped, TransformStamped
from std_msgs.msg import String
from visualization_msgs.msg import InteractiveMarkerFeedback, InteractiveMarkerInit

from itrci_nav_msgs.msg import (
    EdgeState,
    ExecutionRouteStates,
    FleetRobot,
    FleetState,
    MissionRequest,
    MissionStatus,
)
from node_lifecycle.periodic import Periodic
from omron_ld90_msgs.msg import (
    CommandRefused,
    ExecuteCommandAction,
    ExecuteCommandFeedback,
    ExecuteCommandResult,
)
from omron_map import MapDocument
from system_support import Recorder, connected_publisher, run_cases, wait_until

LAB = rospkg.RosPack().get_path('omron_ld90') + '/../../maps/lab.map'


def click(x: float, y: float, frame: str = 'map') -> PointStamped:
    message = PointStamped()
    message.header.frame_id = frame
    message.header.stamp = rospy.Time.now()
    message.point.x, message.point.y = x, y
    return message


def route(route_id: int, *states: int) -> ExecutionRouteStates:
    return ExecutionRouteStates(route_id=route_id, edge_states=[
        EdgeState(edge_id=number, state=state) for number, state in enumerate(states, start=1)])


class ClickTest(unittest.TestCase):
    """Clicks in the form that RViz publishes, and the reactions of goal_sender."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.lab = MapDocument.load(LAB)
        cls.controller = FakeController('/omron_ld90')
        cls.feedback = Recorder('/omron_ld90/user_feedback', String)
        cls.handles = Recorder('/omron_ld90/interactive_goals/update_full', InteractiveMarkerInit)
        cls.clicks = connected_publisher('/omron_ld90/clicked_point', PointStamped)
        cls.events = connected_publisher('/omron_ld90/interactive_goals/feedback',
                                         InteractiveMarkerFeedback)
        cls.routes = connected_publisher('/omron_ld90/execution_route_states',
                                         ExecutionRouteStates, subscribers=2)
        cls.refusals = connected_publisher('/omron_ld90/command_refused', CommandRefused)
        wait_until(lambda: cls.handles.messages and len(cls.handles.messages[-1].markers) == 25,
                   30.0, 'a handle on each of the 24 goals and the dock')

    def setUp(self) -> None:
        self.routes.publish(route(1, EdgeState.COMPLETE))
        self.note_what_was()
        self.all_clicks_are_dealt_with()
        self.note_what_was()

    def note_what_was(self) -> None:
        self.commands_before = len(self.controller.commands)
        self.feedback_before = len(self.feedback.messages)

    def all_clicks_are_dealt_with(self) -> None:
        x, y = self.place('39')  # the goal furthest in the east, so the nearest one to the click
        far = 100.0 + len(self.feedback.messages)
        self.clicks.publish(click(x + far, y))
        self.told(f'{far:.2f} m away')

    def told(self, words: str) -> str:
        return self.feedback.wait_for(lambda text: words in text.data, 10.0, f'"{words}"',
                                      after=self.feedback_before).data

    def sent(self) -> list:
        return self.controller.commands[self.commands_before:]

    def place(self, name: str) -> tuple:
        goal = self.lab.find(name)
        return goal.x / 1000.0, goal.y / 1000.0

    def handle_event(self, event: int, near: str, menu_entry: int = 0) -> None:
        x, y = self.place(near)
        marker = next(marker for marker in self.handles.messages[-1].markers
                      if math.hypot(marker.pose.position.x - x, marker.pose.position.y - y) < 0.01)
        self.events.publish(InteractiveMarkerFeedback(
            client_id='test', marker_name=marker.name, control_name='button', event_type=event,
            menu_entry_id=menu_entry))

    def test_a_click_near_a_goal_sends_the_robot_there_once(self):
        x, y = self.place('12')
        self.clicks.publish(click(x + 0.3, y - 0.3))
        self.told('Arrived at 12')
        self.all_clicks_are_dealt_with()
        self.assertEqual(['goto 12'], self.sent())

    def test_a_click_on_the_dock_docks(self):
        self.clicks.publish(click(*self.place('16')))
        self.told('dock done')
        self.assertEqual(['dock'], self.sent())

    def test_a_click_on_nothing_does_nothing_and_names_the_nearest(self):
        x, y = self.place('12')
        self.clicks.publish(click(x + 0.6, y))
        self.assertIn('goal 12 is the nearest, 0.60 m away', self.told('Nothing within 0.50 m'))
        self.assertEqual([], self.sent())

    def test_a_click_in_another_frame_is_transformed(self):
        turned = TransformStamped(child_frame_id='camera')
        turned.header.frame_id = 'map'
        turned.header.stamp = rospy.Time.now()
        turned.transform.translation.x, turned.transform.translation.y = self.place('33')
        turned.transform.rotation.z = turned.transform.rotation.w = math.sqrt(0.5)
        broadcaster = tf2_ros.StaticTransformBroadcaster()
        broadcaster.sendTransform(turned)
        wait_until(broadcaster.pub_tf.get_num_connections, 10.0, 'goal_sender hears /tf_static')
        x, y = self.place('32')
        dx, dy = x - turned.transform.translation.x, y - turned.transform.translation.y

        def goes_there() -> bool:
            heard = len(self.feedback.messages)
            self.clicks.publish(click(dy, -dx, 'camera'))
            answer = self.feedback.wait_for(
                lambda text: 'no transform' in text.data or 'Arrived at 32' in text.data,
                10.0, 'the answer to the click', after=heard)
            return 'Arrived' in answer.data
        wait_until(goes_there, 20.0, 'a drive to 32')
        self.assertEqual(['goto 32'], self.sent())

    def test_a_click_in_an_unknown_frame_does_nothing(self):
        self.clicks.publish(click(*self.place('12'), frame='nowhere'))
        self.told('nowhere has no transform to map')
        self.assertEqual([], self.sent())

    def test_one_click_on_a_handle_goes_once_though_rviz_sends_several_events(self):
        def handle_is_ready() -> bool:  # the marker server ignores a handle during its first second
            self.handle_event(InteractiveMarkerFeedback.MENU_SELECT, near='24', menu_entry=2)
            return 'stop' in self.sent()
        wait_until(handle_is_ready, 10.0, 'stop')
        for event in (InteractiveMarkerFeedback.MOUSE_DOWN, InteractiveMarkerFeedback.BUTTON_CLICK,
                      InteractiveMarkerFeedback.MOUSE_UP):
            self.handle_event(event, near='24')
        wait_until(lambda: 'goto 24' in self.sent(), 10.0, 'the drive')
        self.handle_event(InteractiveMarkerFeedback.MENU_SELECT, near='24', menu_entry=2)
        wait_until(lambda: self.sent()[-1] == 'stop', 10.0, 'the stop after the drive')
        self.assertEqual(1, self.sent().count('goto 24'), self.sent())

    def test_the_menu_of_a_handle_relocalises_and_stops(self):
        self.handle_event(InteractiveMarkerFeedback.MENU_SELECT, near='16', menu_entry=4)
        self.told('Does the robot stand at')
        self.assertEqual([], self.sent())
        self.handle_event(InteractiveMarkerFeedback.MENU_SELECT, near='16', menu_entry=4)
        self.told('localizeToPoint')
        self.handle_event(InteractiveMarkerFeedback.MENU_SELECT, near='16', menu_entry=3)
        self.told('stop done')
        dock = self.lab.find('16')
        heading = round(dock.theta)
        self.assertEqual([f'localizeToPoint {dock.x:.0f} {dock.y:.0f} {heading}', 'stop'],
                         self.sent())

    def test_while_a_fleet_route_runs_a_click_is_refused_but_stop_is_not(self):
        self.routes.publish(route(7, EdgeState.COMPLETE, EdgeState.PROCESSING))

        def refused() -> bool:
            self.clicks.publish(click(*self.place('12')))
            return any('the fleet drives route 7' in text.data
                       for text in self.feedback.messages[self.feedback_before:])
        wait_until(refused, 20.0, 'a refusal')
        self.note_what_was()
        self.handle_event(InteractiveMarkerFeedback.MENU_SELECT, near='12', menu_entry=2)
        wait_until(lambda: 'stop' in self.sent(), 10.0, 'stop')

    def test_with_allow_takeover_a_click_is_sent_while_a_route_runs(self):
        controller = FakeController('/taker')
        clicks = connected_publisher('/taker/clicked_point', PointStamped)
        self.routes.publish(route(7, EdgeState.PROCESSING))

        def taken() -> bool:
            self.routes.publish(route(7, EdgeState.PROCESSING))
            clicks.publish(click(*self.place('12')))
            return bool(controller.commands)
        wait_until(taken, 10.0, 'goto 12')
        self.assertEqual('goto 12', controller.commands[0])

    def test_a_click_on_a_managed_robot_becomes_a_mission_and_any_other_is_refused(self):
        fleet = connected_publisher('/fleet_state', FleetState, subscribers=3)
        requests = Recorder('/mission_request', MissionRequest)
        statuses = connected_publisher('/mission_status', MissionStatus, subscribers=3)
        manager = FleetManager(fleet)
        try:
            manager.state = FleetRobot.IDLE
            wait_until(lambda: self.localize_is_answered('Not sent: the fleet manager drives'),
                       20.0, 'a refusal')
            self.assertIn('mission VERTEX --robot omron_ld90', self.feedback.messages[-1].data)
            self.note_what_was()

            def mission() -> bool:
                self.clicks.publish(click(*self.place('12')))
                return bool(requests.messages)
            wait_until(mission, 20.0, 'a mission')
            request = requests.messages[-1]
            self.assertEqual(('omron_ld90', (12,)),
                             (request.robot, tuple(request.destination_vertices_id)))
            statuses.publish(MissionStatus(request_id=request.request_id, reason='no way',
                                           state=MissionStatus.REFUSED))
            self.told(f'Mission {request.request_id} was refused: no way')
            self.assertEqual([], self.sent())

            manager.state = FleetRobot.OUT_OF_SERVICE  # the robot waits for a person
            wait_until(lambda: self.localize_is_answered('localizeToPoint'), 20.0, 'a command')
            wait_until(lambda: any(text.startswith('localizeToPoint') for text in self.sent()),
                       20.0, 'the command at the robot')
        finally:
            manager.end()

    def localize_is_answered(self, words: str) -> bool:
        """Tells the robot that it is at the dock. Returns whether an answer has these words."""
        heard = len(self.feedback.messages)
        for _ in range(2):  # after the first event, the node only asks whether the robot is there
            self.handle_event(InteractiveMarkerFeedback.MENU_SELECT, near='16', menu_entry=4)
        try:
            answer = self.feedback.wait_for(
                lambda text: 'Not sent' in text.data or 'localizeToPoint' in text.data, 4.0,
                'the result', after=heard)
        except AssertionError:
            return False  # the caller tries again
        return words in answer.data

    def test_what_becomes_of_a_command_is_told_in_the_robots_words(self):
        self.controller.answers['goto 35'] = (ExecuteCommandResult.FAILED, 'No goal 35')
        self.clicks.publish(click(*self.place('35')))
        self.told('goto 35 failed: No goal 35')
        # otherwise the message that the drive ends can come before the message that it starts
        self.controller.answers['goto 41'] = None
        self.clicks.publish(click(*self.place('41')))
        self.told('Going to 41')
        self.controller.end_all()
        self.told('Arrived at 41')
        self.refusals.publish(CommandRefused(command='goto 12', reason='No connection.'))
        self.assertEqual('goto 12 refused: No connection.', self.told('refused:'))

    def test_a_goal_that_is_being_driven_to_is_not_given_again(self):
        self.controller.answers['goto 6'] = None
        for _ in range(20):
            self.clicks.publish(click(*self.place('6')))
        self.told('goto 6: already under way')
        self.all_clicks_are_dealt_with()
        self.assertEqual(['goto 6'], self.sent())
        self.controller.end_all()
        self.told('Arrived at 6')

    def test_without_a_controller_the_person_is_told_so(self):
        clicks = connected_publisher('/orphan/clicked_point', PointStamped)
        feedback = Recorder('/orphan/user_feedback', String)

        def told() -> bool:
            clicks.publish(click(*self.place('12')))
            return any('was not sent: omron_controller is not running' in text.data
                       for text in feedback.messages)
        wait_until(told, 10.0, 'the message that the controller is not running')


class FleetManager:
    """Reports twice a second that it manages the robots; a test can change their state."""

    def __init__(self, publisher: rospy.Publisher) -> None:
        self.state = FleetRobot.OUT_OF_SERVICE
        self._publisher = publisher
        self._lock = threading.Lock()
        self._manages = True
        self._periodic = Periodic('fleet state', 0.5, self._publish)
        self._listener = subprocess.Popen(  # goal_sender sends only if path_supervisor listens
            ['rostopic', 'echo', '/mission_request', '__name:=path_supervisor'],
            stdout=subprocess.DEVNULL)

    def end(self) -> None:
        """Makes the fleet manager report that it manages no robot."""
        self._periodic.shutdown()
        with self._lock:
            self._manages = False
            self._publisher.publish(FleetState())
        self._listener.terminate()
        self._listener.wait(20)

    def _publish(self) -> None:
        with self._lock:
            if self._manages:
                self._publisher.publish(FleetState(
                    robots=[FleetRobot(name='omron_ld90', state=self.state)]))


class FakeController:
    """The action `execute_command` in a namespace. It drives at once, or answers with `answers`."""

    def __init__(self, namespace: str) -> None:
        self.commands = []
        # for each command: outcome and message; None: it continues until `end_all`
        self.answers = {}
        self._open = []
        self._server = actionlib.ActionServer(
            f'{namespace}/execute_command', ExecuteCommandAction, self._on_goal,
            lambda handle: None, auto_start=False)
        self._server.start()

    def end_all(self) -> None:
        for handle in self._open:
            self._succeed(handle)
        self._open.clear()

    def _on_goal(self, handle: actionlib.ServerGoalHandle) -> None:
        command = handle.get_goal().command
        self.commands.append(command)
        handle.set_accepted()
        answer = self.answers.get(command, ())
        if answer:
            handle.set_aborted(ExecuteCommandResult(outcome=answer[0], message=answer[1]))
            return
        if answer is None:
            self._open.append(handle)
        if command.startswith('goto'):
            handle.publish_feedback(ExecuteCommandFeedback(line=f'Going to {command.split()[-1]}'))
        if answer is not None:
            self._succeed(handle)

    @staticmethod
    def _succeed(handle: actionlib.ServerGoalHandle) -> None:
        name, *arguments = handle.get_goal().command.split()
        words = f'Arrived at {arguments[0]}' if name == 'goto' else f'{name} done'
        handle.set_succeeded(ExecuteCommandResult(outcome=ExecuteCommandResult.SUCCEEDED,
                                                  message=words))


if __name__ == '__main__':
    rospy.init_node('click_test')
    run_cases(__file__)
