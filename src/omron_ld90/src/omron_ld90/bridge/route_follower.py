"""The bridge's mind: routes and robot events in, commands and reports out.

Neither ROS nor sockets nor a clock: every event comes with the time at which it happened (s,
monotonic), and every answer is a list of actions. Metres, the map frame. What the robot does is
judged by `robot_watch`, how a route is driven by `route_run`; here orders are taken up, and the
fleet manager is told.
"""
from __future__ import annotations

from typing import Callable, Iterable, List, Optional, Tuple

from omron_ld90.bridge import route_protocol as p
from omron_ld90.bridge.robot_watch import RobotWatch
from omron_ld90.bridge.route_orders import (
    RouteRefused,
    check_change,
    check_fit,
    first_index,
    is_change,
    is_same_in,
)
from omron_ld90.bridge.route_place import PlaceOnGraph
from omron_ld90.bridge.route_progress import RouteProgress
from omron_ld90.bridge.route_protocol import EdgeState, RouteOrder, RouteReport, SymbolicPose
from omron_ld90.bridge.route_run import Phase, RouteFailed, RouteRun, TakenOver
from omron_ld90.bridge.route_settings import Settings
from trajectory_graph import Graph


class RouteFollower:
    """Drives one robot along the routes of a fleet manager."""

    def __init__(self, settings: Settings, graph: Optional[Graph] = None,
                 links: Iterable[str] = ()) -> None:
        """`links` are those that must have been heard of before an order is taken up."""
        self.settings = settings
        self.graph = graph
        self.robot = RobotWatch(settings, links)
        self.route: Optional[RouteRun] = None
        """The running route, or the last one."""
        self._restored: Optional[Tuple[p.RouteRecord, float]] = None  # with the time to forget
        self._waiting: Optional[Tuple[RouteOrder, float]] = None      # with the time to give up
        self._refused: Tuple[Optional[RouteOrder], str] = (None, '')  # the last one, and why
        self._told_over: Optional[int] = None  # route of which a duplicate was explained
        self._told: Tuple = ()
        self._out: List[p.Action] = []

    # --- what goes in and out ---------------------------------------------------------------------

    def handle(self, event: p.Event, now: float) -> List[p.Action]:
        """Takes an event; commands in the answer come before anything told about them."""
        return self._answer(self._on_order if isinstance(event, RouteOrder) else self._on_event,
                            event, now)

    def tick(self, now: float) -> List[p.Action]:
        """Looks at the clock; to be called about ten times a second."""
        return self._answer(self._check_clock, now)

    def use_graph(self, graph: Graph, now: float) -> List[p.Action]:
        """Replaces the graph; a running route goes on when its edges are what they were."""
        return self._answer(self._use_graph, graph, now)

    def restore(self, record: p.RouteRecord, until: float) -> None:
        """How far the route had come when this program last ran; counts for the next order."""
        self._restored = (record, until)

    @property
    def running(self) -> bool:
        """Whether a route is being driven."""
        return self.route is not None and self.route.running

    @property
    def record(self) -> Optional[p.RouteRecord]:
        """What `restore` is to be given after a restart; None where no route is to go on."""
        return self.route.record if self.route else None

    def report(self) -> RouteReport:
        """What the fleet manager is to know now."""
        route = self.route
        if route is None:
            return RouteReport(self._stamp, 0, (), (), self._pose())
        return RouteReport(self._stamp, route.order.route_id, route.edges, route.states,
                           self._pose(), route.reason)

    def _answer(self, handler: Callable[..., None], *arguments: object) -> List[p.Action]:
        """What a handler makes of an event: commands, notes, a report where more than a
        percentage has changed."""
        try:
            handler(*arguments)
        except RouteFailed as failure:
            self._fail(failure)
        actions: List[p.Action] = [p.Send(command)
                                   for command in self.robot.errand.take_commands()]
        actions += self._out
        self._out = []
        route = self.route
        if route is not None:
            told = (route.order.route_id, route.edges, route.states, route.reason)
            if told != self._told:
                self._told = told
                actions.append(self.report())
        return actions

    @property
    def _stamp(self) -> int:
        last = self.robot.seen.last
        return last.stamp if last else 0

    @property
    def _here(self) -> PlaceOnGraph:
        last = self.robot.seen.last
        return PlaceOnGraph(self.graph, (last.x, last.y), self.robot.errand.docking,
                            self.settings.dock_vertex, self.settings.vertex_tolerance,
                            self.settings.corridor_width)

    def _pose(self) -> SymbolicPose:
        if self.graph is None or self.robot.seen.last is None:
            return SymbolicPose()
        if self.route and self.route.decides_pose(self._here):
            return self.route.progress.pose
        return self._here.symbolic_pose()

    def _note(self, text: str) -> None:
        if text:
            self._out.append(p.Note(text))

    # --- orders -----------------------------------------------------------------------------------

    def _on_order(self, order: RouteOrder, now: float) -> None:
        route = self.route
        if not order.edges:
            self._stop(order, now)
        elif route and 0 < order.stamp < route.order.stamp:
            self._note(f'Route {order.route_id} came late and was left out: route '
                       f'{route.order.route_id} was sent after it.')
        elif route and (order.route_id, order.edges) == (route.order.route_id, route.edges):
            self._explain_duplicate(route)
        elif order.stamp and order == self._refused[0]:
            self._refuse(*self._refused)
        else:
            self._waiting = (order, now + self.settings.location_timeout)
            self._consider_waiting(now)

    def _stop(self, order: RouteOrder, now: float) -> None:
        """An empty order is obeyed whenever it comes, late or twice."""
        self._waiting = None
        self.robot.stop()
        self.route = self._run(order, None, now)

    def _explain_duplicate(self, route: RouteRun) -> None:
        """Nothing is done; who orders a route once more that is over is told so, once."""
        if not route.running and self._told_over != route.order.route_id:
            self._told_over = route.order.route_id
            self._note(f'Route {route.order.route_id} was ordered again and is ignored: it is '
                       f'{route.phase.value}. Another drive needs another id.')

    def _consider_waiting(self, now: float) -> None:
        """Takes up the order that waits, or refuses it, once it can be judged or is too old."""
        if self._waiting is None:
            return
        order, give_up = self._waiting
        unknown = 'there is no graph' if self.graph is None else self.robot.why_unknown()
        if unknown and now <= give_up:
            return
        self._waiting = None
        try:
            if unknown:
                raise RouteRefused(unknown)
            self._take_up(order, now)
        except RouteRefused as refusal:
            self._refuse(order, str(refusal))

    def _take_up(self, order: RouteOrder, now: float) -> None:
        """Changes the route, or begins another one; raises RouteRefused."""
        restored, self._restored = self._restored, None
        check_fit(self.graph, order)
        unable = self.robot.why_unable()
        if unable:
            raise RouteRefused(unable)
        if is_change(self.route, order):
            check_change(self.route, order, self._here)
            self.route.replace(order, now)
        else:
            record = restored[0] if restored and now < restored[1] else None
            self._begin(order, first_index(order, self.route, record, self._here), now)

    def _begin(self, order: RouteOrder, current: int, now: float) -> None:
        """Drives a new route from edge index `current` on."""
        under_way = self.route.edges_under_way if self.running else ()
        dock = () if self.settings.dock_vertex is None else (self.settings.dock_vertex,)
        self.route = self._run(order, RouteProgress(
            self.graph, order.edges, self.settings.vertex_tolerance, dock, self._here.position,
            current), now)
        self.route.allow(under_way)
        self.robot.begin()
        if self.route.progress.done:
            self.route.phase = Phase.COMPLETE
        else:
            self.route.drive()

    def _run(self, order: RouteOrder, progress: Optional[RouteProgress], now: float) -> RouteRun:
        return RouteRun(order, self.settings, self.robot.errand, self.robot.seen, progress, now)

    def _refuse(self, order: RouteOrder, reason: str) -> None:
        """One message with the order's id; a route that runs goes on."""
        self._refused = (order, reason)
        self._out.append(RouteReport(self._stamp, order.route_id, order.edges,
                                     (EdgeState.FAILED,) * len(order.edges), self._pose(), reason))
        self._note(f'Route {order.route_id} was refused: {reason}.')

    # --- what happens to the route ----------------------------------------------------------------

    def _on_event(self, event: p.Event, now: float) -> None:
        route = self.route if self.running else None
        if not isinstance(event, p.Located):
            self.robot.handle(event, route, now)
        elif self.robot.seen.update(event, now) and route:
            self._note(route.locate(self._here, now))
        self._consider_waiting(now)

    def _use_graph(self, graph: Graph, now: float) -> None:
        self.graph = graph
        if self.route and self.route.progress:
            if is_same_in(graph, self.route):
                self.route.progress.graph = graph
            elif self.running:
                raise RouteFailed(
                    'the graph was replaced, and edges of the route are not what they were')
        self._consider_waiting(now)

    def _check_clock(self, now: float) -> None:
        self._consider_waiting(now)
        if self.running:
            self.robot.check_clock(now)
            self._note(self.route.check_clock(now))

    def _fail(self, failure: RouteFailed) -> None:
        """Ends the route; with a stop, unless the robot obeys somebody else already."""
        if isinstance(failure, TakenOver):
            self.robot.errand.end()
        else:
            self.robot.stop()
        self.route.phase = Phase.FAILED
        self.route.reason = failure.reason
        self._note(f'Route {self.route.order.route_id} failed: {failure}')
