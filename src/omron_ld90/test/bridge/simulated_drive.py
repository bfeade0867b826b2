"""The bridge's core drives the simulated LD-90, without ROS, sockets or waiting.

Bridge and simulator have no input and output. So a drive of minutes takes a second or two, and the
same drive gives the same figures each time.
"""
from __future__ import annotations

import math
from functools import lru_cache
from pathlib import Path
from typing import Callable, List, Optional, Tuple

import numpy as np
from bridge_builders import BRIDGE, ENDINGS, told_of
from scipy.spatial import cKDTree

from omron_arcl import (
    ActivityKind,
    Giver,
    StatusAssembler,
    parse_command,
    parse_line,
    read_activity,
)
from omron_arcl.dispatcher import Dispatcher
from omron_arcl.records import RobotMotion
from omron_arcl.replies import DockingState, DockingStatus, OneLineStatus
from omron_ld90.bridge import events as p
from omron_ld90.bridge.route_follower import RouteFollower
from omron_ld90.bridge.route_strategies import STRATEGIES, RouteSettings
from omron_ld90_sim.behaviour.robot import SimRobot
from omron_ld90_sim.clock import SimClock, Ticker
from omron_ld90_sim.interface.commands import execute
from omron_ld90_sim.interface.faults import Faults
from omron_ld90_sim.interface.server import ArclServer
from omron_ld90_sim.interface.session import SimSession
from omron_ld90_sim.motion.floor import SimFloor
from omron_ld90_sim.motion.kinematics import SimPose
from omron_map import MapDocument
from route_protocol.values import RouteOrder, RouteReport
from trajectory_graph import Graph, load_graph

MAPS = Path(__file__).resolve().parents[4] / 'maps'
STEP = 0.05           # s
TICK = 0.1            # s
STATUS_PERIOD = 0.5   # s
PATH_STEP = 0.05  # s between samples of the driven path
NANOSECONDS = 1_000_000_000
DOCK_VERTEX = 16


@lru_cache(maxsize=None)
def _laboratory() -> Graph:
    return load_graph(MAPS / 'lab_graph.yaml')


@lru_cache(maxsize=2)
def _site(map_file: Path) -> Tuple[MapDocument, SimFloor]:
    """Returns a map and its floor. No drive changes them."""
    document = MapDocument.load(str(map_file))
    return document, SimFloor.from_map(document)


class SimulatedDrive:
    """One robot on `lab.map` that drives the routes that the test orders."""

    def __init__(self, strategy: str = 'vertex_by_vertex', vertex: Optional[int] = None,
                 heading: float = 0.0, map_file: Path = MAPS / 'lab.map',
                 graph: Optional[Graph] = None, **settings) -> None:
        """Starts at a vertex with `heading` (degrees), or in the dock."""
        self.graph = graph or _laboratory()
        self.clock = SimClock()
        document, floor = _site(map_file)
        start = None
        if vertex is not None:
            x, y = self.graph.vertex(vertex).position
            start = SimPose(1000.0 * x, 1000.0 * y, heading)
        self.robot = SimRobot(self.clock, document, floor, start, 0)
        self.server = ArclServer(self.clock, self.robot, 'adept', execute)
        self._faults = Faults(self.server)
        self.follower = RouteFollower(RouteSettings(
            dock_vertex=DOCK_VERTEX, strategy=STRATEGIES[strategy], **settings), self.graph)
        self.reports: List[RouteReport] = []
        self.commands: List[str] = []
        self.path: List[Tuple[float, float]] = []  # m
        self.lines: List[str] = []
        self.notes: List[str] = []
        self._dispatcher = Dispatcher()
        self._told: Optional[RobotMotion] = None
        self._statuses = StatusAssembler()
        self._docking = DockingState.DOCKED if vertex is None else DockingState.UNDOCKED
        self._client = self.server.connect()
        self._client.receive(b'adept\n')
        self._lines_of(self._client)
        self._outgoing = self.server.connect_outgoing()
        self._status = Ticker(self.clock, STATUS_PERIOD,
                              lambda: self.server.execute(self._outgoing, 'Status'))
        self._next_tick = self._next_sample = 0.0
        self.run(lambda: self.follower.robot.location.last is not None, 5.0)

    @property
    def now(self) -> float:
        """Simulated seconds since the start."""
        return self.clock.now

    def order(self, route_id: int, *edges: int) -> None:
        """Publishes a route of the fleet manager."""
        self._act(self.follower.handle(RouteOrder(route_id, edges), self.now))

    def drive(self, route_id: int, *edges: int, seconds: float = 600.0) -> float:
        """Drives a route to its end; returns the seconds that it took."""
        start = self.now
        self.order(route_id, *edges)
        self.run(lambda: not self.follower.running and self.follower.orders.waiting is None,
                 seconds)
        return self.now - start

    def wait(self, seconds: float) -> None:
        """Runs for the given simulated time."""
        end = self.now + seconds
        self.run(lambda: self.now >= end, seconds + 1.0)

    def send(self, command: str, seconds: float = 300.0) -> None:
        """Drives the robot by a command, without the bridge, and waits until it has arrived."""
        heard = len(self.lines)
        self._client.receive(f'{command}\n'.encode())
        self.run(lambda: any(line.startswith(('Arrived at', 'DockingState: Docked'))
                             for line in self.lines[heard:]), seconds)

    @property
    def stops(self) -> bool:
        """Whether a stop of the bridge is under way."""
        return self._dispatcher.records.motion.memory.stop_owed

    def inject(self, fault: str) -> None:
        """Injects a fault into the simulator, such as `estop press`."""
        self._faults.inject(fault)

    def enable_motors(self) -> None:
        """Enables the motors, as a person would; the robot's status shows it."""
        self._client.receive(b'enableMotors\n')
        self.wait(2.0 * STATUS_PERIOD)

    def run(self, until: Callable[[], bool], seconds: float) -> None:
        """Runs in simulated time until the condition is true."""
        end = self.now + seconds
        while not until():
            assert self.now < end, f'not within {seconds} s: {self.follower.report()}'
            self.clock.advance(self.now + STEP)
            self._listen()
            if self.now >= self._next_sample:
                self._next_sample += PATH_STEP
                pose = self.robot.true_pose
                self.path.append((pose.x / 1000.0, pose.y / 1000.0))
            if self.now >= self._next_tick:
                self._next_tick += TICK
                self._act(self.follower.tick(self.now))
                self.reports.append(self.follower.report())

    def distance_from(self, edges: Tuple[int, ...], since: int = 0) -> float:
        """Returns the maximum distance (m) between the edges and the path after sample `since`."""
        curves = cKDTree(np.concatenate([self.graph.curve(edge).sample(0.01) for edge in edges]))
        return float(curves.query(self.path[since:])[0].max())

    def first_nearest_to(self, vertex: int, since: int = 0) -> Tuple[float, int]:
        """Returns how near (m) the driven path comes to a vertex, and the index of the nearest
        sample.

        The search begins at sample `since`. Only the first approach to less than a metre counts. If
        there is none, returns infinity and the number of samples.
        """
        away = np.hypot(*(np.array(self.path[since:]) - self.graph.vertex(vertex).position).T)
        near = np.flatnonzero(away < 1.0)
        if not len(near):
            return math.inf, len(self.path)
        leaves = np.flatnonzero(away[near[0]:] >= 1.0)
        end = near[0] + leaves[0] if len(leaves) else len(away)
        best = int(near[0] + away[near[0]:end].argmin())
        return float(away[best]), since + best

    def _listen(self) -> None:
        """Passes on the lines of controller and receiver, as the nodes do for the bridge."""
        for line in self._lines_of(self._client):
            self.lines.append(line)
            self._dispatcher.on_reply(parse_line(line), line, self.now)
        self._dispatcher.on_time(self.now)
        for line in self._lines_of(self._outgoing):
            status = self._statuses.add(parse_line(line), self.now)
            if status is not None:
                self._see(status)
        self._send()

    def _see(self, status: OneLineStatus) -> None:
        activity = read_activity(status.status)
        if isinstance(activity.reply, DockingStatus):
            self._docking = DockingState(activity.reply.docking.value)
        elif activity.kind is not ActivityKind.UNKNOWN:
            self._docking = DockingState.UNDOCKED
        self._tell(p.RobotSeen(
            int(self.now * NANOSECONDS) + 1, activity.kind,
            self._docking, (status.location.x / 1000.0, status.location.y / 1000.0)))

    def _send(self) -> None:
        while True:
            line = self._dispatcher.next_to_send(self.now)
            if line is None:
                break
            self._client.receive(line + b'\n')
        motion = self._dispatcher.records.motion
        if motion != self._told:
            self._told = motion
            self._tell(told_of(motion))
        for call in self._dispatcher.pop_callbacks():
            call()

    def _give(self, give: p.Give) -> None:
        self.commands.append(give.command)
        self._dispatcher.start(
            parse_command(give.command),
            on_end=lambda result: self._tell(p.CommandEnded(
                give.number, ENDINGS[result.outcome], result.words)),
            giver=Giver(BRIDGE), number=give.number)
        self._send()

    def _tell(self, *events: p.Event) -> None:
        for event in events:
            self._act(self.follower.handle(event, self.now))

    def _act(self, actions: List[p.Action]) -> None:
        for action in actions:
            if isinstance(action, p.Give):
                self._give(action)
            elif isinstance(action, RouteReport):
                self.reports.append(action)
            elif isinstance(action, p.BridgeNote):
                self.notes.append(action.text)

    @staticmethod
    def _lines_of(session: SimSession) -> List[str]:
        text = session.output.decode('ascii')
        session.output.clear()
        return text.split('\r\n')[:-1]
