#!/usr/bin/env python3
"""Eight robots in a real RViz: missions, closed edges, fleet stop by mouse; with --long all menus.

The effect of a click is checked in the messages of the fleet manager, in the simulators, and in the
picture.
"""
from __future__ import annotations

import math
import os
import unittest
from typing import Any, Callable, Sequence, Tuple

import numpy as np
import rospy
from fleet_support import READY, Factory
from PIL import Image
from rviz_support import RvizWindow, Screen, close_to, missing_programs
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import MarkerArray

from graph_fleet_manager.nodes.rviz.graph_picture import CLOSED
from graph_fleet_manager.nodes.rviz.menus import (
    BUTTON,
    BUTTON_ABOVE,
    EDGE_MENU,
    ROBOT_MENU,
    VERTEX_MENU,
    MenuAct,
)
from graph_fleet_manager.nodes.rviz.robot_picture import GREY, RED
from graph_fleet_manager.nodes.rviz.stop_picture import MARGIN
from itrci_nav_msgs.msg import ClosedEdges, FleetRobot, MissionStatus
from omron_ld90.nodes.rviz_view import RvizConfiguration
from rviz_drawing import drawing
from system_support import Recorder, run_cases, wait_until

SPEED = 3.0
long_only = unittest.skipUnless(os.environ.get('LD90_LONG_TESTS'), 'a variation, for --long')
MIDDLE = (640, 466)  # pixel of the middle of the 3D view
ROOM_FOR_MENU = (920, 620)  # beyond this pixel a menu would open to the left or upwards
# s in which the effect of a choice must show on a loaded computer; later the test chooses again
EFFECT = 8.0
IN_ALL = 150.0  # s for one choice
Place = Tuple[float, float]


class FleetByMouse(unittest.TestCase):
    """One fleet and one RViz. The tests are the parts of one story, in this order."""

    @classmethod
    def setUpClass(cls) -> None:
        missing = missing_programs()
        if missing:
            raise unittest.SkipTest(f'not installed: {", ".join(missing)}')
        cls.factory = Factory('4', 'longest_edge:=1.5', f'sim_speed:={SPEED}')
        cls.screen = Screen()
        try:
            cls.closed = Recorder('/closed_edges_in_force', ClosedEdges)
            cls.feedback = Recorder('/fleet_markers/feedback', MarkerArray)
            cls.window = cls.open_rviz()
            cls.factory.wait_until_ready()
        except BaseException:
            cls.factory.stop()
            cls.screen.close()
            raise

    @classmethod
    def tearDownClass(cls) -> None:
        cls.window.close()
        cls.screen.close()
        cls.factory.stop()

    @classmethod
    def open_rviz(cls) -> RvizWindow:
        configuration = os.path.join(cls.factory.folder, 'fleet.rviz')
        with open(configuration, encoding='utf-8') as stream:
            view = RvizConfiguration(stream.read()).view
        window = RvizWindow(
            cls.screen, os.environ.get('SYSTEM_TEST_ARTEFACTS', '/tmp'), view.scale, 'omron_ld90',
            'rviz.launch', 'robot_name:=rviz_of_fleet', f'rviz_config:={configuration}',
            f'map_file:={cls.factory.folder}/fleet.map')
        nothing = 4.6, -4.4  # m: a place without handles
        window.calibrate((round(MIDDLE[0] + (nothing[0] - view.x) * view.scale),
                          round(MIDDLE[1] - (nothing[1] - view.y) * view.scale)), nothing)
        return window

    # --- the story -------------------------------------------------------------------------------

    def test_1_all_eight_robots_are_seen(self) -> None:
        self.window.wait_for_picture('fleet_rviz_robots', lambda picture: [
            robot.name for number, robot in enumerate(self.factory.fleet.robots)
            if self.painted(picture, self.place_of(robot.name), drawing.own_colour(number)) < 40],
            60.0)

    def test_2_a_vertex_sends_any_robot(self) -> None:
        goal, known = self.free_vertex(), len(self.factory.statuses.messages)
        mission = self.choose(
            lambda: self.place_at(goal), VERTEX_MENU, MenuAct.SEND_ANY, lambda: next(
                (status.request_id for status in self.factory.statuses.messages[known:]), 0))
        wait_until(lambda: self.factory.ends([mission]), 120.0, f'the end of mission {mission}')
        self.assertEqual({mission: MissionStatus.SUCCEEDED}, self.factory.ends([mission]))
        self.assertLess(min(math.dist(place, self.place_at(goal)) for place
                            in self.factory.places().values()), 0.5)

    @long_only
    def test_3_a_click_chooses_a_robot_and_a_vertex_sends_it(self) -> None:
        robot, goal = self.clickable_robot(), self.free_vertex()
        self.click(lambda: self.place_of(robot), lambda: self.was_said(f'{robot} is chosen'))
        self.choose(lambda: self.place_at(goal), VERTEX_MENU, MenuAct.SEND_CHOSEN,
                    lambda: self.factory.robot(robot).has_mission)
        self.window.picture('fleet_rviz_sent')
        wait_until(lambda: math.dist(self.place_of(robot), self.place_at(goal)) < 0.5, 120.0,
                   f'{robot} at vertex {goal}')

    def test_4_an_edge_is_closed_and_all_are_opened(self) -> None:
        edge = self.free_edge()
        middle = self.middle_of(edge)
        self.choose(lambda: middle, EDGE_MENU, MenuAct.CLOSE,
                    lambda: edge in self.closed.messages[-1].edges)
        self.window.wait_for_picture('fleet_rviz_closed', lambda picture: (
            [] if self.painted(picture, middle, CLOSED) > 20 else [f'a closed edge {edge}']))
        self.choose(lambda: middle, EDGE_MENU, MenuAct.OPEN_ALL,
                    lambda: not self.closed.messages[-1].edges)
        self.window.wait_for_picture('fleet_rviz_opened', lambda picture: (
            [f'an open edge {edge}'] if self.painted(picture, middle, CLOSED) else []))

    @long_only
    def test_5_a_mission_is_paused_goes_on_and_is_cancelled(self) -> None:
        """The robot must stay at a station, so that the test can click on it."""
        robot, goal = self.clickable_robot(), self.free_vertex()
        goals = goal, self.factory.home_of(robot)
        mission = self.factory.send(*goals, robot=robot, dwell=(-1.0, 0.0))
        wait_until(lambda: math.dist(self.place_of(robot), self.place_at(goal)) < 0.1, 120.0,
                   f'{robot} at vertex {goal}')
        for act, state in ((MenuAct.PAUSE, MissionStatus.PAUSED),
                           (MenuAct.RESUME, MissionStatus.ACTIVE),
                           (MenuAct.CANCEL, MissionStatus.CANCELLED)):
            self.choose(lambda: self.place_of(robot), ROBOT_MENU, act,
                        lambda: self.factory.status_of(mission) == state)  # noqa: B023
        second = self.factory.send(*goals, robot=robot, dwell=(-1.0, 0.0))
        wait_until(lambda: self.factory.status_of(second) == MissionStatus.ACTIVE, 30.0,
                   'the second mission')
        self.choose(lambda: self.place_of(robot), ROBOT_MENU, MenuAct.RELEASE,
                    lambda: math.dist(self.place_of(robot), self.place_at(goal)) > 0.5)
        wait_until(lambda: self.factory.ends([second]), 120.0, f'the end of mission {second}')
        self.assertEqual({second: MissionStatus.SUCCEEDED}, self.factory.ends([second]))

    @long_only
    def test_6_a_robot_is_taken_out_and_put_in(self) -> None:
        robot = self.clickable_robot()
        self.choose(lambda: self.place_of(robot), ROBOT_MENU, MenuAct.OUT,
                    lambda: self.factory.robot(robot).state == FleetRobot.OUT_OF_SERVICE)
        self.window.wait_for_picture('fleet_rviz_out', lambda picture: (
            [] if self.painted(picture, self.place_of(robot), GREY) > 40 else [f'{robot} in grey']))
        self.choose(lambda: self.place_of(robot), ROBOT_MENU, MenuAct.IN,
                    lambda: self.factory.robot(robot).state in READY)

    def test_7_stop_all_stops_all_and_go_on_lets_them_go_on(self) -> None:
        before, goal = self.factory.places(), self.free_vertex()
        for robot in self.factory.fleet.robots:
            self.factory.send(goal, robot.vertex, goal, robot.vertex, robot=robot.name)
        wait_until(lambda: len(self.factory.moved(before)) >= 2, 60.0, 'two robots drive')
        self.press(MenuAct.STOP_ALL, 'Every robot was told to stop')
        self.factory.wait_until_all_stand()
        self.window.wait_for_picture('fleet_rviz_stopped', lambda picture: (
            [] if self.is_framed(picture) else ['the red frame of a stopped fleet']))
        stood = self.factory.places()
        self.press(MenuAct.RESUME_ALL, 'The fleet goes on')
        wait_until(lambda: self.factory.moved(stood), 60.0, 'a robot goes on')
        self.window.wait_for_picture('fleet_rviz_going_on', lambda picture: (
            ['no red frame'] if self.is_framed(picture) else []))
        known, place = len(self.feedback.messages), self.place_at(self.free_vertex())
        self.choose(lambda: place, VERTEX_MENU, MenuAct.STOP_ALL,
                    lambda: self.was_said('Every robot was told to stop', known))
        self.factory.wait_until_all_stand()

    # --- the mouse -------------------------------------------------------------------------------

    def choose(self, place: Callable[[], Place], menu: Sequence[MenuAct], act: MenuAct,
               effect: Callable[[], Any]) -> Any:
        """Chooses from the menu at a place until the effect shows, and returns the effect."""
        return self.do(lambda: self.window.choose_from_menu(
            self.window.pixel(*place()), menu, act), effect, f'"{act.value}" at {place()}')

    def click(self, place: Callable[[], Place], effect: Callable[[], Any]) -> None:
        """Clicks on a handle until the effect shows."""
        self.do(lambda: self.window.click_handle(self.window.pixel(*place())), effect,
                f'a click at {place()}')

    def press(self, act: MenuAct, words: str) -> None:
        """Clicks one of the two buttons above the graph until these words appear."""
        vertices = self.factory.graph.vertices.values()
        left = min(vertex.x for vertex in vertices) + BUTTON[0] / 2.0
        button = (left + (BUTTON[0] + 0.3) * (act is MenuAct.RESUME_ALL),
                  max(vertex.y for vertex in vertices) + BUTTON_ABOVE)
        known = len(self.feedback.messages)
        self.click(lambda: button, lambda: self.was_said(words, known))

    def do(self, act: Callable[[], None], effect: Callable[[], Any], what: str) -> Any:
        """Repeats an action until its effect shows, because a menu can close under the mouse if
        RViz draws late.
        """
        def done() -> Any:
            if not effect():
                try:
                    act()
                except AssertionError as missed:
                    print(f'{what}, once more: {missed}')
            try:
                return wait_until(effect, EFFECT, 'its effect')
            except AssertionError:
                return None
        return wait_until(done, IN_ALL, f'the effect of {what}')

    def was_said(self, words: str, after: int = 0) -> bool:
        """Returns whether the last sentence above the graph has these words."""
        said = [marker.text for message in self.feedback.messages[after:]
                for marker in message.markers]
        return bool(said) and words in ' '.join(said[-1].split())

    # --- where things are ------------------------------------------------------------------------

    def place_of(self, robot: str) -> Place:
        return self.factory.places()[robot]

    def place_at(self, vertex: int) -> Place:
        return self.factory.graph.vertices[vertex].position

    def middle_of(self, edge: int) -> Place:
        curve = self.factory.graph.curve(edge)
        x, y = curve.point_at(curve.length / 2.0)
        return x, y

    def is_clickable(self, place: Place, away: float, but: str = '') -> bool:
        """Returns whether there is room for a menu and no robot is nearer than `away` m."""
        x, y = self.window.pixel(*place)
        return x < ROOM_FOR_MENU[0] and y < ROOM_FOR_MENU[1] and all(
            math.dist(place, other) > away
            for name, other in self.factory.places().items() if name != but)

    def free_vertex(self) -> int:
        """Returns a station where no robot stands, and which no robot has as its home."""
        return next(id for id in self.factory.stations if id not in self.factory.homes()
                    and self.is_clickable(self.place_at(id), 1.5))

    def free_edge(self) -> int:
        return next(id for id in self.factory.graph.edges
                    if self.is_clickable(self.middle_of(id), 2.0))

    def clickable_robot(self) -> str:
        """Returns an idle robot on which the test can click."""
        wait_until(lambda: all(robot.state == FleetRobot.IDLE
                               for robot in self.factory.state.messages[-1].robots), 120.0,
                   'a fleet at rest')
        self.factory.wait_until_all_stand()
        return next(name for name, place in self.factory.places().items()
                    if self.is_clickable(place, 1.5, name))

    def is_framed(self, picture: Image.Image) -> bool:
        """Returns whether the red frame of a stopped fleet is drawn; looks only at its left side.
        """
        places = [vertex.position for vertex in self.factory.graph.vertices.values()]
        side = (min(x for x, _ in places) - MARGIN,
                (min(y for _, y in places) + max(y for _, y in places)) / 2.0)
        return self.painted(picture, side, RED) > 20

    def painted(self, picture: Image.Image, place: Place, paint: ColorRGBA) -> int:
        """Returns the number of pixels of about this colour around a place."""
        x, y = self.window.pixel(*place)
        around = np.asarray(picture.crop((x - 15, y - 15, x + 16, y + 16)))
        colour = (round(255 * paint.r), round(255 * paint.g), round(255 * paint.b))
        return int(close_to(around, colour, 60.0).sum())


if __name__ == '__main__':
    rospy.init_node('fleet_rviz_test', disable_signals=True)
    run_cases(__file__)
