"""Checks the promises of docs/explanation/fleet.md while events happen to a fleet.

The true state comes from the robots, the orders under way and the journal file. The supervisor's
allocations must always include all places that a robot can really occupy or reach.
"""
from __future__ import annotations

import sqlite3
from dataclasses import dataclass
from typing import Dict, Iterable, List, Optional, Sequence, Set, Tuple

from shapely.geometry import LineString, MultiPoint, Point
from shapely.geometry.base import BaseGeometry
from shapely.ops import unary_union

from fleet_core.interlocking.reports import CLOCK_ERROR
from fleet_core.supervision.actions import SendRoute
from fleet_core.supervision.missions import MissionState, Request, Status
from fleet_core.supervision.outages import Outage
from fleet_simulation.virtual_fleet import STEP, route_order
from trajectory_graph import Graph
from world.supervised_fleet import SupervisedFleet, blocked

STOPS_WITHIN = 3.5  # s; within this time a robot that can be reached receives a stop
_EXACT = 0.06  # m; a standing robot may deviate by this much from its known place
_STANDS = 1.5       # s; time from the first report after a silence until a robot is known to stand


@dataclass
class Word:
    """A command of a person. If the supervisor crashes before it stores the command, the command
    may be lost.

    since -- virtual time of the command, in s
    """

    since: float
    is_stored: bool = False
    is_past: bool = False
    """The command bypassed the supervisor, which has to detect it from the robots' reports."""


@dataclass
class Rest:
    """A robot whose mission was cancelled or paused.

    refused -- number of orders that the robot had refused before
    """

    word: Word
    refused: int


class Promises:
    """Watches a fleet; raises AssertionError when a promise is broken.

    graph   -- a graph with all edges of all graphs of this run; all edges are straight
    stopped -- the fleet stop in force, if any
    out     -- for each robot out of service: the command that took it out
    resting -- for each robot whose route must end: how its mission was cancelled or paused
    blamed  -- robots to which a fault happened; only these may need a person
    carried -- robots that a person may have moved
    """

    def __init__(self, fleet: SupervisedFleet, graph: Graph) -> None:
        self.fleet = fleet
        self.stopped: Optional[Word] = None
        self.out: Dict[str, Word] = {}
        self.resting: Dict[str, Rest] = {}
        self.blamed: Set[str] = set()
        self.carried: Set[str] = set()
        self._given: Dict[str, Set[int]] = {}
        self._lines = {id: LineString([_at(graph, id, 0.0), _at(graph, id, 1.0)])
                       for id in graph.edges}
        self._vertices = {v.id: Point(v.x, v.y) for v in graph.vertices.values()}
        self._told: Dict[Tuple[int, float], Status] = {}
        self._well_since = dict.fromkeys(fleet.agvs, 0.0)
        self._db = sqlite3.connect(fleet.disk.journal_path)
        fleet.watcher = self

    # -- commands of people -----------------------------------------------------------------------

    def stop(self, is_past: bool = False) -> None:
        """Notes that a person stopped all robots; `is_past`: the stop bypassed the supervisor."""
        self.stopped = Word(self.fleet.now, is_past=is_past)

    def take_out(self, name: str) -> None:
        """Notes that a person took a robot out of service."""
        self.out[name] = Word(self.fleet.now)

    def rest(self, name: str) -> None:
        """Notes that the mission of a robot was cancelled or paused."""
        if len(self.may_drive(name)) > 1:
            self.resting[name] = Rest(Word(self.fleet.now), self.fleet.refused[name])

    def closed(self) -> None:
        """Notes that a person closed edges: only routes that robots already have may still contain
        these edges.
        """
        self._given = {name: set(map(abs, robot.record.held))
                       for name, robot in self.fleet.supervisor.robots.items()}

    def begins_with_older_journal(self) -> None:
        """Notes that the supervisor starts with an older journal: later entries are lost.

        Each robot may need a person, because its stored state is as old as the journal.
        """
        self.stopped = None
        for known in (self.out, self.resting, self._told):
            known.clear()
        self.blamed.update(self.fleet.agvs)

    # -- observed events --------------------------------------------------------------------------

    def sends(self, order: SendRoute) -> None:
        """Checks an order that the supervisor sends now."""
        if not order.edges:
            return
        fleet, name = self.fleet, order.robot
        is_repeated = order.repeated
        is_void = fleet.agvs[name].ignores(route_order(order.order))  # for ever
        assert self.stopped is None or self.stopped.is_past and is_void, (
            f'{order} though the fleet is stopped: {fleet.picture()}')
        assert name not in self.out, f'{order} though it is out of service: {fleet.picture()}'
        outage = fleet.supervisor.robots[name].outage
        assert outage is None or not outage.needs_person, f'{order}: {fleet.picture()}'
        had = self.may_drive(name)
        is_ahead = fleet.ages.get(name, 0.0) < -CLOCK_ERROR
        assert is_repeated or not (is_ahead and set(self._left_of(order)) - had), (
            f'{order} though its clock is ahead: {fleet.picture()}')
        if len(had) <= 1:
            self.resting.pop(name, None)
        rest = self.resting.get(name)
        if rest is not None:
            assert len(self._left_of(order)) <= 2 + fleet.refused[name] - rest.refused, (
                f'{order} though its mission is cancelled or paused: {fleet.picture()}')
        more = [edge for edge in self._left_of(order) if edge not in had]
        if fleet.disk.is_full:
            assert is_repeated or not more, f'{order} is not stored: {fleet.picture()}'
        if fleet.closed:
            inside = {abs(fleet.agvs[name].edge)}  # a robot inside a closed edge may leave it
            closed = set(fleet.closed) & {abs(edge) for edge in more} - self._given[name] - inside
            assert not closed, f'{order} leads over {closed}, which is closed: {fleet.picture()}'
        mission = fleet.supervisor.book.of_robot(name)
        if more and mission is not None and mission.dwell_until is not None:
            assert fleet.now >= mission.dwell_until or mission.state is not MissionState.ACTIVE, (
                f'{order} though it dwells at a destination: {fleet.picture()}')
        here = self.possible(name, more)
        for other, agv in fleet.agvs.items():
            if other == name or other in self.carried:
                continue
            room = (here.distance(self.possible(other, self.may_drive(other)))
                    - agv.kind.radius - fleet.agvs[name].kind.radius - fleet.clearance)
            assert room > -1e-6, f'{order} is too near to the places of {other}: {fleet.picture()}'

    def grants(self, name: str, edge: int) -> None:
        """Checks an edge that is granted to a robot now, whichever program asked for the grant."""
        supervisor = self.fleet.supervisor
        robot = supervisor.robots[name]
        is_inside = robot.position is not None and robot.position.vertex is None
        for is_wrong, why in (
                (self.stopped is not None and not self.stopped.is_past, 'the fleet is stopped'),
                (bool(supervisor.trouble), 'the journal cannot be written'),
                (robot.needs_person, 'a person must look after it'),
                (not robot.liveness.is_seen, 'it has not reported since the start'),
                (bool(supervisor.interlocking.excluding(name)), 'its places exclude another robot'),
                (abs(edge) in self.fleet.closed and not is_inside, 'the edge is closed')):
            assert not is_wrong, f'{name} is granted {edge}, but {why}: {self.fleet.picture()}'

    def publishes(self, status: Status) -> None:
        """Checks a published status: it is stored, and an ended mission keeps its state."""
        key = status.request_id, status.stamp
        before = self._told.get(key)
        if before is not None and before.state is not MissionState.REFUSED:
            assert before.state.is_open or status.state is before.state, (before, status)
            assert status.state is not MissionState.REFUSED, (before, status)
            assert status.reached >= before.reached, (before, status)
            assert status.robot == before.robot or not before.reached, (before, status)
        if status.state is MissionState.REFUSED:
            assert not self.accepted(*key), (before, status)
        else:
            history = self._history(*key)
            assert (status.state, status.robot, status.reached) in history, (
                f'{status} is published, but stored is {history}')
        self._told[key] = status

    def restarted(self) -> None:
        """Checks that the restarted supervisor knows all stored commands."""
        supervisor = self.fleet.supervisor
        stopped = self.stopped
        if stopped is not None and not (stopped.is_past or supervisor.is_stopped):
            assert not stopped.is_stored, 'the stored fleet stop was lost'
            self.stopped = None
        for name, word in list(self.out.items()):
            outage = supervisor.robots[name].outage
            if outage is None or not outage.needs_person:
                assert not word.is_stored, f'{name} is in service again'
                del self.out[name]
        for name, rest in list(self.resting.items()):
            if not rest.word.is_stored:
                del self.resting[name]
        for name in self.fleet.agvs:
            for other in supervisor.interlocking.excluding(name):
                assert {name, other} & self.blamed, (
                    f'by the journal {name} and {other} exclude each other: {self.fleet.picture()}')

    def _check_excluding_ones_stand(self) -> None:
        """Checks that a robot needs a person if another robot excludes it.

        A robot without a route may simply wait, if the places of both robots follow only from
        grants.
        """
        supervisor = self.fleet.supervisor
        for name, robot in supervisor.robots.items():
            if not robot.master.is_heard or robot.needs_person:
                continue
            for other in supervisor.interlocking.excluding(name):
                near = supervisor.robots.get(other)
                assert near is not None and not near.master.is_heard or not (
                    robot.record.ahead or robot.master.is_by_evidence
                    or near is not None and near.master.is_by_evidence), (
                    f'{name} and {other} exclude each other, but {name} is not stopped: '
                    f'{self.fleet.picture()}')

    def stepped(self) -> None:
        """Checks each robot after one time step."""
        fleet = self.fleet
        for name in [name for name in self.resting if len(self.may_drive(name)) <= 1]:
            del self.resting[name]
        if self.stopped is not None and fleet.supervisor.is_stopped:
            self.stopped.is_past = False
        self._check_excluding_ones_stand()
        if not fleet.disk.is_full and not fleet.supervisor.trouble:
            for word in (*([self.stopped] if self.stopped else []), *self.out.values(),
                         *(rest.word for rest in self.resting.values())):
                word.is_stored |= fleet.now - word.since > STEP
        for name in fleet.agvs:
            self._check_robot(name)

    def _check_robot(self, name: str) -> None:
        fleet, agv, robot = self.fleet, self.fleet.agvs[name], self.fleet.supervisor.robots[name]
        vertices, edges = blocked(fleet, name)
        believed = {abs(edge) for edge in robot.record.held} | set(edges)
        is_unknown = name in fleet.supervisor.unknown  # it may be anywhere
        drives = [edge for edge in self.may_drive(name) if abs(edge) not in believed]
        if not agv.off_graph and robot.master.location == (agv.location.x, agv.location.y):
            self.carried.discard(name)
        if not is_unknown and (drives or (
                name not in self.carried and abs(agv.edge) not in believed
                and robot.liveness.is_seen)):
            held = unary_union([*(self._lines[edge] for edge in believed),
                                *(self._vertices[vertex] for vertex in vertices),
                                *(MultiPoint(area.line).convex_hull.buffer(area.radius or _EXACT)
                                  for area in robot.master.allocation.areas)])
            assert held.buffer(_EXACT + agv.kind.play).covers(self.possible(name, drives)), (
                f'{name} may drive {drives}, but holds {believed} {vertices} only: '
                f'{fleet.picture()}')
        if robot.needs_person and name not in self.blamed:
            self._check_blame(name)
        is_well = not (fleet.network.loss or fleet.hangs or name in fleet.lost
                       or not fleet.network.hears(name, fleet.now))
        if not is_well:
            self._well_since[name] = fleet.now
        since = max([self._well_since[name], *([self.stopped.since] if self.stopped else [])])
        if self.stopped is not None and fleet.now - since > STOPS_WITHIN:
            assert not agv.edges, f'{name} did not stop: {fleet.picture()}'

    def _check_blame(self, name: str) -> None:
        """Checks why a robot that had no fault needs a person.

        The only permitted cause is another robot nearby, which had a fault or whose location is
        old. When the step ends, the two robots may already be far enough apart.
        """
        fleet, supervisor = self.fleet, self.fleet.supervisor
        assert supervisor.robots[name].outage is Outage.TOO_NEAR and any(
            supervisor.robots[other].master.allocation.areas
            and (other in self.blamed or fleet.now - self._well_since[other] <= _STANDS)
            for other in supervisor.robots.keys() - {name}), (
            f'{name} needs a person: {fleet.picture()}')
        self.blamed.add(name)

    # -- the true state ---------------------------------------------------------------------------

    def _left_of(self, order: SendRoute) -> Sequence[int]:
        """Returns the edges of an order that the robot has not completed and may still drive."""
        agv, sent = self.fleet.agvs[order.robot], route_order(order.order)
        if agv.ignores(sent):
            return ()
        return sent.edges[max(agv.done - sent.first, 0) if agv.taken else 0:]

    def may_drive(self, name: str) -> Set[int]:
        """Returns the signed ids of the edges that a robot drives, or may drive because of an order
        that is on its way to the robot.
        """
        agv = self.fleet.agvs[name]
        edges = set(agv.ahead)
        for order in self.fleet.network.under_way(name):
            edges.update(self._left_of(order))
        return edges

    def possible(self, name: str, edges: Iterable[int]) -> BaseGeometry:
        """Returns the shape of the robot's position and these edges, without the part that the
        robot has driven.
        """
        agv = self.fleet.agvs[name]
        lines: List[BaseGeometry] = [Point(agv.position)]
        for edge in edges:
            lines.append(LineString([agv.position, _at(agv.graph, edge, 1.0)])
                         if abs(edge) == abs(agv.edge) else self._lines[abs(edge)])
        return unary_union(lines)

    # -- the journal ------------------------------------------------------------------------------

    def _serials(self, id: int, stamp: float) -> List[int]:
        return [serial for serial, in self._db.execute(
            'SELECT serial FROM mission WHERE request_id = ? AND stamp = ? ORDER BY serial',
            (id, stamp))]

    def _history(self, id: int, stamp: float) -> List[Tuple[int, str, int]]:
        """Returns all stored states of a mission in order: state, robot, reached destinations."""
        return [row for serial in self._serials(id, stamp)[-1:] for row in self._db.execute(
            'SELECT state, robot, reached FROM change WHERE serial = ? ORDER BY rowid', (serial,))]

    def accepted(self, id: int, stamp: float) -> int:
        """Returns how many missions the journal has for a request."""
        return len(self._serials(id, stamp))

    def told(self, request: Request) -> Optional[MissionState]:
        """Returns the last published state of a request; None: no state was published."""
        status = self._told.get((request.id, request.stamp))
        return None if status is None else status.state

    def stored(self, id: int, stamp: float) -> Optional[Tuple[MissionState, str, int]]:
        """Returns the last stored state, robot and number of reached destinations of a mission."""
        for state, robot, reached in self._history(id, stamp)[-1:]:
            return MissionState(state), robot, reached
        return None


def _at(graph: Graph, edge: int, share: float) -> Tuple[float, float]:
    curve = graph.curve(edge)
    x, y = curve.point_at(share * curve.length)
    return float(x), float(y)
