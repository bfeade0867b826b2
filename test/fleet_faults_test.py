#!/usr/bin/env python3
"""A fleet of AGVs in a corridor with one siding, with faults.

The robots swap places and drop out one by one. At the end the fleet manager's disk is full. During
the whole test, the distances between robots are measured with the simulator's true poses.
"""
from __future__ import annotations

import itertools
import json
import math
import os
import socket
import threading
import unittest
from typing import Callable, Dict, List, Tuple

import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from small_disk import SmallDisk, why_not
from std_srvs.srv import Trigger

from fleet_core.supervision.history import history
from itrci_nav_msgs.msg import (
    EdgeState,
    ExecutionRouteStates,
    FleetRobot,
    FleetState,
    MissionCommand,
    MissionRequest,
    MissionStatus,
)
from system_support import (
    Recorder,
    connected_publisher,
    kill_node,
    run_cases,
    wait_until,
)

LONG = os.environ.get('LD90_LONG_TESTS') == '1'
SWAPS = 10 if LONG else 2
ALLOWED = 0.4 + 0.4 + 0.1  # m: both radii and the clearance of vectors/siding_fleet.yaml
OFTEN = 120.0  # s; long enough even if another test runs at the same time


class FleetFaults(unittest.TestCase):

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node('fleet_faults_test')
        cls.control = Control()
        cls.fleet = Recorder('/fleet_state', FleetState)
        cls.statuses = Recorder('/mission_status', MissionStatus)
        cls.diagnostics = Recorder('/diagnostics', DiagnosticArray)
        cls.reports = Recorder('/agv_3/execution_route_states', ExecutionRouteStates)
        cls.requests = connected_publisher('/mission_request', MissionRequest, to='path_supervisor')
        cls.commands = connected_publisher('/mission_command', MissionCommand, to='path_supervisor')
        cls.ids = itertools.count(1)
        cls.fleet.wait_for(lambda state: len(state.robots) == 3 and all(
            robot.seen and robot.pose.edge_id for robot in state.robots), 60, 'fleet on the graph')
        wait_until(cls.statuses.is_connected, 30, 'connection to /mission_status')
        cls.watch = Watch()

    def setUp(self) -> None:
        self.assertGreater(self.control.time(), 0.0)

    def tearDown(self) -> None:
        distance, pair = self.watch.nearest
        self.assertGreaterEqual(distance, ALLOWED - 0.001, f'{pair} came too near to each other')
        self.assertGreater(self.watch.looks, 10)

    def send(self, robot: str, *vertices: int) -> int:
        id = next(self.ids)
        self.requests.publish(request_id=id, robot=robot, destination_vertices_id=vertices)
        return id

    def wait_for_success(self, *ids: int) -> None:
        for id in ids:
            end = self.statuses.wait_for(
                lambda status, id=id: status.request_id == id and status.state in (
                    MissionStatus.SUCCEEDED, MissionStatus.FAILED, MissionStatus.REFUSED),
                OFTEN, f'end of mission {id}')
            self.assertEqual(MissionStatus.SUCCEEDED, end.state, end.reason)

    def wait_for_state(self, name: str, *states: int) -> FleetRobot:
        def robot(message: FleetState) -> FleetRobot:
            return next(robot for robot in message.robots if robot.name == name)
        return robot(self.fleet.wait_for(
            lambda message: robot(message).state in states, OFTEN,
            f'{name} in one of the states {states}', after=max(len(self.fleet.messages) - 1, 0)))

    def wait_until_on_its_way(self, name: str) -> None:
        x, y = self.control.places()[name]
        wait_until(lambda: math.dist(self.control.places()[name], (x, y)) > 0.5, OFTEN,
                   f'{name} on its way')

    def bring_in(self, name: str) -> None:
        """Repeats the call of `fleet in`, which is refused until the robot has stood for some time.
        """
        service = f'/{name}/join_fleet'
        rospy.wait_for_service(service, 30)
        wait_until(lambda: rospy.ServiceProxy(service, Trigger)().success, OFTEN,
                   f'{name} back in service')

    def test_1_two_robots_swap_their_places_through_one_siding(self) -> None:
        ends = (5, 1)
        for _ in range(SWAPS):
            self.wait_for_success(self.send('agv_1', ends[0]), self.send('agv_2', ends[1]))
            places = self.control.places()
            for name, vertex in zip(('agv_1', 'agv_2'), ends):
                self.assertLess(math.dist(places[name], (3.0 * (vertex - 1), 0.0)), 0.01)
            ends = ends[::-1]
        if SWAPS % 2:  # brings all robots to the places that the other tests expect
            self.wait_for_success(self.send('agv_1', 1), self.send('agv_2', 5))

    def test_2_after_an_emergency_stop_a_robot_goes_on_by_itself(self) -> None:
        mission = self.send('agv_1', 11)
        self.wait_until_on_its_way('agv_1')
        self.control.inject('agv_1', 'estop')
        self.wait_for_state('agv_1', FleetRobot.STOPPED)
        other = self.send('agv_2', 4)  # this robot must not have to wait
        self.wait_for_success(other)
        self.control.inject('agv_1', 'release')
        self.wait_for_success(mission)

    def test_3_a_robot_that_was_taken_over_waits_for_a_person(self) -> None:
        mission = self.send('agv_2', 2)
        self.wait_until_on_its_way('agv_2')
        self.control.inject('agv_2', 'takeover')
        robot = self.wait_for_state('agv_2', FleetRobot.TAKEN_OVER)
        self.assertIn('taken over', robot.waits_for)
        self.statuses.wait_for(lambda status: status.request_id == mission
                               and status.state == MissionStatus.PENDING and status.reason,
                               OFTEN, 'mission without a robot', self.given_at(mission))
        self.bring_in('agv_2')
        self.wait_for_success(mission)

    def given_at(self, mission: int) -> int:
        """Returns the index of the first status that gives the mission to a robot."""
        return next(k for k, status in enumerate(self.statuses.messages)
                    if status.request_id == mission and status.state == MissionStatus.ACTIVE)

    def test_4_a_robot_that_leaves_keeps_its_place_until_a_person_brings_it_back(self) -> None:
        mission = self.send('agv_3', 4)
        self.wait_until_on_its_way('agv_3')
        self.control.inject('agv_3', 'leave')
        self.wait_for_state('agv_3', FleetRobot.OFFLINE)
        other = self.send('agv_1', 3)  # to a vertex next to the robot that left
        self.wait_for_success(other)
        self.control.inject('agv_3', 'join')
        robot = self.wait_for_state('agv_3', FleetRobot.FAILED)
        self.assertIn('forgotten its route', robot.waits_for)
        self.bring_in('agv_3')
        self.wait_for_success(mission)

    def test_5_on_a_full_disk_people_stop_and_cancel_and_nothing_else_is_begun(self) -> None:
        disk = self.move_to_a_small_disk()
        mission = self.begin_to_drive_over_two_edges()
        with disk.filled():
            self.refused_for_the_disk('free space on its disk')

            self.commands.publish(request_id=mission, command=MissionCommand.CANCEL)
            self.reports.wait_for(lambda report: len(_left_of(report)) == 1, OFTEN,
                                  'route that the cancel cut', after=len(self.reports.messages))
            self.wait_for_status(mission, lambda status: status.reason.startswith(
                'CANCEL is carried out, but will be lost if'))

            self.stopped_but_not_stored()
            states = {line.request_id: line.state.name for line in history(self.journal)}
            self.assertEqual('ACTIVE', states[mission], 'what is on the disk is as it was')

        self.wait_for_status(mission, lambda status: status.state == MissionStatus.CANCELLED)
        self.assertIn('stopped', self.wait_for_fleet_diagnosis(DiagnosticStatus.WARN))
        resumed = rospy.ServiceProxy('/resume_fleet', Trigger)()
        self.assertTrue(resumed.success, resumed.message)
        self.wait_for_success(self.send('agv_3', 4))

    def test_6_on_a_disk_that_dies_people_stop_and_a_new_disk_is_as_a_lost_one(self) -> None:
        disk = self.move_to_a_small_disk()
        self.begin_to_drive_over_two_edges()
        disk.die()
        self.refused_for_the_disk('disk I/O error')
        self.stopped_but_not_stored()
        self.move_to_a_small_disk()
        self.wait_for_success(self.send('agv_3', 6))

    def move_to_a_small_disk(self) -> SmallDisk:
        """Starts the fleet manager anew, with an empty journal on a small separate disk."""
        reason = why_not()
        if reason:
            self.skipTest(reason)
        disk = SmallDisk()
        disk.__enter__()
        self.addCleanup(disk.__exit__)
        type(self).journal = str(disk.folder / 'fleet.sqlite')
        rospy.set_param('/path_supervisor/journal', self.journal)
        kill_node('/path_supervisor')
        for name in ('agv_1', 'agv_2', 'agv_3'):
            self.wait_for_state(name, FleetRobot.IDLE)
        for publisher in (self.requests, self.commands):
            wait_until(lambda p=publisher: any(
                info[1].endswith('/path_supervisor') for info in p.impl.get_stats_info()),
                30, 'the new fleet manager listens')
        return disk

    def begin_to_drive_over_two_edges(self) -> int:
        """Begins a mission of agv_3 from vertex 4. The robot stalls during this mission."""
        self.control.inject('agv_3', 'stall 1000000')
        mission = self.send('agv_3', 6)
        self.reports.wait_for(lambda report: len(_left_of(report)) == 2, OFTEN,
                              'route over two edges', after=len(self.reports.messages))
        return mission

    def refused_for_the_disk(self, words: str) -> None:
        refused = self.wait_for_status(self.send('agv_1', 3), lambda status: True)
        self.assertEqual(MissionStatus.REFUSED, refused.state)
        self.assertIn('cannot be written', refused.reason)
        self.assertIn(words, refused.reason)

    def stopped_but_not_stored(self) -> None:
        """Checks that a stop reaches the robot, and that the answer warns that the stop may be
        forgotten.
        """
        stopped = rospy.ServiceProxy('/stop_fleet', Trigger)()
        self.assertTrue(stopped.success, stopped.message)
        self.assertIn('it is forgotten', stopped.message)
        self.reports.wait_for(lambda report: not report.edge_states, OFTEN, 'stop',
                              after=len(self.reports.messages))
        self.control.inject('agv_3', 'stall 0')
        self.assertIn(os.path.basename(self.journal),
                      self.wait_for_fleet_diagnosis(DiagnosticStatus.ERROR))

    def wait_for_status(self, mission: int,
                        predicate: Callable[[MissionStatus], bool]) -> MissionStatus:
        return self.statuses.wait_for(
            lambda status: status.request_id == mission and predicate(status), OFTEN,
            f'such status of mission {mission}')

    def wait_for_fleet_diagnosis(self, level: int) -> str:
        """Waits until /diagnostics has a new entry of the fleet with this level."""
        def of_fleet(array: DiagnosticArray) -> List[str]:
            return [status.message for status in array.status
                    if status.name == 'path_supervisor: fleet' and status.level == level]
        return of_fleet(self.diagnostics.wait_for(of_fleet, OFTEN, 'a diagnosis of the fleet',
                                                  after=len(self.diagnostics.messages)))[0]


def _left_of(report: ExecutionRouteStates) -> List[int]:
    return [edge.edge_id for edge in report.edge_states if edge.state == EdgeState.PROCESSING]


class Control:
    """The simulator's control socket: faults, and the true poses of all robots."""

    def __init__(self) -> None:
        port = int(os.environ.get('LD90_ARCL_PORT', 17171))
        self._lock = threading.Lock()
        self._connection = wait_until(lambda: _connected(port), 30, 'the control socket')
        self._replies = self._connection.makefile()

    def ask(self, line: str) -> str:
        with self._lock:
            self._connection.sendall(line.encode() + b'\n')
            return self._replies.readline().strip()

    def inject(self, robot: str, fault: str) -> None:
        answer = self.ask(f'@{robot} {fault}')
        assert answer == 'ok', answer

    def time(self) -> float:
        return json.loads(self.ask('where'))['time']

    def places(self) -> Dict[str, Tuple[float, float]]:
        robots = json.loads(self.ask('where'))['robots']
        return {name: (place['x'], place['y']) for name, place in robots.items()}


def _connected(port: int) -> socket.socket:
    try:
        return socket.create_connection(('127.0.0.1', port), timeout=20.0)
    except ConnectionRefusedError:
        return None


class Watch:
    """Reads the true poses continuously, and keeps the smallest distance between two robots."""

    def __init__(self) -> None:
        self.nearest: Tuple[float, List[str]] = (math.inf, [])
        self.looks = 0
        self._control = Control()
        threading.Thread(target=self._measure, daemon=True).start()

    def _measure(self) -> None:
        pause = threading.Event()
        while not pause.wait(0.02):
            places = self._control.places()
            for pair in itertools.combinations(sorted(places), 2):
                self.nearest = min(self.nearest, (math.dist(*map(places.get, pair)), list(pair)))
            self.looks += 1


if __name__ == '__main__':
    run_cases(__file__)
