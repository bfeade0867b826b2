#!/usr/bin/env python3
"""Four LD-90s and four AGVs on one graph: missions end, nobody comes near anybody, stop all stops.

The robots are where their simulators truly have them, not where they say they are.
"""
from __future__ import annotations

import json
import math
import os
import random
import signal
import socket
import subprocess
import threading
import time
import unittest
from typing import Dict, List, Tuple

import rospy
from std_srvs.srv import Trigger

from graph_fleet_manager.files.fleet_file import load_fleet
from itrci_nav_msgs.msg import FleetRobot, FleetState, MissionRequest, MissionStatus
from system_support import Recorder, connected_publisher, run_cases, wait_until
from trajectory_graph import load_graph

SPEED = 5.0
MISSIONS = 20
SKEW = 0.06      # m that robots move between the answers of the two simulators
CORRIDOR = 0.45  # m, half a corridor
DOCK_ZONE = 2.0  # m around a dock, in which an LD-90 manoeuvres as it likes
READY = (FleetRobot.IDLE, FleetRobot.BUSY)
ENDED = (MissionStatus.SUCCEEDED, MissionStatus.FAILED, MissionStatus.REFUSED,
         MissionStatus.CANCELLED)


def free_ports() -> int:
    """A port from which on 40 are free: those of four LD-90s, ten apart."""
    while True:
        first = random.randrange(20000, 32000, 50)
        try:
            for port in range(first, first + 40):
                with socket.socket() as probe:
                    probe.bind(('', port))
            return first
        except OSError:
            continue


class Eye:
    """Sees where all robots truly are, and tells simulators what goes wrong."""

    def __init__(self, ports: List[int]) -> None:
        self._streams = [socket.create_connection(('127.0.0.1', port), timeout=10.0)
                         .makefile('rwb', 0) for port in ports]

    def ask(self, number: int, line: str) -> str:
        self._streams[number].write(line.encode() + b'\n')
        return self._streams[number].readline().decode().strip()

    def places(self) -> Dict[str, Tuple[float, float]]:
        robots: Dict[str, Dict[str, float]] = {}
        for number in range(len(self._streams)):
            robots.update(json.loads(self.ask(number, 'where'))['robots'])
        return {name: (pose['x'], pose['y']) for name, pose in robots.items()}


class FactoryTest(unittest.TestCase):
    """Starts a fleet with scripts/run.sh's own command, and sends it missions."""

    @classmethod
    def setUpClass(cls) -> None:
        first = free_ports()
        made = subprocess.run(
            ['rosrun', 'fleet_bringup', 'fleet_launch', 'fleet:=4', 'longest_edge:=1.5',
             f'sim_speed:={SPEED}', 'rviz:=false', f'arcl_port:={first}',
             f'outgoing_port:={first + 5}', f'control_port:={first + 2}'],
            check=True, stdout=subprocess.PIPE, text=True)
        launch = made.stdout.strip()
        cls.folder = os.path.dirname(launch)
        cls.launch = subprocess.Popen(['roslaunch', launch], start_new_session=True)
        cls.fleet = load_fleet(os.path.join(cls.folder, 'fleet.yaml'))
        cls.graph = load_graph(os.path.join(cls.folder, 'graph.yaml'))
        cls.state = Recorder('/fleet_state', FleetState)
        cls.statuses = Recorder('/mission_status', MissionStatus)
        cls.state.wait_for(
            lambda state: len(state.robots) == 8 and all(r.state in READY for r in state.robots),
            90.0, 'fleet of 8 that is ready')
        cls.eye = Eye([first + 2, first + 3])
        cls.requests = connected_publisher('/mission_request', MissionRequest)

    @classmethod
    def tearDownClass(cls) -> None:
        os.killpg(cls.launch.pid, signal.SIGINT)
        cls.launch.wait(30)
        subprocess.run(['rm', '-rf', cls.folder], check=True)

    def test_missions_end_whatever_stalls_and_nobody_comes_near_anybody(self) -> None:
        chance = random.Random(7)
        places = [id for id, vertex in self.graph.vertices.items()
                  if vertex.parking is not False and not vertex.dock]
        for number in range(1, MISSIONS + 1):
            request = MissionRequest(request_id=number,
                                     destination_vertices_id=chance.sample(places, 2))
            request.header.stamp = rospy.Time.now()
            self.requests.publish(request)
        deadline, next_stall, polls = time.monotonic() + 110.0, 0.0, 0
        while len(self.ends()) < MISSIONS:
            self.assertLess(time.monotonic(), deadline,
                            f'missions at an end: {self.ends()}; {self.state.messages[-1]}')
            if time.monotonic() > next_stall:
                next_stall = time.monotonic() + 4.0
                name = chance.choice([r.name for r in self.fleet.robots if r.driver == 'agv'])
                self.assertEqual('ok', self.eye.ask(1, f'@{name} stall 15'))
            self.check_places()
            polls += 1
            threading.Event().wait(0.03)
        print(f'{polls} looks at all robots; nearest beyond the distance allowed: '
              f'{self.nearest:.2f} m')
        self.assertGreater(polls, 200)
        self.assertEqual({MissionStatus.SUCCEEDED}, set(self.ends().values()))

    def test_stop_all_stops_all_and_they_go_on_afterwards(self) -> None:
        for number, robot in enumerate(self.fleet.robots):
            goal = next(id for id, vertex in self.graph.vertices.items()
                        if vertex.parking is not False and not vertex.dock
                        and id not in {one.vertex for one in self.fleet.robots})
            request = MissionRequest(request_id=1000 + number, robot=robot.name,
                                     destination_vertices_id=[goal, robot.vertex])
            request.header.stamp = rospy.Time.now()
            self.requests.publish(request)
        before = self.eye.places()
        wait_until(lambda: sum(math.dist(place, before[name]) > 0.5
                               for name, place in self.eye.places().items()) >= 2, 30.0,
                   'two robots drive')
        self.assertTrue(rospy.ServiceProxy('/stop_fleet', Trigger)().success)

        def all_stand() -> bool:
            places = self.eye.places()
            threading.Event().wait(0.5)
            return all(math.dist(place, places[name]) < 0.01
                       for name, place in self.eye.places().items())
        wait_until(all_stand, 10.0, 'all robots stand')
        stood = self.eye.places()
        self.assertTrue(rospy.ServiceProxy('/resume_fleet', Trigger)().success)
        wait_until(lambda: any(math.dist(place, stood[name]) > 0.5
                               for name, place in self.eye.places().items()), 30.0,
                   'a robot goes on')

    nearest = math.inf

    def ends(self) -> Dict[int, int]:
        """Missions of the first test at an end, and how they ended."""
        return {status.request_id: status.state for status in list(self.statuses.messages)
                if status.state in ENDED and status.request_id <= MISSIONS}

    def check_places(self) -> None:
        """Distances of all robots, and that each is in a corridor."""
        places = self.eye.places()
        robots = self.fleet.robots
        for number, one in enumerate(robots):
            for other in robots[:number]:
                room = (math.dist(places[one.name], places[other.name]) - one.type.radius
                        - other.type.radius - self.fleet.clearance)
                type(self).nearest = min(self.nearest, room)
                self.assertGreater(room, -SKEW, f'{one.name} and {other.name} are too near')
            x, y = places[one.name]
            if all(math.dist((x, y), vertex.position) > DOCK_ZONE
                   for vertex in self.graph.vertices.values() if vertex.dock):
                _, nearest = self.graph.nearest_edge(x, y)
                self.assertLess(nearest.distance, CORRIDOR, f'{one.name} is out of its corridor')


if __name__ == '__main__':
    rospy.init_node('factory_test')
    run_cases(__file__)
