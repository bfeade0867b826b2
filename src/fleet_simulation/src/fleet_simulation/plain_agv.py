"""A simple AGV for tests of the supervisor. It obeys orders as the route protocol requires.

It shares no code with `agv_sim`. Therefore a mistake in one cannot hide a mistake in the other.
"""
from __future__ import annotations

from dataclasses import replace
from typing import List, Optional, Tuple

from graph_fleet_manager.fleet import RobotType
from graph_fleet_manager.interlocking.reports import Pose, Report
from route_protocol.values import (
    EMERGENCY_STOP,
    NO_REASON,
    EdgeState,
    Location,
    Phase,
    Reason,
    ReasonCode,
    RouteRefusal,
)
from trajectory_graph import Graph, TrajectoryGraphError, check_route

LOST_LINK = Reason(ReasonCode.LOST_LINK, 'lost link: commands')
CANNOT_BRAKE = Reason(ReasonCode.CANNOT_BRAKE, 'it cannot brake in time')

_AT_END = 1e-6  # m
_NEAR = 0.3     # m from a vertex within which a route may begin at the vertex
_JUST_LEFT = 0.5  # m past a vertex within which a route may begin with the edge before the vertex


class Agv:
    """One AGV. Tests set these attributes to cause faults:

    stalled   -- s for which it stands still
    pace      -- factor on its speed
    refusing  -- number of its next orders that it refuses
    emergency -- if True, its route fails, and it refuses orders
    off_graph -- if True, it refuses orders and reports no pose
    near      -- m from a vertex within which it counts as standing there; if a test changes it, a
                 route near a vertex must begin with an edge that leads away from the vertex
    braking   -- m that it needs to stop
    aside     -- m in x and y by which a person pushed it off its edge; it then reports x, y, too
    """

    def __init__(self, graph: Graph, kind: RobotType, vertex: int) -> None:
        self.graph, self.kind = graph, kind
        self.edge = graph.edges_from(vertex)[0]
        """Signed id of the edge on which the AGV is."""
        self.arc = 0.0
        """m from the start of this edge to the AGV."""
        self.route_id = 0
        self.edges: Tuple[int, ...] = ()
        self.current = 0
        self.phase = Phase.STOPPED
        self.reason = NO_REASON
        self._refused: Optional[RouteRefusal] = None
        self._to_begin = 0.0  # m to drive back on this edge, to the vertex where the route begins
        self.stalled = 0.0
        self.emergency = False
        self.off_graph = False
        self.pace = 1.0
        self.refusing = 0
        self.near = _NEAR
        self.braking = 0.0
        self.aside = 0.0, 0.0
        self.travelled = 0.0
        self.visited: List[int] = [vertex]
        """Ids of the visited vertices, in order."""

    @property
    def position(self) -> Tuple[float, float]:
        """The position x, y in m, in the frame of the graph."""
        x, y = self.graph.curve(self.edge).point_at(self.arc)
        return float(x) + self.aside[0], float(y) + self.aside[1]

    @property
    def is_driving(self) -> bool:
        """Whether the AGV has a route that is not finished."""
        return self.phase is Phase.RUNNING

    @property
    def news(self) -> object:
        """The part of the report that is sent at once when it changes."""
        return self.route_id, self.edges, self.current, self.phase, self.reason

    def late_refusals(self) -> List[RouteRefusal]:
        """Returns no refusals: `order` returns each refusal at once."""
        return []

    def __str__(self) -> str:
        return (f'edge {self.edge} at {self.arc:.2f}, route {self.route_id} {self.edges} '
                f'{self.current} {self.phase.value}')

    # -- orders -----------------------------------------------------------------------------------

    def order(self, route_id: int, edges: Tuple[int, ...]) -> Optional[RouteRefusal]:
        """Accepts a new route or a change of the route, or returns the refusal.

        A repeated order gets the same answer again.
        """
        if not edges:
            self.forget()
            self.route_id = route_id
            return None
        if (route_id, edges) == (self.route_id, self.edges):
            return None
        if not self.has_refused(route_id, edges):
            reason = self._take_up(route_id, edges)
            self._refused = RouteRefusal(route_id, edges, reason) if reason else None
        return self._refused

    def refuse(self, route_id: int, edges: Tuple[int, ...], reason: Reason) -> RouteRefusal:
        """Returns the refusal of an order by the AGV's computer; a repetition is refused, too."""
        self._refused = RouteRefusal(route_id, edges, reason)
        return self._refused

    def has_refused(self, route_id: int, edges: Tuple[int, ...]) -> bool:
        """Whether this order is the last one that was refused; it would be refused again."""
        refused = self._refused
        return refused is not None and (route_id, edges) == (refused.route_id, refused.edges)

    def _take_up(self, route_id: int, edges: Tuple[int, ...]) -> Reason:
        if self.emergency:
            return EMERGENCY_STOP
        if self.off_graph:
            return Reason(ReasonCode.OFF_GRAPH, 'the robot is off the graph')
        if self.refusing:
            self.refusing -= 1
            return Reason(ReasonCode.OTHER, 'the test makes the robot refuse')
        try:
            check_route(self.graph, edges)
        except TrajectoryGraphError as error:
            return Reason(ReasonCode.WRONG_ROUTE, str(error))
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
        else:
            begun = self._beginning(edges)
            if begun is None:
                return Reason(ReasonCode.STARTS_ELSEWHERE,
                              f'edge {edges[0]} does not start where the robot is')
            if edges[begun[0]:] == (self.edge,) and self._cannot_brake():
                return CANNOT_BRAKE
            self.current, edge, arc = begun
            self._to_begin = 0.0 if abs(edge) == abs(self.edge) else self._from_vertex(edge)
            if not self._to_begin:
                self.edge, self.arc = edge, arc
        self.route_id, self.edges = route_id, edges
        self.phase = Phase.RUNNING if self.current < len(edges) else Phase.COMPLETE
        self.reason = NO_REASON
        self.drive(0.0)
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
        """Whether the AGV would drive on to another edge and is too near this one's end to stop."""
        return (self.is_driving and self.current + 1 < len(self.edges)
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
        stalled = min(self.stalled, seconds)
        self.stalled -= stalled
        seconds -= stalled
        if self.emergency and self.is_driving:
            self.fail(EMERGENCY_STOP)
        if self.is_driving and self._to_begin:
            back = min(seconds * self._speed(), self._to_begin)
            seconds -= back / self._speed()
            self.arc, self._to_begin = self.arc - back, self._to_begin - back
            if self._to_begin > _AT_END:
                return
            self._to_begin, self.edge, self.arc = 0.0, self.edges[self.current], 0.0
        while self.is_driving:
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

    def forget(self) -> None:
        """Switches the AGV off and on again: it stands where it is and has no route."""
        self.route_id, self.edges, self.current, self._to_begin = 0, (), 0, 0.0
        self.phase, self.reason = Phase.STOPPED, NO_REASON

    def fail(self, reason: Reason) -> None:
        """Lets a running route fail for this reason."""
        if self.phase is Phase.RUNNING:
            self.phase, self.reason = Phase.FAILED, reason

    # -- reports ----------------------------------------------------------------------------------

    def report(self, stamp: float) -> Report:
        """Returns the AGV's report, with this stamp."""
        rest = EdgeState.FAILED if self.phase is Phase.FAILED else EdgeState.PROCESSING
        states = ((EdgeState.COMPLETE,) * self.current
                  + (rest,) * (len(self.edges) - self.current))
        location = Location(*self.position, 0.0) if any(self.aside) else None
        return Report(self.route_id, self.edges, states, self._pose(), self.reason, stamp,
                      location=location)

    def _pose(self) -> Pose:
        if self.off_graph:
            return Pose()
        fraction = min(self.arc / self.graph.curve(self.edge).length, 1.0)
        if self.phase is Phase.RUNNING and self._to_begin:
            return Pose(self.edges[self.current], 0.0)
        if self.phase is Phase.RUNNING:
            return Pose(self.edge, min(fraction, 0.999))
        if self.phase is Phase.COMPLETE:
            return Pose(self.edges[-1], 1.0)
        return Pose(abs(self.edge), fraction if self.edge > 0 else 1.0 - fraction)


class LostLink:
    """A robot's computer while the link between it and the robot is down.

    commands_only -- only the link for commands is down; locations still come by another link
    """

    def __init__(self, agv: Agv, now: float, commands_only: bool = False) -> None:
        self._agv = agv
        self._commands_only = commands_only
        last = agv.report(now)
        failed = (EdgeState.FAILED,) * len(last.left) if last.is_running else ()
        self._told = replace(last, states=last.states[:len(last.states) - len(failed)] + failed,
                            reason=LOST_LINK if failed else last.reason)
        self._stop: Optional[int] = None

    def report(self, now: float) -> Report:
        """Returns the computer's report on the robot at the time `now`."""
        return replace(self._told, stamp=now) if self._commands_only else self._told

    def order(self, route_id: int, edges: Tuple[int, ...]) -> Optional[RouteRefusal]:
        """Keeps a stop until the link is back; refuses each other order."""
        if edges:
            same = (route_id, edges) == (self._told.route_id, self._told.edges)
            return None if same else self._agv.refuse(
                route_id, edges, Reason(ReasonCode.LOST_LINK, 'the link is down'))
        self._stop = route_id
        self._told = replace(self._told, route_id=route_id, edges=(), states=(),
                            reason=Reason(ReasonCode.STOP_OWED, 'the robot has not obeyed the '
                                                                'stop yet: the link is down'))
        return None

    def end(self) -> None:
        """Restores the link: the robot's route fails, and the robot gets the owed stop."""
        self._agv.fail(LOST_LINK)
        if self._stop is not None:
            self._agv.order(self._stop, ())
