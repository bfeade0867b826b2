"""One simulated AGV: it takes orders, drives and reports, and can have faults."""
from __future__ import annotations

import math
import secrets
from dataclasses import replace
from typing import Callable, Collection, List, Optional, Tuple, Union

from graph_fleet_manager.agv_simulator.battery import SimulatedBattery
from graph_fleet_manager.agv_simulator.drive import ON_PLACE, Drive
from graph_fleet_manager.agv_simulator.route_rules import (
    NotYet,
    check_braking,
    check_change,
    check_order,
    find_start,
)
from graph_fleet_manager.agv_simulator.speed_limits import DriveLimits, SpeedLimits
from route_protocol import vehicle as protocol
from route_protocol.old_masters import OldMasters
from route_protocol.order_rules import RouteRefused
from route_protocol.values import (
    ANSWERED_WITHIN,
    EMERGENCY_STOP,
    TAKEN_OVER,
    EdgeState,
    EpochCause,
    Location,
    Motion,
    Phase,
    Reason,
    ReasonCode,
    RouteOrder,
    RouteRefusal,
    RouteReport,
    SymbolicPose,
)
from route_protocol.vehicle import Answer, Judgement, VehicleState
from trajectory_graph import Graph, change_of, speed_of

MOVED_FOR = 1.0  # s for which it reports that somebody moves it
MOST = 99.9  # highest percentage of an edge that is reported before it is complete
FOREVER = float('inf')
_GRAPH_CHANGED = Reason(
    ReasonCode.GRAPH_CHANGED,
    'the graph was replaced, and edges of the route are not what they were: give another route')


def draw_epoch() -> int:
    """Returns the number of a new epoch."""
    return secrets.randbits(63) + 1


class Vehicle:
    """One AGV on a graph.

    `handle` takes orders, `advance` simulates time, and `take_messages` returns the AGV's messages.
    Times are in s of the simulation; stamps are those of the caller.
    """

    def __init__(self, name: str, graph: Graph, vertex: int,
                 limits: Optional[DriveLimits] = None, obeys_edge_speed: bool = True,
                 chargers: Collection[int] = (), charge: float = 100.0,
                 draw: Callable[[], int] = draw_epoch) -> None:
        """`draw` returns the number of a new epoch."""
        self.name = name
        self.battery = SimulatedBattery(charge)
        self._draw = draw
        self.stamp = 0
        self.protocol = self._without_memory()
        self._old_masters = OldMasters()
        self.emergency = False
        self._obeys_edge_speed = obeys_edge_speed
        self._limits = limits or DriveLimits()
        self._chargers = frozenset(chargers)
        self._off_graph: Optional[Tuple[float, float, float]] = None
        self._time = 0.0
        self._stalled_until = self._slow_until = self._silent_until = 0.0
        self._waiting: Optional[Tuple[RouteOrder, float]] = None
        self._moved_until = -math.inf  # by somebody else
        self._reported: object = None
        self._completed = 0  # number of edges of the route before the path of the drive
        self._messages: List[Union[RouteReport, RouteRefusal]] = []
        self.drive = self._placed(graph, vertex)
        self._reported = self._news

    # --- the interface to the fleet manager -------------------------------------------------------

    @property
    def state(self) -> VehicleState:
        """Its end of the route protocol."""
        return self.protocol.state

    @property
    def running(self) -> bool:
        """Whether a route is being driven."""
        return self.state.is_running

    @property
    def silent(self) -> bool:
        """Whether it neither receives nor reports."""
        return self._time < self._silent_until

    @property
    def motion(self) -> Motion:
        """What it does, as it reports."""
        if self._time < self._moved_until:
            return Motion.MOVED
        if self.running:
            return Motion.ON_ROUTE
        return Motion.STANDING if self.drive.at_rest else Motion.COMING_TO_REST

    def handle(self, order: RouteOrder) -> None:
        """Takes an order."""
        if self.silent:
            return
        judged = self._judge(order)
        if judged.answer is Answer.STOP:
            self._waiting = None
            self.protocol.stop(order)
            self._old_masters.passed(order)
        elif judged.answer is Answer.REFUSED:
            self._refuse(order, judged.reason)
        elif judged.answer is Answer.ROUTE and not (
                self._waiting and order.is_repeat_of(self._waiting[0])):
            self._waiting = order, self._time + ANSWERED_WITHIN
            self._consider()
        self._report_change()

    def _judge(self, order: RouteOrder) -> Judgement:
        if order.order or order.is_stop:
            return self.protocol.judge(order)
        return self._old_masters.judge(order, self.state, self._time)

    def report(self) -> RouteReport:
        """The present report to the fleet manager."""
        return self.protocol.report(self.stamp, self._symbolic_pose(), Location(*self.pose),
                                    self.motion, unready=self._unready)

    @property
    def _unready(self) -> ReasonCode:
        if self.emergency:
            return ReasonCode.EMERGENCY_STOP
        return ReasonCode.NONE if self._off_graph is None else ReasonCode.OFF_GRAPH

    def take_messages(self) -> List[Union[RouteReport, RouteRefusal]]:
        """Returns the refusals, and the reports of changes, since the last call."""
        messages, self._messages = self._messages, []
        return [] if self.silent else messages

    @property
    def pose(self) -> Tuple[float, float, float]:
        """The true pose: x, y (m) and heading (rad)."""
        return self._off_graph or self.drive.pose

    def advance(self, seconds: float, stamp: int) -> None:
        """Simulates this time; `stamp` is the stamp of the pose after it."""
        self._time += seconds
        self.stamp = stamp
        if self.running and self.battery.charge <= 0.0:
            self._fail(Reason(ReasonCode.BATTERY_EMPTY, 'the battery is empty'))
        if self._time >= self._slow_until:
            self.drive.pace = 1.0
        hold = not self.running or self._time < self._stalled_until
        self.drive.advance(seconds, hold, self.emergency)
        self.battery.advance(seconds, not self.drive.at_rest, self.drive.vertex in self._chargers)
        self.protocol.complete(self._completed + self.drive.index)
        self._consider()
        self._report_change()

    # --- faults -----------------------------------------------------------------------------------

    def stall(self, seconds: float) -> None:
        """Brakes and stands still for this time; its route stays active."""
        self._stalled_until = self._time + seconds

    def slow_down(self, factor: float, seconds: float) -> None:
        """Drives with this factor on its speed for this time."""
        self.drive.pace, self._slow_until = factor, self._time + seconds

    def fall_silent(self, seconds: float = FOREVER) -> None:
        """Neither receives nor reports for this time, but drives on along its route."""
        self._silent_until = self._time + seconds

    def leave(self) -> None:
        """Is switched off: it stands still, and neither receives nor reports."""
        self._waiting = None
        self.protocol, self._old_masters = self._without_memory(), OldMasters()
        self._silent_until = FOREVER

    def join(self) -> None:
        """Is switched on, without any memory of a route."""
        self._silent_until = self._stalled_until = 0.0
        self._report_change()

    def fail(self, reason: Reason) -> None:
        """Lets the running route fail."""
        self._fail(reason)
        self._report_change()

    def take_over(self) -> None:
        """Another giver stops it: its route fails, and no order on its way is obeyed."""
        self._begin_epoch(EpochCause.OTHER_GIVER, TAKEN_OVER)

    def press_emergency_stop(self) -> None:
        """Brakes hard; the route fails, and orders are refused until the release."""
        self.emergency = True
        self._begin_epoch(EpochCause.EMERGENCY_STOP, EMERGENCY_STOP)
        self._consider()

    def release_emergency_stop(self) -> None:
        """Ends the emergency stop: orders are accepted again."""
        self.emergency = False
        self._report_change()

    def push_off_graph(self, metres: float) -> None:
        """A person pushes it to its left, off the graph: its route fails."""
        x, y, heading = self.pose
        self.drive.speed = 0.0
        self._off_graph = (x - metres * math.sin(heading), y + metres * math.cos(heading), heading)
        self._begin_epoch(EpochCause.OTHER_GIVER, Reason(ReasonCode.OFF_GRAPH, 'off the corridor'))
        self._moved_until = self._time + MOVED_FOR
        self._report_change()

    def put_on(self, vertex: int) -> None:
        """A person puts it onto a vertex; a running route fails. Raises UnknownVertex."""
        drive = self._placed(self.drive.graph, vertex)
        self.take_over()
        self.drive, self._off_graph = drive, None
        self._moved_until = self._time + MOVED_FOR
        self._report_change()

    def use_graph(self, graph: Graph) -> None:
        """Uses another graph from now on, at the present place.

        The route continues if nothing except speeds has changed on its remaining edges; else it
        fails.
        """
        before, drive = self.drive.graph, self.drive
        ahead = drive.path[drive.index:]
        if any(change_of(before, graph, edge) or speed_of(graph, edge) <= 0.0 for edge in ahead):
            self._fail(_GRAPH_CHANGED)
            drive.path = drive.path[:drive.index + 1]
        if self._off_graph is None and drive.edge is not None and (
                change_of(before, graph, drive.edge) is None):
            drive.graph, drive.speeds = graph, self._speeds(graph)
        else:
            self._fail(_GRAPH_CHANGED)
            self._place_again(graph)
        self._report_change()

    # --- internal ---------------------------------------------------------------------------------

    def _place_again(self, graph: Graph) -> None:
        """Places it on the vertex of another graph at its position, or off the graph."""
        x, y, heading = self.pose
        nearest = min(graph.vertices.values(), key=lambda one: math.dist(one.position, (x, y)))
        self.drive = self._placed(graph, nearest.id)
        self.drive.heading = heading
        stands_there = math.dist(nearest.position, (x, y)) < ON_PLACE
        self._off_graph = None if stands_there else (x, y, heading)

    def _placed(self, graph: Graph, vertex: int) -> Drive:
        return Drive(graph, self._limits, self._speeds(graph), vertex)

    def _speeds(self, graph: Graph) -> SpeedLimits:
        return SpeedLimits(graph, self._limits, self._obeys_edge_speed)

    def _without_memory(self) -> protocol.Vehicle:
        return protocol.Vehicle(self._draw, self._milliseconds)

    def _milliseconds(self) -> int:
        return self.stamp // 1_000_000

    def _begin_epoch(self, cause: EpochCause, reason: Reason) -> None:
        self.protocol.begin_epoch(cause, reason)
        self._old_masters.epoch_began(self._time)
        self._consider()
        self._report_change()

    def _consider(self) -> None:
        """Accepts or refuses the waiting order as soon as it can be judged or is too old."""
        if self._waiting is None:
            return
        order, give_up = self._waiting
        judged = self._judge(order)
        try:
            if judged.answer is Answer.REFUSED:
                raise RouteRefused(judged.reason)
            if judged.answer is Answer.ROUTE:
                self._take_up(order, judged)
        except NotYet:
            if self._time < give_up:
                return
            self._refuse(order, Reason(
                ReasonCode.NOT_READY, 'the vehicle did not come to a stop'))
        except RouteRefused as refusal:
            self._refuse(order, refusal.reason)
        self._waiting = None

    def _take_up(self, order: RouteOrder, judged: Judgement) -> None:
        if self.emergency:
            raise RouteRefused(EMERGENCY_STOP)
        check_order(order, self.drive)
        if self._off_graph is not None:
            raise RouteRefused(Reason(ReasonCode.OFF_GRAPH, 'the vehicle is off the graph'))
        state, rest, skipped = self.state, judged.rest, judged.done - order.first
        if not order.order and OldMasters.changes_route(order, state):
            if state.edges and not self.drive.path:
                raise RouteRefused(_GRAPH_CHANGED)
            check_change(order, state)
            skipped = state.completed
            rest = order.edges[skipped:]
        if not order.order and not OldMasters.changes_route(order, state):
            skipped = 0
        if state.is_running and judged.goes_on:
            arc = self.drive.arc
            check_braking(rest, self.drive, 0, arc)
            index = 0
        elif rest:
            index, arc = find_start(rest, state, self.drive)
        else:
            index, arc = 0, 0.0
        numbered = order if order.order else self._old_masters.numbered(order, state)
        if rest:
            self.drive.follow(rest, index, arc)
        self._completed = skipped
        self.protocol.take(numbered, numbered.first + skipped + index)
        self._old_masters.passed(order)

    def _refuse(self, order: RouteOrder, reason: Reason) -> None:
        """Sends a refusal. A master without numbers gets a report with the order's id, too."""
        if not order.order:
            self._old_masters.refused(order, reason)
        self._messages.append(self.protocol.refuse(order, reason))
        if not order.order and self.state.route_id != order.route_id:
            report = self.report()
            self._messages.append(replace(
                report, route_id=order.route_id, edges=order.edges, reason=reason,
                states=(EdgeState.FAILED,) * len(order.edges)))

    def _fail(self, reason: Reason) -> None:
        self.protocol.fail(reason)

    def _report_change(self) -> None:
        """Appends a report if the route, its states or its reason have changed."""
        if self._news != self._reported:
            self._reported = self._news
            self._messages.append(self.report())

    @property
    def _news(self) -> object:
        """The part of the report that is sent at once when it changes."""
        return replace(self.state, report=0), self.motion, self._unready

    def _symbolic_pose(self) -> SymbolicPose:
        """The edge and percentage: with a route the ordered direction, else the edge forwards."""
        if self._off_graph is not None:
            return SymbolicPose()
        drive, graph = self.drive, self.drive.graph
        if drive.edge is None:
            assert drive.vertex is not None
            leaving = next(iter(graph.edges_from(drive.vertex)), 0)
            return SymbolicPose(abs(leaving), 100.0 if leaving < 0 else 0.0)
        done = 100.0 if drive.at_end else 100.0 * drive.arc / graph.curve(drive.edge).length
        if self.state.edges and self.state.phase in (Phase.RUNNING, Phase.COMPLETE):
            return SymbolicPose(drive.edge, done if drive.at_end else min(done, MOST))
        return SymbolicPose(abs(drive.edge), done if drive.edge > 0 else 100.0 - done)
