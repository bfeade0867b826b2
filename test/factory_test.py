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

import rospy
from fleet_support import Factory
from std_srvs.srv import Trigger

from itrci_nav_msgs.msg import MissionStatus
from system_support import run_cases, wait_until

SPEED = 5.0
MISSIONS = 20
CORRIDOR = 0.45  # m, half a corridor
DOCK_ZONE = 2.0  # m around a dock, in which an LD-90 manoeuvres as it likes


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
        for robot in self.factory.fleet.robots:
            self.factory.send(self.free_station(), robot.vertex, robot=robot.name)
        wait_until(lambda: len(self.factory.moved(before)) >= 2, 30.0, 'two robots drive')
        self.assertTrue(rospy.ServiceProxy('/stop_fleet', Trigger)().success)
        self.factory.wait_until_all_stand()
        stood = self.factory.simulators.places()
        self.assertTrue(rospy.ServiceProxy('/resume_fleet', Trigger)().success)
        wait_until(lambda: self.factory.moved(stood), 30.0, 'a robot goes on')

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
