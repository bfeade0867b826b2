"""A simple AGV for tests of the supervisor. It obeys orders as the route protocol requires.

It shares no code with `agv_sim`, nor with `route_protocol.vehicle`. Therefore a mistake in one
cannot hide a mistake in the other.
"""
from __future__ import annotations

import math
from dataclasses import replace
from itertools import count
from typing import Iterator, List, Optional, Tuple

from graph_fleet_manager.fleet import RobotType
from graph_fleet_manager.interlocking.reports import Pose
from graph_fleet_manager.interlocking.route_client import ME
from route_protocol.master import Order
from route_protocol.values import (
    EMERGENCY_STOP,
    NO_REASON,
    OVERRULED,
    EdgeState,
    EpochCause,
    Location,
    Motion,
    Phase,
    Reason,
    ReasonCode,
    RouteRefusal,
    RouteReport,
    SymbolicPose,
)
from trajectory_graph import Graph, TrajectoryGraphError, check_route

LOST_LINK = Reason(ReasonCode.LOST_LINK, 'lost link: commands')
CANNOT_BRAKE = Reason(ReasonCode.CANNOT_BRAKE, 'it cannot brake in time')

_AT_END = 1e-6  # m
_TREMBLE = 0.05  # m by which the location of a standing AGV may change
_NEAR = 0.3     # m from a vertex within which a route may begin at the vertex
_EPOCHS: Iterator[int] = count(10 ** 6)


class Agv:
    """One AGV. Tests set these attributes to cause faults:

    stalled   -- s for which it stands still
    pace      -- factor on its speed
    refusing  -- number of its next orders that it refuses
    emergency -- if True, its route fails, and it refuses orders
    off_graph -- if True, it refuses orders and reports no pose
    near      -- m from a vertex within which it counts as standing there; if a test changes it, a
                 route near a vertex must begin with an edge that leads away from the vertex
    braking   -- m that it needs to stop; when it loses its route, it rolls on along it so far
    aside     -- x, y in m by which it stands beside its edge
    moved     -- s for which it still counts as moved by somebody else
    """

    def __init__(self, graph: Graph, kind: RobotType, vertex: int) -> None:
        self.graph, self.kind = graph, kind
        self.edge = graph.edges_from(vertex)[0]
        """Signed id of the edge on which the AGV is."""
        self.arc = 0.0
        """m from the start of this edge to the AGV."""
        self.epoch, self.cause = next(_EPOCHS), EpochCause.RESTART
        self.taken = self.refused = 0
        """Numbers of the last order that it took, and of the highest that it refused."""
        self.refusal = NO_REASON
        self.route_id = 0
        self.first = 0
        """Number of the first of `edges` in its route record."""
        self.edges: Tuple[int, ...] = ()
        self.current = 0
        self.phase = Phase.STOPPED
        self.reason = NO_REASON
        self.told = 0
        """Number of its last report."""
        self.stalled = 0.0
        self.emergency = False
        self.off_graph = False
        self.pace = 1.0
        self.refusing = 0
        self.near = _NEAR
        self.braking = 0.0
        self.aside = (0.0, 0.0)
        self.moved = 0.0
        self.master = ''
        self.travelled = 0.0
        self.visited: List[int] = [vertex]
        """Ids of the visited vertices, in order."""
        self._to_begin = 0.0  # m to drive back on this edge, to the vertex where the route begins
        self._rolls = 0.0     # m that it still rolls on without a route
        self._stayed: Optional[Tuple[float, float]] = None  # where it was at its last report
        self._drove = False

    @property
    def position(self) -> Tuple[float, float]:
        """The position x, y in m, in the frame of the graph."""
        curve = self.graph.curve(self.edge)
        x, y = curve.point_at(self.arc)
        return float(x) + self.aside[0], float(y) + self.aside[1]

    @property
    def is_driving(self) -> bool:
        """Whether the AGV has a route that is not finished, or still rolls without one."""
        return self.phase is Phase.RUNNING or self._rolls > 0.0

    @property
    def motion(self) -> Motion:
        """What it does."""
        if self.moved > 0.0:
            return Motion.MOVED
        if self.phase is Phase.RUNNING:
            return Motion.ON_ROUTE
        return Motion.COMING_TO_REST if self._rolls else Motion.STANDING

    @property
    def done(self) -> int:
        """Number of the edge under way in its route record."""
        return self.first + self.current

    @property
    def news(self) -> object:
        """The part of the report that is sent at once when it changes."""
        return (self.epoch, self.taken, self.refused, self.current, self.phase, self.reason,
                self.motion, self.unready)

    def late_refusals(self) -> List[RouteRefusal]:
        """Returns no refusals: `receive` returns each refusal at once."""
        return []

    def __str__(self) -> str:
        return (f'edge {self.edge} at {self.arc:.2f}, epoch {self.epoch} {self.cause.name} order '
                f'{self.taken} {self.first} {self.edges} {self.current} {self.phase.value} '
                f'{self.motion.name} refused {self.refused} {self.refusal}')

    # -- orders -----------------------------------------------------------------------------------

    def ignores(self, order: Order) -> bool:
        """Whether it would neither obey nor drive this order if it came now."""
        return bool(order.number) and order.number <= max(self.taken, self.refused) or bool(
            order.edges) and order.epoch != self.epoch

    def receive(self, order: Order) -> Optional[RouteRefusal]:
        """Takes an order, or returns its refusal. A repeated order has no effect."""
        is_mine = self.master in ('', ME)
        if order.number and is_mine and order.number <= max(self.taken, self.refused):
            return None
        if not order.edges and not is_mine:
            self.begin_epoch(EpochCause.OTHER_MASTER)
        if not order.edges:
            self._lose_route()
            first = self.done if self.taken or not order.number else order.first
            self.route_id, self.first, self.edges, self.current = order.route_id, first, (), 0
            self.phase, self.reason = Phase.STOPPED, NO_REASON
            if order.number:
                self.taken, self.master = order.number, ME
            else:
                self.begin_epoch(EpochCause.STOP)
            return None
        if self._rolls:
            return None  # it answers when it stands
        if not is_mine:
            return RouteRefusal(order.route_id, order.edges, OVERRULED, order.number)
        reason = OVERRULED if order.epoch != self.epoch else self._take_up(order)
        return self.refuse(order, reason) if reason else None

    def refuse(self, order: Order, reason: Reason) -> RouteRefusal:
        """Returns the refusal of an order by the AGV's computer; a repetition is refused, too."""
        self.refused, self.refusal = max(self.refused, order.number), reason
        self.master = ME
        return RouteRefusal(order.route_id, order.edges, reason, order.number)

    def obey_another(self, edges: Tuple[int, ...]) -> None:
        """Takes a route of another master, from where it is."""
        self.begin_epoch(EpochCause.OTHER_MASTER)
        self.taken, self.master = 1, 'another'
        self.first, self.edges, self.current = 0, edges, 0
        self.edge, self.arc = edges[0], self.arc if edges[0] == self.edge else 0.0
        self.phase, self.reason = Phase.RUNNING, NO_REASON

    def begin_epoch(self, cause: EpochCause) -> None:
        """Obeys no order any more that is on its way."""
        self.epoch, self.cause = next(_EPOCHS), cause
        self.taken = self.refused = 0
        self.refusal = NO_REASON

    def _lose_route(self) -> None:
        if self.phase is Phase.RUNNING and not self.stalled:
            self._rolls = self.braking

    def _take_up(self, order: Order) -> Reason:
        if self.emergency:
            return EMERGENCY_STOP
        if self.off_graph:
            return Reason(ReasonCode.OFF_GRAPH, 'the robot is off the graph')
        if self.refusing:
            self.refusing -= 1
            return Reason(ReasonCode.OTHER, 'the test makes the robot refuse')
        try:
            check_route(self.graph, order.edges)
        except TrajectoryGraphError as error:
            return Reason(ReasonCode.WRONG_ROUTE, str(error))
        skipped = self.done - order.first if self.taken else 0
        if not 0 <= skipped <= len(order.edges):
            return Reason(ReasonCode.WRONG_CHANGE, 'its record numbers do not fit')
        rest = order.edges[skipped:]
        if self.phase is Phase.RUNNING and self.taken:
            if rest[:1] != self.edges[self.current:self.current + 1]:
                return Reason(ReasonCode.WRONG_CHANGE, 'it must go on with the edge under way')
            if len(rest) == 1 and self._cannot_brake():
                return CANNOT_BRAKE
        elif rest:
            begun = self._beginning(rest)
            if begun is None:
                return Reason(ReasonCode.STARTS_ELSEWHERE,
                              f'edge {rest[0]} does not start where the robot is')
            edge, arc = begun
            self._to_begin = 0.0 if abs(edge) == abs(self.edge) else self._from_vertex(edge)
            if not self._to_begin:
                self.edge, self.arc = edge, arc
        elif self.phase is not Phase.COMPLETE:
            return Reason(ReasonCode.WRONG_CHANGE, 'it ends before the place where it stands')
        self.taken, self.master, self.route_id = order.number, ME, order.route_id
        self.first, self.edges, self.current = order.first, order.edges, skipped
        self.phase = Phase.RUNNING if rest else Phase.COMPLETE
        self.reason = NO_REASON
        self.drive(0.0)
        return NO_REASON

    def _beginning(self, edges: Tuple[int, ...]) -> Optional[Tuple[int, float]]:
        """Returns where a new route begins: the edge, and m from its start.

        Returns None if the route does not begin where the AGV is.
        """
        first = edges[0]
        length = self.graph.curve(self.edge).length
        if first == self.edge and (length - self.arc > self.near or self.near == _NEAR):
            return first, self.arc
        if first == -self.edge and (self.arc > self.near or self.near == _NEAR):
            return first, length - self.arc
        start = self.graph.start_vertex(first).id
        if self.arc <= self.near and start == self.graph.start_vertex(self.edge).id:
            return first, 0.0
        if length - self.arc <= self.near and start == self.graph.end_vertex(self.edge).id:
            return first, 0.0
        return None

    def _cannot_brake(self) -> bool:
        """Whether the AGV would drive on to another edge and is too near this one's end to stop."""
        return (self.phase is Phase.RUNNING and self.current + 1 < len(self.edges)
                and self.graph.curve(self.edge).length - self.arc < self.braking)

    def _from_vertex(self, first: int) -> float:
        """Returns the distance (m) on the current edge to the start of edge `first`; 0: there."""
        if self.graph.start_vertex(first).id != self.graph.start_vertex(self.edge).id:
            self.edge, self.arc = -self.edge, self.graph.curve(self.edge).length - self.arc
        return self.arc if self.arc > _AT_END else 0.0

    # -- driving ----------------------------------------------------------------------------------

    def drive(self, seconds: float) -> None:
        """Advances the AGV by the given virtual time, in s."""
        self._drive(seconds)
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
        if self.phase is Phase.RUNNING and self._to_begin:
            back = min(seconds * self._speed(), self._to_begin)
            seconds -= back / self._speed()
            self.arc, self._to_begin = self.arc - back, self._to_begin - back
            if self._to_begin > _AT_END:
                return
            self._to_begin, self.edge, self.arc = 0.0, self.edges[self.current], 0.0
        if self._rolls:
            self._roll(seconds)
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
            if self.current == len(self.edges):
                self.phase = Phase.COMPLETE
                return
            self.edge, self.arc = self.edges[self.current], 0.0

    def _speed(self) -> float:
        edge = self.graph.edge(self.edge)
        speed = edge.velocity_forward if self.edge > 0 else edge.velocity_backwards
        return self.pace * (self.kind.drives_at(speed) or self.kind.speed)

    def _roll(self, seconds: float) -> None:
        """Rolls on along the edge, at most to its end, after the loss of its route."""
        step = min(seconds * self._speed(), self._rolls,
                   self.graph.curve(self.edge).length - self.arc)
        self.arc, self.travelled = self.arc + step, self.travelled + step
        self._rolls = self._rolls - step if step else 0.0
        if self._rolls < _AT_END:
            self._rolls = 0.0

    def forget(self) -> None:
        """Switches the AGV off and on again: it stands where it is and has no memory."""
        self.route_id, self.edges, self.current, self._to_begin = 0, (), 0, 0.0
        self.first, self._rolls, self.master = 0, 0.0, ''
        self.phase, self.reason = Phase.STOPPED, NO_REASON
        self.begin_epoch(EpochCause.RESTART)

    def fail(self, reason: Reason) -> None:
        """Lets a running route fail for this reason."""
        if self.phase is Phase.RUNNING:
            self._lose_route()
            self.phase, self.reason = Phase.FAILED, reason
            self._to_begin = 0.0
        cause = _CAUSES.get(reason.code)
        if cause is not None:
            self.begin_epoch(cause)

    # -- reports ----------------------------------------------------------------------------------

    def report(self, stamp: float) -> RouteReport:
        """Returns the AGV's next report, with this stamp (s)."""
        rest = EdgeState.FAILED if self.phase is Phase.FAILED else EdgeState.PROCESSING
        states = ((EdgeState.COMPLETE,) * self.current
                  + (rest,) * (len(self.edges) - self.current))
        self.told += 1
        self._notice_motion()
        pose = self._pose()
        return RouteReport(
            round(1e9 * stamp), self.route_id, self.edges, states,
            SymbolicPose(pose.edge, 100.0 * pose.fraction), self.reason,
            None if self.off_graph else Location(*self.position, math.nan), self.epoch, self.cause,
            self.master, self.taken, self.refused, self.refusal, self.first, self.motion, self.told,
            self.unready)

    @property
    def unready(self) -> ReasonCode:
        """Why it would refuse each route now."""
        if self.emergency:
            return ReasonCode.EMERGENCY_STOP
        return ReasonCode.OFF_GRAPH if self.off_graph else ReasonCode.NONE

    def _notice_motion(self) -> None:
        """If it moves without its own drive, somebody moves it, until it stays for a second."""
        here = self.position
        if self._stayed is not None and not self._drove and (
                math.dist(here, self._stayed) > _TREMBLE):
            self.moved = 1.0
        elif not self._drove and self._stayed is not None:
            return
        self._stayed, self._drove = here, self.is_driving

    def come_to_rest_at(self, arc: float) -> None:
        """It has come to rest on its edge by its own drive, `arc` m from the start of the edge."""
        self.arc, self._stayed = arc, None

    @property
    def ahead(self) -> Tuple[int, ...]:
        """The edges that it drives, or on which it rolls on without a route."""
        if self.phase is Phase.RUNNING:
            return self.edges[self.current:]
        return (self.edge,) if self._rolls else ()

    @property
    def pose(self) -> Pose:
        """The place on the graph that it reports."""
        return self._pose()

    def _pose(self) -> Pose:
        if self.off_graph:
            return Pose()
        fraction = min(self.arc / self.graph.curve(self.edge).length, 1.0)
        if self.phase is Phase.RUNNING and self._to_begin:
            return Pose(self.edges[self.current], 0.0)
        if self.phase is Phase.RUNNING:
            return Pose(self.edge, min(fraction, 0.999))
        if self.phase is Phase.COMPLETE and self.edges:
            return Pose(self.edges[-1], 1.0)
        return Pose(abs(self.edge), fraction if self.edge > 0 else 1.0 - fraction)


_CAUSES = {
    ReasonCode.TAKEN_OVER: EpochCause.OTHER_GIVER, ReasonCode.LOST_LINK: EpochCause.LOST_LINK,
    ReasonCode.EMERGENCY_STOP: EpochCause.EMERGENCY_STOP}


class LostLink:
    """A robot's computer while the link between it and the robot is down.

    commands_only -- only the link for commands is down; locations still come by another link
    """

    def __init__(self, agv: Agv, now: float, commands_only: bool = False) -> None:
        self._agv = agv
        self._commands_only = commands_only
        last = agv.report(now)
        failed = (EdgeState.FAILED,) * (len(last.edges) - last.completed)
        had_route = agv.phase is Phase.RUNNING
        self._told = replace(
            last, states=last.states[:len(last.states) - len(failed)] + failed if had_route
            else last.states, reason=LOST_LINK if had_route else last.reason,
            motion=Motion.COMING_TO_REST if had_route else Motion.UNKNOWN,
            unready=ReasonCode.LOST_LINK)
        if had_route:
            self._told = replace(self._told, epoch=next(_EPOCHS), cause=EpochCause.LOST_LINK,
                                 order=0, refused=0, refusal=NO_REASON)
        self._stop: Optional[Order] = None

    def report(self, now: float) -> RouteReport:
        """Returns the computer's report on the robot at the time `now`."""
        self._agv.told += 1
        told = replace(self._told, number=self._agv.told)
        if not self._commands_only:
            return told
        seen = self._agv.report(now)
        return replace(told, stamp=seen.stamp, pose=seen.pose, location=seen.location,
                       number=self._agv.told)

    def receive(self, order: Order) -> Optional[RouteRefusal]:
        """Keeps a stop until the link is back; refuses each other order."""
        told = self._told
        if order.number and order.number <= max(told.order, told.refused):
            return None
        if order.edges:
            reason = Reason(ReasonCode.LOST_LINK, 'the link is down')
            self._told = replace(told, refused=order.number, refusal=reason, master=ME)
            return RouteRefusal(order.route_id, order.edges, reason, order.number)
        self._stop = order
        first = told.done if told.order else order.first
        self._told = replace(told, order=order.number, master=ME, first=first, edges=(),
                             states=(), reason=Reason(ReasonCode.STOP_OWED,
                                                      'the robot has not obeyed the stop yet: '
                                                      'the link is down'),
                             motion=Motion.COMING_TO_REST)
        return None

    def end(self) -> None:
        """Restores the link: the robot's route fails, and the robot gets the owed stop."""
        agv, told = self._agv, self._told
        agv.fail(LOST_LINK)
        agv.epoch, agv.cause = told.epoch, told.cause
        agv.taken, agv.refused, agv.refusal = told.order, told.refused, told.refusal
        if self._stop is not None:
            agv.first, agv.edges, agv.current = told.first, (), 0
            agv.phase, agv.reason = Phase.STOPPED, NO_REASON
