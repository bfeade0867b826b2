"""Common parts of the bridge's tests: small graphs, and a robot without sockets."""
from __future__ import annotations

import heapq
import math
from itertools import count
from typing import Callable, Dict, List, Optional, Sequence, Tuple

from omron_arcl import ActivityKind, Outcome
from omron_arcl.drives import REFUSED
from omron_arcl.records import CommandFate, LastCommand, MotionCause, MotionState, RobotMotion
from omron_arcl.replies import DockingState
from omron_ld90.bridge import events as p
from omron_ld90.bridge.route_follower import RouteFollower
from omron_ld90.bridge.route_strategies import STRATEGIES, RouteSettings
from route_protocol.values import EpochCause, RouteOrder, RouteRefusal, RouteReport
from trajectory_graph import Edge, Graph, Vertex

BRIDGE = '/bridge'
DOCK_VERTEX = 90
NANOSECONDS = 1_000_000_000

# maps each outcome to the outcome that the bridge gets in a message
ENDINGS = {**{outcome: outcome for outcome in Outcome}, **dict.fromkeys(
    (*REFUSED, Outcome.TIMED_OUT), Outcome.FAILED)}


def told_of(motion: RobotMotion) -> p.MotionTold:
    """Returns the event with which the bridge learns the robot's motion from the controller."""
    memory = motion.memory
    last = next((one for one in memory.last_commands if one.giver == BRIDGE),
                LastCommand(BRIDGE, 0, CommandFate.NOT_OBEYED, memory.foreign_epoch))
    return p.MotionTold(
        memory.epoch, last.foreign_epoch,
        memory.giver.name == BRIDGE or memory.cause is MotionCause.EMERGENCY_STOP,
        memory.stop_owed, memory.reason,
        EpochCause.OTHER_GIVER
        if memory.cause in (MotionCause.STOP, MotionCause.INTERRUPTED)
        else EpochCause(memory.cause),
        obeys_us=memory.giver.name == BRIDGE and memory.cause is MotionCause.OTHER_GIVER,
        number=last.number, fate=last.fate, is_unexplained=memory.cause is MotionCause.INTERRUPTED,
        state=motion.state, emergency_stop=motion.emergency_stop, giver=memory.giver.name,
        previous_epoch=memory.previous_epoch)


def graph_of(places: Dict[int, Tuple[float, float]], ends: Dict[int, Tuple[int, int]]) -> Graph:
    """Returns a graph of straight edges.

    places -- {id of a vertex: (x, y)}
    ends -- {id of an edge: (origin, destination)}
    """
    return Graph([Vertex(id, x, y, 0.0) for id, (x, y) in places.items()],
                 [Edge(id, *pair, velocity_forward=1.0, velocity_backwards=1.0)
                  for id, pair in ends.items()])


def yard() -> Graph:
    """Returns a block of 4 x 4 m (vertices 1 to 4), a tail in the east (5, 6), a dock in the south.

        4 --3-- 3
        |4      |2
        1 --1-- 2 --5-- 5 --6-- 6
        |9
       90 (dock)
    """
    return graph_of(
        {1: (0, 0), 2: (4, 0), 3: (4, 4), 4: (0, 4), 5: (8, 0), 6: (12, 0), DOCK_VERTEX: (0, -4)},
        {1: (1, 2), 2: (2, 3), 3: (3, 4), 4: (4, 1), 5: (2, 5), 6: (5, 6), 9: (1, DOCK_VERTEX)})


def dissertation_graph() -> Graph:
    """Returns the dissertation's graph: edges 1, 4, 5 lead from vertex 1 through 2 and 7 to 6."""
    return graph_of({1: (0, 0), 2: (4, 0), 7: (8, 0), 6: (12, 2), 3: (4, 4)},
                    {1: (1, 2), 4: (2, 7), 5: (7, 6), 2: (2, 3)})


class GraphRobot:
    """Drives as an LD-90 would, behind a controller that reports how commands end.

    The robot takes the shortest path, brakes for its goal, and reports its place at 2 Hz.
    """

    TOP_SPEED, ACCELERATION, BRAKING = 1.35, 0.5, 0.2
    STEP, STATUS_PERIOD = 0.1, 0.5

    def __init__(self, graph: Graph, vertex: int, period: float = STATUS_PERIOD) -> None:
        self.graph = graph
        self.position = graph.vertex(vertex).position
        self.docked = vertex == DOCK_VERTEX
        self.goal: Optional[str] = None
        self.commands: List[str] = []
        self.trail: List[Tuple[float, float]] = [self.position]
        self.speed = 0.0
        self.halts = 0
        self.period = period
        self.motion = ActivityKind.DOCKED if self.docked else ActivityKind.STOPPED
        self.emergency = False
        self.number: Optional[int] = None  # number of the present drive
        self.last = 0, CommandFate.NOT_OBEYED  # number and fate of our last command
        self.foreign = False  # whether another client gave the last command
        self._way: List[Tuple[float, float]] = []
        self._since_status = period

    def obey(self, number: Optional[int], command: str) -> List[p.Event]:
        """Takes a command; returns the reports about it and about the previous command."""
        self.commands.append(command)
        self.foreign = number is None
        stops = command == 'stop'
        self.last = ((self.last[0], CommandFate.NOT_OBEYED) if number is None else
                     (number, CommandFate.COMPLETED if stops else CommandFate.OBEYED))
        events: List[p.Event] = []
        if self.number is not None:
            events.append(p.CommandEnded(self.number, Outcome.INTERRUPTED,
                                         f'replaced by "{command}"'))
            self.number = None
        if stops:
            self.halt(ActivityKind.STOPPED)
            return [*events, p.CommandEnded(number, Outcome.SUCCEEDED, 'Stopped')]
        self.docked = False
        self.number = number
        self.goal = command.split()[-1]
        vertex = DOCK_VERTEX if command == 'dock' else int(self.goal)
        self.motion = ActivityKind.DOCKING if command == 'dock' else ActivityKind.GOING_TO_GOAL
        self._way = self._shortest_way(vertex)
        return events

    def halt(self, motion: ActivityKind) -> None:
        """Makes the robot stand, and show this in its status."""
        self.goal, self._way, self.speed, self.motion = None, [], 0.0, motion

    def press_emergency_stop(self) -> List[p.Event]:
        """Presses the emergency stop, as a person would."""
        self.emergency = True
        self.halt(ActivityKind.STOPPED)
        number, self.number = self.number, None
        self.last = self.last[0], CommandFate.NOT_OBEYED
        return [] if number is None else [
            p.CommandEnded(number, Outcome.EMERGENCY_STOPPED, 'EStop pressed')]

    def step(self, now: float) -> List[p.Event]:
        """Drives for STEP seconds; returns the events of that time."""
        events: List[p.Event] = []
        left = self._left()
        if self._way:
            self.speed = min(self.speed + self.ACCELERATION * self.STEP, self.TOP_SPEED,
                             max(math.sqrt(2.0 * self.BRAKING * left), 0.05))
            self._advance(self.speed * self.STEP)
            if not self._way:
                self.halts += 1
                self.docked = self.goal == 'dock'
                if self.last[1] is CommandFate.OBEYED:
                    self.last = self.last[0], CommandFate.COMPLETED
                self.halt(ActivityKind.DOCKED if self.docked else ActivityKind.ARRIVED_AT_GOAL)
                if self.number is not None:
                    events.append(p.CommandEnded(self.number, Outcome.SUCCEEDED))
                    self.number = None
        self._since_status += self.STEP
        if self._since_status >= self.period - 1e-9:
            self._since_status = 0.0
            events.append(self.seen(now))
        return events

    def seen(self, now: float) -> p.RobotSeen:
        """Returns the robot's present status."""
        docking = {ActivityKind.DOCKED: DockingState.DOCKED,
                   ActivityKind.DOCKING: DockingState.DOCKING}
        return p.RobotSeen(int(now * NANOSECONDS), self.motion,
                           docking.get(self.motion, DockingState.UNDOCKED), self.position, 0.0)

    def _left(self) -> float:
        points = [self.position, *self._way]
        return sum(math.dist(a, b) for a, b in zip(points, points[1:]))

    def _advance(self, length: float) -> None:
        while self._way:
            gap = math.dist(self.position, self._way[0])
            if gap > length:
                t = length / gap
                self.position = tuple(a + t * (b - a)
                                      for a, b in zip(self.position, self._way[0]))
                break
            length -= gap
            self.position = self._way.pop(0)
        self.trail.append(self.position)

    def _shortest_way(self, vertex: int) -> List[Tuple[float, float]]:
        """Returns the points of the shortest path to a vertex over the straight edges."""
        edge, projection = self.graph.nearest_edge(*self.position)
        queue = [(projection.arc_length, self.graph.start_vertex(edge).id, ()),
                 (self.graph.curve(edge).length - projection.arc_length,
                  self.graph.end_vertex(edge).id, ())]
        heapq.heapify(queue)
        seen = set()
        while queue:
            cost, at, before = heapq.heappop(queue)
            way = (*before, self.graph.vertex(at).position)
            if at == vertex:
                return list(way)
            if at in seen:
                continue
            seen.add(at)
            for edge in self.graph.edges_from(at):
                heapq.heappush(queue, (cost + self.graph.curve(edge).length,
                                       self.graph.end_vertex(edge).id, way))
        raise AssertionError(f'no way to vertex {vertex}')


class Bench:
    """A follower that commands a robot. The test moves the clock."""

    def __init__(self, graph: Graph, vertex: int, strategy: str = 'vertex_by_vertex',
                 period: float = GraphRobot.STATUS_PERIOD, links: Sequence[p.RobotLink] = (),
                 **settings) -> None:
        self.robot = GraphRobot(graph, vertex, period)
        self.now = 100.0
        self.draw = count(1000).__next__  # epochs of the vehicle; the controller's are smaller
        self.follower = RouteFollower(
            RouteSettings(dock_vertex=DOCK_VERTEX, strategy=STRATEGIES[strategy], **settings),
            graph, links, self.draw, self.clock)
        self.link_is_up = dict.fromkeys(links, True)  # None while the link's node is away
        self.reports: List[RouteReport] = []
        self.refusals: List[RouteRefusal] = []
        self.notes: List[str] = []
        self.epoch = 1
        self._heard: object = None  # the news (`_news`) that the present bridge has heard
        self.hear_links()
        self.hear_motion('')
        self.look()

    def clock(self) -> int:
        """The wall clock, in ms."""
        return int(1000.0 * self.now)

    def hear_motion(self, reason: str) -> None:
        """Lets the controller report the present epoch."""
        self._heard = self._news
        self.tell(p.MotionTold(self.epoch, reason=reason,
                               number=self.robot.last[0], fate=self.robot.last[1],
                               emergency_stop=self.robot.emergency))

    def press(self, pressed: bool) -> None:
        """Presses or releases the emergency stop; the controller reports this."""
        self.robot.emergency = pressed
        self.hear_motion('')

    @property
    def _news(self) -> object:
        return self.follower, self.robot.last, self.robot.emergency

    def hear_news(self) -> None:
        """Lets the controller report a change: another client's act, the fate of our last command,
        or the emergency stop.
        """
        if self.robot.foreign:
            self.robot.foreign = False
            self.epoch += 1
            self.tell(p.MotionTold(self.epoch, reason='another client',
                                   number=self.robot.last[0],
                                   fate=CommandFate.NOT_OBEYED))
        if self._heard != self._news:
            self.hear_motion('')

    def overrule(self, reason: str = '"stop" of /rviz', command: str = '') -> None:
        """Stops or drives the robot for another giver; the controller reports it."""
        self.epoch += 1
        if command:
            self.robot.obey(None, command)
            self.robot.foreign = False
        self.hear_motion(reason)

    def master_acts(self, master: str, state: MotionState = MotionState.STANDING) -> None:
        """The master drives or stops the robot itself, and the controller reports it."""
        before, self.epoch = self.epoch, self.epoch + 1
        self.tell(p.MotionTold(
            self.epoch, state=state, number=self.robot.last[0], fate=self.robot.last[1],
            giver=f'/robot/{master}', previous_epoch=before))

    def tell(self, *events: p.Event) -> None:
        """Passes events to the follower; the robot obeys its commands."""
        for event in events:
            self._act(self.follower.handle(event, self.now))

    def look(self) -> None:
        """Lets the robot report its place and its motion."""
        self.tell(self.robot.seen(self.now))

    def hear_links(self) -> None:
        """Lets the nodes report the state of their links, as they do every second."""
        for link, up in self.link_is_up.items():
            if up is not None:
                self.tell(p.LinkReported(link, up, '' if up else 'connection refused'))

    def order(self, route_id: int, *edges: int, stamp: float = 0.0) -> None:
        self.tell(RouteOrder(route_id, edges, int(stamp * NANOSECONDS)))

    def run(self, until: Optional[Callable[[Bench], bool]] = None, seconds: float = 300.0) -> None:
        """Runs until the condition is true; by default until no route runs and no order waits."""
        until = until or (lambda bench: not bench.follower.running
                          and bench.follower.orders.waiting is None)
        end = self.now + seconds
        while not until(self):
            assert self.now < end, f'not within {seconds} s; last report: {self.last}'
            self.step()
            self.reports.append(self.follower.report())

    def drive(self, seconds: float) -> None:
        """Runs for a time in which the robot drives and reports its place."""
        end = self.now + seconds - 1e-9
        while self.now < end:
            self.step()

    def step(self) -> None:
        """Runs for a tenth of a second."""
        self.now += GraphRobot.STEP
        if round(self.now * 10) % 10 == 0:
            self.hear_links()
        self.tell(*self.robot.step(self.now))
        if any(self.link_is_up.values()) or not self.link_is_up:
            self.hear_news()
        self._act(self.follower.tick(self.now))

    def wait(self, seconds: float) -> None:
        """Moves the clock on without any message from the robot or a node."""
        end = self.now + seconds
        while self.now < end:
            self.now += GraphRobot.STEP
            self._act(self.follower.tick(self.now))

    def restart(self, away: float = 0.0) -> None:
        """Restarts the bridge's process after `away` s. The robot drives on meanwhile."""
        record = self.follower.record
        follower = self.follower
        end = self.now + away
        while self.now < end:
            self.now += GraphRobot.STEP
            self.robot.step(self.now)
        self.robot.number = None  # the new process does not receive the end of the old command
        self.follower = RouteFollower(follower.settings, follower.graph, tuple(self.link_is_up),
                                      self.draw, self.clock)
        if record:
            self.follower.restore(record, away < 20.0, self.now)
        self.hear_links()
        self.epoch += self.robot.foreign
        self.robot.foreign = False
        self.hear_motion('"stop" of /rviz')
        self.look()

    @property
    def last(self) -> Optional[RouteReport]:
        return self.reports[-1] if self.reports else None

    @property
    def commands(self) -> List[str]:
        return self.robot.commands

    def states(self) -> Sequence[int]:
        return [int(state) for state in self.follower.report().states]

    def give(self, give: p.Give) -> None:
        """Sends a command to the robot, which receives it at once."""
        if give.known_epoch not in (0, self.epoch):
            self.tell(p.CommandEnded(give.number, Outcome.OVERRULED, 'another giver came first'))
            self.robot.last = (give.number, CommandFate.NOT_OBEYED)
            self.hear_motion('')
            return
        self.tell(*self.robot.obey(give.number, give.command))

    def _act(self, actions: Sequence[p.Action]) -> None:
        for action in actions:
            if isinstance(action, p.Give):
                self.give(action)
            elif isinstance(action, RouteReport):
                self.reports.append(action)
            elif isinstance(action, RouteRefusal):
                self.refusals.append(action)
            else:
                self.notes.append(action.text)
