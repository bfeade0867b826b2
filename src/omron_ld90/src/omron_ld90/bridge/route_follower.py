"""The core of the bridge: turns orders and robot events into commands and reports.

It uses neither ROS nor sockets nor a clock: every event comes with its time (s, monotonic), and
every answer is a list of actions. Lengths are in m, in the map frame. Events update the known state
(`robot_monitor`). The running route is then judged and driven on (`route_run`). `order_intake`
sorts orders; here they become routes, and the fleet manager gets reports.
"""
from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Callable, Iterable, List, Optional, Tuple

from omron_ld90.bridge import events as p
from omron_ld90.bridge.goal_tracker import RouteFailed, TakenOver
from omron_ld90.bridge.graph_location import GraphLocation
from omron_ld90.bridge.order_intake import OrderIntake
from omron_ld90.bridge.robot_monitor import RobotMonitor
from omron_ld90.bridge.route_orders import (
    check_change,
    check_start,
    first_change,
    is_change,
)
from omron_ld90.bridge.route_progress import RouteProgress
from omron_ld90.bridge.route_restart import go_on
from omron_ld90.bridge.route_run import RouteRun
from omron_ld90.bridge.route_strategies import Settings
from trajectory_graph import Graph
from trajectory_graph.order_rules import RouteRefused, check_edges
from trajectory_graph.route_protocol import (
    NO_REASON,
    EdgeState,
    Location,
    Phase,
    Reason,
    ReasonCode,
    RouteOrder,
    RouteRefusal,
    RouteReport,
    SymbolicPose,
)

_SILENT = Reason(ReasonCode.NO_LOCATION, 'the robot has sent no status')


class RouteFollower:
    """Drives one robot along the routes of a fleet manager."""

    def __init__(self, settings: Settings, graph: Optional[Graph] = None,
                 links: Iterable[p.Link] = ()) -> None:
        """`links`: the links that must be up before an order is accepted."""
        self.settings = settings
        self.graph = graph
        self._next_graph: Optional[Graph] = None  # it waits until the running route has ended
        self.robot = RobotMonitor(settings, links)
        self.route: Optional[RouteRun] = None
        """The running route, or the last one."""
        self._restored: Optional[Tuple[p.RouteRecord, float]] = None  # to continue; time to give up
        self._orders = OrderIntake(self.robot, settings.location_timeout, self._tell_refusal,
                                   self._note)
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
        order = RouteOrder(record.route_id, record.edges, record.stamp)
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
            owes_stop = True
        if owes_stop:
            self.robot.stop_duty.require(record.epoch)
        if self.route.phase in (Phase.RUNNING, Phase.COMPLETE):
            self._restored = (record, now + self.settings.restart_timeout)

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
                       past=self._orders.past)

    def report(self) -> RouteReport:
        """The present report for the fleet manager."""
        route = self.route
        if route is None:
            return RouteReport(self._stamp, 0, (), (), self._pose(), location=self._location,
                               epoch=self.robot.epoch)
        return RouteReport(self._stamp, route.order.route_id, route.edges, route.states,
                           self._pose(), self._reason, self._location, self.robot.epoch)

    def _answer(self, handle: Callable[[], None], now: float) -> List[p.Action]:
        """Runs a handler; returns commands, notes, and a report if more than the percentage of the
        pose has changed."""
        try:
            handle()
            if self._next_graph is not None and not self.running:
                self._use_graph(self._next_graph, now)
        except RouteFailed as failure:
            self._fail(failure, now)
        actions: List[p.Action] = [*self.robot.due_commands(now), *self._out]
        self._out = []
        if self.route is not None:
            reported = (self.route.order.route_id, self.route.edges, self.route.states,
                        self._reason, self.robot.epoch)
            if reported != self._last_reported:
                self._last_reported = reported
                actions.append(self.report())
        return actions

    @property
    def _reason(self) -> Reason:
        """The reason why the route has failed, or why a stop has not been obeyed yet."""
        duty = self.robot.stop_duty
        if self.route and not self.route.reason and duty.owed and duty.problem:
            return Reason(ReasonCode.STOP_OWED,
                          f'the robot has not obeyed the stop yet: {duty.problem}')
        return self.route.reason if self.route else NO_REASON

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
        if not order.edges:
            self._stop(order, now)
        elif self._orders.take(order, self.route, now):
            self._go_on(now)

    def _stop(self, order: RouteOrder, now: float) -> None:
        """Obeys an empty order at once, even one that is late or repeated."""
        self._orders.drop()
        self._restored = None
        self.robot.stop(0)
        self.route = self._run(order, None, now, Phase.STOPPED)

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
        check_edges(here.graph, order.edges)
        if route and is_change(route, order):
            check_change(route, order, here)
            if not route.running:
                self.robot.go_on()
            route.replace(order, now)
        else:
            check_start(order, route, here)
            self._begin(order, now)
        self._orders.accepted(order)

    def _begin(self, order: RouteOrder, now: float) -> None:
        """Begins to drive a new route."""
        driven = self._driven
        under_way = driven.edges_under_way if driven else ()
        self._restored = None
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
        """Sends a refusal; also a report, if the order is not about the route in the reports."""
        self._out.append(RouteRefusal(order.route_id, order.edges, reason))
        if self.route is None or self.route.order.route_id != order.route_id:
            self._out.append(RouteReport(
                self._stamp, order.route_id, order.edges,
                (EdgeState.FAILED,) * len(order.edges), self._pose(), reason,
                self._location, self.robot.epoch))

    # --- progress of the route --------------------------------------------------------------------

    @property
    def _driven(self) -> Optional[RouteRun]:
        """The route if it is running and its edges belong to a graph, else None."""
        route = self.route
        return route if route and route.running and route.is_on_graph else None

    def _on_event(self, event: p.Event, now: float) -> None:
        known = self.robot.epoch
        moved, driven = self.robot.update(event, now), self._driven
        if self.robot.epoch != known and self._drives_without_route():
            self.robot.stop(self.robot.epoch)
            self._note('The robot obeys a drive of a route that has ended, and is stopped.')
        if known and not self.robot.knows(known):
            self._orders.overrule(now)
        if moved and driven:
            self._note(driven.locate(self._here, now))
        self._go_on(now)

    def _drives_without_route(self) -> bool:
        """Whether the robot has just begun to obey a drive of ours, but no route needs it."""
        return (self.robot.drives_for_us and not self.running and self._restored is None
                and not self.robot.stop_duty.owed)

    def _go_on(self, now: float) -> None:
        """Judges the known state, and drives on."""
        self._consider_restored(now)
        self._consider_order(now)
        driven = self._driven
        if driven:
            self.robot.check(now)
            self._note(driven.go_on(now, self.robot.docking_changed))

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
        route.phase = Phase.FAILED
        route.reason = failure.reason
        self._note(f'Route {route.order.route_id} failed: {failure}')
