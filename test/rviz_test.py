#!/usr/bin/env python3
"""Mouse actions in RViz move the robot, and RViz shows the map, the robot and the faults."""
from __future__ import annotations

import math
import os

import rospkg
import rospy
from geometry_msgs.msg import PointStamped, PoseStamped
from rviz_support import RvizTestCase, RvizWindow, Screen, count_near
from std_msgs.msg import String
from visualization_msgs.msg import MarkerArray

from itrci_nav_msgs.msg import TargetRoute
from omron_ld90.nodes.rviz.interactive_goals import MENUS, ROBOT_MENU, HandleAction
from omron_ld90.operator.goal_clicks import TargetKind
from omron_ld90_msgs.msg import RobotStatus
from omron_ld90_sim import Simulator
from omron_map import MapDocument
from system_support import CommandRecorder, Recorder, connected_publisher, run_cases, wait_until
from trajectory_graph import load_graph

LAB = rospkg.RosPack().get_path('omron_ld90') + '/../../maps/lab.map'
SCALE = 40.0  # pixels per metre in rviz/omron_ld90.rviz
MIDDLE = (640, 466)  # pixel of the 3D view at which nothing of the laboratory is
SPEED = 4.0
GOAL_MENU, DOCK_MENU = MENUS[TargetKind.GOAL], MENUS[TargetKind.DOCK]
ROUTE = (-13, 8, 9, 3)  # from the dock to vertex 14
START = (-8000.0, 0.0, 0.0)  # at goal 10

GREEN, YELLOW = (20, 175, 50), (245, 208, 40)
ARROW = (67, 88, 210)  # like BODY, seen through the red of the stop handle
VIOLET, LIGHT_BLUE, WHITE, BLUE = (185, 170, 250), (90, 190, 255), (255, 255, 255), (75, 150, 250)
# colours of one area, and of two overlapping areas
ORANGE, DEEP_ORANGE = (146, 108, 52), (190, 121, 31)
DONE_GREEN = (62, 185, 90)
FAILURE = (255, 97, 77)
BODY = (211, 184, 190)  # the deck, seen through the red of the stop handle


def orange_near(picture, pixel: tuple) -> int:
    """Returns the number of orange pixels at `pixel`; where two areas overlap, orange is deeper."""
    return count_near(picture, pixel, ORANGE, 1) + count_near(picture, pixel, DEEP_ORANGE, 1)


class RvizTest(RvizTestCase):
    """One RViz and one simulated robot. At the end of each test the robot is idle."""

    screen = window = simulator = None

    @classmethod
    def set_up(cls) -> None:
        cls.lab = MapDocument.load(LAB)
        cls.graph = load_graph(LAB.replace('lab.map', 'lab_graph.yaml'))
        cls.start_robot()
        cls.artefacts = os.environ.get('SYSTEM_TEST_ARTEFACTS', '/tmp')
        cls.lines = Recorder('/omron_ld90/arcl_response', String)
        cls.commands = CommandRecorder('omron_ld90')
        cls.clicks = Recorder('/omron_ld90/clicked_point', PointStamped)
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
        """Clicks on the map. The map position of the click shows where the map is on the screen."""
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
        super().setUp()
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
        return self.commands.texts[self.before[self.commands]:]

    def robot_is_at(self, x: float, y: float) -> bool:
        here = self.simulator.pose
        return math.hypot(here[0] / 1000.0 - x, here[1] / 1000.0 - y) < 0.2

    def robot_believes_to_be_at(self, name: str) -> bool:
        here, (x, y) = self.poses.messages[-1].pose.position, self.place(name)
        return math.hypot(here.x - x, here.y - y) < 0.2

    def seen_on_route(self, picture, colour: tuple) -> bool:
        places = [self.graph.curve(edge).point_at(0.7) for edge in ROUTE]
        return any(count_near(picture, self.window.pixel(*place), colour, 3) > 3
                   for place in places)

    # Display

    def test_01_the_map_the_graph_and_the_robot_are_to_be_seen(self):
        self.assertGreaterEqual(len(self.lab.forbidden_areas), 3)
        for name in self.names.messages[-1].markers:
            if name.text:
                x, y = self.place(name.text)
                away = abs(name.pose.position.x - x), abs(name.pose.position.y - y)
                self.assertGreater(min(away), 0.35, f'{name.text} stands at a corner')
        self.window.wait_for_picture('rviz_map', self.missing_of_the_map, timeout=60.0)

    def missing_of_the_map(self, picture) -> list:
        """Returns the parts of the map, the graph and the robot that a picture does not show."""
        def colour_at(x: float, y: float, colour: tuple, *reach) -> int:
            return count_near(picture, self.window.pixel(x, y), colour, *reach)

        robot = self.poses.messages[-1].pose.position  # the robot is at goal 10 and faces east
        seen = {
            'the blue arrow of the robot': colour_at(robot.x + 0.4, robot.y, ARROW, 8) > 10,
            'the body of the robot': colour_at(robot.x - 0.2, robot.y + 0.1, BODY, 3, 15.0) > 10,
        }
        for goal in self.lab.goals:
            if goal.name != '10':  # the robot stands there
                seen[f'the green of goal {goal.name}'] = colour_at(
                    *self.place(goal.name), GREEN) > 60
        for name in self.names.messages[-1].markers:
            if name.text not in ('', '10'):
                place = name.pose.position
                seen[f'the white name of {name.text}'] = colour_at(
                    place.x, place.y, WHITE, 9, 140) > 2
        for area in (area.rectangle for area in self.lab.forbidden_areas):
            inside = 0.85 * area.corners + 0.15 * area.corners.mean(axis=0)
            orange = sum(orange_near(picture, self.window.pixel(x / 1000.0, y / 1000.0)) > 0
                         # with a wrong rotation, at most two of the corners would be there
                         for x, y in inside)
            seen[f'orange at the corners of {area}'] = orange >= 3
        middle = [(a + b) / 2 for a, b in zip(self.place('26'), self.place('14'))]
        seen['the edge from vertex 26 to 14'] = colour_at(*middle, VIOLET, 8) > 6
        blue = sum(count_near(picture, (x, 466), LIGHT_BLUE, 32) for x in range(100, 1240, 64))
        seen['light blue laser points in the corridor'] = blue > 20
        return [what for what, is_seen in seen.items() if not is_seen]

    # Actions

    def test_02_a_click_with_publish_point_drives_to_the_goal(self):
        self.window.tool('c')
        self.window.click(self.at('12'))
        self.robot_says('Going to 12')
        self.told('Going to 12')
        self.window.picture('rviz_drive')
        self.robot_says('Arrived at 12')
        self.assertTrue(self.robot_is_at(*self.place('12')), self.simulator.pose)
        self.assertEqual(['goto 12'], self.sent())

    def test_03_a_click_on_a_handle_goes_once_and_its_menu_stops(self):
        self.window.click_handle(self.at('26'))
        self.robot_says('Going to 26')
        self.window.choose_from_menu(self.at('32'), GOAL_MENU, HandleAction.STOP)
        self.robot_says('Stopped')
        self.assertEqual(['goto 26', 'stop'], self.sent())

    def test_04_the_handle_on_the_robot_stops_it(self):
        self.window.click_handle(self.at('8'))
        self.robot_says('Going to 8')

        def stop_is_sent() -> bool:
            here = self.poses.messages[-1].pose.position
            self.window.click(self.window.pixel(here.x, here.y))
            return 'stop' in self.sent()
        wait_until(stop_is_sent, 60.0, 'a click on the robot sends stop')
        self.robot_says('Stopped')

    def localize_at(self, goal: str) -> None:
        for _ in range(2):  # after the first choice, the node only asks whether the robot is there
            self.window.choose_from_menu(self.at(goal), GOAL_MENU, HandleAction.LOCALIZE)

    def test_05_the_menu_of_a_goal_goes_there_and_tells_the_robot_where_it_is(self):
        self.window.choose_from_menu(self.at('10'), GOAL_MENU, HandleAction.GO)
        self.robot_says('Arrived at 10')
        self.localize_at('22')
        wait_until(lambda: self.robot_believes_to_be_at('22'), 30.0, 'the robot has a wrong pose')
        self.localize_at('10')
        wait_until(lambda: self.robot_believes_to_be_at('10'), 30.0, 'the robot has the right pose')
        # The previous test clicks until a stop is sent. So a late click can send another stop.
        self.assertEqual(
            ['goto', 'localizeToPoint', 'localizeToPoint'],
            [command.split()[0] for command in self.sent() if command != 'stop'])

    def test_06_2d_nav_goal_drives_to_a_pose(self):
        x, y = -6.0, 0.0
        self.window.tool('g')
        self.window.drag(self.window.pixel(x, y), self.window.pixel(x, y + 2.0))
        wait_until(lambda: self.robot_is_at(x, y), 60.0, 'the robot at the pose')
        self.robot_says('Arrived at')
        wait_until(lambda: abs(self.simulator.pose[2] - 90.0) < 5.0, 10.0, 'the robot faces north')

    def test_07_2d_pose_estimate_relocalises(self):
        x, y, heading = self.simulator.pose
        x, y = x / 1000.0, y / 1000.0
        ahead = (x + 2.0 * math.cos(math.radians(heading)),
                 y + 2.0 * math.sin(math.radians(heading)))

        def relocalised() -> bool:  # if RViz draws slowly, a drag is lost
            self.window.tool('p')
            self.window.drag(self.window.pixel(x, y), self.window.pixel(*ahead))
            try:
                self.robot_says('Localized to point', timeout=10.0)
            except AssertionError:
                return False
            return True
        wait_until(relocalised, 60.0, 'the robot gets its pose')

    def test_08_a_click_on_the_dock_docks_and_the_robots_menu_undocks(self):
        self.window.tool('c')
        self.window.click(self.at('16'))
        self.robot_says('DockingState: Docked', timeout=120.0)
        self.assertEqual(['dock'], self.sent())
        self.told('Docked')
        here = self.poses.messages[-1].pose.position
        self.window.choose_from_menu(self.window.pixel(here.x, here.y), ROBOT_MENU,
                                     HandleAction.UNDOCK)
        self.robot_says('DockingState: Undocked')
        wait_until(lambda: len(self.sent()) > 1, 10.0, 'the command on its topic')
        self.assertEqual(['dock', 'undock'], self.sent())

    def test_09_the_menu_of_the_dock_docks(self):
        # drives away from the dock, where the robot's handle would be above the dock's handle
        self.window.tool('c')
        self.window.click(self.at('1'))
        self.robot_says('Arrived at 1')
        self.window.choose_from_menu(self.at('16'), DOCK_MENU, HandleAction.DOCK)
        self.robot_says('DockingState: Docked')
        self.assertEqual(['goto 1', 'dock'], self.sent())

    def test_10_a_route_shows_what_is_done_current_and_coming(self):
        self.routes.publish(TargetRoute(route_id=7, edges=list(ROUTE)))
        colours = {'done': DONE_GREEN, 'current': YELLOW, 'coming': BLUE}
        self.window.wait_for_picture(
            'rviz_route', lambda picture: [f'an edge that is {state}' for state, colour
                                           in colours.items()
                                           if not self.seen_on_route(picture, colour)],
            timeout=90.0)
        self.window.tool('c')
        self.window.click(self.at('39'))
        self.told('the fleet drives route 7')
        self.routes.publish(TargetRoute(route_id=8, edges=[]))

    # Faults

    def test_11_a_dead_link_is_told_and_nothing_stays_behind(self):
        here = self.poses.messages[-1].pose.position
        RvizTest.simulator.stop()
        RvizTest.simulator = None
        pixel = self.window.pixel(here.x, here.y)

        def missing(picture) -> list:
            banner = sum(count_near(picture, (x, 98), FAILURE, 20) for x in range(200, 1100, 41))
            seen = {'the banner in red': banner > 50,
                    'a place without the arrow': count_near(picture, pixel, ARROW, 20) == 0,
                    'a place without the body': count_near(picture, pixel, BODY, 12, 15.0) == 0}
            return [what for what, is_seen in seen.items() if not is_seen]
        self.window.wait_for_picture('rviz_dead_link', missing)


if __name__ == '__main__':
    rospy.init_node('rviz_test')
    run_cases(__file__)
