#!/usr/bin/env python3
"""A fleet file of nine robots: missions end, faults delay no other robot, menus work.

The launch simulates three LD-90s and four AGVs. Another LD-90 is a real robot for the fleet, which
has only the robot's address and password. One more robot is switched off.

The test checks the true positions in the simulators, not the reported positions.
"""
from __future__ import annotations

import math
import os
import random
import tempfile
import time
import unittest
from pathlib import Path
from typing import Callable, List

import rospy
from fleet_support import READY, Factory, Menus, Viewer, free_fleet_ports
from rosgraph_msgs.msg import Log
from std_msgs.msg import String

from graph_fleet_manager.nodes.rviz.menus import MenuAct
from itrci_nav_msgs.msg import ClosedEdges, FleetRobot, MissionStatus
from omron_ld90_sim import Simulator
from system_support import Recorder, connected_publisher, run_cases, wait_until

SPEED = 5.0
MISSIONS, DESTINATIONS = (60, 2) if os.environ.get('LD90_LONG_TESTS') else (8, 1)
CORRIDOR = 0.45  # m, half the width of a corridor
DOCK_ZONE = 2.0  # m around a dock; there an LD-90 may leave the corridor to manoeuvre
FLEET = '''clearance: 0.1
robot_types:
- {{name: ld90, radius: 0.43, speed: 1.35, play: 0.25, obeys_edge_speed: false, release_ahead: 8.0}}
- {{name: agv, radius: 0.35, speed: 1.0}}
robots:
- {{name: ld90_1, type: ld90, vertex: 6, driver: ld90}}
- {{name: ld90_2, type: ld90, vertex: 14, driver: ld90}}
- {{name: ld90_3, type: ld90, vertex: 32, driver: ld90}}
- {{name: real, type: ld90, vertex: 39, driver: ld90, host: 127.0.0.1, arcl_port: {port},
   outgoing_port: {outgoing}, password_file: secret}}
- {{name: agv_1, type: agv, vertex: 8, driver: agv}}
- {{name: agv_2, type: agv, vertex: 18, driver: agv}}
- {{name: agv_3, type: agv, vertex: 33, driver: agv}}
- {{name: agv_4, type: agv, vertex: 41, driver: agv}}
- {{name: switched_off, type: ld90, vertex: 52, driver: ld90, host: 127.0.0.9, arcl_port: {port},
   outgoing_port: {silent}, password_file: secret, absent: true}}
'''
PASSWORD = 'Kestrel-31'
REAL, ABSENT = 'real', 'switched_off'
STOPPED, LOST, STUCK = 'ld90_1', 'ld90_2', 'ld90_3'
FAULTS = {STOPPED: ('estop press',), LOST: ('refuse on', 'drop', 'outgoing off'),
          # 32 is its start vertex. An obstacle there would not do: a robot that drives around an
          # obstacle may leave its corridor.
          STUCK: ('fail 32',)}
REMEDIES = {STOPPED: ('estop release',), LOST: ('refuse off', 'outgoing on'),
            STUCK: ('mend 32',)}
# The first two robots get far destinations, because they may be parked at their own home vertices.
HOME_OF = {STOPPED: REAL, LOST: 'agv_4', STUCK: STUCK}


class FactoryTest(unittest.TestCase):
    """Starts a fleet with the command of scripts/run.sh, and sends it missions."""

    next_try = 0.0

    @classmethod
    def setUpClass(cls) -> None:
        cls.folder = tempfile.TemporaryDirectory()
        # with real robots, the fleet manager keeps its files in ROS_HOME
        os.environ['ROS_HOME'] = cls.folder.name
        first = free_fleet_ports()
        (Path(cls.folder.name) / 'secret').write_text(PASSWORD)
        fleet = Path(cls.folder.name) / 'fleet.yaml'
        fleet.write_text(FLEET.format(port=first, outgoing=first + 1, silent=first + 2))
        cls.log = Recorder('/rosout', Log)
        cls.factory = Factory(str(fleet), 'longest_edge:=1.5', f'sim_speed:={SPEED}',
                              first_port=first + 10)
        try:
            cls.real = cls.real_robot(first, first + 1)
            cls.pictures = {name: Viewer(f'/fleet_markers/{name}')
                            for name in ('graph', 'plans', 'robots')}
            cls.closed = Recorder('/closed_edges_in_force', ClosedEdges)
            cls.present = [robot for robot in cls.factory.fleet.robots if robot.name != ABSENT]
            cls.factory.wait_until_ready(*(robot.name for robot in cls.present))
            cls.menus = Menus()
        except BaseException:
            cls.factory.stop()
            raise

    @classmethod
    def real_robot(cls, port: int, outgoing: int) -> Simulator:
        """Puts the real robot on its vertex. Only its own nodes report where it is."""
        home = cls.factory.graph.vertices[cls.factory.home_of(REAL)]
        robot = Simulator(os.path.join(cls.factory.folder, 'fleet.map'), port, PASSWORD,
                          ('127.0.0.1', outgoing), SPEED, (1e3 * home.x, 1e3 * home.y, 0.0),
                          lists=((0.5, 'Status'),))
        robot.start()
        cls.factory.more_places[REAL] = lambda: (robot.pose[0] / 1e3, robot.pose[1] / 1e3)
        return robot

    @classmethod
    def tearDownClass(cls) -> None:
        cls.factory.stop()
        cls.real.stop()
        cls.folder.cleanup()

    def test_0_without_a_page_the_log_says_what_is_ready_and_how_to_begin(self) -> None:
        told = self.log.wait_for(
            lambda line: line.name == '/fleet_visualisation' and line.msg.startswith('Ready: '),
            60.0, 'line that says what is ready')
        self.assertIn(f'Ready: {len(self.present)} robots. ', told.msg)
        self.assertIn('rosrun graph_fleet_manager mission ', told.msg)

    def test_1_missions_end_whatever_stalls_and_nobody_comes_near_anybody(self) -> None:
        chance = random.Random(7)
        missions = [self.factory.send(*chance.sample(self.factory.stations, DESTINATIONS))
                    for _ in range(MISSIONS)]
        next_stall = 0.0

        def all_succeeded() -> bool:
            nonlocal next_stall
            if time.monotonic() > next_stall:
                next_stall = time.monotonic() + 4.0
                self.factory.simulators.fault(f'agv_{chance.randint(1, 4)}', 'stall 15')
            self.check_corridors()
            return self.factory.succeeded(missions) == MISSIONS
        looks = self.factory.run_until(all_succeeded, 400.0, 'all missions', missions)
        self.assertGreater(looks, 5 * MISSIONS)
        self.assertEqual(FleetRobot.ABSENT, self.factory.robot(ABSENT).state)

    def test_2_stop_all_stops_all_and_they_go_on_afterwards(self) -> None:
        before = self.factory.places()
        type(self).missions = [
            self.factory.send(goal, robot=robot.name)
            for goal, robot in zip(self.free_stations(), self.present)]
        wait_until(lambda: len(self.factory.moved(before)) >= 2, 60.0, 'two robots drive')
        self.menus.choose('robot agv_1', MenuAct.STOP_ALL.value)
        self.factory.wait_until_all_stand()
        stood = self.factory.places()
        self.menus.choose('button GO ON', MenuAct.RESUME_ALL.value)
        wait_until(lambda: self.factory.moved(stood), 60.0, 'a robot goes on')

    def test_3_robots_out_of_order_hold_up_nobody_whose_path_they_do_not_block(self) -> None:
        """Emergency stop, lost link and unreachable goal come at the same time, at any place."""
        self.all_succeed(self.missions)
        places = self.factory.places()
        own = [self.factory.send(self.factory.home_of(other), robot=name)
               for name, other in HOME_OF.items()]
        self.factory.run_until(lambda: STOPPED in self.factory.moved(places), 60.0,
                               f'{STOPPED} drives', own)
        for name, faults in FAULTS.items():
            for fault in faults:
                self.factory.simulators.fault(name, fault)
        self.factory.wait_for_state(STOPPED, FleetRobot.STOPPED)
        others = [self.factory.send(goal) for goal in self.free_stations()[len(places):]]
        self.factory.run_until(
            lambda: self.factory.succeeded(others) >= 2 or self.all_others_are_blocked(), 90.0,
            'missions of others', [*own, *others])
        # the third robot may have arrived already
        self.assertEqual(0, self.factory.succeeded(own[:2]))
        for name, faults in REMEDIES.items():
            for fault in faults:
                self.factory.simulators.fault(name, fault)
        connected_publisher(f'/{STOPPED}/send_command', String, to='omron_controller').publish(
            'enableMotors')
        everything = [*own, *others]
        self.factory.run_until(
            lambda: self.factory.succeeded(everything) == len(everything) or self.put_back(),
            180.0, 'all missions', everything)

    def all_others_are_blocked(self) -> bool:
        """Returns whether each robot with a mission reports that it waits for a robot that is out
        of order.
        """
        working = [robot for robot in map(self.factory.robot, (one.name for one in self.present))
                   if robot.state in READY]
        return all(any(name in robot.waits_for for name in REMEDIES) for robot in working)

    def put_back(self) -> bool:
        """Puts the failed robot back into service, as a person does; returns False."""
        if self.factory.robot(STUCK).state == FleetRobot.FAILED and (
                time.monotonic() > self.next_try):
            type(self).next_try = time.monotonic() + 3.0
            self.menus.choose(f'robot {STUCK}', MenuAct.IN.value)
        return False

    def test_4_the_menu_of_a_robot(self) -> None:
        graph, here = self.factory.graph, self.factory.places()['agv_1']
        goal = next(id for id in sorted(
            self.free_stations(), key=lambda id: math.dist(graph.vertices[id].position, here))
            if math.dist(graph.vertices[id].position, here) > 1.0)
        place = graph.vertices[goal].position
        mission = self.factory.send(goal, self.factory.home_of('agv_1'), robot='agv_1',
                                    dwell=(-1.0, -1.0))
        for act, state in ((MenuAct.PAUSE, MissionStatus.PAUSED),
                           (MenuAct.RESUME, MissionStatus.ACTIVE)):
            self.choose(act, lambda: self.factory.status_of(mission) == state)  # noqa: B023
        wait_until(lambda: math.dist(self.factory.places()['agv_1'], place) < 0.1, 60.0,
                   f'agv_1 at vertex {goal}')
        self.choose(MenuAct.RELEASE, lambda: any(
            status.request_id == mission and status.destinations_reached
            for status in list(self.factory.statuses.messages)))
        self.choose(MenuAct.CANCEL,
                    lambda: self.factory.status_of(mission) == MissionStatus.CANCELLED)
        self.choose(MenuAct.OUT,
                    lambda: self.factory.robot('agv_1').state == FleetRobot.OUT_OF_SERVICE)
        self.factory.wait_until_all_stand()
        self.choose(MenuAct.IN, lambda: self.factory.robot('agv_1').state in READY)
        known = len(self.factory.statuses.messages)
        self.menus.choose('robot agv_1', MenuAct.CHOOSE.value)
        self.menus.choose(f'vertex {goal}', MenuAct.SEND_CHOSEN.value)
        self.factory.statuses.wait_for(lambda status: status.robot == 'agv_1', 30.0, 'its mission',
                                       after=known)

    def test_5_the_menu_of_an_edge_and_nothing_is_left_behind(self) -> None:
        edges = [min(self.factory.graph.edges), max(self.factory.graph.edges)]
        for edge in edges:
            self.menus.choose(f'edge {edge}', MenuAct.CLOSE.value)
            wait_until(lambda: edge in self.closed.messages[-1].edges, 30.0,  # noqa: B023
                       f'edge {edge} is closed')
        wait_until(lambda: 'closed' in self.pictures['graph'].namespaces(), 30.0, 'they are red')
        self.menus.choose(f'edge {edges[0]}', MenuAct.OPEN.value)
        wait_until(lambda: edges[0] not in self.closed.messages[-1].edges, 30.0, 'one is open')
        self.assertIn(edges[1], self.closed.messages[-1].edges)
        self.menus.choose(f'edge {edges[0]}', MenuAct.OPEN_ALL.value)
        wait_until(lambda: not self.closed.messages[-1].edges, 30.0, 'all are open')
        wait_until(lambda: not {'closed', 'closed_names'} & self.pictures['graph'].namespaces(),
                   30.0, 'nothing red is left')
        for name, picture in self.pictures.items():
            self.assertGreater(picture.messages, 1, name)
            self.assertEqual([], picture.flickers, name)

    def choose(self, act: MenuAct, effect: Callable[[], bool]) -> None:
        """Chooses from the menu of agv_1 until the effect shows.

        The choice is repeated, because the node may receive a mission later than this test.
        """
        def shows() -> bool:
            if effect():
                return True
            self.menus.choose('robot agv_1', act.value)
            deadline = time.monotonic() + 3.0
            while not effect() and time.monotonic() < deadline:
                time.sleep(0.05)
            return effect()
        wait_until(shows, 60.0, f'"{act.value}" of agv_1')

    def all_succeed(self, missions: List[int]) -> None:
        self.factory.run_until(lambda: self.factory.succeeded(missions) == len(missions), 180.0,
                               'all missions', missions)

    def free_stations(self) -> List[int]:
        """Returns the stations at which no robot stood at the start."""
        return [id for id in self.factory.stations if id not in self.factory.homes()]

    def check_corridors(self) -> None:
        """Checks that each robot is in a corridor."""
        graph = self.factory.graph
        for name, (x, y) in self.factory.places().items():
            if all(math.dist((x, y), vertex.position) > DOCK_ZONE
                   for vertex in graph.vertices.values() if vertex.dock):
                _, nearest = graph.nearest_edge(x, y)
                self.assertLess(nearest.distance, CORRIDOR, f'{name} is out of its corridor')


if __name__ == '__main__':
    rospy.init_node('factory_test', disable_signals=True)
    run_cases(__file__)
