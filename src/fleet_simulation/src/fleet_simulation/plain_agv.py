"""A simple AGV for tests of the supervisor: it obeys routes as the route protocol says.

It shares no code with `agv_sim`, so that neither hides a mistake of the other.
"""
from __future__ import annotations

from dataclasses import replace
from typing import List, Optional, Tuple

from graph_fleet_manager.fleet import RobotType
from graph_fleet_manager.interlocking.reports import Pose, Report
from trajectory_graph import Graph, TrajectoryGraphError, check_route
from trajectory_graph.route_protocol import (
    EMERGENCY_STOP,
    NO_REASON,
    EdgeState,
    Phase,
    Reason,
    ReasonCode,
    RouteRefusal,
)

LOST_LINK = Reason(ReasonCode.LOST_LINK, 'lost link: commands')
CANNOT_BRAKE = Reason(ReasonCode.CANNOT_BRAKE, 'it cannot brake in time')

_AT_END = 1e-6  # m
_NEAR = 0.3     # m from a vertex at which a route may begin there
_JUST_LEFT = 0.5  # m behind a vertex up to which a route may begin with the edge before it


class Agv:
    """One AGV.

    It stands still for `stalled` s, drives with `pace` of its speed, and refuses the next
    `refusing` orders; with `emergency` set it fails and refuses, and with `off_graph` it refuses,
    too, and does not tell where it is. Within `near` m of a vertex it is at that, and begins on no
    other edge than one that leads away.
    """

    def __init__(self, graph: Graph, kind: RobotType, vertex: int) -> None:
        self.graph, self.kind = graph, kind
        self.edge = graph.edges_from(vertex)[0]
        """Signed id of the edge on which it is."""
        self.arc = 0.0
        """m of that edge that lie behind it."""
        self.route_id = 0
        self.edges: Tuple[int, ...] = ()
        self.current = 0
        self.phase = Phase.STOPPED
        self.reason = NO_REASON
        self._refused: Optional[RouteRefusal] = None
        self._to_begin = 0.0  # m to drive back on its edge, to the vertex at which the route begins
        self.stalled = 0.0
        self.emergency = False
        self.off_graph = False
        self.pace = 1.0
        self.refusing = 0
        self.near = _NEAR
        self.braking = 0.0
        self.travelled = 0.0
        self.visited: List[int] = [vertex]
        """Vertices at which it was, in order."""

    @property
    def position(self) -> Tuple[float, float]:
        """x, y in m."""
        x, y = self.graph.curve(self.edge).point_at(self.arc)
        return float(x), float(y)

    @property
    def is_driving(self) -> bool:
        """Has it anything to drive?"""
        return self.phase is Phase.RUNNING

    @property
    def news(self) -> object:
        """What of its report is told at once where it changes."""
        return self.route_id, self.edges, self.current, self.phase, self.reason

    def late_refusals(self) -> List[RouteRefusal]:
        """It thinks about no order: it refuses at once."""
        return []

    def __str__(self) -> str:
        return (f'edge {self.edge} at {self.arc:.2f}, route {self.route_id} {self.edges} '
                f'{self.current} {self.phase.value}')

    # -- orders -----------------------------------------------------------------------------------

    def order(self, route_id: int, edges: Tuple[int, ...]) -> Optional[RouteRefusal]:
        """Takes up a route, or a change of its route, or refuses it, as often as it comes."""
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
        """Its computer refuses an order for it; the same order is refused again."""
        self._refused = RouteRefusal(route_id, edges, reason)
        return self._refused

    def has_refused(self, route_id: int, edges: Tuple[int, ...]) -> bool:
        """Is that the last order that it refused, and would refuse again?"""
        refused = self._refused
        return refused is not None and (route_id, edges) == (refused.route_id, refused.edges)

    def _take_up(self, route_id: int, edges: Tuple[int, ...]) -> Reason:
        if self.emergency:
            return EMERGENCY_STOP
        if self.off_graph:
            return Reason(ReasonCode.OFF_GRAPH, 'the robot is off the graph')
        if self.refusing:
            self.refusing -= 1
            return Reason(ReasonCode.OTHER, 'it does not want to')
        try:
            check_route(self.graph, edges)
        except TrajectoryGraphError as error:
            return Reason(ReasonCode.WRONG_ROUTE, str(error))
        if route_id == self.route_id and self.phase is not Phase.STOPPED:
            if self.phase is Phase.FAILED:
                return Reason(ReasonCode.WRONG_CHANGE, f'route {route_id} has failed')
            kept = self.edges[:self.current + 1]
            if edges[:len(kept)] != kept:
                return Reason(ReasonCode.WRONG_CHANGE, f'route {route_id} must go on with the '
                                                       'edges done and the current one')
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
        """Index of the edge, the edge, and the arc at which a new route begins here."""
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
        """Does it drive on to another edge, and is it too near the end of this one to stop there?
        """
        return (self.is_driving and self.current + 1 < len(self.edges)
                and self.graph.curve(self.edge).length - self.arc < self.braking)

    def _from_vertex(self, first: int) -> float:
        """How far (m) it is from where edge `first` begins, on its own edge; 0: there."""
        if self.graph.start_vertex(first).id != self.graph.start_vertex(self.edge).id:
            self.edge, self.arc = -self.edge, self.graph.curve(self.edge).length - self.arc
        return self.arc if self.arc > _AT_END else 0.0

    # -- driving ----------------------------------------------------------------------------------

    def drive(self, seconds: float) -> None:
        """Drives along its route for so long, or stands."""
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
        """It is switched off and on again: it stands where it is and knows of no route."""
        self.route_id, self.edges, self.current, self._to_begin = 0, (), 0, 0.0
        self.phase, self.reason = Phase.STOPPED, NO_REASON

    def fail(self, reason: Reason) -> None:
        """Ends its route."""
        if self.phase is Phase.RUNNING:
            self.phase, self.reason = Phase.FAILED, reason

    # -- reports ----------------------------------------------------------------------------------

    def report(self, stamp: float) -> Report:
        """What it tells."""
        rest = EdgeState.FAILED if self.phase is Phase.FAILED else EdgeState.PROCESSING
        states = ((EdgeState.COMPLETE,) * self.current
                  + (rest,) * (len(self.edges) - self.current))
        return Report(self.route_id, self.edges, states, self._pose(), self.reason, stamp)

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
    """What a robot's computer tells of it while the link between them is down.

    commands_only -- locations come as before: the robot has a link of its own for them
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
        """What is known of the robot at `now`."""
        return replace(self._told, stamp=now) if self._commands_only else self._told

    def order(self, route_id: int, edges: Tuple[int, ...]) -> Optional[RouteRefusal]:
        """A stop is owed to the robot; nothing else can be taken up."""
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
        """The robot is told to stop."""
        self._agv.fail(LOST_LINK)
        if self._stop is not None:
            self._agv.order(self._stop, ())
