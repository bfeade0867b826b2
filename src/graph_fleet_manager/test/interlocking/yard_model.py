"""A model of a small yard that tests the interlocking with all possible events.

Robots move in steps of half an edge. Orders reach them in order, late, or never. Reports arrive
late, twice, in any order, or never. The supervisor's side is the real code: route clients and the
interlocking. The true situation is computed here, from straight lines alone.
"""
from __future__ import annotations

import copy
import math
from collections import deque
from dataclasses import dataclass, replace
from itertools import count
from random import Random
from typing import (
    Callable,
    Deque,
    Dict,
    FrozenSet,
    Iterator,
    List,
    NamedTuple,
    Optional,
    Set,
    Tuple,
)

from graph_fleet_manager.fleet import RobotType
from graph_fleet_manager.geometry.site_geometry import SiteGeometry
from graph_fleet_manager.interlocking.allocation import Allocation
from graph_fleet_manager.interlocking.interlocking import Interlocking
from graph_fleet_manager.interlocking.orders import Memory
from graph_fleet_manager.interlocking.reports import (
    Pose,
    Report,
    WrongReport,
    check_report,
    position_of,
)
from graph_fleet_manager.interlocking.route_client import RouteClient
from graph_fleet_manager.interlocking.route_record import RouteRecord
from graph_fleet_manager.supervision.restoring import lost_areas
from route_protocol.values import NO_REASON, EdgeState, Phase, Reason, ReasonCode
from route_protocol.values import RouteRefusal as Refused
from trajectory_graph import Graph

CLEARANCE = 0.1
CHANGED = 99  # id of the edge with which a reload replaces another one
NO = Reason(ReasonCode.OTHER, 'no')


class Told(NamedTuple):
    """A report on its way; `moved` is the distance in m that the robot had driven by then."""

    report: Report
    moved: float


class Unheard(NamedTuple):
    """A refusal on its way."""

    refusal: Refused
    stamp: float


@dataclass
class Machine:
    """The true robot, `half` halves of a signed edge from its beginning."""

    edge: int
    half: int = 0
    route_id: int = 0
    edges: Tuple[int, ...] = ()
    current: int = 0
    phase: Phase = Phase.STOPPED
    moved: float = 0.0
    told: int = 0
    is_ahead: bool = False
    """True if its clock is ahead."""
    refuses: bool = False
    refused: Tuple[int, Tuple[int, ...]] = (0, ())
    """The order that it refused last. It refuses this order each time."""
    slides: int = 0
    """The edge into which it can slide half way, because its route was cut while it drove; or 0."""
    is_moved: bool = False
    """True if a person has moved it; until this is known, its place is not the interlocking's
    fault.
    """
    orders: Tuple[Tuple[int, Tuple[int, ...]], ...] = ()
    """Orders on their way to the robot."""
    words: Tuple[object, ...] = ()
    """Reports and refusals on their way from the robot."""

    def order(self, graph: Graph, route_id: int, edges: Tuple[int, ...]) -> bool:
        """Accepts or refuses an order by the rules of the route protocol."""
        if not edges:
            self.route_id, self.edges, self.current, self.phase = route_id, (), 0, Phase.STOPPED
            self.slides = 0
            return True
        if (route_id, edges) == (self.route_id, self.edges):
            return True
        if self.refuses or (route_id, edges) == self.refused or not (
                set(map(abs, edges)) <= graph.edges.keys()):
            self.refuses = False
            return False
        if route_id == self.route_id and self.phase is not Phase.STOPPED:
            kept = self.edges[:self.current + 1]
            if self.phase is Phase.FAILED or edges[:len(kept)] != kept:
                return False
            more = self.edges[self.current + 1:self.current + 2]
            is_cut = edges == kept and more and self.phase is Phase.RUNNING and self.half == 1
            self.slides = more[0] if is_cut else 0
        else:
            begins = self._begins(graph, edges)
            if begins is None:
                return False
            self.current, self.edge, self.half = begins
            self.slides = 0
        self.route_id, self.edges = route_id, edges
        self.phase = Phase.RUNNING if self.current < len(edges) else Phase.COMPLETE
        self._arrive()
        return True

    def _begins(self, graph: Graph, edges: Tuple[int, ...]) -> Optional[Tuple[int, int, int]]:
        first = edges[0]
        if first == self.edge and self.half < 2:
            return 0, first, self.half
        if first == -self.edge and self.half > 0:
            return 0, first, 2 - self.half
        at = {0: graph.start_vertex(self.edge).id, 2: graph.end_vertex(self.edge).id}.get(self.half)
        if at == graph.start_vertex(first).id:
            return 0, first, 0
        driven = self.edges[self.current - 1] if 0 < self.current < len(self.edges) else 0
        if first == driven and edges[1:2] == (self.edge,) and self.half == 0:
            return 1, self.edge, 0
        return None

    def _arrive(self) -> None:
        while self.phase is Phase.RUNNING and (
                self.edge == self.edges[self.current] and self.half == 2):
            self.current += 1
            if self.current == len(self.edges):
                self.phase = Phase.COMPLETE
            else:
                self.edge, self.half = self.edges[self.current], 0

    def move(self, graph: Graph) -> None:
        """Moves half an edge along its route."""
        if self.edge != self.edges[self.current]:
            self.edge, self.half = self.edges[self.current], 0
        self.half += 1
        self.moved += graph.curve(self.edge).length / 2
        self._arrive()

    def slide(self, graph: Graph) -> None:
        """Moves to the end of its route, and half an edge beyond it."""
        edge = self.slides
        self.move(graph)
        self.edge, self.half, self.slides = edge, 1, 0
        self.moved += graph.curve(edge).length / 2

    def report(self) -> Told:
        """Its present report."""
        self.told += 1
        rest = EdgeState.FAILED if self.phase is Phase.FAILED else EdgeState.PROCESSING
        states = ((EdgeState.COMPLETE,) * self.current
                  + (rest,) * (len(self.edges) - self.current))
        return Told(Report(self.route_id, self.edges, states, Pose(self.edge, self.half / 2),
                           NO if self.phase is Phase.FAILED else NO_REASON,
                           100.0 + self.told * 1e-3), self.moved)


@dataclass
class Believed:
    """A robot as the fleet manager knows it."""

    name: str
    type: RobotType
    client: RouteClient
    needs_person: bool = False
    is_silent: bool = False
    is_halted: bool = False
    stored: Optional[Memory] = None
    """The robot's entry on the disk."""


@dataclass
class World:
    """The whole state, true and believed."""

    machines: Dict[str, Machine]
    robots: Dict[str, Believed]
    given: int = 0
    faults: int = 0
    ids: int = 0
    is_stopped: bool = False
    is_disk_full: bool = False
    closed: FrozenSet[int] = frozenset()
    is_changed: bool = False
    """True if another edge replaces one in the graph in force."""
    history: Tuple[str, ...] = ()

    def clone(self) -> World:
        """A copy, from which another sequence of events can follow."""
        return World({name: replace(machine) for name, machine in self.machines.items()},
                     {name: replace(robot, client=_clone(robot.client))
                      for name, robot in self.robots.items()},
                     self.given, self.faults, self.ids, self.is_stopped, self.is_disk_full,
                     self.closed, self.is_changed, self.history)


def _clone(client: RouteClient) -> RouteClient:
    other = copy.copy(client)
    other.record = copy.copy(client.record)
    other.record.edges = list(client.record.edges)
    other.evidence = copy.copy(client.evidence)
    other._pending = copy.copy(client._pending)
    other._bases = dict(client._bases)
    other._acknowledged, other._ended = set(client._acknowledged), set(client._ended)
    other._since_loss = set(client._since_loss)
    return other


class Limits(NamedTuple):
    """Limits on events: grants, faults, and messages on their way at once."""

    grants: int
    faults: int
    flights: int = 2


class Found(NamedTuple):
    """A fault, and the events that led to it."""

    what: str
    history: Tuple[str, ...]


class Yard:
    """All possible events on a graph of straight edges.

    begins  -- signed edge at whose beginning each robot stands unheard -- robots that have not
    reported yet spare   -- id of an edge that a reload replaces by another one, and the next reload
    brings back sends_before_commit -- an order is sent before the data that it relies on is stored
    """

    def __init__(self, graph: Graph, kind: RobotType, begins: Dict[str, int],
                 limits: Limits, sends_before_commit: bool = False,
                 unheard: FrozenSet[str] = frozenset(), spare: int = 0) -> None:
        self.graph, self.kind, self.limits, self.spare = graph, kind, limits, spare
        changed = [replace(edge, id=CHANGED) if edge.id == spare else edge
                   for edge in graph.edges.values()]
        self._changed = Graph(graph.vertices.values(), changed)
        self._truth = Graph(graph.vertices.values(), {*graph.edges.values(), *changed})
        self.sends_before_commit = sends_before_commit
        self._geometries = SiteGeometry(graph), SiteGeometry(self._changed)
        self._begins, self.unheard = begins, unheard
        self.states = 0
        self._points: Dict[Tuple[int, int], Tuple[float, float]] = {}

    # -- the search -------------------------------------------------------------------------------

    def search(self, most: Optional[int] = None) -> Optional[Found]:
        """Checks all states, or the first `most` of them; returns the first fault."""
        world = self.begin()
        waiting: Deque[World] = deque([world])
        seen: Set[object] = {self._key(world)}
        while waiting and (most is None or self.states < most):
            world = waiting.popleft()
            self.states += 1
            for event in self.events(world):
                after = world.clone()
                after.history = (*world.history, ' '.join(map(str, event)))
                if not self.happen(after, event):
                    continue
                fault = self.fault(after, event)
                if fault:
                    return Found(fault, after.history)
                key = self._key(after)
                if key not in seen:
                    seen.add(key)
                    waiting.append(after)
        return None

    def begin(self) -> World:
        """The initial state: each robot stands at the beginning of its edge, and has reported."""
        machines = {name: Machine(edge) for name, edge in self._begins.items()}
        robots = {name: Believed(name, self.kind, self._client(self.graph)) for name in machines}
        world = World(machines, robots)
        for name in sorted(machines.keys() - self.unheard):
            self._hear(world, name, machines[name].report())
            self._store(world, name)
        return world

    def _store(self, world: World, name: str) -> None:
        robot = world.robots[name]
        if not world.is_disk_full:
            robot.stored = robot.client.memory

    def _client(self, graph: Graph) -> RouteClient:
        return RouteClient(RouteRecord(graph, self.kind, stopping=4.0))

    def graph_in_force(self, world: World) -> Graph:
        """The graph that the fleet manager and the robots use."""
        return self._changed if world.is_changed else self.graph

    def interlocking(self, world: World, only: str = '') -> Interlocking:
        """The interlocking of a world, or of one robot of it."""
        ids = count(world.ids + 1)

        def new_id() -> int:
            world.ids = next(ids)
            return world.ids
        robots = {only: world.robots[only]} if only else world.robots
        site = Interlocking(self._geometries[world.is_changed], CLEARANCE, robots, new_id)
        site.is_stopped, site.closed = world.is_stopped, world.closed
        site.trouble = 'a full disk' if world.is_disk_full else ''
        return site

    # -- events
    # --------------------------------------------------------------------------------------

    def events(self, world: World) -> Iterator[Tuple[object, ...]]:
        """All events that are possible next."""
        flights = sum(len(m.orders) + len(m.words) for m in world.machines.values())
        is_free, may_fail = flights < self.limits.flights, world.faults < self.limits.faults
        for name, machine in world.machines.items():
            robot = world.robots[name]
            client = robot.client
            if world.given < self.limits.grants:
                for edge in self._next_edges(world, client):
                    yield 'grant', name, edge
            if client.order is not None and is_free:
                yield 'send', name
            if machine.orders:
                yield 'deliver', name
            if machine.phase is Phase.RUNNING:
                yield 'move', name
                if machine.slides and machine.half == 1 and (
                        machine.current == len(machine.edges) - 1):
                    yield 'slide', name
            if is_free:
                yield 'report', name
            for number in range(len(machine.words)):
                yield 'hear', name, number
            if len(client.record.ahead) > 1:
                yield 'cut', name
            if robot.is_halted and not robot.needs_person and client.order is None and (
                    machine.phase is Phase.STOPPED and self._is_located(robot, machine)):
                yield 'settle', name
            if may_fail:
                if machine.orders:
                    yield 'lose order', name
                for number in range(len(machine.words)):
                    yield 'lose', name, number
                    yield 'repeat', name, number
                if not machine.refuses:
                    yield 'refuse', name
                if machine.phase is Phase.RUNNING:
                    yield 'fail', name
                if not machine.is_moved and machine.phase is not Phase.RUNNING:
                    yield 'carry', name
                yield 'halt', name
        if may_fail:
            yield ('restart',)
            if self.spare and all(self._may_lose_edge(m) for m in world.machines.values()):
                yield ('reload',)

    def of_people(self, world: World) -> Iterator[Tuple[object, ...]]:
        """Further acts of people, for random walks; a complete search would not end with them."""
        yield ('resume' if world.is_stopped else 'stop',)
        yield ('free disk' if world.is_disk_full else 'fill disk',)
        for edge in self.graph.edges:
            yield 'open' if edge in world.closed else 'close', edge
        for name, machine in world.machines.items():
            robot = world.robots[name]
            yield 'mend clock' if machine.is_ahead else 'set clock', name
            if (robot.needs_person or robot.is_halted) and machine.phase is not Phase.RUNNING and (
                    robot.client.order is None) and self._is_located(robot, machine):
                yield 'bring in', name

    def _is_located(self, robot: Believed, machine: Machine) -> bool:
        return robot.client.record.pose == Pose(machine.edge, machine.half / 2)

    def _may_lose_edge(self, machine: Machine) -> bool:
        """True if a machine is neither on that edge nor on its way to it, as graph_server asks."""
        ahead = machine.edges[machine.current:] if machine.phase is Phase.RUNNING else ()
        return not {self.spare, CHANGED} & set(map(abs, (machine.edge, machine.slides, *ahead)))

    def _next_edges(self, world: World, client: RouteClient) -> Tuple[int, ...]:
        record = client.record
        if record.is_standing and record.position is not None and record.position.vertex is None:
            return record.position.edge, -record.position.edge
        vertex = record.last_vertex
        return () if vertex is None else tuple(self.graph_in_force(world).edges_from(vertex))

    def happen(self, world: World, event: Tuple[object, ...]) -> bool:
        """Carries out an event; False if it changes nothing."""
        what, rest = str(event[0]), event[1:]
        world.faults += what in ('lose order', 'lose', 'repeat', 'refuse', 'fail', 'carry', 'halt',
                                 'restart', 'reload')
        if what in ('restart', 'reload'):
            before = self.graph_in_force(world)
            world.is_changed ^= what == 'reload'
            self._restart(world, before)
        elif what in ('stop', 'resume'):
            world.is_stopped = what == 'stop'
            for robot in world.robots.values() if world.is_stopped else ():
                self._halt(world, robot)
        elif what in ('fill disk', 'free disk'):
            world.is_disk_full = what == 'fill disk'
            for name in () if world.is_disk_full else world.robots:
                self._store(world, name)
        elif what in ('open', 'close'):
            world.closed = world.closed ^ {int(str(rest[0]))}
        else:
            return self._happen_to(world, what, str(rest[0]), rest[1:])
        return True

    def _halt(self, world: World, robot: Believed) -> None:
        robot.client.halt(self.interlocking(world)._new_id)
        robot.is_halted = True
        self._store(world, robot.name)

    def _happen_to(self, world: World, what: str, name: str, rest: Tuple[object, ...]) -> bool:
        machine, robot = world.machines[name], world.robots[name]
        if what == 'grant':
            if not self.interlocking(world).grant(robot, (int(str(rest[0])),)).edges:
                return False
            world.given += 1
        elif what == 'send':
            return self._send(world, name)
        elif what == 'deliver':
            self._deliver(machine, self.graph_in_force(world))
        elif what == 'move':
            machine.move(self._truth)
        elif what == 'slide':
            machine.slide(self._truth)
        elif what == 'report':
            machine.words += (machine.report(),)
        elif what in ('hear', 'repeat', 'lose'):
            number = int(str(rest[0]))
            word = machine.words[number]
            if what != 'repeat':
                machine.words = machine.words[:number] + machine.words[number + 1:]
            if what != 'lose':
                self._hear(world, name, word)
        elif what == 'cut':
            ids = self.interlocking(world)._new_id
            before = robot.client.order
            robot.client.shorten(ids)
            self._store(world, name)
            return robot.client.order is not before
        elif what == 'settle':
            record = robot.client.record
            robot.client.settle(position_of(record.pose, record.graph, record.near))
            robot.is_halted = False
            self._store(world, name)
        elif what == 'lose order':
            machine.orders = machine.orders[1:]
        elif what == 'refuse':
            machine.refuses = True
        elif what == 'fail':
            machine.phase = Phase.FAILED
        elif what == 'carry':
            machine.is_moved, machine.phase = True, Phase.STOPPED
            machine.half = 1 if machine.half != 1 else 2
            machine.moved += self._truth.curve(machine.edge).length / 2
        elif what == 'halt':
            self._halt(world, robot)
        elif what in ('set clock', 'mend clock'):
            machine.is_ahead = not machine.is_ahead
        elif what == 'bring in':
            record = robot.client.record
            if world.is_disk_full:
                return False  # a restart would forget it
            if robot.client.withdrawn is not None:
                self._halt(world, robot)
                return True
            robot.client.settle(position_of(record.pose, record.graph, record.near))
            robot.needs_person = bool(self.interlocking(world).excluding(name))
            robot.is_halted = world.is_stopped
            machine.is_moved = robot.needs_person
            self._store(world, name)
        return True

    def _send(self, world: World, name: str) -> bool:
        if not self.sends_before_commit:
            self._store(world, name)
        for _, sending in self.interlocking(world, name).orders(math.inf):
            world.machines[name].orders += ((sending.route_id, sending.edges),)
            return True
        return False

    def _deliver(self, machine: Machine, graph: Graph) -> None:
        (route_id, edges), machine.orders = machine.orders[0], machine.orders[1:]
        if not machine.order(graph, route_id, edges):
            machine.refused = route_id, edges
            told = machine.report()
            machine.words += (Unheard(Refused(route_id, edges, NO), told.report.stamp),)
            if route_id != machine.route_id:
                machine.words += (told._replace(report=replace(
                    told.report, route_id=route_id, edges=edges, reason=NO,
                    states=(EdgeState.FAILED,) * len(edges))),)

    def _hear(self, world: World, name: str, word: object) -> None:
        robot, machine = world.robots[name], world.machines[name]
        client = robot.client
        if isinstance(word, Unheard):
            client.refuse(word.refusal, word.stamp)
            self._store(world, name)
            return
        assert isinstance(word, Told)
        before = client.progress
        age = (machine.moved - word.moved) / self.kind.speed
        report = replace(word.report, age=-1.0 if machine.is_ahead else age)
        try:
            check_report(report, client.record.graph)
        except WrongReport:
            return
        heard = client.take(report)
        if heard.foreign or heard.failed or heard.left:
            robot.needs_person = True
            client.withdraw()
        if client.to_order_anew:
            self.interlocking(world).grant_again(robot, client.to_order_anew)
        if client.progress != before:
            self._store(world, name)

    def _restart(self, world: World, before: Graph) -> None:
        """The supervisor dies and restarts; messages already sent still reach the robots.

        before -- the graph until then: after a reload another graph is in force
        """
        graph = self.graph_in_force(world)
        for name, robot in world.robots.items():
            robot.client = self._client(graph)
            if robot.stored is not None:
                robot.client.restore(robot.stored.on(graph))
                robot.client.lose(lost_areas(robot.stored, graph, before))
                robot.client.stop_after_loss(self.interlocking(world)._new_id)
                self._store(world, name)
            if robot.is_halted:
                robot.client.halt(self.interlocking(world)._new_id)

    # -- invariants
    # ----------------------------------------------------------------------------------

    def fault(self, world: World, event: Tuple[object, ...] = ('',)) -> str:
        """The fault of a world after an event; empty if there is none."""
        found = self._wrong_grant(world, event) if event[0] == 'grant' else ''
        if event[0] == 'send':
            found = self._wrong_order(world, str(event[1]))
        for name, machine in world.machines.items():
            if machine.is_moved or name in self.unheard and not world.robots[name].client.is_heard:
                continue
            allocation = world.robots[name].client.allocation
            held = {abs(hold.edge) for hold in allocation.holds}
            ahead = machine.edges[machine.current:] if machine.phase is Phase.RUNNING else ()
            if not all(abs(edge) in held or self._is_area(edge, allocation) for edge in ahead):
                return f'{name} drives {ahead}, but holds {sorted(held)}'
            if not self._is_allocated(world.robots[name], machine):
                return f'{name} is outside its allocation'
        names = sorted(world.machines)
        for k, one in enumerate(names):
            for other in names[k + 1:]:
                a, b = world.machines[one], world.machines[other]
                apart = math.dist(self._point(a), self._point(b))
                if not (a.is_moved or b.is_moved) and apart < self._distance - 1e-6:
                    return f'{one} and {other} are {apart:.2f} m apart'
        return found

    @property
    def _distance(self) -> float:
        return 2.0 * self.kind.radius + CLEARANCE

    def _wrong_grant(self, world: World, event: Tuple[object, ...]) -> str:
        """Why the edge just granted should not have been granted, from the true situation."""
        name, edge = str(event[1]), int(str(event[2]))
        robot, machine = world.robots[name], world.machines[name]
        record = robot.client.record
        unheard = [one for one, other in world.robots.items()
                   if other.stored is None and not other.client.is_heard]
        begin = record.position
        is_inside = len(record.ahead) == 1 and begin is not None and begin.vertex is None
        at = self._truth.end_vertex(record.ahead[-2]).id if len(record.ahead) > 1 else (
            None if begin is None else begin.vertex)
        follows = at == self._truth.start_vertex(edge).id or (
            is_inside and begin is not None and abs(begin.edge) == abs(edge))
        for wrong, what in (
                (world.is_stopped, 'the fleet is stopped'),
                (world.is_disk_full, 'the disk cannot be written'),
                (robot.needs_person, 'the robot needs a person'),
                (bool(unheard), f'the place of {unheard} is unknown'),
                (not robot.client.is_heard, 'the robot has not reported'),
                (robot.client.evidence.clock_is_off, 'the clock of the robot is wrong'),
                (abs(edge) in world.closed and not is_inside, 'the edge is closed'),
                (abs(edge) not in self.graph_in_force(world).edges, 'the graph lacks this edge'),
                (not follows, 'the edge does not follow')):
            if wrong:
                return f'{name} was granted {edge}, but {what}'
        for other, near in world.machines.items():
            if other != name and self._is_located(robot, machine) and self._is_located(
                    world.robots[other], near) and (
                        math.dist(self._point(machine), self._point(near)) < self._distance - 1e-6):
                return f'{name} was granted {edge}, but is too near to {other}'
        for other, moved in world.machines.items():
            if other != name and moved.is_moved and not machine.is_moved and self._is_located(
                    world.robots[other], moved) and _apart(
                        self._point(moved), self._end(edge, 0), self._end(edge, 2)) < (
                            self._distance - 1e-6) and not is_inside:
                return f'{name} was granted {edge}, where {other} was moved'
        return ''

    def _wrong_order(self, world: World, name: str) -> str:
        """Why the order just sent should not have been sent."""
        edges = world.machines[name].orders[-1][1]
        robot = world.robots[name]
        if edges and not robot.client.takes_away and (world.is_stopped or robot.needs_person):
            return f'{name} was sent {edges} although it must stand'
        return ''

    def _is_allocated(self, robot: Believed, machine: Machine) -> bool:
        allocation = robot.client.allocation
        point = self._point(machine)
        lines = [(self._end(hold.edge, 0), self._end(hold.edge, 2)) for hold in allocation.holds]
        if allocation.vertex is not None:
            vertex = self._truth.vertices[allocation.vertex].position
            lines.append((vertex, vertex))
        lines += [(area.line[0], area.line[-1]) for area in allocation.areas]
        return any(_apart(point, *line) < 0.05 for line in lines)

    def _is_area(self, edge: int, allocation: Allocation) -> bool:
        """True if the areas of an allocation cover an edge of another graph."""
        return any(all(_apart(self._end(edge, half), area.line[0], area.line[-1]) < 0.05
                       for half in (0, 2)) for area in allocation.areas)

    def _point(self, machine: Machine) -> Tuple[float, float]:
        return self._end(machine.edge, machine.half)

    def _end(self, edge: int, half: int) -> Tuple[float, float]:
        one, other = self._truth.start_vertex(edge), self._truth.end_vertex(edge)
        share = half / 2
        return one.x + share * (other.x - one.x), one.y + share * (other.y - one.y)

    # -- equal states
    # --------------------------------------------------------------------------------

    def _key(self, world: World) -> object:
        ids: Dict[int, int] = {0: 0}

        def of(route_id: int) -> int:
            return ids.setdefault(route_id, len(ids))
        parts: List[object] = [world.given, world.faults, world.is_stopped, world.is_disk_full,
                               world.closed, world.is_changed]
        for name in sorted(world.machines):
            parts.append(_machine_key(world.machines[name], of))
            parts.append(_robot_key(world.robots[name], world.machines[name], of))
        return tuple(parts)


def _apart(point: Tuple[float, float], one: Tuple[float, float],
           other: Tuple[float, float]) -> float:
    """The distance of a point from a straight line, in m."""
    path = other[0] - one[0], other[1] - one[1]
    square = path[0] ** 2 + path[1] ** 2
    share = 0.0 if not square else min(max(
        ((point[0] - one[0]) * path[0] + (point[1] - one[1]) * path[1]) / square, 0.0), 1.0)
    return math.dist(point, (one[0] + share * path[0], one[1] + share * path[1]))


def _machine_key(machine: Machine, of: Callable[[int], int]) -> object:
    rank = _ranks(machine)
    words = tuple(
        (of(word.report.route_id), word.report.edges, word.report.states, word.report.pose,
         rank[word.report.stamp], machine.moved - word.moved) if isinstance(word, Told) else
        (of(word.refusal.route_id), word.refusal.edges, rank[word.stamp])
        for word in machine.words)
    return (machine.edge, machine.half, of(machine.route_id), machine.edges, machine.current,
            machine.phase, machine.refuses, machine.slides, machine.is_moved,
            of(machine.refused[0]),
            machine.refused[1],
            tuple((of(id), edges) for id, edges in machine.orders), words)


def _ranks(machine: Machine) -> Dict[float, int]:
    stamps = {word.report.stamp if isinstance(word, Told) else word.stamp
              for word in machine.words}
    return {stamp: rank for rank, stamp in enumerate(sorted(stamps))}


def _robot_key(robot: Believed, machine: Machine, of: Callable[[int], int]) -> object:
    client, record = robot.client, robot.client.record
    stamps = [word.report.stamp if isinstance(word, Told) else word.stamp
              for word in machine.words]
    order = client.order
    number, fraction = record.cleared
    return (of(client.route_id), client.over, client.to_order_anew,
            None if order is None else (of(order.route_id), order.base - record.first, order.edges),
            client.takes_away, client.is_new_motion,
            tuple(sorted((of(id), base.moved(-record.first))
                         for id, base in client._bases.items())),
            tuple(sorted(map(of, client._acknowledged))), tuple(sorted(map(of, client._ended))),
            tuple(sorted(map(of, client._since_loss))),
            client._awaits_report, of(client.withdrawn or 0), client._ordered,
            max(client._cut_refused - record.first, -1),
            sum(stamp > client._stamp for stamp in stamps),
            sum(stamp > client._refused_at for stamp in stamps) if client._awaits_report else 0,
            tuple(record.edges), record.done - record.first, number - record.first,
            round(fraction, 6), record.tail, record.told - record.first, record.position,
            record.pose, client.evidence.outliers, client.evidence.lost, client.evidence.foreign,
            robot.needs_person, robot.is_halted, client.is_heard, _memory_key(robot, of))


def _memory_key(robot: Believed, of: Callable[[int], int]) -> object:
    """The robot's entry on the disk, if it differs from the present knowledge."""
    stored, now = robot.stored, robot.client.memory
    if stored is None or stored._replace(stamp=0.0) == now._replace(stamp=0.0):
        return None
    return (of(stored.route_id), stored.edges, stored.done, stored.position, stored.over,
            tuple(sorted((of(id), base) for id, base in stored.bases.items())),
            tuple(sorted(map(of, stored.ended))), stored.is_stopping, stored.shortened,
            stored.cleared, stored.tail, tuple(sorted(map(of, stored.acknowledged))),
            stored.evidence._replace(location=None))


def walk(yard: Yard, random: Random, steps: int, trouble: float = 0.03) -> Optional[Found]:
    """Carries out random events, most of them useful; returns the first fault.

    trouble -- probability of a fault in each step
    """
    world = yard.begin()
    for _ in range(steps):
        kinds: Dict[str, List[Tuple[object, ...]]] = {}
        for event in (*yard.events(world), *yard.of_people(world)):
            kinds.setdefault(str(event[0]), []).append(event)
        mended = [kind for kind in kinds if kind in MENDING]
        useful = [kind for kind in kinds if kind in USEFUL]
        if random.random() < trouble:
            kind = random.choice([kind for kind in kinds if kind not in (*MENDING, *USEFUL)])
        elif mended and random.random() < 0.3:
            kind = random.choice(mended)
        else:
            kind = random.choice(useful)
        event = random.choice(kinds[kind])
        if kind == 'grant' and random.random() < 0.1:  # in most cases an edge that does not follow
            edges = list(yard.graph_in_force(world).edges)
            edge = random.choice(edges) * random.choice((1, -1))
            event = (*event[:2], edge)
        yard.states += 1
        if yard.happen(world, event):
            world.history = (*world.history[-HISTORY:], ' '.join(map(str, event)))
            fault = yard.fault(world, event)
            if fault:
                return Found(fault, world.history)
    return None


HISTORY = 60  # number of events that are printed with a fault
USEFUL = ('grant', 'send', 'deliver', 'move', 'slide', 'cut', 'report', 'hear')
MENDING = ('bring in', 'mend clock', 'settle', 'resume', 'free disk', 'open')
