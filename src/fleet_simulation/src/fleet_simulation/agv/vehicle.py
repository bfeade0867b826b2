"""One simulated AGV: it takes orders, drives and reports, and can have faults.

States: the AGV's `motion`. In addition the AGV may be off the graph, in emergency stop, or silent.
`route_protocol.vehicle` has the states of its route.
Events: an order, time, a fault, an act of a person or of another program, another graph.
Invariants: At most one giver drives the AGV. If another giver moves or stops the AGV, a new epoch
begins; orders that are then on their way are refused. The AGV reports at once if more than its
place has changed.
"""
from __future__ import annotations

import math
from dataclasses import replace
from typing import Callable, Collection, List, Optional, Tuple, Union

from fleet_simulation.agv.battery import SimulatedBattery
from fleet_simulation.agv.drive import ON_PLACE, AgvMotion
from fleet_simulation.agv.route_rules import (
    check_change,
    check_order,
    find_start,
    has_just_left,
)
from fleet_simulation.agv.speed_limits import DriveLimits, SpeedLimits
from fleet_simulation.agv.steps import SimulatedSteps
from route_protocol import vehicle as protocol
from route_protocol.intake import DueOrder, Intake, NotYet, messages_of
from route_protocol.order_rules import RouteRefused
from route_protocol.values import (
    EMERGENCY_STOP,
    NO_REASON,
    TAKEN_OVER,
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
from route_protocol.vehicle import Answer, VehicleState
from trajectory_graph import Graph, change_of, speed_of

MOST = 99.9  # highest percentage of an edge that is reported before the edge is complete
FOREVER = float('inf')
MOVED_FOR = 1.0  # s; for this time after a push, the AGV reports that a person moves it
_GRAPH_CHANGED = Reason(
    ReasonCode.GRAPH_CHANGED,
    'the graph was replaced, and edges of the route are not what they were: give another route')
_ROLLS = Reason(ReasonCode.NOT_READY, 'the vehicle did not come to a stop')


class AgvVehicle:
    """One AGV on a graph.

    `handle` takes orders, `advance` simulates time, and `new_messages` returns the AGV's messages.
    Times are in s of the simulation; the caller gives the stamps. `route_protocol.vehicle` decides
    which orders count; this class decides whether the AGV can drive an order from its place. One
    class handles orders, time, faults and people, because all of them change the same route, place
    and epoch.

    draw  -- returns the number of a new epoch, different from all earlier ones
    clock -- returns ms since 1970; the numbers of reports are not lower than this
    """

    def __init__(self, name: str, graph: Graph, vertex: int, draw: Callable[[], int],
                 clock: Callable[[], int], limits: Optional[DriveLimits] = None,
                 obeys_edge_speed: bool = True, chargers: Collection[int] = (),
                 charge: float = 100.0) -> None:
        self.name = name
        self.battery = SimulatedBattery(charge)
        self.steps = SimulatedSteps(clock)
        self.stamp = 0
        self.emergency = False
        self._draw, self._clock = draw, clock
        self._obeys_edge_speed = obeys_edge_speed
        self._limits = limits or DriveLimits()
        self._speed_limit = 0.0
        """Speed limit (m/s) that the last route has because of the load; 0: no limit."""
        self._chargers = frozenset(chargers)
        self._off_graph: Optional[Tuple[float, float, float]] = None
        self._time = 0.0
        self._stalled_until = self._slow_until = self._silent_until = self._moved_until = 0.0
        self._messages: List[Union[RouteReport, RouteRefusal]] = []
        self.drive = self._placed(graph, vertex)
        self._forget()
        self._reported = self.news

    def _forget(self) -> None:
        """Forgets all orders."""
        self._protocol = protocol.Vehicle(self._draw, self._clock)
        self._intake = Intake(self._protocol, self._begin_route, self._report_refusal)
        self._giver: Optional[str] = None  # the master whose route it drives
        self._driven_by_hand = False
        self._path_begins = 0  # record number of the first edge of the drive's path

    # --- the interface to the fleet manager -------------------------------------------------------

    @property
    def state(self) -> VehicleState:
        """The route, its progress, and which orders were taken and refused."""
        return self._protocol.state

    @property
    def running(self) -> bool:
        """Whether a route is being driven."""
        return self.state.is_running

    @property
    def silent(self) -> bool:
        """Whether the AGV neither receives nor reports."""
        return self._time < self._silent_until

    @property
    def motion(self) -> Motion:
        """Whether the AGV moves, and because of which giver."""
        if self.running:
            return Motion.ON_ROUTE
        if self._driven_by_hand or self._time < self._moved_until:
            return Motion.MOVED
        if self.drive.at_rest:
            return Motion.STANDING
        if self.state.master is None:
            return Motion.UNKNOWN
        return Motion.COMING_TO_REST if self._giver == self.state.master else Motion.MOVED

    @property
    def _unready(self) -> ReasonCode:
        """The reason why the AGV refuses every route now; NONE: it does not refuse every route."""
        if self.emergency:
            return ReasonCode.EMERGENCY_STOP
        if self._off_graph is not None:
            return ReasonCode.OFF_GRAPH
        return ReasonCode.TAKEN_OVER if self._driven_by_hand else ReasonCode.NONE

    @property
    def news(self) -> Tuple[VehicleState, Motion, ReasonCode]:
        """The values whose changes are reported at once."""
        return self.state, self.motion, self._unready

    def handle(self, order: RouteOrder) -> None:
        """Handles an order that has arrived."""
        if self.silent:
            return
        if self._intake.arrived(order, self._time).answer is Answer.STOP:
            self._driven_by_hand = False
        self._intake.answer(self._time)
        self._report_change()

    def report(self) -> RouteReport:
        """Returns the next report to the fleet manager."""
        return self._protocol.report(self.stamp, self._symbolic_pose(), VehicleLocation(*self.pose),
                                     self.motion, unready=self._unready)

    def new_messages(self) -> List[Union[RouteReport, RouteRefusal]]:
        """Returns the refusals, and the reports of changes, since the last call."""
        messages, self._messages = self._messages, []
        return [] if self.silent else messages

    @property
    def pose(self) -> Tuple[float, float, float]:
        """The true pose: x, y (m) and heading (rad)."""
        return self._off_graph or self.drive.pose

    @property
    def left(self) -> float:
        """The distance (m) to the end of its route."""
        return self.distance_to(self._path_begins + len(self.drive.path), 0.0)

    def distance_to(self, number: int, fraction: float) -> float:
        """Returns the distance (m) to the point at `fraction` of an edge of its route.

        Negative: the AGV has passed this point. `number` is the edge's number in the route record.
        """
        drive, at = self.drive, number - self._path_begins
        arcs = [drive.graph.curve(edge).length for edge in drive.path]
        own = fraction * arcs[at] if 0 <= at < len(arcs) else 0.0
        return sum(arcs[:max(at, 0)]) + own - sum(arcs[:drive.index]) - drive.arc

    def advance(self, seconds: float, stamp: int) -> None:
        """Simulates the next `seconds`; the pose at their end gets the stamp `stamp`."""
        self.stamp = stamp
        end = self._time + seconds
        for pause in sorted((self._stalled_until, self._slow_until)):
            if self._time < pause < end:
                self._pass(pause - self._time)
        self._pass(end - self._time)
        self._report_change()

    def _pass(self, seconds: float) -> None:
        """Simulates a period in which stalls and slow drives neither begin nor end."""
        if self.battery.charge <= 0.0:
            self._lose_route(Reason(ReasonCode.BATTERY_EMPTY, 'the battery is empty'))
        if self._time >= self._slow_until:
            self.drive.pace = 1.0
        hold = self._holds
        self._time += seconds
        moving = self.drive.advance(seconds, hold, self.emergency)
        self.steps.advance(seconds)
        self.battery.advance(moving, True, False)
        self.battery.advance(seconds - moving, False, self.drive.vertex in self._chargers)
        if self.running:
            self._protocol.complete(self._path_begins + self.drive.index - self.state.first)
        self._driven_by_hand = self._driven_by_hand and not self.drive.at_end
        self._intake.answer(self._time)

    @property
    def _holds(self) -> bool:
        """Whether the AGV must stand, or brake until it stands."""
        return not (self.running or self._driven_by_hand) or self._time < self._stalled_until

    @property
    def next_event(self) -> float:
        """The seconds for which only the place can change in the AGV's report.

        An order or a fault can change the report earlier. 0: this time is unknown.
        """
        if self._intake.waiting is not None or self._time < self._moved_until:
            return 0.0
        pauses = [pause - self._time for pause in (self._stalled_until, self._slow_until)
                  if pause > self._time]
        return min(self.drive.next_event(self._holds, self.emergency), *pauses, FOREVER)

    # --- faults -----------------------------------------------------------------------------------

    def stall(self, seconds: float) -> None:
        """Brakes and stands still for `seconds`; its route stays active."""
        self._stalled_until = self._time + seconds

    def slow_down(self, factor: float, seconds: float) -> None:
        """Drives with `factor` times its speed for `seconds`."""
        self.drive.pace, self._slow_until = factor, self._time + seconds

    def fall_silent(self, seconds: float = FOREVER) -> None:
        """Receives nothing and reports nothing for `seconds`, but drives on along its route."""
        self._silent_until = self._time + seconds

    def leave(self) -> None:
        """Switches the vehicle off: it stands still, and neither receives nor reports."""
        self._forget()
        self._silent_until = FOREVER

    def join(self) -> None:
        """Switches the vehicle on; after `leave` it has no memory of a route."""
        self._silent_until = self._stalled_until = 0.0
        self.steps.restart()
        self._report_change()

    def fail(self, reason: Reason) -> None:
        """Lets the running route fail."""
        self._lose_route(reason)
        self._report_change()

    def press_emergency_stop(self) -> None:
        """Brakes hard; the route fails, and routes are refused until the release."""
        self.emergency = True
        self._begin_epoch(EpochCause.EMERGENCY_STOP, EMERGENCY_STOP)
        self._intake.answer(self._time)
        self._report_change()

    def release_emergency_stop(self) -> None:
        """Ends the emergency stop: routes are accepted again."""
        self.emergency = False
        self._report_change()

    def take_over(self) -> None:
        """Lets another program take over the AGV and leave it standing: a running route fails."""
        self._begin_epoch(EpochCause.OTHER_GIVER, TAKEN_OVER)
        self._report_change()

    def drive_by_hand(self, edge: int) -> None:
        """Lets another program drive the AGV to the end of this edge (signed id); a running route
        fails.

        Raises RouteRefused if the AGV cannot drive this edge from its place.
        """
        order = RouteOrder(0, (edge,))
        self._check(order)
        arc = find_start(order.edges, self.state, self.drive)
        self._begin_epoch(EpochCause.OTHER_GIVER, TAKEN_OVER)
        self.drive.follow(order.edges, 0, arc)
        self._giver, self._driven_by_hand = None, True
        self._report_change()

    def push_off_graph(self, metres: float) -> None:
        """Lets a person push the AGV to its left, off the graph: its route fails."""
        x, y, heading = self.pose
        self.drive.stop_dead()
        self._off_graph = (x - metres * math.sin(heading), y + metres * math.cos(heading), heading)
        self._moved_by_person(Reason(ReasonCode.OFF_GRAPH, 'off the corridor'))

    def put_on(self, vertex: int) -> None:
        """Lets a person put the AGV onto a vertex; a running route fails. Raises UnknownVertex."""
        self.drive, self._off_graph = self._placed(self.drive.graph, vertex), None
        self._moved_by_person(TAKEN_OVER)

    def use_graph(self, graph: Graph) -> None:
        """Uses another graph from now on, at the present place.

        The route continues if its remaining edges are unchanged, except for their speeds. Otherwise
        it fails.
        """
        before, drive = self.drive.graph, self.drive
        ahead = drive.path[drive.index:]
        if any(change_of(before, graph, edge) or speed_of(graph, edge) <= 0.0 for edge in ahead):
            self._lose_route(_GRAPH_CHANGED)
            drive.path = drive.path[:drive.index + 1]
        if self._off_graph is None and drive.edge is not None and (
                change_of(before, graph, drive.edge) is None):
            drive.graph, drive.speeds = graph, self._speeds(graph)
        else:
            self._lose_route(_GRAPH_CHANGED)
            self._place_again(graph)
        self._report_change()

    # --- internal ---------------------------------------------------------------------------------

    def _place_again(self, graph: Graph) -> None:
        """Places the AGV on another graph: on the vertex at its position, or off the graph."""
        x, y, heading = self.pose
        nearest = min(graph.vertices.values(), key=lambda one: math.dist(one.position, (x, y)))
        self.drive = self._placed(graph, nearest.id)
        self.drive.heading = heading
        stands_there = math.dist(nearest.position, (x, y)) < ON_PLACE
        self._off_graph = None if stands_there else (x, y, heading)

    def _placed(self, graph: Graph, vertex: int) -> AgvMotion:
        return AgvMotion(graph, self._limits, self._speeds(graph), vertex)

    def _speeds(self, graph: Graph) -> SpeedLimits:
        limits = self._limits
        if 0.0 < self._speed_limit < limits.speed:
            limits = replace(limits, speed=self._speed_limit)
        return SpeedLimits(graph, limits, self._obeys_edge_speed)

    def _check(self, order: RouteOrder) -> None:
        """Raises RouteRefused for an order that the vehicle must refuse now, wherever it is."""
        if self.emergency:
            raise RouteRefused(EMERGENCY_STOP)
        check_order(order, self.drive)
        if self._off_graph is not None:
            raise RouteRefused(Reason(ReasonCode.OFF_GRAPH, 'the vehicle is off the graph'))
        if self._driven_by_hand:
            raise RouteRefused(TAKEN_OVER)

    def _begin_route(self, due: DueOrder) -> None:
        """Takes a route. Raises RouteRefused, or NotYet while the vehicle comes to rest."""
        self._check(due.given)
        if not due.given.order:
            due = self._from_here(due)
        if not (self.running or self.drive.at_rest):
            raise NotYet(_ROLLS)
        if due.given.speed != self._speed_limit and due.given.edges:
            self._speed_limit = due.given.speed
            self.drive.speeds = self._speeds(self.drive.graph)
        if due.rest:
            self.drive.follow(due.rest, 0, find_start(due.rest, self.state, self.drive))
            self._path_begins = due.done
        self._intake.take_order(due, self._time)
        self._giver = due.order.master

    def _from_here(self, due: DueOrder) -> DueOrder:
        """Returns an order without a number; removes its first edge if the vehicle has just left
        this edge.
        """
        if due.goes_on:
            if self.state.edges and not self.drive.path:
                raise RouteRefused(_GRAPH_CHANGED)
            check_change(self.state, due.given, self.drive.graph)
        elif has_just_left(due.given.edges, self.state):
            return replace(due, done=due.done + 1, rest=due.rest[1:])
        return due

    def _report_refusal(self, refusal: RouteRefusal) -> None:
        self._messages += messages_of(refusal, self.state, self.report)

    def _lose_route(self, reason: Reason) -> None:
        """Lets a running route fail, and ends a drive by hand."""
        self._protocol.fail(reason)
        self._driven_by_hand = False

    def _begin_epoch(self, cause: EpochCause, reason: Reason = NO_REASON) -> None:
        """Begins a new epoch: a running route fails, and orders that are on their way to the AGV
        are refused.
        """
        self._lose_route(reason)
        self._intake.begin_epoch(cause, NO_REASON, self._time)

    def _moved_by_person(self, reason: Reason) -> None:
        self._moved_until = self._time + MOVED_FOR
        self._begin_epoch(EpochCause.OTHER_GIVER, reason)
        self._report_change()

    def _report_change(self) -> None:
        """Appends a report if more than the place has changed."""
        if self.news != self._reported:
            self._reported = self.news
            self._messages.append(self.report())

    def _symbolic_pose(self) -> SymbolicPose:
        """Returns the edge, and the place on it as a percentage. On a route the edge has the
        ordered direction; otherwise it is forward.
        """
        if self._off_graph is not None:
            return SymbolicPose()
        drive, graph = self.drive, self.drive.graph
        if drive.edge is None:
            assert drive.vertex is not None
            leaving = next(iter(graph.edges_from(drive.vertex)), 0)
            return SymbolicPose(abs(leaving), 100.0 if leaving < 0 else 0.0)
        done = 100.0 if drive.at_end else 100.0 * drive.arc / graph.curve(drive.edge).length
        if self.state.phase in (Phase.RUNNING, Phase.COMPLETE):
            return SymbolicPose(drive.edge, done if drive.at_end else min(done, MOST))
        return SymbolicPose(abs(drive.edge), done if drive.edge > 0 else 100.0 - done)
