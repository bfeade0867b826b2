"""A model of a small yard: several robots, searched in every sequence of events.

The fleet manager's side is the real code: `ManagedRobot` with its `RouteMaster`, `Interlocking`,
and `robots_of` after a restart. Each robot itself is the vehicle of the model of numbered orders,
on the edges of a graph. This module computes from straight lines alone whether two robots are too
near.

The actions of one robot, and the effects of its reports, do not depend on other robots. So the real
code runs once for each state of one robot and each event, and the search combines the results. Only
grants, and the stops of robots that exclude each other, depend on several robots.

Events
    * A robot drives half an edge, takes or refuses an order, loses its route, comes to rest on its
      edge or on the next one, or restarts without its memory. (A restart with its memory changes
      nothing.) Another giver takes the robot and drives it to the end of an edge. A person stops it
      without the fleet manager. Its clock may be ahead: then its reports arrive at once or never,
      because the fleet manager could not know the age of a late report.
    * Any order that was sent arrives: at any time, any number of times, or never.
    * A report arrives at once, or never. One report of each robot may be kept on its way: it
      arrives at any time, any number of times, before or after newer reports.
    * The fleet manager is asked for any edge of the yard, makes a route shorter, stores the changes
      that reports made, and restarts from its present journal, or from its first one. It may end
      between the storing of a grant and the sending of the order. Its disk may become full at any
      time, even before a grant is stored, and may become free again.
    * A person stops the fleet and resumes it, takes a robot out of service, and returns it to
      service where it stands.

Properties
    CONTAINED  All places where a robot is, or to which its route still leads, are in its
               allocation, and in the allocation that it would have after a restart. While another
               giver drives a robot, its place is unknown until a report shows it.
    APART      No two allocations exclude each other, and no two entries of the journal do. No two
               robots are too near to each other, unless another giver has taken one of the two.
               Then both are stopped.
    STORED     An order with edges is in the journal before it is sent.
    GRANTED    Nothing is granted that a gate or a condition must forbid in the true situation.
    LIVE       If, from any state on, messages arrive, nothing fails, and a person helps, then a
               robot is granted an edge and takes the order. (This need not hold if another giver
               has taken a robot: then a person may have to move a robot by hand.)

A search visits all states within its bounds, which limit the numbers of grants, faults and acts of
people. The number of reports has no bound. A walk follows one random sequence of events with far
wider bounds. The distances have no reserve: a robot that has passed a vertex may still be `SLACK`
short of it, and counts as exactly on its edge.

Not in this model: robots beside their edges, other beginnings of a route, other masters (which
`test_master.py` of route_protocol has for one robot), changes of the graph, robots that are
declared absent.
"""
from __future__ import annotations

import copy
import gc
import math
import random
import re
import sys
from collections import deque
from dataclasses import replace
from enum import Enum
from itertools import combinations
from pathlib import Path
from typing import (
    Any,
    Deque,
    Dict,
    FrozenSet,
    Hashable,
    Iterator,
    List,
    Mapping,
    NamedTuple,
    Optional,
    Sequence,
    Tuple,
)

from fleet_core.fleet import Fleet, Robot, RobotType
from fleet_core.geometry.site_geometry import SiteGeometry
from fleet_core.interlocking.allocation import Allocation, Knowledge
from fleet_core.interlocking.changes import Changes
from fleet_core.interlocking.interlocking import Interlocking
from fleet_core.interlocking.reports import Pose, Report, check_report
from fleet_core.supervision.journal import RobotMemory
from fleet_core.supervision.outages import Sign
from fleet_core.supervision.restoring import robots_of
from fleet_core.supervision.robots import ManagedRobot
from fleet_core.supervision.settings import RobotSettings
from route_protocol import values
from route_protocol.messages import WrongReport
from trajectory_graph import Graph

sys.path.append(str(Path(__file__).resolve().parents[3] / 'route_protocol/test'))
from numbered_orders_model import (  # noqa: E402
    ME,
    NOBODY,
    OTHER,
    Edge,
    Found,
    Model,
    Motion,
    Order,
    Vehicle,
    drive,
    motion_of,
    new_epoch,
    without_route,
)

MASTER = 'path_supervisor'
CLEARANCE = 0.1
NOW = 0.0
LATER = math.inf  # at this time each order is due, even one sent at LATER: inf - inf is NaN
NEAR = 1e-6       # m
SLACK = 0.05      # m that a robot may be short of its reported place
AHEAD = 5.0       # s by which a wrong clock is ahead
SETTINGS = dict.fromkeys('abc', RobotSettings(slack=SLACK))
FAILED = values.Reason(values.ReasonCode.DRIVE_FAILED, 'its drive failed')
NO = values.Reason(values.ReasonCode.OTHER, 'no')
MOTIONS = {
    Motion.STANDING: values.Motion.STANDING, Motion.ON_ROUTE: values.Motion.ON_ROUTE,
    Motion.COMING_TO_REST: values.Motion.COMING_TO_REST, Motion.MOVED: values.Motion.MOVED,
    Motion.UNKNOWN: values.Motion.UNKNOWN}

Step = Tuple[str, int, int, int, int]
"""An event, the state after it, the numbers of faults and of acts in this event, and the flags of
its consequences (HEARD and so on).
"""
Point = Tuple[float, float]
Piece = Tuple[Point, Point, float]
"""All points within a radius of a straight line."""

HELPS = ('the disk is freed', 'the fleet is resumed', 'drives', 'obeys or refuses order',
         'reports, which is heard at once', 'is told to stop first', 'its order is sent', 'goes on',
         'a person brings it back', 'the journal is believed again')
"""The events that help robots to drive again, in the order in which they are tried."""

_NUMBERS = re.compile(r'[-\d]+')

# flags for the immediate consequences of an event of one robot
HEARD, SENDS, STOPS, IS_OLDER = 1, 2, 4, 8

class Said(NamedTuple):
    """A report on its way.

    content -- index of the content of the report: all fields except `number`
    number  -- the number of the report
    moved   -- half edges that the robot has driven since it made the report
    ahead   -- the clock that stamped the report is ahead
    """

    content: int
    number: int
    moved: int = 0
    ahead: bool = False


class Side(NamedTuple):
    """One robot: the vehicle, the messages on their way, and the fleet manager's state of it.

    since  -- half edges that another giver has driven the robot since its last known location
    belief -- index of the ManagedRobot
    memory -- index of the robot's entry in the journal
    listed -- index of the allocation that the interlocking counts as stored
    stale  -- the robot must be stored again
    drawn  -- the highest order number that was drawn so far; the clock shows the next one
    shown  -- the order that the robot follows, or followed last
    short  -- the edge behind the robot on which a part of it may still be; 0: none
    ahead  -- the robot's clock is ahead
    taken  -- another giver has driven the robot, or it stood too near to another one at the
              beginning; only the properties use this
    flaw   -- what was wrong with the last event
    """

    vehicle: Vehicle
    belief: int
    memory: int
    listed: int
    cause: values.EpochCause = values.EpochCause.NONE
    orders: FrozenSet[Order] = frozenset()
    kept: Optional[Said] = None
    since: int = 0
    stale: bool = False
    drawn: int = 0
    shown: Optional[Order] = None
    short: int = 0
    ahead: bool = False
    taken: bool = False
    flaw: str = ''


class View(NamedTuple):
    """The part of one robot's state that matters to other robots.

    halts -- the robot has nothing to drive, or it is stopped until a person brings it back
    """

    name: str
    allocated: int
    restored: int
    place: Point
    halts: bool
    taken: bool
    is_heard: bool


class Site(NamedTuple):
    """The state that all robots share.

    grants, faults, acts -- how many grants, faults and acts may still happen

    door -- further state of a DoorYard
    """

    grants: int
    faults: int
    acts: int
    is_stopped: bool = False
    trouble: bool = False
    is_starting: bool = False
    is_wrong_run: bool = False
    to_store: FrozenSet[int] = frozenset()
    door: Hashable = None


class Answer(NamedTuple):
    """The result of a robot's request for an edge.

    belief   -- index of the ManagedRobot after a grant; None: nothing is granted
    to_store -- the robots that must be stored with the grant
    door     -- further state of a DoorYard after the request
    """

    edge: int
    belief: Optional[int]
    to_store: FrozenSet[int]
    door: Hashable


State = Tuple[int, ...]
"""The index of a Site, and the index of the Side of each robot."""


class Fault(Enum):
    """The kinds of faults. The values are shown with a flaw."""

    ROUTE = 'loses its route'
    REFUSAL = 'refuses an order'
    MEMORY = 'restarts without memory'
    STOP = 'is stopped past the fleet manager'
    GIVER = 'is taken'
    DISK = 'the disk fills'
    RESTART = 'the fleet manager restarts'
    JOURNAL = 'the fleet manager starts with the first journal'
    CLOCK = 'has a clock that is ahead'


EVERY: FrozenSet[Fault] = frozenset(Fault)


class Bounds(NamedTuple):
    """The maximum numbers of grants, faults, and acts of people.

    kept -- whether reports may be kept on their way
    of   -- the kinds of faults
    """

    grants: int = 2
    faults: int = 0
    acts: int = 0
    kept: bool = True
    of: FrozenSet[Fault] = EVERY


class Clock:
    """A clock from which the fleet manager draws numbers."""

    drawn, ahead = 0, 1

    def __call__(self) -> int:
        return self.drawn + self.ahead


def separate(site: Interlocking, robots: Mapping[str, ManagedRobot], is_starting: bool) -> bool:
    """Stops robots that exclude each other, as the supervisor does.

    Returns whether it stops any.
    """
    stopped = site.separate(is_starting)
    for name in stopped:
        robots[name].notice(Sign.EXCLUDED, 'too near')
    return bool(stopped)


def _values(thing: object, without: Sequence[str]) -> Tuple[Hashable, ...]:
    """The values of an object's attributes, except those in `without`."""
    return tuple(value for name, value in vars(thing).items() if name not in without)


def key_of(robot: ManagedRobot) -> Hashable:
    """All state of a robot on which later events depend.

    The code names the attributes that do not count, so that no new attribute is forgotten. Only
    plans read `_driven` and `generation`. More than two stray locations have the effect of two.
    """
    master = robot.master
    return (_values(robot, ('name', 'type', 'settings', 'why', 'battery', 'passed', 'driven',
                            '_timer', '_located', 'master', 'liveness')),
            _values(robot.liveness, ()),
            _values(master, ('record', '_clock', '_allocation', '_elsewhere', '_strays')),
            min(master._strays, 2),
            _values(master.record, ('graph', 'kind', '_slack', '_driven', 'generation')))


class Yard:
    """All possible events on a graph of straight edges of the same length.

    begins -- for each name of a robot, the vertex where it stands at the beginning
    closed -- ids of closed edges
    model  -- the rules of the vehicles
    """

    def __init__(self, graph: Graph, kind: RobotType, begins: Mapping[str, int],
                 closed: FrozenSet[int] = frozenset(), model: Optional[Model] = None) -> None:
        self.graph, self.kind, self.closed = graph, kind, closed
        self.names = sorted(begins)
        self._begins = begins
        self._model = model or Model()
        self._geometry = SiteGeometry(graph)
        self.clock = Clock()
        self._half = graph.curve(next(iter(graph.edges))).length / 2
        self._edges = {sign * id: Edge(sign * id, graph.start_vertex(sign * id).id,
                                       graph.end_vertex(sign * id).id)
                       for id in graph.edges for sign in (1, -1)}
        self._sides, self._side_ids = _table(Side)
        self._beliefs: List[ManagedRobot] = []
        self._belief_ids: Dict[Hashable, int] = {}
        self._allocations, self._allocation_ids = _table(Allocation)
        self._memories, self._memory_ids = _table(RobotMemory)
        self._contents, self._content_ids = _table(values.RouteReport)
        self._sites, self._site_ids = _table(Site)
        self._views, self._view_ids = _table(View)
        self._view: List[int] = []       # index of the view of each side
        self._flaws: List[str] = []      # flaw of each side
        self._own: Dict[int, List[Step]] = {}
        self._bounds = Bounds()
        self._known: Dict[Hashable, Any] = {}  # results that were computed before
        self._first: List[int] = []

    # -- numbers of states ------------------------------------------------------------------------

    def _belief_id(self, robot: ManagedRobot) -> int:
        key = (robot.name, key_of(robot))
        id = self._belief_ids.setdefault(key, len(self._beliefs))
        if id == len(self._beliefs):
            self._beliefs.append(robot)
        return id

    def _robot(self, side: Side) -> ManagedRobot:
        """A copy of the fleet manager's state of the robot; the copy may be changed."""
        robot = copy.copy(self._beliefs[side.belief])
        robot.master = copy.copy(robot.master)
        record = robot.master.record = copy.copy(robot.master.record)
        record._driven = copy.copy(record._driven)
        robot.liveness, robot._timer = copy.copy(robot.liveness), copy.copy(robot._timer)
        robot.passed, robot.driven = [], []
        self.clock.drawn = side.drawn
        return robot

    def _put(self, side: Side) -> int:
        """The index of a side.

        The numbers of reports are only compared, so they are replaced by their ranks.
        """
        id = self._side_ids.get(side)
        if id is not None:
            return id
        given = side
        if side.short and not (side.vehicle.route or side.vehicle.rolling):
            side = side._replace(short=0)  # a standing robot reports exactly where it stands
        protocol = self._beliefs[side.belief].master.protocol
        vehicle, kept = side.vehicle, side.kept
        stored = self._memories[side.memory].master.protocol.report
        if vehicle.moved_since < min(protocol.report, stored):
            vehicle = vehicle._replace(moved_since=-1)
        numbers = {-1, 0, protocol.report, stored, vehicle.sequence, vehicle.moved_since}
        if kept is not None:
            numbers.add(kept.number)
        rank = {number: k for k, number in enumerate(sorted(numbers), -1)}
        side = side._replace(
            vehicle=vehicle._replace(sequence=rank[vehicle.sequence],
                                     moved_since=rank[vehicle.moved_since]),
            kept=kept and kept._replace(number=rank[kept.number]),
            belief=self._ranked(side, rank[protocol.report]),
            memory=self._memory_ranked(side.memory, rank[stored]),
            drawn=max(side.drawn, protocol.number))
        id = _number(side, self._sides, self._side_ids)
        if id == len(self._view):
            self._view.append(self._view_of(side))
            self._flaws.append(side.flaw or self._not_contained(side))
        self._side_ids[given] = id
        return id

    def _ranked(self, side: Side, report: int) -> int:
        if report == self._beliefs[side.belief].master.protocol.report:
            return side.belief
        key = 'rank', side.belief, report
        if key not in self._known:
            robot = self._robot(side)
            record = robot.master.record
            record.protocol = replace(record.protocol, report=report)
            self._known[key] = self._belief_id(robot)
        return self._known[key]

    def _memory_ranked(self, id: int, report: int) -> int:
        memory = self._memories[id]
        if report == memory.master.protocol.report:
            return id
        key = 'memory', id, report
        if key not in self._known:
            self._known[key] = _number(memory._replace(master=memory.master._replace(
                protocol=replace(memory.master.protocol, report=report))),
                self._memories, self._memory_ids)
        return self._known[key]

    def _allocated(self, belief: int) -> int:
        """Index of the allocation of a robot."""
        key = 'allocation', belief
        if key not in self._known:
            self._known[key] = _number(self._beliefs[belief].master.allocation,
                                       self._allocations, self._allocation_ids)
        return self._known[key]

    def _restored(self, side: Side) -> int:
        """Index of the allocation that the robot would have after a restart."""
        key = 'restored', side.memory
        if key not in self._known:
            self._known[key] = _number(self._restart(side).master.allocation, self._allocations,
                                       self._allocation_ids)
        return self._known[key]

    def _view_of(self, side: Side) -> int:
        robot, pose = self._beliefs[side.belief], self._pose(side.vehicle)
        return _number(View(
            robot.name, self._allocated(side.belief), self._restored(side),
            self._point(pose.edge, pose.percentage / 100.0),
            not robot.record.ahead or robot.needs_person and robot.master.is_stopping,
            side.taken, robot.master.is_heard), self._views, self._view_ids)

    # -- the beginning ----------------------------------------------------------------------------

    def begin(self, bounds: Bounds) -> State:
        """The first state: each robot stands on its vertex, and has reported."""
        self._bounds = bounds
        ids = []
        for name in self.names:
            robot = self._started(name, {})
            belief = self._belief_id(robot)
            side = Side(Vehicle(place=self._begins[name]), belief, self._entry(belief),
                        self._allocated(belief), taken=self._begin_too_near)
            ids.append(self._stored(self._hear(*self._report(side))[0]))
            self._first.append(self._memory_ranked(self._sides[ids[-1]].memory, 0))
        return (self._site_id(Site(bounds.grants, bounds.faults, bounds.acts)), *ids)

    @property
    def _begin_too_near(self) -> bool:
        places = [self.graph.vertices[vertex].position for vertex in self._begins.values()]
        return any(math.dist(*pair) < self._distance for pair in combinations(places, 2))

    def _site_id(self, site: Site) -> int:
        return _number(site, self._sites, self._site_ids)

    def _entry(self, belief: int) -> int:
        """Index of the entry that would be stored for a robot in the journal now."""
        key = 'entry', belief
        if key not in self._known:
            robot = self._beliefs[belief]
            self._known[key] = _number(RobotMemory(
                robot.master.memory, robot.outage, '', robot.is_halted, robot.comes_to_rest,
                robot.dock, None, robot.type), self._memories, self._memory_ids)
        return self._known[key]

    def _started(self, name: str, memories: Mapping[str, RobotMemory]) -> ManagedRobot:
        fleet = Fleet((self.kind,), (Robot(name, self.kind, self._begins[name]),))
        return robots_of(fleet, SETTINGS, self.graph, memories, None, NOW, self.clock,
                         Changes())[name]

    def _restart(self, side: Side) -> ManagedRobot:
        name = self._beliefs[side.belief].name
        self.clock.drawn = side.drawn
        return self._started(name, {name: self._memories[side.memory]})

    # -- one robot --------------------------------------------------------------------------------

    def own_events(self, id: int) -> List[Step]:
        """All events that can happen to one robot alone."""
        if id not in self._own:
            side = self._sides[id]
            self._own[id] = [step for step in self._events_of(side) if step[1] != id]
        return self._own[id]

    def _events_of(self, side: Side) -> Iterator[Step]:
        yield from self._drives(side)
        for order in sorted(side.orders):
            yield from self._arrives(side, order)
        after, said = self._report(side)
        yield ('reports, which is heard at once', *self._hear(after, said))
        if self._bounds.kept and not side.ahead and (
                side.kept is None or side.kept.content != said.content or side.kept.moved):
            yield 'reports, which is kept on its way', self._put(after._replace(kept=said)), 0, 0, 0
        if side.kept is not None:
            yield ('its kept report is heard', *self._hear(side, side.kept))
        yield from self._decides(side)

    def _drives(self, side: Side) -> Iterator[Step]:
        vehicle = side.vehicle
        if vehicle.route or vehicle.rolling:
            yield 'drives', self._driven(side), 0, 0, HEARD
        if vehicle.rolling:
            yield 'comes to rest', self._put(side._replace(
                vehicle=vehicle._replace(rolling=(), giver=NOBODY))), 0, 0, 0
        if self._bounds.faults:
            yield from self._fails(side)

    def _fails(self, side: Side) -> Iterator[Step]:
        vehicle, kinds = side.vehicle, self._bounds.of
        if vehicle.route and vehicle.giver == ME and Fault.ROUTE in kinds:
            yield Fault.ROUTE.value, self._put(side._replace(
                vehicle=without_route(vehicle)._replace(failed=True))), 1, 0, 0
        for cause, fault, master in (
                (values.EpochCause.RESTART, Fault.MEMORY, NOBODY),
                (values.EpochCause.STOP, Fault.STOP, vehicle.master)):
            if fault in kinds:
                anew = new_epoch(without_route(vehicle), 0)._replace(master=master)
                yield fault.value, self._put(side._replace(vehicle=anew, cause=cause)), 1, 0, 0
        if Fault.CLOCK in kinds:
            yield Fault.CLOCK.value, self._put(side._replace(ahead=True)), 1, 0, 0
        for edge in self._edges.values() if Fault.GIVER in kinds else ():
            if edge.origin == vehicle.place or vehicle.edge in (edge, self._turned(edge)):
                anew = new_epoch(without_route(vehicle), 0)._replace(
                    route=(edge,), rolling=(), giver=OTHER, moved_since=vehicle.sequence,
                    edge=vehicle.edge and edge)
                yield f'{Fault.GIVER.value} along {edge.label}', self._put(side._replace(
                    vehicle=anew, cause=values.EpochCause.OTHER_GIVER, taken=True)), 1, 0, 0

    def _driven(self, side: Side) -> int:
        """The robot after it has driven half an edge.

        While another giver moves the robot, the area in which it may be grows.
        """
        before, vehicle, kept = side.vehicle, drive(side.vehicle), side.kept
        short = before.edge.label if before.edge is not None and vehicle.route else 0
        side = side._replace(vehicle=vehicle, short=short,
                             kept=kept and kept._replace(moved=kept.moved + 1),
                             since=side.since + (before.giver == OTHER))
        if self._beliefs[side.belief].master.protocol.is_anywhere:
            robot = self._robot(side)
            robot.master.grow(side.since * self._half / self.kind.speed)
            side = side._replace(belief=self._belief_id(robot))
        return self._put(side)

    def _turned(self, edge: Edge) -> Edge:
        return self._edges[-edge.label]

    def _arrives(self, side: Side, order: Order) -> Iterator[Step]:
        vehicle = side.vehicle
        after = self._model.obey(vehicle, order)
        if vehicle.edge is not None and not vehicle.route and not vehicle.rolling:
            turned = self._model.obey(vehicle._replace(edge=self._turned(vehicle.edge)), order)
            if turned.route and after == self._model.obey(vehicle, order, willing=False):
                after = turned  # the robot turns back on its edge
        if after == vehicle:
            return
        shown = order if after.order == order.number else side.shown
        yield f'obeys or refuses order {order.number}', self._put(
            side._replace(vehicle=after, shown=shown)), 0, 0, 0
        refusing = self._model.obey(vehicle, order, willing=False)
        if refusing != after and Fault.REFUSAL in self._bounds.of:
            yield f'refuses order {order.number}', self._put(
                side._replace(vehicle=refusing)), 1, 0, 0

    # -- reports ----------------------------------------------------------------------------------

    def _report(self, side: Side) -> Tuple[Side, Said]:
        """The robot after its next report, and the report."""
        vehicle = side.vehicle
        number = vehicle.sequence + 1
        shown = side.shown
        edges: Tuple[int, ...] = ()
        states: Tuple[values.EdgeState, ...] = ()
        first = vehicle.done
        if shown is not None and shown.edges and vehicle.master == ME and vehicle.order:
            first, edges = shown.first, tuple(edge.label for edge in shown.edges)
            driven = min(max(vehicle.done - first, 0), len(edges))
            rest = values.EdgeState.FAILED if vehicle.failed else values.EdgeState.PROCESSING
            states = (values.EdgeState.COMPLETE,) * driven + (rest,) * (len(edges) - driven)
        pose = self._pose(vehicle)
        x, y = self._point(pose.edge, pose.percentage / 100.0)
        report = values.RouteReport(
            0, vehicle.order, edges, states, pose, FAILED if vehicle.failed else values.NO_REASON,
            values.VehicleLocation(x, y, 0.0), vehicle.epoch, side.cause,
            MASTER if vehicle.master == ME else '', vehicle.order, vehicle.refused,
            NO if vehicle.refused else values.NO_REASON, first, self._motion(vehicle))
        return (side._replace(vehicle=vehicle._replace(sequence=number)),
                Said(_number(report, self._contents, self._content_ids), number, 0, side.ahead))

    @staticmethod
    def _motion(vehicle: Vehicle) -> values.Motion:
        """The motion that a robot reports. Even without its memory it knows whether another giver
        drives it.
        """
        is_moved = vehicle.giver == OTHER and bool(vehicle.route or vehicle.rolling)
        return values.Motion.MOVED if is_moved else MOTIONS[motion_of(vehicle)]

    def _pose(self, vehicle: Vehicle) -> values.SymbolicPose:
        if vehicle.edge is not None:
            return values.SymbolicPose(vehicle.edge.label, 50.0)
        ahead = vehicle.route or vehicle.rolling
        edge = ahead[0].label if ahead else self.graph.edges_from(vehicle.place)[0]
        return values.SymbolicPose(edge, 0.0)

    def _hear(self, side: Side, said: Said) -> Tuple[int, int, int, int]:
        """The effects when the fleet manager hears a report."""
        key = 'hear', side.belief, said, side.drawn
        if key not in self._known:
            self._known[key] = self._heard(side, said)
        belief, is_stale, is_located, follows, flaw = self._known[key]
        return self._put(side._replace(
            belief=belief, stale=side.stale or is_stale,
            since=said.moved if is_located and side.since else side.since,
            flaw=flaw)), 0, 0, follows

    def _heard(self, side: Side, said: Said) -> Tuple[int, bool, bool, int, str]:
        """The effects of a report, computed as in `Supervisor.report`."""
        robot = self._robot(side)
        before = robot.master.progress, robot.outage
        report = Report(replace(self._contents[said.content], number=said.number),
                        said.moved * self._half / self.kind.speed - AHEAD * said.ahead)
        try:
            check_report(report, self.graph)
            heard = robot.hear(report, NOW)
        except WrongReport as wrong:
            return side.belief, False, False, 0, f'a report is refused: {wrong}'
        follows = HEARD
        if heard.news.is_older:
            follows |= IS_OLDER
        elif heard.cause is values.EpochCause.STOP:
            follows |= STOPS
        if robot.needs_person and robot.master.protocol.ahead and not robot.master.is_stopping:
            robot.master.halt()
            follows |= SENDS
        is_stale = before != (robot.master.progress, robot.outage) or bool(follows & SENDS)
        return self._belief_id(robot), is_stale, heard.is_located, follows, ''

    def _decides(self, side: Side) -> Iterator[Step]:
        """The acts of the fleet manager or of a person that concern only one robot."""
        key = 'decide', side.belief, side.drawn
        if key not in self._known:
            self._known[key] = tuple(self._decisions_on(side))
        for event, belief, acts, follows in self._known[key]:
            yield event, self._put(side._replace(belief=belief, stale=True)), 0, acts, follows

    def _decisions_on(self, side: Side) -> Iterator[Tuple[str, int, int, int]]:
        robot = self._robot(side)
        if robot.master.shorten() and robot.master.order is not None:
            yield 'is to stop at the end of its edge', self._belief_id(robot), 1, SENDS
        robot = self._robot(side)
        if robot.master.needs_stop and robot.liveness.stands:
            robot.master.halt()
            yield 'is told to stop first', self._belief_id(robot), 0, SENDS
        robot = self._robot(side)
        robot.master.halt()
        robot.notice(Sign.TAKEN_OUT)
        yield 'is taken out of service', self._belief_id(robot), 1, SENDS | HEARD

    # -- all robots -------------------------------------------------------------------------------

    def steps(self, state: State) -> Iterator[Tuple[str, State]]:
        """Each event that is possible now, and the state after it."""
        number, ids = state[0], state[1:]
        site = self._sites[number]
        for k, id in enumerate(ids):
            for event, after, faults, acts, follows in self.own_events(id):
                if faults > site.faults or acts > site.acts:
                    continue
                there = number if not faults and not acts else self._site_id(site._replace(
                    faults=site.faults - faults, acts=site.acts - acts))
                changed = (*ids[:k], after, *ids[k + 1:])
                yield f'{self.names[k]}: {event}', (
                    self._followed(there, ids, changed, follows) if follows
                    else (there, *changed))
            yield from self._decisions(site, number, ids, k)
        yield from self._of_all(site, number, ids)

    def _followed(self, number: int, before: Tuple[int, ...], ids: Tuple[int, ...],
                  follows: int) -> State:
        """The state after an event and its immediate consequences.

        before, ids -- the ids of the robots before and after the event
        follows     -- flags of the consequences
        """
        site = self._sites[number]
        if follows & IS_OLDER:
            site = site._replace(is_wrong_run=True)
            ids = tuple(self._doubted(id) if id == old else id for id, old in zip(ids, before))
        if follows & (STOPS | IS_OLDER) and not site.is_stopped:
            ids = tuple(self._halted(id) for id in ids)
            follows |= SENDS
            site = site._replace(is_stopped=bool(follows & STOPS))
        views = tuple(self._view[id] for id in ids)
        if self._any_exclusion(views):
            ids, stops = self._separated(site.is_starting, before, ids)
            follows |= SENDS * stops
        if site.is_starting and all(self._views[view].is_heard for view in views):
            site = site._replace(is_starting=False)
        if follows & SENDS:
            return self._taken(site, ids)
        return (self._site_id(site), *ids)

    def _any_exclusion(self, views: Tuple[int, ...]) -> bool:
        allocated = [self._views[view].allocated for view in views]
        return any(self._exclude(*pair) for pair in combinations(allocated, 2))

    def _separated(self, is_starting: bool, before: Tuple[int, ...],
                   ids: Tuple[int, ...]) -> Tuple[Tuple[int, ...], bool]:
        sides = [self._sides[id] for id in ids]
        old = tuple(self._sides[id].belief for id in before)
        key = ('separate', is_starting, old, tuple((one.belief, one.drawn) for one in sides))
        if key not in self._known:
            robots = {name: self._robot(self._sides[id])
                      for name, id in zip(self.names, before)}
            interlocking = Interlocking(self._geometry, CLEARANCE, robots)
            interlocking.separate(is_starting)  # processes the changes of the previous event
            copies = {name: self._robot(side) for name, side in zip(self.names, sides)}
            robots.update(copies)
            self.clock.drawn = max(one.drawn for one in sides)
            stops = separate(interlocking, copies, is_starting)
            self._known[key] = tuple(self._belief_id(robot) for robot in copies.values()), stops
        beliefs, stops = self._known[key]
        return tuple(id if belief == one.belief else self._put(
            one._replace(belief=belief, stale=True))
            for id, one, belief in zip(ids, sides, beliefs)), stops

    def _halted(self, id: int) -> int:
        side = self._sides[id]
        robot = self._robot(side)
        robot.master.halt()
        robot.is_halted = True
        return self._put(side._replace(stale=True, belief=self._belief_id(robot)))

    def _doubted(self, id: int) -> int:
        side = self._sides[id]
        robot = self._robot(side)
        robot.master.doubt()
        return self._put(side._replace(stale=True, belief=self._belief_id(robot)))

    # -- the journal ------------------------------------------------------------------------------

    def _taken(self, site: Site, ids: Tuple[int, ...]) -> State:
        """The state after all changes were stored and the orders sent, as in `Outbox.actions`."""
        if not site.trouble:
            site, ids = self._committed(site, ids)
        return (self._site_id(site), *(self._sent(site, id) for id in ids))

    def _granted_in_vain(self, what: str, site: Site,
                         ids: Tuple[int, ...]) -> Iterator[Tuple[str, State]]:
        """The faults that can happen between a grant and the sending of its order (`Outbox`)."""
        if not site.faults or site.trouble:
            return
        site = site._replace(faults=site.faults - 1)
        if Fault.DISK in self._bounds.of:
            yield f'{what}, but the disk is full', self._taken(
                site._replace(trouble=True), tuple(map(self._not_stored, ids)))
        if Fault.RESTART in self._bounds.of:
            yield f'{what}, but {Fault.RESTART.value}', self._restarted_all(
                *self._committed(site, ids))

    def _not_stored(self, id: int) -> int:
        side = self._sides[id]
        key = 'not stored', side.belief
        if key not in self._known:
            robot = self._robot(side)
            Interlocking(self._geometry, CLEARANCE, {robot.name: robot}).not_stored('a full disk')
            self._known[key] = self._belief_id(robot)
        return self._put(side._replace(belief=self._known[key]))

    def _committed(self, site: Site, ids: Tuple[int, ...]) -> Tuple[Site, Tuple[int, ...]]:
        ids = tuple(self._stored(id) if self._sides[id].stale or k in site.to_store else id
                    for k, id in enumerate(ids))
        return site._replace(to_store=frozenset()) if site.to_store else site, ids

    def _stored(self, id: int) -> int:
        side = self._sides[id]
        return self._put(side._replace(memory=self._entry(side.belief), stale=False,
                                       listed=self._allocated(side.belief)))

    def _sent(self, site: Site, id: int) -> int:
        """The robot after the fleet manager has sent the order that is due now."""
        side = self._sides[id]
        if self._beliefs[side.belief].master.order is None:
            return id
        key = 'send', side.belief, site.is_stopped, site.trouble, site.door
        if key not in self._known:
            robot = self._robot(side)
            interlocking = self._interlocking_of(site, robot)
            sent = [sending.order for _, sending in interlocking.orders(LATER)]
            self._known[key] = self._belief_id(robot), sent, robot.master.takes_away
        belief, sent, takes_away = self._known[key]
        if not sent:
            return id
        one, stored = sent[0], self._memories[side.memory].master.protocol.open
        order = Order(one.number, one.epoch, one.first,
                      tuple(self._edges[edge] for edge in one.edges))
        is_wrong = not takes_away and order not in side.orders and one not in stored
        return self._put(side._replace(
            belief=belief, orders=side.orders | {order},
            flaw=f'STORED: {one} is sent, but is not stored' if is_wrong else side.flaw))

    def _interlocking_of(self, site: Site, robot: ManagedRobot) -> Interlocking:
        """An interlocking that has only this robot."""
        interlocking = Interlocking(self._geometry, CLEARANCE, {robot.name: robot})
        interlocking.is_stopped = site.is_stopped
        interlocking.trouble = 'a full disk' * site.trouble
        return interlocking

    # -- decisions about several robots ------------------------------------------------------------

    def _decisions(self, site: Site, number: int, ids: Tuple[int, ...],
                   k: int) -> Iterator[Tuple[str, State]]:
        name, id = self.names[k], ids[k]
        side = self._sides[id]
        robot = self._beliefs[side.belief]
        if site.grants:
            for edge, belief, to_store, door in self._answers(site, ids, k):
                if belief is None:
                    yield f'{name}: asks for {edge}', (
                        self._site_id(site._replace(door=door)), *ids)
                    continue
                after = self._put(side._replace(belief=belief, stale=True,
                                                flaw=self._wrong_grant(site, ids, k, edge)))
                there, robots = site._replace(
                    grants=site.grants - 1, to_store=site.to_store | to_store, door=door), (
                        *ids[:k], after, *ids[k + 1:])
                yield f'{name}: is granted {edge}', self._taken(there, robots)
                yield from self._granted_in_vain(f'{name}: is granted {edge}', there, robots)
        if robot.master.order is not None:
            sent = self._sent(site, id)
            if sent != id:
                yield f'{name}: its order is sent', (number, *ids[:k], sent, *ids[k + 1:])
        if not site.is_stopped and (robot.is_halted or robot.outage is not None):
            after = self._goes_on(side)
            if after != id:
                yield f'{name}: goes on', (number, *ids[:k], after, *ids[k + 1:])
            if not site.trouble:
                brought = self._brought_in(ids, k)
                if brought != id:
                    yield f'{name}: a person brings it back', self._followed(
                        number, ids, (*ids[:k], brought, *ids[k + 1:]), SENDS)

    def _goes_on(self, side: Side) -> int:
        key = 'goes on', side.belief
        if key not in self._known:
            robot = self._robot(side)
            self._known[key] = self._belief_id(robot) if robot.return_to_work(NOW) else side.belief
        return self._put(side if self._known[key] == side.belief else side._replace(
            belief=self._known[key], stale=True))

    def _brought_in(self, ids: Tuple[int, ...], k: int) -> int:
        """The id of the robot after a person has returned it to service.

        It must stand where the fleet manager believes it to be; otherwise nothing changes.
        """
        side = self._sides[ids[k]]
        vehicle = side.vehicle
        robot = self._beliefs[side.belief]
        if vehicle.route or vehicle.rolling or not self._is_at(robot.record.pose, vehicle):
            return ids[k]
        key = ('bring in', side.belief, side.drawn,
               *(self._views[self._view[id]].allocated for j, id in enumerate(ids) if j != k))
        if key not in self._known:
            robot = self._robot(side)
            if robot.works or robot.not_back_yet(NOW):
                self._known[key] = side.belief
            else:
                self._bring_in(robot, ids)
                self._known[key] = self._belief_id(robot)
        if self._known[key] == side.belief:
            return ids[k]
        return self._put(side._replace(belief=self._known[key], stale=True))

    def _bring_in(self, robot: ManagedRobot, ids: Tuple[int, ...]) -> None:
        """Brings a robot back as `Supervisor.bring_in` does."""
        if robot.master.protocol.unknown:
            robot.master.halt()
            return
        robot.come_back()
        robots = {**self._robots(ids), robot.name: robot}
        if Interlocking(self._geometry, CLEARANCE, robots).excluding(robot.name):
            robot.notice(Sign.EXCLUDED)

    def _is_at(self, pose: Pose, vehicle: Vehicle) -> bool:
        true = self._pose(vehicle)
        return pose.edge != 0 and math.dist(
            self._point(pose.edge, pose.fraction),
            self._point(true.edge, true.percentage / 100.0)) < NEAR

    def _robots(self, ids: Tuple[int, ...]) -> Dict[str, ManagedRobot]:
        return {name: self._beliefs[self._sides[id].belief] for name, id in zip(self.names, ids)}

    def _answers(self, site: Site, ids: Tuple[int, ...], k: int) -> Tuple[Answer, ...]:
        """The results of a robot's requests for all edges, except those that change nothing."""
        side = self._sides[ids[k]]
        key = ('ask', side.belief, side.drawn, site.is_stopped, site.trouble, site.door, *(
            (self._views[self._view[id]].allocated, self._sides[id].listed)
            for j, id in enumerate(ids) if j != k))
        if key not in self._known:
            self._known[key] = tuple(one for one in self._asked(site, ids, k)
                                     if one.belief is not None or one.door != site.door)
        answers: Tuple[Answer, ...] = self._known[key]
        return answers

    def _asked(self, site: Site, ids: Tuple[int, ...], k: int) -> Iterator[Answer]:
        robot, interlocking = self._asking(site, ids, k)
        for edge in self._edges:
            answer = self._ask(interlocking, robot, site, ids, edge)
            yield answer
            if answer.belief is not None:  # the grant has changed the copy of the robot
                robot, interlocking = self._asking(site, ids, k)

    def _asking(self, site: Site, ids: Tuple[int, ...],
                k: int) -> Tuple[ManagedRobot, Interlocking]:
        """A robot, and the interlocking from which it may request an edge."""
        robot = self._robot(self._sides[ids[k]])
        robots: Dict[str, Any] = {
            name: _Stored(self.kind, self._allocations[self._sides[id].listed])
            for name, id in zip(self.names, ids)}
        interlocking = Interlocking(self._geometry, CLEARANCE, robots)
        interlocking.stored(self.names)
        robots.update({**self._robots(ids), robot.name: robot})
        interlocking.is_stopped, interlocking.closed = site.is_stopped, self.closed
        interlocking.trouble = 'a full disk' * site.trouble
        return robot, interlocking

    def _ask(self, interlocking: Interlocking, robot: ManagedRobot, site: Site,
             _: Tuple[int, ...], edge: int) -> Answer:
        is_granted = bool(interlocking.grant(robot, (edge,)).edges)
        return Answer(edge, self._belief_id(robot) if is_granted else None,
                      frozenset(map(self.names.index, interlocking.to_store)), site.door)

    def _wrong_grant(self, site: Site, ids: Tuple[int, ...], k: int, edge: int) -> str:
        """Why the true situation forbids the grant of an edge; empty: it does not."""
        side = self._sides[ids[k]]
        robot, vehicle, its = self._beliefs[side.belief], side.vehicle, self._edges[edge]
        own, *others = (self._views[self._view[id]].allocated
                        for id in (ids[k], *ids[:k], *ids[k + 1:]))
        ahead, is_inside = robot.master.protocol.ahead, vehicle.edge in (its, self._turned(its))
        follows = (self._edges[ahead[-1]].destination == its.origin if ahead
                   else vehicle.place == its.origin or is_inside)
        # if another giver moved the robot since its last report, the robot refuses the order
        was_moved = vehicle.moved_since >= robot.master.protocol.report
        for wrong, what in (
                (site.is_stopped, 'the fleet is stopped'),
                (site.trouble, 'the disk cannot be written'),
                (robot.needs_person, 'a person must look after it'),
                (not robot.master.is_heard, 'it has not reported'),
                (robot.master.clock_is_off, 'its clock is wrong'),
                (robot.master.is_stopping, 'it is told to stop'),
                (any(self._allocations[one].knowledge is Knowledge.UNKNOWN for one in others),
                 'another robot may be anywhere'),
                (any(self._exclude(own, one) for one in others), 'another robot is too near'),
                (abs(edge) in self.closed and not is_inside and not was_moved,
                 'the edge is closed'),
                (not follows and not was_moved, 'it does not lead there')):
            if wrong:
                return f'GRANTED: {robot.name} is granted {edge}, but {what}'
        return ''

    def _of_all(self, site: Site, number: int,
                ids: Tuple[int, ...]) -> Iterator[Tuple[str, State]]:
        if not site.trouble and any(self._sides[id].stale for id in ids):
            there, stored = self._committed(site, ids)
            yield 'what has changed is stored', (self._site_id(there), *stored)
        if site.is_stopped:
            yield 'the fleet is resumed', (
                self._site_id(site._replace(is_stopped=False)), *ids)
        elif site.acts:
            yield 'the fleet is stopped', self._followed(
                self._site_id(site._replace(acts=site.acts - 1)), ids, ids, STOPS)
        if site.trouble:
            yield 'the disk is freed', self._taken(site._replace(trouble=False), ids)
        if site.is_wrong_run and not site.trouble and not any(
                self._beliefs[self._sides[id].belief].master.protocol.unknown for id in ids):
            yield 'the journal is believed again', self._taken(
                site._replace(is_wrong_run=False), ids)
        if not site.faults or site.trouble:
            return
        there, kinds = site._replace(faults=site.faults - 1), self._bounds.of
        if Fault.DISK in kinds:
            yield Fault.DISK.value, (self._site_id(there._replace(trouble=True)), *ids)
        if Fault.RESTART in kinds:
            yield Fault.RESTART.value, self._restarted_all(there, ids)
        there = there._replace(is_starting=True, to_store=frozenset())
        if Fault.JOURNAL in kinds:
            yield Fault.JOURNAL.value, (
                self._site_id(there._replace(is_wrong_run=True, is_stopped=False)), *(
                    self._restarted(self._sides[id]._replace(memory=first), False, True)
                    for first, id in zip(self._first, ids)))

    def _restarted_all(self, site: Site, ids: Tuple[int, ...]) -> State:
        """The state after the fleet manager has restarted from its journal."""
        return (self._site_id(site._replace(is_starting=True, to_store=frozenset())), *(
            self._restarted(self._sides[id], site.is_stopped, site.is_wrong_run) for id in ids))

    def _restarted(self, side: Side, is_stopped: bool, is_wrong_run: bool) -> int:
        key = 'restart', side.memory, side.drawn, is_stopped, is_wrong_run
        if key not in self._known:
            robot = self._restart(side)
            listed = _number(robot.master.allocation, self._allocations, self._allocation_ids)
            if is_wrong_run:
                robot.master.doubt()
            halts = is_stopped and not robot.is_halted
            if halts:
                robot.master.halt()
                robot.is_halted = True
            self._known[key] = self._belief_id(robot), listed, halts
        belief, listed, halts = self._known[key]
        return self._put(side._replace(belief=belief, listed=listed, stale=halts))

    # -- what must hold ---------------------------------------------------------------------------

    def _not_contained(self, side: Side) -> str:
        """How a robot violates CONTAINED; empty: it does not."""
        report = self._beliefs[side.belief].master.protocol.report
        return self._outside(side, self._allocated(side.belief), report, 'its allocation')

    def _not_in_journal(self, side: Side) -> str:
        return self._outside(side, self._restored(side),
                             self._memories[side.memory].master.protocol.report, 'the journal')

    def _outside(self, side: Side, allocation: int, report: int, where: str) -> str:
        """How a robot violates CONTAINED; empty: it does not.

        allocation -- index of the allocation in which the robot must be
        report     -- number of the report on which the allocation is based
        """
        vehicle = side.vehicle
        if vehicle.moved_since >= max(report, 0):
            return ''
        route = (vehicle.route or vehicle.rolling) if vehicle.giver == ME else ()
        behind = side.short if route and vehicle.place is not None else 0
        key = 'contained', allocation, vehicle.place, vehicle.edge, route, behind
        if key not in self._known:
            point = self._point_outside(allocation, vehicle, route, behind)
            self._known[key] = '' if point is None else (
                f'CONTAINED: a robot may be at {point}, which is not in ')
        return self._known[key] and self._known[key] + where

    def _point_outside(self, allocation: int, vehicle: Vehicle, route: Tuple[Edge, ...],
                       behind: int) -> Optional[Point]:
        known = self._allocations[allocation]
        if known.knowledge is Knowledge.UNKNOWN:
            return None
        pose = self._pose(vehicle)
        points = [self._point(pose.edge, pose.percentage / 100.0)]
        if behind:
            points.append(self._point(behind, 1.0 - SLACK / (2.0 * self._half)))
        for k, edge in enumerate(route):
            begin = 2 if vehicle.edge is not None and not k else 0
            points += [self._point(edge.label, part / 4.0) for part in range(begin, 5)]
        pieces = self._pieces(known)
        return next((point for point in points if not any(
            _apart(point, point, *piece[:2]) <= piece[2] + NEAR for piece in pieces)), None)

    def flaw(self, state: State) -> str:
        """The property that a state violates, and how; empty: it violates none."""
        site, ids = self._sites[state[0]], state[1:]
        for id in ids:
            found = self._flaws[id] or not site.is_wrong_run and self._not_in_journal(
                self._sides[id])
            if found:
                return found
        for pair in combinations([self._view[id] for id in ids], 2):
            key = 'flaw', pair, site.is_starting, site.is_wrong_run
            if key not in self._known:
                self._known[key] = self._flaw_of_pair(
                    site, self._views[pair[0]], self._views[pair[1]])
            if self._known[key]:
                return self._known[key]
        return ''

    def _flaw_of_pair(self, site: Site, one: View, other: View) -> str:
        names = f'{one.name} and {other.name}'
        is_taken = one.taken or other.taken
        if self._exclude(one.allocated, other.allocated):
            if not is_taken:
                return f'APART: the allocations of {names} exclude each other'
            if not site.is_starting and not (one.halts and other.halts):
                return f'APART: {names} exclude each other, and are not both stopped'
        if is_taken:
            return ''
        if not site.is_wrong_run and self._exclude(one.restored, other.restored):
            return f'APART: the journal entries of {names} exclude each other'
        if math.dist(one.place, other.place) < self._distance - NEAR:
            return f'APART: {names} are too near to each other'
        return ''

    @property
    def _distance(self) -> float:
        return 2.0 * self.kind.reach + CLEARANCE

    def _exclude(self, one: int, other: int) -> bool:
        """Returns whether two allocations have places that are too near to each other."""
        key = 'exclude', one, other
        if key not in self._known:
            both = self._allocations[one], self._allocations[other]
            self._known[key] = all(a.knowledge is Knowledge.KNOWN for a in both) and any(
                _apart(*a[:2], *b[:2]) < self._distance + a[2] + b[2] - NEAR
                for a in self._pieces(both[0]) for b in self._pieces(both[1]))
        return self._known[key]

    def _pieces(self, allocation: Allocation) -> List[Piece]:
        pieces: List[Piece] = [
            (self._point(hold.edge, hold.cleared), self._point(hold.edge, 1.0), 0.0)
            for hold in allocation.holds]
        if allocation.vertex is not None:
            place = self.graph.vertices[allocation.vertex].position
            pieces.append((place, place, 0.0))
        for area in allocation.areas:
            pieces += [(begin, end, area.radius)
                       for begin, end in zip(area.line, area.line[1:] or area.line)]
        return pieces

    def _point(self, edge: int, share: float) -> Point:
        one, other = self.graph.start_vertex(edge), self.graph.end_vertex(edge)
        return one.x + share * (other.x - one.x), one.y + share * (other.y - one.y)

    # -- the search -------------------------------------------------------------------------------

    def is_live(self, state: State) -> bool:
        """Returns whether a robot is granted an edge and takes the order if all events help.

        For this check, all clocks are set right.
        """
        state = (self._site_id(self._sites[state[0]]._replace(grants=1, faults=0, acts=0)), *(
            self._put(self._sides[id]._replace(ahead=False)) for id in state[1:]))
        passed: List[State] = []
        found: Optional[bool] = None
        while found is None:
            passed.append(state)
            found = self._known.get(('live', state))
            if found is None and self._may_drive(state):
                found = True
            if found is None:
                state = self._helped(state)
                if state in passed:
                    found = False
        self._known.update({('live', one): found for one in passed})
        return found

    def _may_drive(self, state: State) -> bool:
        for event, after in self.steps(state):
            name, _, edge = event.partition(': is granted ')
            if edge:
                k = self.names.index(name)
                order = max(self._sides[after[k + 1]].orders)
                vehicle = self._model.obey(self._sides[after[k + 1]].vehicle, order)
                if vehicle.order == order.number and vehicle.route:
                    return True
        return False

    def _helped(self, state: State) -> State:
        """The state after all events of HELPS, each tried once for each robot."""
        steps = list(self.steps(state))
        for kind in HELPS:
            for subject in ('', *(f'{name}: ' for name in self.names)):
                helped = [after for event, after in steps if event.startswith(subject + kind)]
                if helped and helped[-1] != state:
                    state = helped[-1]
                    steps = list(self.steps(state))
        return state

    def search(self, bounds: Bounds, most: Optional[int] = None, live: bool = False) -> Found:
        """Visits all states within the bounds, near ones first, until a property is violated.

        most -- the search ends after this number of states
        live -- LIVE is checked, too, which takes several times as long
        """
        gc.disable()
        try:
            return self._search(bounds, most, live)
        finally:
            gc.enable()

    def _search(self, bounds: Bounds, most: Optional[int], live: bool) -> Found:
        start = self.begin(bounds)
        came_from: Dict[State, Optional[State]] = {start: None}
        waiting: Deque[State] = deque([start])
        while waiting and (most is None or len(came_from) < most):
            state = waiting.popleft()
            for _, after in self.steps(state):
                if after in came_from:
                    continue
                came_from[after] = state
                flaw = self.flaw(after)
                if not flaw and live and not self.is_live(after):
                    flaw = 'LIVE: no robot is brought to a new edge'
                if flaw:
                    return Found(len(came_from), flaw, self._way(came_from, after))
                waiting.append(after)
        return Found(len(came_from))

    def walk(self, bounds: Bounds, seed: int, events: int) -> Found:
        """Follows one random sequence of events, until a state violates a property.

        A walk reaches states that a search cannot reach, after many grants, faults and acts of
        people. About every tenth event is a fault or an act. Each kind of event is equally likely,
        even if many orders may arrive.
        """
        draw = random.Random(f'walk {seed}')
        state = self.begin(bounds)
        way: List[str] = []
        while len(way) < events:
            left = self._left(state)
            kinds: Dict[bool, Dict[str, List[Tuple[str, State]]]] = {True: {}, False: {}}
            for event, after in self.steps(state):
                kinds[self._left(after) < left].setdefault(
                    _NUMBERS.sub('', event), []).append((event, after))
            is_trouble = draw.random() < 0.1
            drawn = kinds[is_trouble] or kinds[not is_trouble]
            if not drawn:
                break
            event, state = draw.choice(drawn[draw.choice(sorted(drawn))])
            way.append(event)
            flaw = self.flaw(state)
            if flaw:
                return Found(len(way), flaw, tuple(way))
        return Found(len(way))

    def _left(self, state: State) -> int:
        """The number of faults and acts of people that may still happen."""
        site = self._sites[state[0]]
        return site.faults + site.acts

    def _way(self, came_from: Dict[State, Optional[State]], end: State) -> Tuple[str, ...]:
        way: List[str] = []
        before = came_from[end]
        while before is not None:
            way.append(next(event for event, after in self.steps(before) if after == end))
            end = before
            before = came_from[end]
        return tuple(reversed(way))


def _table(_: type) -> Tuple[List[Any], Dict[Any, int]]:
    """An empty table: values by their index, and the index of each value."""
    return [], {}


def _number(value: Any, values: List[Any], numbers: Dict[Any, int]) -> int:
    """The index of a value in a table; a new value is added."""
    id = numbers.setdefault(value, len(values))
    if id == len(values):
        values.append(value)
    return id


class _Stored:
    """A robot as it is in the journal, for the interlocking's list of stored allocations."""

    def __init__(self, kind: RobotType, allocation: Allocation) -> None:
        self.type, self.allocation, self.master = kind, allocation, self


def _apart(a: Point, b: Point, c: Point, d: Point) -> float:
    """The distance of two straight lines, in m."""
    if _cross(a, b, c) * _cross(a, b, d) < 0 and _cross(c, d, a) * _cross(c, d, b) < 0:
        return 0.0
    return min(_to_line(a, c, d), _to_line(b, c, d), _to_line(c, a, b), _to_line(d, a, b))


def _cross(a: Point, b: Point, c: Point) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _to_line(point: Point, one: Point, other: Point) -> float:
    path = other[0] - one[0], other[1] - one[1]
    square = path[0] ** 2 + path[1] ** 2
    share = 0.0 if not square else min(max(
        ((point[0] - one[0]) * path[0] + (point[1] - one[1]) * path[1]) / square, 0.0), 1.0)
    return math.dist(point, (one[0] + share * path[0], one[1] + share * path[1]))
