#!/usr/bin/env python3
"""Two robots in one RViz: a click for one robot never moves the other."""
from __future__ import annotations

import os

import rospkg
import rospy
from geometry_msgs.msg import PointStamped
from rviz_support import RvizTestCase, RvizWindow, Screen
from std_msgs.msg import String

from omron_map import MapDocument
from ports import free_port
from system_support import CommandRecorder, Recorder, run_cases, wait_until

LAB = rospkg.RosPack().get_path('omron_ld90') + '/../../maps/lab.map'
SCALE = 38.0  # pixels per metre in rviz/two_robots.rviz
MIDDLE = (640, 440)  # pixel between goals, at x = 0 of the map
TOOLS = range(200, 480, 40)  # x of the toolbar's part that contains the two Publish Point tools
APART = 8  # pixels between the clicks that look for these tools
ROBOTS = ('robot_a', 'robot_b')
OUTER_RING = 0.45  # m from a goal: inside robot_b's handle, outside robot_a's


class TwoRobotsTest(RvizTestCase):
    """RViz as launch/two_robots.launch starts it."""

    screen = window = None

    @classmethod
    def set_up(cls) -> None:
        cls.lab = MapDocument.load(LAB)
        cls.commands = {robot: CommandRecorder(robot) for robot in ROBOTS}
        cls.lines = {robot: Recorder(f'/{robot}/arcl_response', String) for robot in ROBOTS}
        cls.clicks = {robot: Recorder(f'/{robot}/clicked_point', PointStamped) for robot in ROBOTS}
        cls.screen = Screen()
        ports = zip(('arcl_port_a', 'outgoing_port_a', 'arcl_port_b', 'outgoing_port_b'),
                    [free_port() for _ in range(4)])
        cls.window = RvizWindow(
            cls.screen, os.environ.get('SYSTEM_TEST_ARTEFACTS', '/tmp'), SCALE,
            'omron_ld90', 'two_robots.launch', 'rviz:=true', 'sim_speed:=4.0',
            *(f'{name}:={port}' for name, port in ports))
        for robot in ROBOTS:
            cls.lines[robot].wait_for(lambda line: True, 30.0, 'answer of the robot')
        cls.find_the_tools()

    @classmethod
    def find_the_tools(cls) -> None:
        """Tries the toolbar's tools from the left, with clicks where there is no goal.

        With each tool, the test clicks at another pixel. So the position of a click shows to which
        robot the tool belongs, even if the click is processed late.
        """
        cls.tools = {}

        def both_found() -> bool:
            for number, x in enumerate(TOOLS):
                cls.window.tool_at(x)
                cls.window.click((MIDDLE[0] + number * APART, MIDDLE[1]))
            for robot in ROBOTS:
                for click in cls.clicks[robot].messages[-1:]:
                    cls.tools[robot] = TOOLS[round(click.point.x * SCALE / APART)]
            return len(cls.tools) == 2
        wait_until(both_found, 60.0, 'a Publish Point tool for each robot')
        point = cls.clicks['robot_a'].messages[-1].point
        cls.window.calibrate((MIDDLE[0] + round(point.x * SCALE), MIDDLE[1]), (point.x, point.y))

    @classmethod
    def tearDownClass(cls) -> None:
        for part in (cls.window, cls.screen):
            if part is not None:
                part.close()

    def setUp(self) -> None:
        super().setUp()
        self.before = {robot: len(self.commands[robot].messages) for robot in ROBOTS}

    def at(self, name: str, right: float = 0.0) -> tuple:
        goal = self.lab.find(name)
        return self.window.pixel(goal.x / 1000.0 + right, goal.y / 1000.0)

    def sent(self, robot: str) -> list:
        return self.commands[robot].texts[self.before[robot]:]

    def arrives(self, robot: str, goal: str) -> None:
        self.lines[robot].wait_for(lambda line: line.data == f'Arrived at {goal}', 60.0,
                                   f'arrival at {goal}')

    def test_each_robot_has_a_click_tool_of_its_own(self):
        for robot, goal in (('robot_a', '4'), ('robot_b', '32')):
            self.window.tool_at(self.tools[robot])
            self.window.click(self.at(goal))
        self.arrives('robot_a', '4')
        self.arrives('robot_b', '32')
        self.window.picture('rviz_two_robots')
        self.assertEqual((['goto 4'], ['goto 32']), (self.sent('robot_a'), self.sent('robot_b')))

    def test_on_a_goal_the_inner_handle_is_one_robots_and_the_outer_the_others(self):
        self.window.click_handle(self.at('12'))
        self.arrives('robot_a', '12')
        self.window.click_handle(self.at('33', right=OUTER_RING))
        self.arrives('robot_b', '33')
        self.assertEqual((['goto 12'], ['goto 33']), (self.sent('robot_a'), self.sent('robot_b')))


if __name__ == '__main__':
    rospy.init_node('rviz_two_robots_test')
    run_cases(__file__)
