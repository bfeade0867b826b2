#!/usr/bin/env python3
"""A fleet file starts real and simulated robots together; one that does not answer keeps nobody.

The real robot is a simulator that only its address is known of, with a password of its own.
"""
from __future__ import annotations

import os
import tempfile
import unittest
from pathlib import Path

import rospy
from fleet_support import READY, Factory, free_fleet_ports

from itrci_nav_msgs.msg import FleetRobot, MissionStatus
from omron_ld90_sim import Simulator
from system_support import run_cases, wait_until

MAP = Path(__file__).resolve().parents[1] / 'maps' / 'lab.map'
SPEED = 4.0
PASSWORD = 'Kestrel-31'
VERTEX_8 = (-12000.0, 0.0, 0.0)  # mm and degrees
FLEET = '''clearance: 0.1
robot_types:
- {{name: ld90, radius: 0.43, speed: 1.35, play: 0.25, obeys_edge_speed: false, release_ahead: 8.0}}
- {{name: agv, radius: 0.35, speed: 1.0}}
robots:
- {{name: real, type: ld90, vertex: 8, driver: ld90, host: 127.0.0.1, arcl_port: {port},
   outgoing_port: {outgoing}, password_file: secret}}
- {{name: simulated, type: ld90, vertex: 14, driver: ld90}}
- {{name: agv, type: agv, vertex: 35, driver: agv}}
- {{name: switched_off, type: ld90, vertex: 52, driver: ld90, host: 127.0.0.9, arcl_port: {port},
   outgoing_port: {silent}, password_file: secret}}
'''


class FleetFile(unittest.TestCase):

    @classmethod
    def setUpClass(cls) -> None:
        cls.folder = tempfile.TemporaryDirectory()
        os.environ['ROS_HOME'] = cls.folder.name  # with real robots the fleet's memory lies there
        first = free_fleet_ports()
        cls.real = Simulator(MAP, password=PASSWORD, start=VERTEX_8, speed=SPEED,
                             outgoing=('127.0.0.1', first), lists=((0.5, 'Status'),))
        cls.real.start()
        (Path(cls.folder.name) / 'secret').write_text(PASSWORD)
        fleet_file = Path(cls.folder.name) / 'fleet.yaml'
        fleet_file.write_text(FLEET.format(port=cls.real.port, outgoing=first, silent=first + 1))
        cls.factory = Factory(str(fleet_file), f'map_file:={MAP}', f'sim_speed:={SPEED}',
                              first_port=first + 10)

    @classmethod
    def tearDownClass(cls) -> None:
        cls.factory.stop()
        cls.real.stop()
        cls.folder.cleanup()

    def test_all_that_answer_serve_missions_and_one_that_does_not_is_shown_offline(self) -> None:
        present = ('real', 'simulated', 'agv')
        self.factory.wait_until_ready(*present)
        self.factory.wait_for_state('switched_off', FleetRobot.OFFLINE)
        missions = [self.factory.send(goal, robot=robot)
                    for robot, goal in zip(present, (10, 32, 41))]
        wait_until(lambda: len(self.factory.ends(missions)) == len(missions), 120.0,
                   f'the ends of missions {missions}')
        self.assertEqual({MissionStatus.SUCCEEDED}, set(self.factory.ends(missions).values()),
                         self.factory.why(missions))
        place = self.factory.graph.vertices[10].position
        x, y, _ = self.real.pose
        self.assertLess(abs(x / 1000.0 - place[0]) + abs(y / 1000.0 - place[1]), 0.5)
        self.assertTrue(all(self.factory.robot(name).state in READY for name in present))


if __name__ == '__main__':
    rospy.init_node('fleet_file_test')
    run_cases(__file__)
