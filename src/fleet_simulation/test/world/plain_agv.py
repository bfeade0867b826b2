"""A simple AGV for tests of the supervisor. It obeys orders as the route protocol requires.

It shares no code with `agv_sim` and `route_protocol.vehicle`, only the values of the protocol.
Therefore a mistake in this AGV cannot hide the same mistake in that code.
"""
from __future__ import annotations

import math
from dataclasses import replace
from itertools import count
from typing import Any, Dict, Iterator, List, Optional, Tuple

from fleet_core.fleet import RobotType
from fleet_core.interlocking.reports import Pose
from route_protocol.values import (
    EMERGENCY_STOP,
    NO_REASON,
    OVERRULED,
    TAKEN_OVER,
    EdgeState,
    EpochCause,
    Motion,
    Phase,
    Reason,
    ReasonCode,
    RouteOrder,
    RouteRefusal,
    RouteReport,
    SymbolicPose,
    VehicleLocation,
)
from trajectory_graph import Graph, TrajectoryGraphError, check_drivable

LOST_LINK = Reason(ReasonCode.LOST_LINK, 'lost link: commands')
CANNOT_BRAKE = Reason(ReasonCode.CANNOT_BRAKE, 'it cannot brake in time')

_AT_END = 1e-6  # m
_TREMBLE = 0.05  # m; the location of a standing AGV may change by this much
_NEAR = 0.3     # m; from this distance to a vertex, a route may begin at the vertex
_JUST_LEFT = 0.5  # m; up to this far past a vertex, a route may begin with the edge before it
_EPOCHS: Iterator[int] = count(10 ** 6)

_NO_ORDERS: Dict[str, Any] = {'taken': 0, 'refused': 0, 'refusal': NO_REASON}


class Agv:
    """One AGV. Tests set these attributes to cause faults:

    stalled   -- s for which it stands still
    pace      -- factor on its speed
    refusing  -- number of its next orders that it refuses
    emergency -- if True, its route fails, and it refuses orders
    off_graph -- if True, it refuses orders and reports no pose
    near      -- m; within this distance of a vertex the AGV is at the vertex; if a test changes
                 `near`, a route from the vertex must begin with an edge that leads away from it
    braking   -- m that it needs to stop; after the loss of its route it rolls this far along the
                 route
    aside     -- m in x and y by which it is beside its edge, until it begins another route
    error     -- m in x and y by which the location in its reports is wrong
    moved     -- s for which it still reports that a person or another program moves it
    old       -- age (ns) of the location in its reports; None: the reports have no location

    `knows` has the AGV's knowledge of its orders:
    epoch, cause   -- number of its epoch, and why the epoch began
    master         -- the master whose orders it counts; None: no master has sent an order yet
    taken, refused -- number of the last order that it took, and the highest number of an order that
                      it refused
    refusal        -- why it refused the order of the number `refused`
    first          -- number of the first edge of its route
    done           -- number of the edge under way, or of the next edge if none is under way
    report         -- number of the last report
    """

    def __init__(self, graph: Graph, kind: RobotType, vertex: int) -> None:
        self.graph, self.kind = graph, kind
        self.due = 0.0  # its motion is simulated in each step of the world
        self.edge = graph.edges_from(vertex)[0]
        """Signed id of the edge on which the AGV is."""
        self.arc = 0.0
        """Distance (m) from the start of this edge to the AGV."""
        self.route_id = 0
        self.edges: Tuple[int, ...] = ()
        self.current = 0
        self.phase = Phase.STOPPED
        self.reason = NO_REASON
        self.knows: Dict[str, Any] = {'report': 0}
        self._start_without_memory()
        self._refused: Optional[RouteRefusal] = None  # the last refusal of an unnumbered order
        self._to_begin = 0.0  # m; distance to drive back on this edge to the start of the route
        self._rolls = 0.0     # m; distance that it still rolls after the loss of its route
        self._rolls_along: Tuple[int, ...] = ()  # the edges after the present one
        self._giver: Optional[str] = None        # the master whose route it drives
        self._waits: Optional[RouteOrder] = None  # a route that waits until it stands
        self._late_refusals: List[RouteRefusal] = []
        self.stalled = 0.0
        self.emergency = False
        self.off_graph = False
        self.pace = 1.0
        self.refusing = 0
        self.near = _NEAR
        self.braking = 0.0
        self.aside = 0.0, 0.0
        self.error = 0.0, 0.0
        self.moved = 0.0
        self.old: Optional[int] = 0
        self.travelled = 0.0
        self._stayed: Optional[Tuple[float, float]] = None  # where it was at its last report
        self._drove = False
        self.visited: List[int] = [vertex]
        """Ids of the visited vertices, in order."""

    @staticmethod
    def seconds_left(ahead: float) -> float:
        """Returns infinity, because the AGV does not know its motion in advance."""
        return math.inf

    @staticmethod
    def seconds_past(number: int, fraction: float, distance: float) -> float:
        """Returns infinity, because the AGV does not know its motion in advance."""
        return math.inf

    @property
    def position(self) -> Tuple[float, float]:
        """The position x, y in m, in the frame of the graph."""
        x, y = self.graph.curve(self.edge).point_at(self.arc)
        return float(x) + self.aside[0], float(y) + self.aside[1]

    @property
    def location(self) -> VehicleLocation:
        """The location that the AGV reports; `error` is added to its true position."""
        (x, y), error = self.position, self.error
        return VehicleLocation(x + error[0], y + error[1], math.nan)

    @property
    def is_driving(self) -> bool:
        """Whether the AGV has a route that is not finished, or still rolls without one."""
        return self.phase is Phase.RUNNING or self._rolls > 0.0

    @property
    def motion(self) -> Motion:
        """The kind of motion that the AGV reports."""
        if self.phase is Phase.RUNNING:
            return Motion.ON_ROUTE
        if self.moved > 0.0:
            return Motion.MOVED
        if self._rolls <= 0.0:
            return Motion.STANDING
        if self.knows['master'] is None:
            return Motion.UNKNOWN
        return (Motion.COMING_TO_REST if self._giver == self.knows['master'] else Motion.MOVED)

    @property
    def news(self) -> object:
        """The part of the report that is sent at once when it changes."""
        knows = self.knows
        return (self.route_id, self.edges, self.current, self.phase, self.reason, self.motion,
                knows['epoch'], knows['taken'], knows['refused'], self.unready)

    def late_refusals(self) -> List[RouteRefusal]:
        """Returns the refusals of routes that waited, since the last call."""
        refusals, self._late_refusals = self._late_refusals, []
        return refusals

    def __str__(self) -> str:
        return (f'edge {self.edge} at {self.arc:.2f}, route {self.route_id} {self.edges} '
                f'{self.current} {self.phase.value} {self.motion.name} {self.knows}')

    # -- orders -----------------------------------------------------------------------------------

    def receive(self, order: RouteOrder) -> Optional[RouteRefusal]:
        """Takes an order, or returns its refusal. Returns None for an order that it ignores."""
        if not order.order:
            return self.order(order.route_id, order.edges)
        knows = self.knows
        is_mine = order.master == knows['master']
        if is_mine and order.order <= max(knows['taken'], knows['refused']):
            return None
        is_another = not is_mine and knows['master'] is not None
        is_first = is_another or not knows['taken']
        if not order.edges:
            self.stand(order.route_id)
            self.count_stop(order)
            return None
        reason = self._why_not(order, is_first)
        if reason is _ROLLS:
            self._wait(order)
            return None
        if reason:
            return self.refuse(order, reason)
        if is_another:
            self.begin_epoch(EpochCause.OTHER_MASTER)
        done = order.first if is_first else knows['done']
        knows.update(master=order.master, taken=order.order, first=order.first, done=done)
        self._giver = order.master
        self._set_route(order.route_id, order.edges, done - order.first)
        return None

    def _wait(self, order: RouteOrder) -> None:
        """Keeps a route until the AGV stands. The route replaces an older waiting route.

        If the older waiting route is of another master, it is refused.
        """
        before = self._waits
        is_of_another = before is not None and order.master != before.master
        if before is not None and is_of_another:
            self._late_refusals.append(self.refuse(before, OVERRULED))
        if before is None or is_of_another or order.order > before.order or not order.order:
            self._waits = order

    def refuse(self, order: RouteOrder, reason: Reason) -> RouteRefusal:
        """Counts the refusal of a route, and returns it."""
        knows = self.knows
        refusal = RouteRefusal(order.route_id, order.edges, reason, order.order)
        if not order.order:
            self._refused = refusal
        elif knows['master'] in (None, order.master) and order.order > knows['refused']:
            knows.update(master=order.master, refused=order.order, refusal=reason)
        return refusal

    def count_stop(self, order: RouteOrder) -> None:
        """Counts a stop as taken."""
        knows = self.knows
        if not order.order:
            self.begin_epoch(EpochCause.STOP)
            return
        if knows['master'] not in (None, order.master):
            self.begin_epoch(EpochCause.OTHER_MASTER)
        number = knows['done'] if knows['taken'] else order.first
        knows.update(master=order.master, taken=order.order, first=number, done=number)

    def obey_another(self, edges: Tuple[int, ...]) -> None:
        """Takes a route of another master that begins at the AGV's place."""
        self.receive(RouteOrder(1, edges, known_epoch=self.knows['epoch'], order=1,
                                master='another'))

    def begin_epoch(self, cause: EpochCause) -> None:
        """Begins a new epoch: the AGV refuses routes that were ordered before."""
        self.knows.update(_NO_ORDERS, epoch=next(_EPOCHS), cause=cause)

    def ignores(self, order: RouteOrder) -> bool:
        """Returns whether the AGV would neither drive this order nor stop because of it."""
        knows = self.knows
        return bool(order.order) and (
            order.master == knows['master']
            and order.order <= max(knows['taken'], knows['refused'])
            or bool(order.edges) and order.known_epoch != knows['epoch'])

    def _why_not(self, order: RouteOrder, is_first: bool) -> Reason:
        """Returns why the AGV refuses a numbered route; places the AGV if it takes the route."""
        knows = self.knows
        if not order.known_epoch or order.known_epoch != knows['epoch']:
            return OVERRULED
        skipped = 0 if is_first else knows['done'] - order.first
        if not 0 <= skipped <= len(order.edges):
            return Reason(ReasonCode.WRONG_CHANGE, 'its record numbers do not fit')
        rest = order.edges[skipped:]
        is_under_way = self.phase is Phase.RUNNING and not is_first
        if is_under_way and rest[:1] != self.edges[self.current:self.current + 1]:
            return Reason(ReasonCode.WRONG_CHANGE, 'it must go on with the edge under way')
        if not rest and self.phase is not Phase.COMPLETE:
            return Reason(ReasonCode.WRONG_CHANGE, 'it ends before the place where it stands')
        reason = self._unable(order.edges)
        if reason:
            return reason
        if self._rolls > 0.0:
            return _ROLLS
        if rest[:1] == (self.edge,) and len(rest) == 1 and self._cannot_brake():
            return CANNOT_BRAKE
        if rest and not is_under_way:
            return self._begin_with(rest)
        return NO_REASON

    def _unable(self, edges: Tuple[int, ...]) -> Reason:
        """Returns why the AGV can drive no route now, or why no robot can drive this route."""
        if self.emergency:
            return EMERGENCY_STOP
        if self.off_graph:
            return Reason(ReasonCode.OFF_GRAPH, 'the robot is off the graph')
        if self.refusing:
            self.refusing -= 1
            return Reason(ReasonCode.OTHER, 'the test makes the robot refuse')
        try:
            check_drivable(self.graph, edges)
        except TrajectoryGraphError as error:
            return Reason(ReasonCode.WRONG_ROUTE, str(error))
        return NO_REASON

    def _begin_with(self, rest: Tuple[int, ...]) -> Reason:
        """Places the AGV at the beginning of `rest`, or returns why the AGV cannot begin there."""
        begun = self._beginning(rest)
        turns_back = (self.phase is Phase.RUNNING and self.braking > 0.0 and self.arc > _AT_END
                      and rest[0] != self.edge)
        if begun is None or begun[0] or turns_back:
            return Reason(ReasonCode.STARTS_ELSEWHERE,
                          f'edge {rest[0]} does not start where the robot is')
        self._place(begun[1], begun[2])
        return NO_REASON

    def _place(self, edge: int, arc: float) -> None:
        self.aside = 0.0, 0.0
        self._to_begin = 0.0 if abs(edge) == abs(self.edge) else self._from_vertex(edge)
        if not self._to_begin:
            self.edge, self.arc = edge, arc

    def _set_route(self, route_id: int, edges: Tuple[int, ...], current: int) -> None:
        self.route_id, self.edges, self.current = route_id, edges, current
        self.phase = Phase.RUNNING if current < len(edges) else Phase.COMPLETE
        self.reason = NO_REASON
        self.drive(0.0)

    def stand(self, route_id: int) -> None:
        """Ends the route; the AGV brakes."""
        self._lose_route()
        self.route_id, self.edges, self.current, self._to_begin = route_id, (), 0, 0.0
        self.phase, self.reason = Phase.STOPPED, NO_REASON
        self.knows['first'] = self.knows['done']

    def _lose_route(self) -> None:
        """Rolls on along the lost route for the braking distance."""
        if self.phase is Phase.RUNNING:
            self._rolls = 0.0 if self.stalled or self._to_begin else self.braking
            self._rolls_along = self.edges[self.current + 1:]

    # -- orders without a number ------------------------------------------------------------------

    def order(self, route_id: int, edges: Tuple[int, ...]) -> Optional[RouteRefusal]:
        """Accepts a new route or a change of the route, or returns the refusal.

        A repeated order gets the same answer again.
        """
        if not edges:
            self.stand(route_id)
            if self._waits is not None and not self._waits.order:
                self._waits = None
            self.count_stop(RouteOrder(route_id, ()))
            return None
        if (route_id, edges) == (self.route_id, self.edges):
            return None
        if not self.has_refused(route_id, edges):
            reason = self._take_up(route_id, edges)
            if reason is _ROLLS:
                self._wait(RouteOrder(route_id, edges))
                return None
            self._refused = RouteRefusal(route_id, edges, reason) if reason else None
        return self._refused

    def has_refused(self, route_id: int, edges: Tuple[int, ...]) -> bool:
        """Returns whether this order is the last refused order; it is then refused again."""
        refused = self._refused
        return refused is not None and (route_id, edges) == (refused.route_id, refused.edges)

    def _take_up(self, route_id: int, edges: Tuple[int, ...]) -> Reason:
        reason = self._unable(edges)
        if reason:
            return reason
        knows = self.knows
        first, current = knows['first'], self.current
        if route_id == self.route_id and self.phase is not Phase.STOPPED:
            if self.phase is Phase.FAILED:
                return Reason(ReasonCode.WRONG_CHANGE, f'route {route_id} has failed')
            kept = self.edges[:self.current + 1]
            if edges[:len(kept)] != kept:
                return Reason(ReasonCode.WRONG_CHANGE, f'route {route_id} must begin with its '
                                                       'completed edges and the current one')
            if edges == kept and self._cannot_brake():
                return CANNOT_BRAKE
            if self.phase is Phase.COMPLETE and self.current < len(edges):
                self.edge, self.arc = edges[self.current], 0.0
        elif self._rolls > 0.0:
            return _ROLLS
        else:
            begun = self._beginning(edges)
            if begun is None:
                return Reason(ReasonCode.STARTS_ELSEWHERE,
                              f'edge {edges[0]} does not start where the robot is')
            if edges[begun[0]:] == (self.edge,) and self._cannot_brake():
                return CANNOT_BRAKE
            current = begun[0]
            first = knows['done'] - current
            self._place(begun[1], begun[2])
        if knows['master'] not in (None, _OLD):
            self.begin_epoch(EpochCause.OTHER_MASTER)
        number = max(knows['taken'], knows['refused']) + 1
        knows.update(master=_OLD, taken=number, first=first, done=first + current)
        self._giver = _OLD
        self._set_route(route_id, edges, current)
        return NO_REASON

    def _beginning(self, edges: Tuple[int, ...]) -> Optional[Tuple[int, int, float]]:
        """Returns where a new route begins: index of the edge, the edge, and m from its start.

        Returns None if the route does not begin where the AGV is.
        """
        first = edges[0]
        length = self.graph.curve(self.edge).length
        if first == self.edge and (length - self.arc > self.near or self.near == _NEAR):
            return 0, first, self.arc
        if first == -self.edge and (self.arc > self.near or self.near == _NEAR):
            return 0, first, length - self.arc
        start = self.graph.start_vertex(first).id
        if self.arc <= self.near and start == self.graph.start_vertex(self.edge).id:
            return 0, first, 0.0
        if length - self.arc <= self.near and start == self.graph.end_vertex(self.edge).id:
            return 0, first, 0.0
        driven = self.edges[self.current - 1] if 0 < self.current < len(self.edges) else 0
        if first == driven and edges[1:2] == (self.edge,) and self.arc <= _JUST_LEFT:
            return 1, self.edge, self.arc
        return None

    def _cannot_brake(self) -> bool:
        """Returns whether the AGV is to drive on after this edge and cannot stop at the end of the
        edge any more.
        """
        return (self.phase is Phase.RUNNING and self.current + 1 < len(self.edges)
                and self.graph.curve(self.edge).length - self.arc < self.braking)

    def _from_vertex(self, first: int) -> float:
        """Returns the distance (m) on the current edge to the start of `first`; 0: the AGV is
        there.
        """
        if self.graph.start_vertex(first).id != self.graph.start_vertex(self.edge).id:
            self.edge, self.arc = -self.edge, self.graph.curve(self.edge).length - self.arc
        return self.arc if self.arc > _AT_END else 0.0

    # -- driving ----------------------------------------------------------------------------------

    def drive(self, seconds: float) -> None:
        """Advances the AGV by the given virtual time, in s."""
        self._drive(seconds)
        waited, self._waits = self._waits, None
        refusal = self.receive(waited) if waited is not None else None
        if refusal is not None:
            self._late_refusals.append(refusal)
        if self.arc <= _NEAR:
            self._visit(self.graph.start_vertex(self.edge).id)
        if self.graph.curve(self.edge).length - self.arc <= _NEAR:
            self._visit(self.graph.end_vertex(self.edge).id)

    def _visit(self, vertex: int) -> None:
        if vertex != self.visited[-1]:
            self.visited.append(vertex)

    def _drive(self, seconds: float) -> None:
        self._drove |= self.is_driving
        self.moved = max(self.moved - seconds, 0.0)
        stalled = min(self.stalled, seconds)
        self.stalled -= stalled
        seconds -= stalled
        if self.emergency and self.phase is Phase.RUNNING:
            self.fail(EMERGENCY_STOP)
        if self._rolls > 0.0:
            self._roll(seconds)
        if self.phase is Phase.RUNNING and self._to_begin:
            back = min(seconds * self._speed(), self._to_begin)
            seconds -= back / self._speed()
            self.arc, self._to_begin = self.arc - back, self._to_begin - back
            if self._to_begin > _AT_END:
                return
            self._to_begin, self.edge, self.arc = 0.0, self.edges[self.current], 0.0
        while self.phase is Phase.RUNNING:
            self.edge = self.edges[self.current]
            length, speed = self.graph.curve(self.edge).length, self._speed()
            step = min(seconds * speed, length - self.arc)
            self.arc += step
            self.travelled += step
            if self.arc < length - _AT_END:
                return
            self.arc = length
            self._visit(self.graph.end_vertex(self.edge).id)
            seconds -= step / speed
            self.current += 1
            self.knows['done'] = self.knows['first'] + self.current
            if self.current == len(self.edges):
                self.phase = Phase.COMPLETE
                return
            self.edge, self.arc = self.edges[self.current], 0.0

    def _speed(self) -> float:
        edge = self.graph.edge(self.edge)
        speed = edge.velocity_forward if self.edge > 0 else edge.velocity_backwards
        return self.pace * (self.kind.drives_at(speed) or self.kind.speed)

    def _roll(self, seconds: float) -> None:
        """Rolls on after the loss of its route."""
        left = min(seconds * self._speed(), self._rolls)
        self._rolls -= left
        while left > 0.0:
            step = min(left, self.graph.curve(self.edge).length - self.arc)
            self.arc, left = self.arc + step, left - step
            self.travelled += step
            if left > 0.0:
                self._visit(self.graph.end_vertex(self.edge).id)
                if not self._rolls_along:
                    self._rolls = 0.0
                    return
                self.edge, self.arc = self._rolls_along[0], 0.0
                self._rolls_along = self._rolls_along[1:]

    def forget(self) -> None:
        """Switches the AGV off and on again: it stands where it is, and has no memory."""
        self.route_id, self.edges, self.current, self._to_begin = 0, (), 0, 0.0
        self.phase, self.reason = Phase.STOPPED, NO_REASON
        self._rolls, self._giver, self._refused, self._waits = 0.0, None, None, None
        self._start_without_memory()

    def _start_without_memory(self) -> None:
        self.begin_epoch(EpochCause.RESTART)
        self.knows.update(master=None, first=0, done=0)

    def be_carried(self, edge: int, arc: float) -> None:
        """Lets a person switch the AGV off, carry it to this place, and switch it on again."""
        self.forget()
        self.edge, self.arc, self.aside = edge, arc, (0.0, 0.0)

    def restart(self) -> None:
        """Starts the AGV again with its memory: nothing changes, except that it stands."""
        self._rolls = 0.0

    def fail(self, reason: Reason) -> None:
        """Lets a running route fail. Some reasons begin a new epoch, with or without a route."""
        if self.phase is Phase.RUNNING:
            self._lose_route()
            self.phase, self.reason, self._to_begin = Phase.FAILED, reason, 0.0
        cause = _CAUSES.get(reason.code)
        if cause is not None:
            self.begin_epoch(cause)

    def move_to(self, edge: int, arc: float) -> None:
        """Lets a person or another program move the AGV to this place. For 1 s, the AGV reports
        that it is moved.
        """
        self.fail(TAKEN_OVER)
        self.edge, self.arc, self._rolls, self.moved = edge, arc, 0.0, 1.0
        self.drive(0.0)

    # -- reports ----------------------------------------------------------------------------------

    def told(self, stamp: int) -> RouteReport:
        """Returns the AGV's next report, with this stamp (ns)."""
        knows = self.knows
        knows['report'] += 1
        self._notice_motion()
        pose = self.pose
        return RouteReport(
            stamp - (self.old or 0), self.route_id, self.edges, self._states(),
            SymbolicPose(pose.edge, 100.0 * pose.fraction), self.reason,
            None if self.old is None or self.off_graph else self.location,
            knows['epoch'], knows['cause'], knows['master'] or '', knows['taken'], knows['refused'],
            knows['refusal'], knows['first'], self.motion, knows['report'],
            self.unready)

    def report(self, stamp: float) -> RouteReport:
        """Returns the AGV's next report, with this stamp (s)."""
        return self.told(round(1e9 * stamp))

    @property
    def taken(self) -> int:
        """Number of the last order that it took."""
        taken: int = self.knows['taken']
        return taken

    @property
    def unready(self) -> ReasonCode:
        """Why the AGV would refuse any route now."""
        if self.emergency:
            return ReasonCode.EMERGENCY_STOP
        return ReasonCode.OFF_GRAPH if self.off_graph else ReasonCode.NONE

    def _notice_motion(self) -> None:
        """Notes that a person moves the AGV, if its place has changed although it did not drive."""
        here = self.position
        if self._stayed is not None and not self._drove and (
                math.dist(here, self._stayed) > _TREMBLE):
            self.moved = 1.0
        elif not self._drove and self._stayed is not None:
            return
        self._stayed, self._drove = here, self.is_driving

    def _states(self) -> Tuple[EdgeState, ...]:
        rest = EdgeState.FAILED if self.phase is Phase.FAILED else EdgeState.PROCESSING
        return ((EdgeState.COMPLETE,) * self.current
                + (rest,) * (len(self.edges) - self.current))

    def come_to_rest_at(self, arc: float) -> None:
        """Puts the AGV on its edge, `arc` m from the start, as if it had stopped there."""
        self.arc, self._stayed = arc, None

    @property
    def done(self) -> int:
        """Number in the route record of the edge under way, or of the next edge if none is under
        way.
        """
        return self.knows['first'] + self.current

    @property
    def ahead(self) -> Tuple[int, ...]:
        """The edges that it drives, or on which it rolls on without a route."""
        if self.phase is Phase.RUNNING:
            return self.edges[self.current:]
        return (self.edge, *self._rolls_along) if self._rolls > 0.0 else ()

    @property
    def pose(self) -> Pose:
        """The place on the graph that it reports."""
        if self.off_graph:
            return Pose()
        fraction = min(self.arc / self.graph.curve(self.edge).length, 1.0)
        if self.phase is Phase.RUNNING and self._to_begin:
            return Pose(self.edges[self.current], 0.0)
        if self.phase is Phase.RUNNING:
            return Pose(self.edge, min(fraction, 0.999))
        if self.phase is Phase.COMPLETE and self.edge == self.edges[-1]:
            return Pose(self.edge, fraction)
        return Pose(abs(self.edge), fraction if self.edge > 0 else 1.0 - fraction)


_ROLLS = Reason(ReasonCode.NOT_READY, 'it has not come to rest yet')
_OLD = ''  # all masters that do not number their orders
_CAUSES = {
    ReasonCode.TAKEN_OVER: EpochCause.OTHER_GIVER, ReasonCode.LOST_LINK: EpochCause.LOST_LINK,
    ReasonCode.EMERGENCY_STOP: EpochCause.EMERGENCY_STOP}


class LostLink:
    """A robot's computer while the link between it and the robot is down.

    The computer takes stops, and gives the last stop to the robot when the link is restored. If the
    robot had a route when the link was lost, the route fails when the link is restored, and a new
    epoch begins.

    commands_only -- only the link for commands is down; another link still carries locations
    """

    def __init__(self, agv: Agv, now: float, commands_only: bool = False) -> None:
        self._agv = agv
        self._commands_only = commands_only
        self._lost_route = agv.phase is Phase.RUNNING
        last = agv.told(round(1e9 * now))
        if self._lost_route:
            self._said = replace(
                last, reason=LOST_LINK, motion=Motion.UNKNOWN,
                unready=ReasonCode.LOST_LINK,
                states=tuple(state if state is EdgeState.COMPLETE else EdgeState.FAILED
                             for state in last.states))
        else:
            self._said = replace(last, motion=Motion.UNKNOWN, unready=ReasonCode.LOST_LINK)
        self._stop: Optional[RouteOrder] = None

    def told(self, stamp: int) -> RouteReport:
        """Returns the computer's next report about the robot."""
        self._agv.knows['report'] += 1
        said = replace(self._said, number=self._agv.knows['report'])
        if self._commands_only:
            pose = self._agv.pose
            said = replace(said, stamp=stamp, pose=SymbolicPose(pose.edge, 100.0 * pose.fraction),
                           location=self._agv.location)
        return said

    def report(self, now: float) -> RouteReport:
        """Returns the computer's next report at the time `now` (s)."""
        return self.told(round(1e9 * now))

    def receive(self, order: RouteOrder) -> Optional[RouteRefusal]:
        """Keeps a stop until the link is restored. Refuses all other orders."""
        said = self._said
        if order.order and order.master == said.master and (
                order.order <= max(said.order, said.refused)):
            return None
        if not order.edges:
            self._stop = order
            self._agv.count_stop(order)
            self._said = replace(
                self._counted(), route_id=order.route_id, first=self._agv.knows['done'],
                edges=(), states=(),
                reason=Reason(ReasonCode.STOP_OWED,
                              'the robot has not obeyed the stop yet: the link is down'))
            return None
        if not order.order and (order.route_id, order.edges) == (said.route_id, said.edges):
            return None
        reason = Reason(ReasonCode.LOST_LINK, 'the link is down')
        refusal = self._agv.refuse(order, reason)
        self._said = self._counted()
        return refusal

    def _counted(self) -> RouteReport:
        """Returns the last report, with the present epoch and order numbers of the robot."""
        knows = self._agv.knows
        return replace(self._said, epoch=knows['epoch'], cause=knows['cause'],
                       master=knows['master'] or '', order=knows['taken'],
                       refused=knows['refused'], refusal=knows['refusal'])

    def order(self, route_id: int, edges: Tuple[int, ...]) -> Optional[RouteRefusal]:
        """Takes an order of a master that does not number its orders."""
        return self.receive(RouteOrder(route_id, edges))

    def end(self) -> None:
        """Restores the link: the robot's route fails, and the robot gets the owed stop."""
        if self._lost_route:
            self._agv.fail(LOST_LINK)
        if self._stop is not None:
            self._agv.receive(self._stop)  # counts the stop in the new epoch, if one began
            self._agv.stand(self._stop.route_id)
