"""A fleet that scripts/run.sh fleet:=... starts: its places, missions, faults and menus."""
from __future__ import annotations

import itertools
import json
import math
import os
import random
import shutil
import signal
import socket
import subprocess
import time
from typing import IO, Callable, Dict, List, Sequence, Set, Tuple

import rospy
from visualization_msgs.msg import (
    InteractiveMarkerFeedback,
    InteractiveMarkerInit,
    Marker,
    MarkerArray,
)

from fleet_core.files.fleet_file import load_fleet
from fleet_requests import Sender, mission_request
from itrci_nav_msgs.msg import FleetPlan, FleetRobot, FleetState, MissionRequest, MissionStatus
from system_support import Recorder, connected_publisher, wait_until
from trajectory_graph import load_graph

READY = (FleetRobot.IDLE, FleetRobot.BUSY)
ENDED = (MissionStatus.SUCCEEDED, MissionStatus.FAILED, MissionStatus.REFUSED,
         MissionStatus.CANCELLED)
SKEW = 0.06  # m that robots can drive between the answers of the two simulators
STANDS = 0.01  # m, largest movement of a standing robot in half a second
Place = Tuple[float, float]


def free_fleet_ports() -> int:
    """Returns the first of 40 free ports. The ports of four LD-90s are ten apart."""
    while True:
        first = random.randrange(20000, 32000, 50)
        try:
            for port in range(first, first + 40):
                with socket.socket() as probe:
                    probe.bind(('', port))
            return first
        except OSError:
            continue


def _connected(port: int) -> IO[bytes]:
    return socket.create_connection(('127.0.0.1', port), timeout=10.0).makefile('rwb', 0)


class Simulators:
    """Reads the true positions of all robots, and applies faults to simulated robots."""

    def __init__(self, ports: Sequence[int]) -> None:
        self._ports = ports
        self._streams = [_connected(port) for port in ports]

    def _ask(self, number: int, line: str) -> str:
        """Sends one line and returns the answer. Connects again if the connection has ended."""
        for _ in range(2):
            try:
                self._streams[number].write(line.encode() + b'\n')
                answer = self._streams[number].readline()
            except OSError:
                answer = b''
            if answer:
                return answer.decode().strip()
            self._streams[number] = _connected(self._ports[number])
        raise AssertionError(f'the simulator on port {self._ports[number]} does not answer')

    def places(self) -> Dict[str, Place]:
        """Returns the positions of all simulated robots."""
        robots: Dict[str, Dict[str, float]] = {}
        for number in range(len(self._ports)):
            robots.update(json.loads(self._ask(number, 'where'))['robots'])
        return {name: (pose['x'], pose['y']) for name, pose in robots.items()}

    def fault(self, robot: str, fault: str) -> None:
        """Applies a fault to a robot, in the simulator that plays it."""
        answers = [self._ask(number, f'@{robot} {fault}') for number in range(len(self._ports))]
        assert 'ok' in answers, f'{fault} of {robot}: {answers}'


class Menus:
    """Chooses from the menus of the fleet like RViz, but without a mouse."""

    def __init__(self) -> None:
        self._choices = connected_publisher('/fleet_menus/feedback', InteractiveMarkerFeedback,
                                            to='fleet_visualisation')

    def choose(self, handle: str, words: str) -> None:
        """Chooses the entry with these words in the menu of a handle, such as `robot agv_1` or
        `edge 3`.
        """
        shown = rospy.wait_for_message('/fleet_menus/update_full', InteractiveMarkerInit, 10.0)
        entries = {entry.title: entry.id for marker in shown.markers if marker.name == handle
                   for entry in marker.menu_entries}
        self._choices.publish(InteractiveMarkerFeedback(
            client_id=rospy.get_name(), marker_name=handle, control_name='menu',
            event_type=InteractiveMarkerFeedback.MENU_SELECT, menu_entry_id=entries[words]))


class Viewer:
    """The markers of a topic, as a viewer shows them. It finds markers that would flicker."""

    def __init__(self, topic: str) -> None:
        self.shown: Dict[Tuple[str, int], Marker] = {}
        self.messages = 0
        self.flickers: List[str] = []
        self._subscriber = rospy.Subscriber(topic, MarkerArray, self._on_message)

    def _on_message(self, message: MarkerArray) -> None:
        before = dict(self.shown)
        for marker in message.markers:
            name = marker.ns, marker.id
            if marker.action == Marker.DELETEALL:
                if self.messages:
                    self.flickers.append('everything is taken away')
                self.shown.clear()
            elif marker.action == Marker.DELETE:
                self.shown.pop(name, None)
            else:
                if name in before and name not in self.shown:
                    self.flickers.append(f'{name} is taken away and shown again')
                self.shown[name] = marker
        self.messages += 1

    def namespaces(self) -> Set[str]:
        """Returns the namespaces of all visible markers."""
        return {namespace for namespace, _ in list(self.shown)}


class Factory:
    """A fleet on free ports, without RViz. `stop` ends it and removes its files."""

    def __init__(self, fleet: str, *options: str, first_port: int = 0) -> None:
        """fleet -- a number, or a fleet file

        `more_places` must get the positions of robots that the simulators do not play.
        """
        self.more_places: Dict[str, Callable[[], Place]] = {}
        first = first_port or free_fleet_ports()
        made = subprocess.run(
            ['rosrun', 'fleet_bringup', 'fleet_launch', f'fleet:={fleet}', 'rviz:=false',
             'page:=false', f'arcl_port:={first}', f'outgoing_port:={first + 5}',
             f'control_port:={first + 2}', *options],
            check=True, stdout=subprocess.PIPE, text=True)
        launch = made.stdout.strip()
        self.folder = os.path.dirname(launch)
        self._launch = subprocess.Popen(['roslaunch', launch], start_new_session=True)
        self._control = first + 2, first + 3
        self._ids = itertools.count(1)
        self.fleet = load_fleet(os.path.join(self.folder, 'fleet.yaml')
                                if fleet.isdigit() else fleet)
        self.graph = load_graph(os.path.join(self.folder, 'graph.yaml'))
        self.state = Recorder('/fleet_state', FleetState)
        self.plans = Recorder('/fleet_plan', FleetPlan)
        self.statuses = Recorder('/mission_status', MissionStatus)

    def wait_until_ready(self, *names: str) -> None:
        """Waits until these robots take missions; without names, until all robots do."""
        wanted = set(names or [robot.name for robot in self.fleet.robots])
        self.state.wait_for(
            lambda state: wanted <= {robot.name for robot in state.robots if robot.state in READY},
            120.0, f'fleet in which {", ".join(sorted(wanted))} are ready')
        self.simulators = Simulators(self._control)
        self._requests = Sender(MissionRequest)
        wait_until(lambda: self._requests.is_heard, 30.0, 'a program that takes missions')

    def stop(self) -> None:
        """Ends the fleet."""
        os.killpg(self._launch.pid, signal.SIGINT)
        try:
            self._launch.wait(30)
        finally:
            shutil.rmtree(self.folder)

    def places(self) -> Dict[str, Place]:
        """Returns the true position of each robot; an absent robot is left out."""
        return {**self.simulators.places(),
                **{name: place() for name, place in self.more_places.items()}}

    def robot(self, name: str) -> FleetRobot:
        """Returns the newest state of a robot from the fleet manager."""
        return next(robot for robot in self.state.messages[-1].robots if robot.name == name)

    def released(self, name: str) -> List[int]:
        """Returns the edges that a robot may drive or on which it stands."""
        return [abs(edge) for plan in self.plans.messages[-1].plans if plan.robot == name
                for edge in plan.drives.edges[:plan.released]]

    def wait_for_state(self, name: str, *states: int, timeout: float = 60.0) -> None:
        """Waits until the fleet manager reports the robot in one of these states."""
        wait_until(lambda: self.robot(name).state in states, timeout,
                   f'{name} in a state of {states}')

    @property
    def stations(self) -> List[int]:
        """Vertices to which robots can be sent: no docks, and no points that divide a long edge."""
        return [id for id, vertex in self.graph.vertices.items()
                if vertex.parking is not False and not vertex.dock]

    def home_of(self, name: str) -> int:
        """Returns the vertex at which a robot stood at the start."""
        return next(robot.vertex for robot in self.fleet.robots if robot.name == name)

    def homes(self) -> List[int]:
        """Returns the vertices at which robots stood at the start."""
        return [robot.vertex for robot in self.fleet.robots]

    def send(self, *vertices: int, robot: str = '', dwell: Sequence[float] = ()) -> int:
        """Sends a mission. Returns its id when the fleet manager has received the mission.

        This waits because the publisher's queue can overflow if many missions are sent at once.
        """
        request = mission_request(vertices, request_id=next(self._ids), robot=robot, dwell=dwell)
        self._requests.send(request)
        wait_until(lambda: any(status.request_id == request.request_id
                               for status in list(self.statuses.messages)), 30.0,
                   f'a status of mission {request.request_id}')
        return request.request_id

    def ends(self, missions: Sequence[int]) -> Dict[int, int]:
        """Returns the final state of each of these missions that has ended."""
        return {status.request_id: status.state for status in list(self.statuses.messages)
                if status.state in ENDED and status.request_id in missions}

    def status_of(self, mission: int) -> int:
        """Returns the last reported state of a mission; PENDING before the first report."""
        return next((status.state for status in reversed(self.statuses.messages)
                     if status.request_id == mission), MissionStatus.PENDING)

    def run_until(self, condition: Callable[[], bool], timeout: float, what: str,
                  missions: Sequence[int] = ()) -> int:
        """Waits for a condition, and checks the distances between robots. Returns the number of
        checks.
        """
        looks, deadline = 0, time.monotonic() + timeout
        while not condition():
            assert time.monotonic() < deadline, (
                f'not within {timeout:.0f} s: {what}; {self.why(missions)}')
            self.check_distances()
            looks += 1
            time.sleep(0.03)
        return looks

    def succeeded(self, missions: Sequence[int]) -> int:
        """Returns how many of these missions have succeeded; fails if one has ended without
        success.
        """
        ends = self.ends(missions)
        assert set(ends.values()) <= {MissionStatus.SUCCEEDED}, self.why(missions)
        return len(ends)

    def why(self, missions: Sequence[int]) -> str:
        """Returns a text for a failed test: the open missions, and all robots."""
        last = {status.request_id: (status.state, status.robot, status.reason)
                for status in list(self.statuses.messages) if status.request_id in missions}
        robots = [(robot.name, robot.state, robot.pose.edge_id, robot.destination, robot.waits_for)
                  for robot in self.state.messages[-1].robots]
        return f'missions (state, robot, reason): {last}; robots: {robots}'

    def check_distances(self) -> float:
        """Returns the smallest distance between two robots minus the required distance (m). Fails
        if it is negative.

        The simulators are read one after the other, and a robot can drive on between the readings.
        So the positions of two robots that seem too near are read once more. The robots are too
        near only if both distances between an old and a new position are too small.
        """
        places = self.places()
        nearest = math.inf
        present = [robot for robot in self.fleet.robots if robot.name in places]
        for one, other in itertools.combinations(present, 2):
            apart = one.type.radius + other.type.radius + self.fleet.clearance
            room = math.dist(places[one.name], places[other.name]) - apart
            if room <= -SKEW:
                later = self.places()
                room = max(math.dist(later[one.name], places[other.name]),
                           math.dist(places[one.name], later[other.name])) - apart
            assert room > -SKEW, f'{one.name} and {other.name} are too near: {places}'
            nearest = min(nearest, room)
        return nearest

    def moved(self, before: Dict[str, Place]) -> List[str]:
        """Returns the robots that are not where they were before."""
        return [name for name, place in self.places().items()
                if math.dist(place, before[name]) > 0.5]

    def wait_until_all_stand(self) -> None:
        """Waits until no robot moves."""
        before = self.places()

        def all_stand() -> bool:
            nonlocal before
            time.sleep(0.5)
            places, last = self.places(), before
            before = places
            return all(math.dist(place, last[name]) < STANDS for name, place in places.items())
        wait_until(all_stand, 20.0, 'all robots stand')
