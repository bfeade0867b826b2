"""The core of the bridge: turns orders and robot events into commands and reports.

It uses neither ROS nor sockets nor a clock: every event comes with its time (s, monotonic), and
every answer is a list of actions. Lengths are in m, in the map frame. Events update the known state
(`robot_monitor`). The running route is then judged and driven on (`route_run`). `order_intake`
sorts orders; here they become routes, and the fleet manager gets reports.
"""
from __future__ import annotations

import secrets
import time
from dataclasses import replace
from functools import partial
from typing import Callable, Iterable, List, Optional, Tuple

from omron_ld90.bridge import events as p
from omron_ld90.bridge.goal_tracker import RouteFailed, TakenOver
from omron_ld90.bridge.graph_location import GraphLocation
from omron_ld90.bridge.motion_judge import MotionJudge
from omron_ld90.bridge.order_intake import OrderIntake
from omron_ld90.bridge.robot_monitor import RobotMonitor
from omron_ld90.bridge.route_orders import (
    check_braking,
    check_change,
    check_start,
    first_change,
    is_change,
)
from omron_ld90.bridge.route_progress import RouteProgress
from omron_ld90.bridge.route_restart import go_on
from omron_ld90.bridge.route_run import RouteRun
from omron_ld90.bridge.route_strategies import Settings
from route_protocol.old_masters import OldMasters
from route_protocol.order_rules import RouteRefused, wrong_route
from route_protocol.values import (
    NO_REASON,
    EdgeState,
    EpochCause,
    Location,
    Motion,
    Phase,
    Reason,
    ReasonCode,
    RouteOrder,
    RouteReport,
    SymbolicPose,
)
from route_protocol.vehicle import Answer, Vehicle, VehicleState
from trajectory_graph import Graph, TrajectoryGraphError, check_route

_CAUSES = {
    ReasonCode.TAKEN_OVER: EpochCause.OTHER_GIVER, ReasonCode.LOST_LINK: EpochCause.LOST_LINK,
    ReasonCode.EMERGENCY_STOP: EpochCause.EMERGENCY_STOP}
_SILENT = Reason(ReasonCode.NO_LOCATION, 'the robot has sent no status')


def draw_epoch() -> int:
    """Returns the number of a new epoch."""
    return secrets.randbits(63) + 1


def milliseconds() -> int:
    """Returns ms since 1970."""
    return int(1000.0 * time.time())


def _check_edges(graph: Graph, edges: Tuple[int, ...]) -> None:
    try:
        check_route(graph, edges)
    except TrajectoryGraphError as error:
        raise wrong_route(error) from None


class RouteFollower:
    """Drives one robot along the routes of a fleet manager."""

    def __init__(self, settings: Settings, graph: Optional[Graph] = None,
                 links: Iterable[p.Link] = (), draw: Callable[[], int] = draw_epoch,
                 clock: Callable[[], int] = milliseconds) -> None:
        """`links`: the links that must be up before an order is accepted.

        draw  -- returns the number of a new epoch
        clock -- returns ms since 1970
        """
        self._draw, self._clock = draw, clock
        self.vehicle = Vehicle(draw, clock)
        """Which orders were taken and refused."""
        self._base = 0  # number of the route's first edge in the route record
        self._judge = MotionJudge()
        self._now = 0.0
        self.settings = settings
        self.graph = graph
        self._next_graph: Optional[Graph] = None  # it waits until the running route has ended
        self.robot = RobotMonitor(settings, links)
        self.route: Optional[RouteRun] = None
        """The running route, or the last one."""
        self._restored: Optional[Tuple[p.RouteRecord, float]] = None  # to continue; time to give up
        self._orders = OrderIntake(self.robot, settings.location_timeout, self._tell_refusal,
                                   self._note, lambda epoch: epoch == self.vehicle.state.epoch)
        self._last_reported: Tuple[object, ...] = ()
        self._out: List[p.Action] = []

    # --- interface --------------------------------------------------------------------------------

    def handle(self, event: p.Event, now: float) -> List[p.Action]:
        """Takes an event; the answer lists commands before reports and notes about them."""
        if isinstance(event, RouteOrder):
            return self._answer(partial(self._on_order, event, now), now)
        return self._answer(partial(self._on_event, event, now), now)

    def tick(self, now: float) -> List[p.Action]:
        """Passes the time; to be called about ten times a second."""
        return self._answer(partial(self._go_on, now), now)

    def use_graph(self, graph: Graph, now: float) -> List[p.Action]:
        """Replaces the graph; if it changes edges of the running route, waits for the end of it."""
        return self._answer(partial(self._use_graph, graph, now), now)

    def restore(self, record: p.RouteRecord, is_recent: bool, now: float) -> None:
        """Takes the record of the last route from before a restart.

        The bridge continues a route that was running, unless it did not run for too long.
        """
        order = RouteOrder(record.route_id, record.edges, record.stamp,
                           order=record.protocol.order if (
                               record.protocol and record.protocol.master) else 0)
        self.vehicle = Vehicle(self._draw, self._clock, self._remembered(record, is_recent))
        self._base = record.base
        self.route = RouteRun(order, self.settings, self.robot.tracker, self.robot.location, None,
                              now, record.phase, record.completed)
        self.route.reason = record.reason
        self.robot.tracker.goals.remember(record.goal)
        self.robot.resume(record.epoch)
        self._orders.past = record.past
        owes_stop = record.owes_stop
        if record.phase is Phase.RUNNING and not is_recent:
            self.route.phase = Phase.FAILED
            self.route.reason = Reason(ReasonCode.RESTARTED, 'the bridge was away for too long')
            self.vehicle.fail(self.route.reason)
            owes_stop = True
        if self.route.phase is not Phase.COMPLETE:
            self._judge.route_lost()
        if owes_stop:
            self.robot.stop_duty.require(record.epoch)
        if self.route.phase in (Phase.RUNNING, Phase.COMPLETE):
            self._restored = (record, now + self.settings.restart_timeout)

    def _remembered(self, record: p.RouteRecord, is_recent: bool) -> VehicleState:
        """The protocol's state before a restart. Numbers of long ago do not count any more."""
        if is_recent and record.protocol is not None:
            return record.protocol
        shown = record.protocol or VehicleState(
            0, done=record.base + record.completed, route_id=record.route_id, first=record.base,
            edges=record.edges, phase=record.phase, reason=record.reason)
        return replace(shown, epoch=self._draw(), cause=EpochCause.RESTART, master=None, order=0,
                       refused=0, refusal=NO_REASON)

    @property
    def running(self) -> bool:
        """Whether a route is being driven."""
        return self.route is not None and self.route.running

    @property
    def record(self) -> Optional[p.RouteRecord]:
        """The record for `restore` after a restart; None before the first route."""
        if self._restored:  # nothing newer is known yet
            record = self._restored[0]
        elif self.route:
            record = self.route.record()
        else:
            return None
        return replace(record, owes_stop=self.robot.stop_duty.to_give, epoch=self.robot.epoch,
                       past=self._orders.past, base=self._base,
                       protocol=replace(self.vehicle.state, report=0))

    def report(self) -> RouteReport:
        """The next report for the fleet manager."""
        self._count_progress()
        return self.vehicle.report(self._stamp, self._pose(), self._location, self.motion,
                                   self._owed, self._unready)

    @property
    def _unready(self) -> ReasonCode:
        """Why the robot would refuse each route now."""
        if self.robot.emergency:
            return ReasonCode.EMERGENCY_STOP
        return self._why_unknown(self._now).code

    @property
    def motion(self) -> Motion:
        """What the robot does."""
        seen = self.robot.seen
        is_linked = self.robot.links.stands(p.Link.OUTGOING, self._now)
        return self._judge.motion(self.running, is_linked, seen.motion if seen else None,
                                  self._now)

    def _count_progress(self) -> None:
        """Tells the protocol which edges the route has driven."""
        route = self.route
        if route is not None and self.vehicle.state.is_running:
            self.vehicle.complete(self._base + route.completed - self.vehicle.state.first)

    def _answer(self, handle: Callable[[], None], now: float) -> List[p.Action]:
        """Runs a handler; returns commands, notes, and a report if more than the percentage of the
        pose has changed."""
        self._now = now
        try:
            handle()
            if self._next_graph is not None and not self.running:
                self._use_graph(self._next_graph, now)
        except RouteFailed as failure:
            self._fail(failure, now)
        actions: List[p.Action] = [*self.robot.due_commands(now), *self._out]
        self._out = []
        self._count_progress()
        reported = (replace(self.vehicle.state, report=0), self._owed, self.motion, self._unready)
        if reported != self._last_reported:
            self._last_reported = reported
            if self.route is not None or self.vehicle.state.refused:
                actions.append(self.report())
        return actions

    @property
    def _owed(self) -> Reason:
        """The reason why a stop has not been obeyed yet."""
        duty = self.robot.stop_duty
        if duty.owed and duty.problem:
            return Reason(ReasonCode.STOP_OWED,
                          f'the robot has not obeyed the stop yet: {duty.problem}')
        return NO_REASON

    @property
    def _stamp(self) -> int:
        last = self.robot.location.last
        return last.stamp if last else 0

    @property
    def _location(self) -> Optional[Location]:
        last = self.robot.location.last
        return Location(last.x, last.y, last.heading) if last else None

    @property
    def _here(self) -> GraphLocation:
        """The robot's location on the graph; requires that both are known."""
        last = self.robot.location.last
        assert self.graph is not None and last is not None
        return GraphLocation(self.graph, last.position, self.robot.docking,
                             self.settings.dock_vertex, self.settings.vertex_tolerance,
                             self.settings.corridor_width)

    def _pose(self) -> SymbolicPose:
        if self.graph is None or self.robot.location.last is None:
            return SymbolicPose()
        if self.route and self.route.decides_pose(self._here):
            return self.route.progress.pose
        return self._here.symbolic_pose()

    def _note(self, text: str) -> None:
        if text:
            self._out.append(p.Note(text))

    # --- orders -----------------------------------------------------------------------------------

    def _on_order(self, order: RouteOrder, now: float) -> None:
        self._count_progress()
        if not (order.order or order.is_stop):
            if self._orders.take(order, self.route, now):
                self._go_on(now)
            return
        judged = self.vehicle.judge(order)
        if judged.answer is Answer.STOP:
            self._stop(order, now)
        elif judged.answer is Answer.REFUSED:
            self._orders.refuse(order, judged.reason)
        elif judged.answer is Answer.ROUTE:
            self._orders.wait(order, now)
            self._go_on(now)

    def _stop(self, order: RouteOrder, now: float) -> None:
        """Obeys an empty order at once, even one without a number."""
        self._orders.drop()
        self._restored = None
        if self.route is not None and self.route.running:
            self._judge.route_lost()
        self.robot.stop(0)
        self.vehicle.stop(order)
        self.route = self._run(order, None, now, Phase.STOPPED)
        self._base = self.vehicle.state.done

    def _consider_order(self, now: float) -> None:
        """Accepts or refuses the waiting order, once it can be judged."""
        order = self._orders.due(self._why_unknown, now)
        if order is None:
            return
        try:
            self._take_up(order, now)
        except RouteRefused as refusal:
            self._orders.refuse(order, refusal.reason)

    def _why_unknown(self, now: float) -> Reason:
        if self.graph is None:
            return Reason(ReasonCode.NOT_READY, 'there is no graph')
        return self.robot.why_unknown(now)

    def _take_up(self, order: RouteOrder, now: float) -> None:
        """Changes the route or begins a new one; raises RouteRefused."""
        here, route = self._here, self.route
        if order.order:
            self._take_numbered(order, here, now)
        else:
            _check_edges(here.graph, order.edges)
            numbered = OldMasters().numbered(order, self.vehicle.state)
            if route and is_change(route, order):
                check_change(route, order, here)
                self.vehicle.take(numbered, self.vehicle.state.done)
                self._change(route, order, now)
            else:
                check_start(order, route, here)
                self.vehicle.take(numbered, numbered.first)
                self._begin(order, numbered.first, now)
        self._orders.accepted(order)

    def _take_numbered(self, order: RouteOrder, here: GraphLocation, now: float) -> None:
        self._count_progress()
        judged, route = self.vehicle.judge(order), self.route
        if judged.answer is Answer.REFUSED:
            raise RouteRefused(judged.reason)
        if judged.answer is not Answer.ROUTE:
            return
        rest = judged.rest
        _check_edges(here.graph, rest)
        if judged.goes_on and route is not None and route.is_on_graph:
            edges = route.edges[:judged.done - self._base] + rest
            if not route.decides_pose(here):
                raise RouteRefused(Reason(
                    ReasonCode.STARTS_ELSEWHERE,
                    f'the route ended at vertex {route.progress.end(-1).id}, but the robot is no '
                    'longer there'))
            if route.running:
                check_braking(route, edges, self.robot.location.speed, self.settings.braking)
            self.vehicle.take(order, judged.done)
            self._change(route, replace(order, edges=edges), now)
        else:
            check_start(replace(order, edges=rest), route, here)
            self.vehicle.take(order, judged.done)
            self._begin(replace(order, edges=rest), judged.done, now)

    def _change(self, route: RouteRun, order: RouteOrder, now: float) -> None:
        """Makes the route longer or shorter."""
        if not route.running:
            self.robot.go_on()
        self._judge.route_begins()
        route.replace(order, now)

    def _begin(self, order: RouteOrder, base: int, now: float) -> None:
        """Begins to drive a new route, whose first edge has the number `base` in the record."""
        driven = self._driven
        under_way = driven.edges_under_way if driven else ()
        self._restored = None
        self._base = base
        self._judge.route_begins()
        self.route = self._run(order, self._progress(order.edges, 0), now)
        self.route.allow(under_way)
        self.robot.begin()
        self.route.drive()

    def _progress(self, edges: Tuple[int, ...], current: int) -> RouteProgress:
        dock = () if self.settings.dock_vertex is None else (self.settings.dock_vertex,)
        here = self._here
        return RouteProgress(here.graph, edges, self.settings.vertex_tolerance, dock,
                             here.position, current)

    def _run(self, order: RouteOrder, progress: Optional[RouteProgress], now: float,
             phase: Phase = Phase.RUNNING) -> RouteRun:
        return RouteRun(order, self.settings, self.robot.tracker, self.robot.location, progress,
                        now, phase)

    def _tell_refusal(self, order: RouteOrder, reason: Reason) -> None:
        """Sends a refusal. A master without numbers gets a report with the order's id, too."""
        self._out.append(self.vehicle.refuse(order, reason))
        if not order.order and (
                self.route is None or self.route.order.route_id != order.route_id):
            self._out.append(replace(
                self.report(), route_id=order.route_id, edges=order.edges, reason=reason,
                states=(EdgeState.FAILED,) * len(order.edges)))

    # --- progress of the route --------------------------------------------------------------------

    @property
    def _driven(self) -> Optional[RouteRun]:
        """The route if it is running and its edges belong to a graph, else None."""
        route = self.route
        return route if route and route.running and route.is_on_graph else None

    def _on_event(self, event: p.Event, now: float) -> None:
        known, was_emergency = self.robot.epoch, self.robot.emergency
        moved, driven = self.robot.update(event, now), self._driven
        if known and not self.robot.knows(known):
            self._orders.overrule(now)
            self._judge.is_foreign = True
            if not self.running and isinstance(event, p.MotionTold):
                self.vehicle.begin_epoch(event.cause)
        if self.robot.emergency and not was_emergency and not self.running:
            self.vehicle.begin_epoch(EpochCause.EMERGENCY_STOP)
        if moved and self.robot.location.last is not None:
            self._judge.located(self.robot.location.last.position, now)
        if moved and driven:
            self._note(driven.locate(self._here, now))
        self._go_on(now)

    def _go_on(self, now: float) -> None:
        """Judges the known state, and drives on."""
        self._consider_restored(now)
        self._consider_order(now)
        driven = self._driven
        if driven:
            self.robot.check(now)
            self._note(driven.go_on(now, self.robot.docking_changed))
            if not driven.running:
                self._judge.arrived()

    def _consider_restored(self, now: float) -> None:
        """Continues the route from before a restart, once the robot's state is known."""
        route, seen = self.route, self.robot.seen
        if self._restored is None or route is None:
            return
        record, give_up = self._restored
        unknown = self._why_unknown(now) or (NO_REASON if seen else _SILENT)
        if unknown and now <= give_up:
            return
        self._restored = None
        if seen and not unknown:
            self._note(go_on(route, record, self._here, self._progress, seen, now))
        elif route.running:
            raise RouteFailed(unknown)

    def _use_graph(self, graph: Graph, now: float) -> None:
        self._next_graph = None
        if graph.is_same(self.graph):
            return
        route = self.route
        changed = route and route.is_on_graph and first_change(
            graph, route.progress.graph, route.edges)
        if route and route.running and changed:
            self._next_graph = graph
            self._note(f'A /graph is refused until route {route.order.route_id} has ended: '
                       f'{changed}')
            return
        self.graph = graph
        if route and route.is_on_graph and not changed:
            route.use_graph(graph)
        self._go_on(now)

    def _fail(self, failure: RouteFailed, now: float) -> None:
        """Ends the route, and stops the robot unless it already obeys another giver."""
        route = self.route
        assert route is not None  # only a running route fails
        if isinstance(failure, TakenOver):
            self.robot.leave()
            self._orders.overrule(now)
        else:
            self.robot.stop(self.robot.epoch)
        self._count_progress()
        cause = _CAUSES.get(failure.reason.code)
        if cause is not None:
            self.vehicle.begin_epoch(cause, failure.reason)
        self.vehicle.fail(failure.reason)
        self._judge.route_lost()
        self._judge.is_foreign = isinstance(failure, TakenOver)
        route.phase = Phase.FAILED
        route.reason = failure.reason
        self._note(f'Route {route.order.route_id} failed: {failure}')
