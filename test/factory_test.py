#!/usr/bin/env python3
"""Four LD-90s and four AGVs on one graph: missions end, nobody comes near anybody, stop all stops.

The robots are where their simulators truly have them, not where they say they are.
"""
from __future__ import annotations

import math
import random
import threading
import time
import unittest
from typing import Callable, List, Set

import networkx as nx
import rospy
from fleet_support import READY, Factory
from std_msgs.msg import String
from std_srvs.srv import Trigger

from itrci_nav_msgs.msg import FleetRobot, MissionStatus
from system_support import connected_publisher, run_cases, wait_until

SPEED = 5.0
MISSIONS = 20
CORRIDOR = 0.45  # m, half a corridor
DOCK_ZONE = 2.0  # m around a dock, in which an LD-90 manoeuvres as it likes
IN_THE_WAY = 1.5  # m around what a robot that is out of order holds: nobody is sent there


class FactoryTest(unittest.TestCase):
    """Starts a fleet with scripts/run.sh's own command, and sends it missions."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.factory = Factory('4', 'longest_edge:=1.5', f'sim_speed:={SPEED}')
        try:
            cls.factory.wait_until_ready()
        except BaseException:
            cls.factory.stop()
            raise

    @classmethod
    def tearDownClass(cls) -> None:
        cls.factory.stop()

    def test_1_missions_end_whatever_stalls_and_nobody_comes_near_anybody(self) -> None:
        chance = random.Random(7)
        missions = [self.factory.send(*chance.sample(self.factory.stations, 2))
                    for _ in range(MISSIONS)]
        next_stall, polls, nearest = 0.0, 0, math.inf
        deadline = time.monotonic() + 240.0
        while len(self.factory.ends(missions)) < MISSIONS:
            self.assertLess(time.monotonic(), deadline, self.factory.why(missions))
            if time.monotonic() > next_stall:
                next_stall = time.monotonic() + 4.0
                self.factory.simulators.fault(f'agv_{chance.randint(1, 4)}', 'stall 15')
            nearest = min(nearest, self.factory.check_distances())
            self.check_corridors()
            polls += 1
            threading.Event().wait(0.03)
        print(f'{polls} looks at all robots; nearest beyond the distance allowed: {nearest:.2f} m')
        self.assertGreater(polls, 200)
        self.assertEqual({MissionStatus.SUCCEEDED}, set(self.factory.ends(missions).values()))

    def test_2_stop_all_stops_all_and_they_go_on_afterwards(self) -> None:
        before = self.factory.simulators.places()
        missions = [self.factory.send(self.free_station(), robot.vertex, robot=robot.name)
                    for robot in self.factory.fleet.robots]
        wait_until(lambda: len(self.factory.moved(before)) >= 2, 30.0, 'two robots drive')
        self.assertTrue(rospy.ServiceProxy('/stop_fleet', Trigger)().success)
        self.factory.wait_until_all_stand()
        stood = self.factory.simulators.places()
        self.assertTrue(rospy.ServiceProxy('/resume_fleet', Trigger)().success)
        wait_until(lambda: self.factory.moved(stood), 30.0, 'a robot goes on')
        self.all_succeed(missions)

    def test_3_an_emergency_stop_of_one_holds_up_nobody_else(self) -> None:
        self.out_of_order(
            'ld90_1', lambda: self.factory.simulators.fault('ld90_1', 'estop press'),
            FleetRobot.STOPPED, self.switch_on)

    def switch_on(self) -> None:
        self.factory.simulators.fault('ld90_1', 'estop release')
        connected_publisher('/ld90_1/send_command', String, to='omron_controller').publish(
            'enableMotors')

    def test_4_a_lost_link_to_one_holds_up_nobody_else(self) -> None:
        def each(*faults: str) -> Callable[[], None]:
            def inject() -> None:
                for fault in faults:
                    self.factory.simulators.fault('ld90_2', fault)
            return inject
        self.out_of_order('ld90_2', each('refuse on', 'drop', 'outgoing off'),
                          FleetRobot.OFFLINE, each('refuse off', 'outgoing on'))

    def test_5_a_robot_that_cannot_go_on_holds_up_nobody_else(self) -> None:
        def clear() -> None:
            self.factory.simulators.fault('ld90_3', 'unblock')
            if self.factory.robot('ld90_3').state not in READY:  # it gave up: a person looks at it
                rospy.ServiceProxy('/ld90_3/join_fleet', Trigger)()
        self.out_of_order('ld90_3', lambda: self.factory.simulators.fault('ld90_3', 'block'),
                          None, clear)

    def out_of_order(self, name: str, bring_about: Callable[[], None], state, mend) -> None:
        """While one robot is out of order on its way, others serve missions; then it goes on."""
        before = self.factory.simulators.places()
        own = self.factory.send(self.free_station(), self.home_of(name), robot=name)
        wait_until(lambda: name in self.factory.moved(before), 60.0, f'{name} drives')
        bring_about()
        if state is not None:
            self.factory.wait_for_state(name, state)
        self.stands(name)
        others = self.missions_of_others(name)
        self.assertTrue(others, 'somebody has a way around it')
        self.all_succeed(others)
        self.assertNotIn(own, self.factory.ends([own]))
        mend()
        self.factory.wait_for_state(name, *READY)
        self.all_succeed([own])

    def stands(self, name: str) -> None:
        before = self.factory.simulators.places()[name]

        def rests() -> bool:
            nonlocal before
            rospy.sleep(0.5)
            last, before = before, self.factory.simulators.places()[name]
            return math.dist(last, before) < 0.01
        wait_until(rests, 30.0, f'{name} stands')

    def missions_of_others(self, name: str) -> List[int]:
        """For up to three AGVs, to places that they reach without passing what the robot holds."""
        places = self.factory.simulators.places()
        graph = self.factory.graph
        held = [places[name], *(graph.vertices[vertex].position
                                for edge in self.factory.released(name) for vertex in (
                                    graph.edges[edge].origin, graph.edges[edge].destination))]
        ways = nx.Graph((edge.origin, edge.destination) for edge in graph.edges.values())
        ways.remove_nodes_from([
            vertex.id for vertex in graph.vertices.values()
            if any(math.dist(vertex.position, place) < IN_THE_WAY for place in held)])
        open_ways: Set[int] = max(nx.connected_components(ways), key=len)
        goals = [station for station in self.factory.stations if station in open_ways
                 and all(math.dist(graph.vertices[station].position, place) > 1.0
                         for place in places.values())]
        robots = [robot.name for robot in self.factory.fleet.robots if robot.driver == 'agv'
                  and min(graph.vertices.values(), key=lambda vertex: math.dist(
                      vertex.position, places[robot.name])).id in open_ways]
        return [self.factory.send(goal, robot=robot) for goal, robot in zip(goals, robots[:3])]

    def all_succeed(self, missions: List[int]) -> None:
        """They do, and nobody comes near anybody meanwhile."""
        deadline = time.monotonic() + 180.0
        while len(self.factory.ends(missions)) < len(missions):
            self.assertLess(time.monotonic(), deadline, self.factory.why(missions))
            self.factory.check_distances()
            threading.Event().wait(0.05)
        self.assertEqual({MissionStatus.SUCCEEDED}, set(self.factory.ends(missions).values()),
                         self.factory.why(missions))

    def home_of(self, name: str) -> int:
        return next(robot.vertex for robot in self.factory.fleet.robots if robot.name == name)

    def free_station(self) -> int:
        """Where no robot was at the start."""
        return next(id for id in self.factory.stations if id not in self.factory.homes())

    def check_corridors(self) -> None:
        """Every robot is in a corridor."""
        graph = self.factory.graph
        for name, (x, y) in self.factory.simulators.places().items():
            if all(math.dist((x, y), vertex.position) > DOCK_ZONE
                   for vertex in graph.vertices.values() if vertex.dock):
                _, nearest = graph.nearest_edge(x, y)
                self.assertLess(nearest.distance, CORRIDOR, f'{name} is out of its corridor')


if __name__ == '__main__':
    rospy.init_node('factory_test')
    run_cases(__file__)
