"""The fleet manager's end of the route protocol for one robot, and where the robot may be.

`route_protocol.master` keeps what the robot may still do according to its orders. The reports also
say where the robot is. The allocation is computed from these two alone:

    | the robot may be                    | because                                                |
    |-------------------------------------|--------------------------------------------------------|
    | on an edge                          | an open order leads over it, it has not certainly left |
    |                                     | it, or it is held until the robot stands               |
    | on the vertex where it stands, or   | its last report says STANDING                          |
    | at the point between vertices       |                                                        |
    | near its last location, and near    | this location is on no edge or vertex of the rows above|
    | the one before if it was a stray one|                                                        |
    | within a radius of its last location| another giver moves it; the radius grows with the age  |
    |                                     | of the location                                        |
    | in an area                          | it held an edge that the graph does not have any more  |
    | anywhere                            | it has never reported, or the journal is an older one  |
"""
from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Callable, List, NamedTuple, Optional, Sequence, Tuple

from fleet_core.fleet import AT_VERTEX, NEAR, RobotType
from fleet_core.geometry.areas import Area, Point
from fleet_core.interlocking.allocation import Allocation, Hold, Knowledge
from fleet_core.interlocking.reports import (
    CLOCK_ERROR,
    TREMBLE,
    GraphPosition,
    Pose,
    Report,
    position_of,
)
from fleet_core.interlocking.route_record import RouteRecord
from route_protocol.master import (
    OLD_NEWS,
    REPEAT,
    MasterState,
    News,
    Order,
    give_route,
    give_stop,
    hear,
    label_of,
    next_number,
)
from route_protocol.values import EpochCause, Motion, RouteReport
from trajectory_graph import Graph, TrajectoryGraphError, check_route
from trajectory_graph.drawn_names import drawn_ids
from trajectory_graph.id_lists import listed

ME = 'path_supervisor'
"""The name of this master in its orders."""
# m that a robot may have moved since its last location while another giver moves it
MANUAL_REACH = 10.0
# m that a standing robot may be beside the place where its route begins or ends
BESIDE = NEAR + TREMBLE
# These values count while another giver moves a robot.
_STEP = 0.5   # m: the area around the robot grows in steps of this size
_SOON = 0.2   # s by which the area grows ahead of time; it is more than the time between ticks
_SQUARE = 1.0  # m: a location is stored when the robot enters another square of this size

Clock = Callable[[], int]
"""Returns ms since 1970."""


class Sending(NamedTuple):
    """An order to be sent now."""

    order: Order
    repeated: bool = False


class Located(NamedTuple):
    """A location of the robot.

    age      -- how long (s) the robot may have moved on before the report arrived
    is_stray -- the location was on no place that the robot had then. A stray location counts until
                two later locations have arrived
    """

    point: Point
    age: float = 0.0
    is_stray: bool = True

    def area(self, kind: RobotType) -> Area:
        """Returns the area in which the robot may have been when the report arrived."""
        return Area((self.point,), max(self.age, 0.0) * kind.fastest)


class Lost(NamedTuple):
    """Areas of edges that a robot held, and that the graph in force does not have.

    until -- number of a stop; the areas end when the robot stands after this stop
    """

    areas: Tuple[Area, ...] = ()
    until: int = 0


NOT_LOST = Lost()


class Memory(NamedTuple):
    """The state of a route master that must survive a restart.

    position   -- where the robot stands
    locations  -- at most two, the newest first: the last locations that matter after a restart
    """

    protocol: MasterState = MasterState()
    cleared: Tuple[int, float] = (0, 0.0)
    position: Optional[GraphPosition] = None
    locations: Tuple[Located, ...] = ()
    lost: Lost = NOT_LOST
    is_absent: bool = False

    @property
    def held(self) -> Tuple[int, ...]:
        """All edges that the robot may be on, signed."""
        return tuple(step.edge for step in self.protocol.may_be_on
                     if step.number >= self.cleared[0])


@dataclass
class Heard:
    """The results of one report.

    news    -- what the report changes about the orders
    passed  -- vertices passed since the last report, in order
    cause   -- why a new epoch of the robot began; None: none began, or none was known before
    had_route -- the robot had a route before, or an order for a route was on its way
    is_off_graph -- this report and the one before say that the robot is off the graph
    left    -- the robot stands, but not where it may be according to its orders
    expected -- if it has left: a clause that says where it was expected, and where it is
    is_near -- the robot is still on the edge on which it stood, or on an edge at its vertex
    is_located -- the report has a new location
    """

    news: News = OLD_NEWS
    passed: List[int] = field(default_factory=list)
    cause: Optional[EpochCause] = None
    had_route: bool = False
    is_off_graph: bool = False
    left: bool = False
    expected: str = ''
    is_near: bool = False
    is_located: bool = False


class RouteMaster:
    """Orders routes, repeats orders that no report shows yet, and computes where the robot may be.

    Only the interlocking orders routes through it.

    tell -- is called after each change, so that the interlocking reads the allocation again

    The class has one method for each event of the route, and one property for each question about
    the route. They all read or change the same record: what is ordered, and where the robot may be.
    """

    def __init__(self, record: RouteRecord, clock: Clock,
                 tell: Callable[[], None] = lambda: None) -> None:
        self.record = record
        self._clock, self._tell = clock, tell
        # Number of the last order that may have been sent, and the time when this program sent it;
        # -inf: this program has not sent it
        self._sent: Tuple[int, float] = (0, -math.inf)
        self._label = 0  # route id of the route that `extend` extends; 0: none
        self.locations: Tuple[Located, ...] = ()
        self.reach = 0.0
        """Radius (m) around the last location within which another giver may have moved the robot.
        """
        self._lost = NOT_LOST
        # Stamp and point of the newest location; None: the robot has not reported since the start.
        self._told: Optional[Tuple[float, Optional[Point]]] = None
        self._strays = 0         # number of consecutive locations that were stray
        self._off_graph = 0      # number of consecutive reports that were off the graph
        self._absent_since: Optional[float] = None  # the supervisor's time
        self.clock_is_off = False
        self._beside: Optional[Point] = None
        """The location of the robot when `begin_at` chose where its next route begins."""
        self._cut_refused = 0  # `end` of a shorter route that the robot refused
        # Computed from the attributes above; None: not computed since the last change.
        self._allocation: Optional[Allocation] = None
        self._elsewhere: Optional[Tuple[Located, ...]] = None
        self._progress: Optional[Tuple[object, ...]] = None

    # -- state ------------------------------------------------------------------------------------

    @property
    def protocol(self) -> MasterState:
        """What the robot may still do according to its orders."""
        return self.record.protocol

    @property
    def order(self) -> Optional[Order]:
        """The newest order, if no report shows it yet."""
        return self.protocol.pending

    @property
    def last_sent(self) -> int:
        """Number of the last order that may have left this program."""
        return self._sent[0]

    @property
    def is_stopping(self) -> bool:
        """Whether the robot has an order to stop that it has not answered yet."""
        return self.protocol.is_stopping

    @property
    def takes_away(self) -> bool:
        """Whether `order` stops the robot, or shortens its route."""
        return self.protocol.takes_away

    @property
    def is_new_motion(self) -> bool:
        """Whether `order` lets the robot drive, and was never sent."""
        return (self.order is not None and not self.takes_away
                and self.last_sent < self.order.number)

    @property
    def is_ready(self) -> bool:
        """Whether the robot may be given a route now.

        If it stands at an unexpected place, its next location must first confirm this place.
        """
        return self.protocol.is_ready and not self.has_lost_places and not (
            self._strays and self.record.is_standing)

    @property
    def has_lost_places(self) -> bool:
        """Whether the robot may be at places that the graph does not have any more."""
        return bool(self._lost.areas)

    @property
    def is_heard(self) -> bool:
        """Whether the robot has reported since the start."""
        return self._told is not None

    @property
    def is_absent(self) -> bool:
        """Whether a person declared that the robot is not on the site."""
        return self._absent_since is not None

    @property
    def needs_stop(self) -> bool:
        """Whether the robot must be stopped before it can be given a route.

        True if its reports do not count the orders of this fleet manager yet. Also true if the
        journal is an older one: orders that are not in this journal may still reach the robot.
        """
        protocol = self.protocol
        return (not protocol.commands or bool(protocol.unknown)) and (
            self.is_heard and not self.is_stopping and not self.is_absent)

    @property
    def location(self) -> Optional[Point]:
        """The last location, x, y in m."""
        return self.locations[0].point if self.locations else None

    @property
    def is_confirmed(self) -> bool:
        """Whether two consecutive locations have shown that the robot is elsewhere."""
        return self._strays >= 2

    @property
    def is_by_evidence(self) -> bool:
        """Whether the robot may be at places that follow from evidence, not only from grants."""
        return bool(self.allocation.areas or self.protocol.held)

    @property
    def allocation(self) -> Allocation:
        """All places that the robot may occupy or still reach. Each change makes a new object."""
        if self._allocation is None:
            self._allocation = self._allocated()
        return self._allocation

    def _allocated(self) -> Allocation:
        record, kind = self.record, self.record.kind
        if self.is_absent:
            return Allocation(kind, Knowledge.ABSENT)
        holds = record.holds()
        standing = record.position if record.is_standing else None
        vertex = None if standing is None else standing.vertex
        areas = list(self._lost.areas)
        if standing is not None and vertex is None:
            areas.append(Area((standing.point(record.graph),)))
        areas += [one.area(kind) for one in self._locations_elsewhere]
        if self.reach and self.location is not None:
            areas.append(Area((self.location,), self.reach))
        is_known = bool(holds or areas or vertex is not None) and not self.protocol.unknown
        return Allocation(kind, Knowledge.KNOWN if is_known else Knowledge.UNKNOWN, holds, vertex,
                          tuple(dict.fromkeys(areas)))

    @property
    def _locations_elsewhere(self) -> Tuple[Located, ...]:
        """Of the last two locations, those that are on no place of the robot.

        The older location counts only if it was stray.
        """
        if self._elsewhere is None:
            record = self.record
            holds, standing = record.holds(), record.position if record.is_standing else None
            self._elsewhere = tuple(
                one for k, one in enumerate(self.locations)
                if (one.is_stray or not k) and not self._covers(one.point, holds, standing))
        return self._elsewhere

    def _covers(self, point: Point, holds: Sequence[Hold],
                position: Optional[GraphPosition]) -> bool:
        """Returns whether a point is on a place that the robot has. The tolerance is the accuracy
        with which the robot stands or follows its edges.

        When a robot begins a route, it is as far from the route as it was from the place where it
        stood. The tolerance on edges allows for this, so a grant adds no place except its edges.

        position -- where the robot stands; None: it drives, or its place is not known
        """
        record, graph = self.record, self.record.graph
        if position is not None and math.dist(
                point, position.point(graph)) <= record.near + TREMBLE:
            return True
        within = max(record.kind.play, record.near) + TREMBLE
        here = record.pose.edge  # most probably the point is on this edge
        for hold in sorted(holds, key=lambda hold: hold.edge != here):
            curve = graph.curve(hold.edge)
            if curve.project(*point, start=hold.cleared * curve.length).distance <= within:
                return True
        return False

    @property
    def progress(self) -> Tuple[object, ...]:
        """The part of the state that must be stored as soon as a report changes it."""
        if self._progress is None:
            protocol, record = self.protocol, self.record
            self._progress = (
                protocol.epoch, protocol.order, protocol.refused, protocol.done, protocol.open,
                protocol.held, protocol.is_anywhere, protocol.unknown, record.generation,
                record.position, self._stored_locations, self._lost)
        return self._progress

    def _changed(self) -> None:
        self._allocation = self._elsewhere = self._progress = None
        self._tell()

    def _set(self, protocol: MasterState) -> None:
        self.record.set_protocol(protocol)
        self._changed()

    # -- orders -----------------------------------------------------------------------------------

    def _next_number(self) -> int:
        return next_number(self.protocol, self._clock())

    def extend(self, edges: Sequence[int], renew: bool = False) -> None:
        """Lets the robot drive more edges; `renew`: under a new route id, for another mission."""
        number = self._next_number()
        if renew or not self.record.ahead or not self._label:
            self._label = label_of(number)
        if not self.record.ahead:
            self.record.begins_with(edges[0])
        self._set(give_route(self.protocol, number, (*self.record.ahead, *edges), self._label))

    def shorten(self) -> bool:
        """Orders the robot to stop at the end of its edge. Returns whether it may still drive on
        beyond that edge.

        If the robot refuses because it cannot brake in time, the next call orders it to stop at the
        end of the following edge.
        """
        self._take_back_unsent()
        ahead = self.record.ahead
        if len(ahead) <= 1:
            return False
        if self.takes_away or not self.is_heard or not self.protocol.commands:
            return True
        end = max(self.record.done, self._cut_refused) + 1
        if end < self.record.end:
            self._cut(end - self.record.done)
        return True

    def end_after(self, edges: int) -> bool:
        """Limits the route to the first `edges` of the edges ahead. Returns whether the orders
        change.

        Routes that never left this program are withdrawn. If other orders give the robot more
        edges, it is sent a shorter route, or a stop if no edge is left. If the robot has refused
        such a shorter route before, it keeps its route, because it cannot brake in time.
        """
        before = self.protocol
        self._take_back_unsent()
        ahead = self.record.ahead
        if len(ahead) > edges and self.is_heard and self.protocol.commands and (
                not self.takes_away):
            if not edges:
                self.halt()
            elif self.record.done + edges > self._cut_refused:
                self._cut(edges)
        return self.protocol is not before

    def _cut(self, edges: int) -> None:
        """Orders the route that ends after the first `edges` of the edges ahead."""
        self._set(give_route(self.protocol, self._next_number(), self.record.ahead[:edges],
                             self._label))

    def _take_back_unsent(self) -> None:
        """Withdraws the routes that never left this program: no robot can know of them."""
        kept = tuple(order for order in self.protocol.open
                     if not order.edges or order.number <= self.last_sent)
        if len(kept) == len(self.protocol.open):
            return
        self._set(replace(self.protocol, open=kept))
        if not self.record.ahead:
            self.record.stand(self.record.position)

    def not_stored(self) -> None:
        """Notes that the last order cannot be stored, and withdraws it if it lets the robot drive.

        A stop or a shorter route stays: it is sent although it is not stored.
        """
        if self.is_new_motion:
            self._take_back_unsent()

    def halt(self) -> None:
        """Stops the robot wherever it is. It keeps its allocation until it reports STANDING."""
        self._take_back_unsent()
        number = self._next_number()
        self._set(give_stop(self.protocol, number, label_of(number)))

    def drop_stops(self) -> None:
        """Drops the stops: the robot has no topics here any more, so nothing can be sent to it."""
        protocol = self.protocol
        self._set(replace(protocol, open=tuple(one for one in protocol.open if one.edges)))

    def due(self, now: float) -> Optional[Sending]:
        """Returns the order to send now, if there is one."""
        order = self.order
        if order is None:
            return None
        number, at = self._sent
        is_repeat = number == order.number and at > -math.inf
        if is_repeat and now - at < REPEAT:
            return None
        self._sent = order.number, now
        return Sending(order, is_repeat)

    def begin_at(self, position: GraphPosition) -> None:
        """Notes that the next route begins at this position.

        The robot may stand a little beside this position.
        """
        self._beside = self.location
        self.record.stand(position)
        self.record.begin_anew()
        self._changed()

    # -- reports ----------------------------------------------------------------------------------

    def hear(self, report: Report) -> Heard:
        """Updates the state from a report, and returns the results. Raises WrongReport."""
        said, record = report.said, self.record
        point = report.located(record.graph)
        before, had_route = self.protocol, self.protocol.may_drive
        is_stray = self._is_stray(point)
        is_covered = not is_stray or self._is_beside(report, point)
        protocol, news = hear(before, said, ME, self._clock(), point is not None)
        if not news.is_new:
            return Heard()
        known = self._known
        record.set_protocol(protocol)
        is_first = not self.is_heard
        self._note_pose(report)
        heard = Heard(news, record.passed(news.passed), news.cause if before.epoch else None,
                      had_route)
        self._follow_news(news, said, before)
        heard.is_off_graph = self._off_graph >= 2
        # If a robot may be anywhere, no place is wrong for it.
        heard.is_located = self._locate(report, point, is_covered,
                                        is_stray and not before.unknown)
        self.clock_is_off = report.is_ahead
        if protocol.ahead:
            self._beside = None
            record.leave(report.age)
        elif news.stands and (is_covered or is_first or self.is_confirmed):
            self._come_to_rest(report, heard, '' if is_covered or is_first
                               else self._expected(before))
        if not news.is_repeat or known != self._known:
            self._changed()
        return heard

    def _note_pose(self, report: Report) -> None:
        self._told = self._told or (0.0, None)
        self.record.pose = report.pose
        # A report without a location does not say whether the robot is on the graph.
        self._off_graph = 0 if self.record.pose.edge else self._off_graph + bool(report.stamp)

    @property
    def _known(self) -> Tuple[object, ...]:
        """The state that a report may change even if it says nothing new about orders.

        The reports of a waiting robot do not change this state, so nothing is computed anew.
        `test_told_changes.py` finds a field that is missing here.
        """
        record = self.record
        return (record.pose, record.position, record.cleared, self.locations, self.reach,
                self._lost, self._beside, self._strays, self._off_graph, self.clock_is_off,
                self.is_heard)

    def _is_stray(self, point: Optional[Point]) -> bool:
        """Returns whether the robot is on no place that it holds."""
        record = self.record
        return point is not None and not self._covers(
            point, record.holds(), None if record.ahead else record.position)

    def _come_to_rest(self, report: Report, heard: Heard, expected: str) -> None:
        """Notes that the robot stands.

        `expected`: a clause that says where it should be; empty if it is there or was unknown.
        """
        heard.left = bool(expected)
        heard.is_near = self._is_near(report)
        self._stand(report)
        if heard.left:
            heard.expected = f'{expected}, but is {self._place()}'

    def _follow_news(self, news: News, said: RouteReport, before: MasterState) -> None:
        if news.refused and news.was_shorter:
            self._cut_refused = max((one.end for one in before.open
                                     if self.protocol.order < one.number <= said.refused),
                                    default=0)
        if news.cause is not None or news.failed or news.took and not said.edges:
            self.record.begin_anew()
            self._cut_refused = 0  # a shorter route may now end at a lower number again

    def _is_beside(self, report: Report, point: Optional[Point]) -> bool:
        """Returns whether the robot counts as at its place, although it is not exactly there.

        A standing robot may be a little beside the place where its route begins or ends. If its
        place was not known before, every place counts.
        """
        position = self.record.position
        if position is None:
            return not self.protocol.may_be_on
        return report.motion is Motion.STANDING and point is not None and math.dist(
            point, position.point(self.record.graph)) <= BESIDE

    def _expected(self, before: MasterState) -> str:
        """Returns a clause that says where the robot may have been according to its orders."""
        edges = dict.fromkeys(abs(step.edge) for step in before.may_be_on
                              if step.number >= self.record.cleared[0])
        return (f'it was expected on the edges {listed(drawn_ids(self.record.graph, edges))}'
                if edges else f'it was expected {self._place()}')

    def _place(self) -> str:
        position = self.record.position
        return 'off the graph' if position is None else position.told(self.record.graph)

    def _is_near(self, report: Report) -> bool:
        """Returns whether the robot is on the edge on which it stood, or on an edge at its vertex.
        """
        position, graph = self.record.position, self.record.graph
        if position is None or not report.pose.edge:
            return False
        if position.vertex is None:
            return abs(position.edge) == abs(report.pose.edge)
        edge = graph.edge(report.pose.edge)
        return position.vertex in (edge.origin, edge.destination)

    def _locate(self, report: Report, point: Optional[Point], is_covered: bool,
                is_stray: bool) -> bool:
        """Keeps the location of a report. Returns whether it is a new one."""
        told = report.stamp, point
        if point is None or told == self._told and report.stamp:
            return False
        self._told = told
        self.reach = 0.0
        age = 0.0 if report.motion is Motion.STANDING else report.age
        self.locations = (Located(point, age, is_stray), *self.locations[:1])
        self._strays = 0 if is_covered else self._strays + 1
        return True

    def _stand(self, report: Report) -> None:
        """Notes that the robot stands at the location of this report, and on nothing else."""
        record = self.record
        if self.protocol.order >= self._lost.until:
            self._lost = NOT_LOST
        if self._beside is not None and self.location is not None and (
                math.dist(self._beside, self.location) <= TREMBLE):
            record.stand(record.position)
            return
        self._beside = None
        before, here = record.position, position_of(report.pose, record.graph, record.near)
        if here != before:
            here = self.position_at(report.pose)
        if before is not None and here is not None and math.dist(
                before.point(record.graph), here.point(record.graph)) <= TREMBLE:
            here = before
        record.stand(here)
        self._strays = 0

    def beside(self, position: GraphPosition) -> float:
        """Returns the distance (m) of the last location from a position.

        0: there is no location.
        """
        return 0.0 if self.location is None else math.dist(
            self.location, position.point(self.record.graph))

    def position_at(self, pose: Pose) -> Optional[GraphPosition]:
        """Returns where the robot can begin a route if it is at this pose.

        The robot is on a dock only if it is within AT_VERTEX of the dock. A robot near a dock is
        not docked: it must still drive into the dock.
        """
        graph = self.record.graph
        position = position_of(pose, graph, self.record.near)
        return position_of(pose, graph, AT_VERTEX) if is_dock(position, graph) else position

    # -- storing and restoring --------------------------------------------------------------------

    @property
    def _stored_locations(self) -> Tuple[Located, ...]:
        """The locations that matter after a restart.

        While another giver moves the robot, they change only if it enters another square.
        """
        if self.protocol.is_anywhere:
            return tuple(Located((math.floor(x / _SQUARE) * _SQUARE + _SQUARE / 2,
                                  math.floor(y / _SQUARE) * _SQUARE + _SQUARE / 2), _SQUARE)
                         for (x, y), *_ in self.locations[:1])
        return self._locations_elsewhere

    @property
    def memory(self) -> Memory:
        """The state for `restore` after a restart. It must be stored before an order is sent."""
        return Memory(self.protocol, self.record.cleared, self.record.position,
                      self._stored_locations, self._lost, self.is_absent)

    def restore(self, memory: Memory, now: float = 0.0) -> None:
        """Sets the state from before a restart."""
        number = memory.protocol.number
        self.record.cleared, self.record.protocol = memory.cleared, memory.protocol
        # This run does not know the orders between these two numbers: the journal lacks them.
        self.record.set_protocol(replace(memory.protocol, gap=(number, self._next_number())))
        self._sent = number, -math.inf
        self.record.position = memory.position
        self.locations, self._lost = memory.locations, memory.lost
        self._absent_since = now if memory.is_absent else None
        self.reach = MANUAL_REACH if memory.protocol.is_anywhere else 0.0
        self._changed()

    def lose(self, areas: Sequence[Area]) -> None:
        """Adds areas of edges that the graph in force does not have, and stops the robot.

        The areas end when the robot stands after that stop.
        """
        if not areas:
            return
        if not self.is_stopping:
            self.halt()
        self._lost = Lost((*self._lost.areas, *areas), self.protocol.number)
        self._changed()

    # -- other evidence ---------------------------------------------------------------------------

    def grow(self, age: float) -> bool:
        """Grows the area around a robot that another giver moves. Returns whether it grew.

        age -- s since its last location
        """
        if not self.protocol.is_anywhere or self.is_absent:
            return False
        reach = min((age + CLOCK_ERROR + _SOON) * self.record.kind.fastest, MANUAL_REACH)
        reach = min(math.ceil(reach / _STEP) * _STEP, MANUAL_REACH)
        if reach <= self.reach:
            return False
        self.reach = reach
        self._changed()
        return True

    def become(self, kind: RobotType) -> None:
        """Notes that the robot counts as a robot of another type, because of its load."""
        self.record.kind = kind
        self._changed()

    def doubt(self) -> None:
        """Notes that the restored state comes from an older journal: the robot may be anywhere.

        An order that is not in the journal may still be on its way. So the doubt ends when the
        robot stands after a stop that is ordered later than this call.
        """
        self._absent_since = None
        self._set(replace(self.protocol, unknown=self._next_number()))

    def settle(self, position: Optional[GraphPosition]) -> None:
        """Notes that, according to a person, the robot stands here and holds nothing else."""
        self._set(replace(self.protocol, behind=(), held=(), is_anywhere=False))
        self.record.stand(position)
        self.record.begin_anew()
        self.locations, self._lost = self.locations[:1], NOT_LOST
        self.reach, self._strays = 0.0, 0
        self._beside = None
        self._changed()

    def declare_absent(self, now: float) -> None:
        """Notes that a person declares that the robot is not on the site.

        `now` is the supervisor's time.
        """
        self.settle(None)
        self.locations = ()
        self._set(replace(self.protocol, open=(), unknown=0))
        self._absent_since = now

    def is_back(self, report: Report, now: float) -> bool:
        """Ends the absence if this location is newer than the absence. Returns whether it ended."""
        if self._absent_since is None or not report.stamp or (
                now - max(report.age, 0.0) <= self._absent_since + CLOCK_ERROR):
            return False
        self._absent_since = None
        self._changed()
        return True


def is_dock(position: Optional[GraphPosition], graph: Graph) -> bool:
    """Returns whether this position is a dock."""
    return (position is not None and position.vertex is not None
            and graph.vertices[position.vertex].dock)


def is_on(graph: Graph, edges: Sequence[int]) -> bool:
    """Returns whether a route over these edges can be driven on this graph."""
    try:
        check_route(graph, edges)
    except TrajectoryGraphError:
        return False
    return True

