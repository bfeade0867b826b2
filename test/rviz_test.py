#!/usr/bin/env python3
"""What a person does in RViz with the mouse ends in what the robot does; and what is to be seen."""
from __future__ import annotations

import math
import os
import unittest

import rospkg
import rospy
import rostest
from geometry_msgs.msg import PointStamped, PoseStamped
from rviz_support import RvizWindow, Screen, count_near, missing_programs, report_failure
from std_msgs.msg import String
from visualization_msgs.msg import MarkerArray

from itrci_nav_msgs.msg import TargetRoute
from omron_ld90.maps import MapDocument
from omron_ld90_msgs.msg import RobotStatus
from omron_ld90_sim import Simulator
from system_support import Recorder, connected_publisher, skip, wait_until
from trajectory_graph import load_graph

LAB = rospkg.RosPack().get_path('omron_ld90') + '/../../maps/lab.map'
SCALE = 40.0  # pixels per metre in rviz/omron_ld90.rviz
MIDDLE = (640, 466)  # of the 3D view: nothing of the lab is there
SPEED = 4.0
STOP_ENTRY = 3  # of a goal's menu
ROUTE = (-13, 8, 9, 3)  # from the dock to vertex 14
START = (-8000.0, 0.0, 0.0)  # at goal 10

GREEN, RED, YELLOW = (20, 175, 50), (215, 20, 20), (245, 208, 40)
VIOLET, LIGHT_BLUE, WHITE, BLUE = (185, 170, 250), (90, 190, 255), (255, 255, 255), (75, 150, 250)
ORANGE, DEEP_ORANGE = (146, 108, 52), (190, 121, 31)  # one area; two on each other
DONE_GREEN = (62, 185, 90)
FAILURE = (255, 97, 77)


def orange_near(picture, pixel: tuple) -> int:
    """Pixels next to `pixel` of any of the oranges that areas make where they lie on each other."""
    return count_near(picture, pixel, ORANGE, 1) + count_near(picture, pixel, DEEP_ORANGE, 1)


class RvizTest(unittest.TestCase):
    """One RViz and one simulated robot; each test leaves the robot idle."""

    screen = window = simulator = None

    @classmethod
    def setUpClass(cls) -> None:
        cls.missing = missing_programs()
        if not cls.missing:
            report_failure(cls.set_up)

    @classmethod
    def set_up(cls) -> None:
        cls.lab = MapDocument.load(LAB)
        cls.graph = load_graph(LAB.replace('lab.map', 'lab_graph.yaml'))
        cls.start_robot()
        cls.artefacts = os.environ.get('SYSTEM_TEST_ARTEFACTS', '/tmp')
        cls.lines = Recorder('/omron_ld90/arcl_response', String)
        cls.commands = Recorder('/omron_ld90/send_command', String)
        cls.clicks = Recorder('/clicked_point', PointStamped)
        cls.feedback = Recorder('/omron_ld90/user_feedback', String)
        cls.names = Recorder('/omron_ld90/map_markers/goal_names', MarkerArray)
        cls.poses = Recorder('/omron_ld90/pose', PoseStamped)
        cls.status = Recorder('/omron_ld90/robot_status', RobotStatus)
        cls.routes = connected_publisher('/omron_ld90/target_route', TargetRoute)
        cls.screen = Screen()
        cls.window = RvizWindow(cls.screen, cls.artefacts, SCALE)
        cls.poses.wait_for(lambda pose: True, 30.0, 'pose')
        cls.calibrate_by_a_click_on_nothing()

    @classmethod
    def start_robot(cls) -> None:
        cls.simulator = Simulator(
            LAB, port=int(os.environ.get('LD90_ARCL_PORT', 17171)), speed=SPEED, start=START,
            outgoing=('127.0.0.1', int(os.environ.get('LD90_OUTGOING_PORT', 17179))))
        cls.simulator.start()

    @classmethod
    def calibrate_by_a_click_on_nothing(cls) -> None:
        """Where a click lands on the map tells where the map is on the screen."""
        def landed() -> bool:
            cls.window.tool('c')
            cls.window.click(MIDDLE)
            return bool(cls.clicks.messages)
        wait_until(landed, 60.0, 'a click of Publish Point lands on the map')
        point = cls.clicks.messages[0].point
        cls.window.calibrate(MIDDLE, (point.x, point.y))

    @classmethod
    def tearDownClass(cls) -> None:
        for part, end in ((cls.window, 'close'), (cls.screen, 'close'), (cls.simulator, 'stop')):
            if part is not None:
                getattr(part, end)()

    def setUp(self) -> None:
        if self.missing:
            skip(self, f'not installed: {", ".join(self.missing)}')
        self.before = {recorder: len(recorder.messages) for recorder in
                       (self.lines, self.commands, self.feedback, self.status)}

    def place(self, name: str) -> tuple:
        goal = self.lab.find(name)
        return goal.x / 1000.0, goal.y / 1000.0

    def at(self, name: str) -> tuple:
        return self.window.pixel(*self.place(name))

    def robot_says(self, words: str, timeout: float = 60.0) -> None:
        self.lines.wait_for(lambda line: line.data.startswith(words), timeout, f'"{words}"',
                            after=self.before[self.lines])

    def told(self, words: str) -> str:
        return self.feedback.wait_for(lambda text: words in text.data, 10.0, f'"{words}"',
                                      after=self.before[self.feedback]).data

    def sent(self) -> list:
        return [message.data for message in self.commands.messages[self.before[self.commands]:]]

    def robot_is_at(self, x: float, y: float) -> bool:
        here = self.simulator.pose
        return math.hypot(here[0] / 1000.0 - x, here[1] / 1000.0 - y) < 0.2

    def seen_on_route(self, picture, colour: tuple) -> bool:
        places = [self.graph.curve(edge).point_at(0.7) for edge in ROUTE]
        return any(count_near(picture, self.window.pixel(*place), colour, 3) > 3
                   for place in places)

    # See

    def test_1_the_map_the_graph_and_the_robot_are_to_be_seen(self):
        window = self.window
        robot = self.poses.messages[-1].pose.position

        def robot_seen(picture) -> bool:
            return count_near(picture, window.pixel(robot.x + 0.4, robot.y), RED, 8) > 10
        picture = window.wait_for_picture('rviz_map', robot_seen, 'the red arrow of the robot')
        for goal in self.lab.goals:
            pixel = window.pixel(goal.x / 1000.0, goal.y / 1000.0)
            if goal.name != '10':  # the robot stands there
                self.assertGreater(count_near(picture, pixel, GREEN), 60, f'goal {goal.name}')
        for name in self.names.messages[-1].markers:
            place = name.pose.position
            if name.text not in ('', '10'):
                pixel = window.pixel(place.x, place.y)
                self.assertGreater(count_near(picture, pixel, WHITE, 9, 140), 2,
                                   f'white name of {name.text}')
                self.assertLess(pixel[0], self.at(name.text)[0], f'{name.text} stands at the left')
        areas = [area.rectangle for area in self.lab.forbidden_areas]
        self.assertGreaterEqual(len(areas), 3)
        for area in areas:
            inside = 0.85 * area.corners + 0.15 * area.corners.mean(axis=0)
            orange = sum(orange_near(picture, window.pixel(x / 1000.0, y / 1000.0)) > 0
                         for x, y in inside)  # a wrong rotation would leave two at most
            self.assertGreaterEqual(orange, 3, f'orange at the corners of {area}')
        middle = [(a + b) / 2 for a, b in zip(self.place('26'), self.place('14'))]
        self.assertGreater(count_near(picture, window.pixel(*middle), VIOLET, 8), 6,
                           'the edge from vertex 26 to 14')
        blue = sum(count_near(picture, (x, 466), LIGHT_BLUE, 32) for x in range(100, 1240, 64))
        self.assertGreater(blue, 20, 'light blue laser points in the corridor')

    # Act

    def test_2_a_click_with_publish_point_drives_to_the_goal(self):
        self.window.tool('c')
        self.window.click(self.at('12'))
        self.robot_says('Going to 12')
        self.told('Going to 12')
        self.window.picture('rviz_drive')
        self.robot_says('Arrived at 12')
        self.assertTrue(self.robot_is_at(*self.place('12')), self.simulator.pose)
        self.assertEqual(['goto 12'], self.sent())

    def test_3_a_click_on_a_handle_goes_once_and_its_menu_stops(self):
        self.window.click_handle(self.at('26'))
        self.robot_says('Going to 26')
        self.window.choose_from_menu(self.at('41'), STOP_ENTRY)
        self.robot_says('Stopped')
        self.assertEqual(['goto 26', 'stop'], self.sent())

    def test_4_the_handle_on_the_robot_stops_it(self):
        self.window.click_handle(self.at('8'))
        self.robot_says('Going to 8')

        def stop_is_sent() -> bool:
            here = self.poses.messages[-1].pose.position
            self.window.click(self.window.pixel(here.x, here.y))
            return 'stop' in self.sent()
        wait_until(stop_is_sent, 30.0, 'a click on the robot sends stop')
        self.robot_says('Stopped')

    def test_5_2d_nav_goal_drives_to_a_pose(self):
        x, y = -6.0, 0.0
        self.window.tool('g')
        self.window.drag(self.window.pixel(x, y), self.window.pixel(x, y + 2.0))
        wait_until(lambda: self.robot_is_at(x, y), 60.0, 'the robot at the pose')
        self.robot_says('Arrived at')
        wait_until(lambda: abs(self.simulator.pose[2] - 90.0) < 5.0, 10.0, 'the robot faces north')

    def test_6_2d_pose_estimate_relocalises(self):
        x, y, heading = self.simulator.pose
        x, y = x / 1000.0, y / 1000.0
        ahead = (x + 2.0 * math.cos(math.radians(heading)),
                 y + 2.0 * math.sin(math.radians(heading)))
        self.window.tool('p')
        self.window.drag(self.window.pixel(x, y), self.window.pixel(*ahead))
        self.robot_says('Localized to point')

    def test_7_a_click_on_the_dock_docks(self):
        self.window.tool('c')
        self.window.click(self.at('16'))
        self.robot_says('DockingState: Docked', timeout=120.0)
        self.assertEqual(['dock'], self.sent())
        self.told('Docked')

    def test_8_a_route_shows_what_is_done_current_and_coming(self):
        self.routes.publish(TargetRoute(route_id=7, edges=list(ROUTE)))

        def in_three_colours(picture) -> bool:
            return all(self.seen_on_route(picture, colour) for colour in (DONE_GREEN, YELLOW, BLUE))
        self.window.wait_for_picture('rviz_route', in_three_colours,
                                     'edges done, current and coming', timeout=90.0)
        self.window.tool('c')
        self.window.click(self.at('39'))
        self.told('the fleet drives route 7')
        self.routes.publish(TargetRoute(route_id=8, edges=[]))

    # Know

    def test_9_a_dead_link_is_told_and_nothing_stays_behind(self):
        here = self.poses.messages[-1].pose.position
        RvizTest.simulator.stop()
        RvizTest.simulator = None
        pixel = self.window.pixel(here.x, here.y)

        def robot_is_gone(picture) -> bool:
            banner = sum(count_near(picture, (x, 98), FAILURE, 20) for x in range(200, 1100, 41))
            return count_near(picture, pixel, RED, 20) == 0 and banner > 50
        self.window.wait_for_picture('rviz_dead_link', robot_is_gone,
                                     'no arrow, and the banner in red', timeout=30.0)


if __name__ == '__main__':
    rospy.init_node('rviz_test')
    rostest.rosrun('omron_ld90', 'rviz', RvizTest)
