"""The bridge's mind: routes and robot events in, commands and reports out.

Neither ROS nor sockets nor a clock: every event comes with the time at which it happened (s,
monotonic), and every answer is a list of actions. Metres, the map frame.
"""
from __future__ import annotations

from typing import Callable, Dict, Iterable, List, Optional, Tuple

from omron_ld90.graph import route_protocol as p
from omron_ld90.graph.robot_errand import DOCK, RobotErrand
from omron_ld90.graph.robot_links import RobotLinks
from omron_ld90.graph.robot_place import RobotPlace
from omron_ld90.graph.route_orders import (
    is_change,
    is_same_edge,
    resumed_at,
    why_no_change,
    why_unfit,
)
from omron_ld90.graph.route_place import PlaceOnGraph
from omron_ld90.graph.route_progress import RouteProgress
from omron_ld90.graph.route_protocol import EdgeState, RouteOrder, RouteReport, SymbolicPose
from omron_ld90.graph.route_run import Phase, RouteFailed, RouteRun
from omron_ld90.graph.route_settings import Settings
from trajectory_graph import Graph

TAKEN_OVER = 'taken over'
PATIENCE = 0.5  # s for the robot to say why its motion was interrupted


class RouteFollower:
    """Drives one robot along the routes of a fleet manager."""

    def __init__(self, settings: Settings, graph: Optional[Graph] = None,
                 links: Iterable[str] = ()) -> None:
        """`links` are those that must have been heard of before an order is taken up."""
        self.settings = settings
        self.graph = graph
        self.seen = RobotPlace()
        self.errand = RobotErrand()
        self.route: Optional[RouteRun] = None
        """The running route, or the last one."""
        self._restored: Optional[Tuple[p.RouteRecord, float]] = None  # with the time to forget
        self._waiting: Optional[Tuple[RouteOrder, float]] = None      # with the time to give up
        self._links = RobotLinks(links)
        self._refused: Tuple[Optional[RouteOrder], str] = (None, '')  # the last one, and why
        self._told_over: Optional[int] = None  # route of which a duplicate was explained
        self._emergency = False
        self._owes_stop = False  # a stop could not reach the robot
        self._interrupted_at: Optional[float] = None
        self._strange_goals = 0  # status texts in a row that name a goal we do not know
        self._told: Tuple = ()
        self._out: List[p.Action] = []
        self._handlers: Dict[type, Callable[..., None]] = {
            RouteOrder: self._on_order, p.Located: self._on_located,
            p.GoalStarted: self._on_goal_started, p.GoalReached: self._on_goal_reached,
            p.GoalShown: self._on_goal_shown, p.MotionInterrupted: self._on_interrupted,
            p.RobotFailed: self._on_robot_failed, p.CommandRejected: self._on_rejected,
            p.EmergencyStop: self._on_emergency_stop, p.Docking: self._on_docking,
            p.ForeignCommand: self._on_foreign_command, p.CommandRefused: self._on_refused,
            p.LinkChanged: self._on_link,
        }

    # --- what goes in and out ---------------------------------------------------------------------

    def handle(self, event: p.Event, now: float) -> List[p.Action]:
        """Takes an event; commands in the answer come before anything told about them."""
        return self._answer(self._handlers[type(event)], event, now)

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
            self._fail(str(failure))
        actions: List[p.Action] = [p.Send(command) for command in self.errand.take_commands()]
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
        return self.seen.last.stamp if self.seen.last else 0

    @property
    def _here(self) -> PlaceOnGraph:
        return PlaceOnGraph(self.graph, (self.seen.last.x, self.seen.last.y), self.errand.docking,
                            self.settings.dock_vertex, self.settings.vertex_tolerance,
                            self.settings.corridor_width)

    def _pose(self) -> SymbolicPose:
        if self.graph is None or self.seen.last is None:
            return SymbolicPose()
        if self.route and self.route.decides_pose(self._here):
            return self.route.progress.pose
        return self._here.symbolic_pose()

    # --- orders -----------------------------------------------------------------------------------

    def _on_order(self, order: RouteOrder, now: float) -> None:
        route = self.route
        if not order.edges:
            self._on_empty_order(order, now)
        elif route and 0 < order.stamp < route.order.stamp:
            self._note(f'Route {order.route_id} came late and was left out: route '
                       f'{route.order.route_id} was sent after it.')
        elif route and (order.route_id, order.edges) == (route.order.route_id, route.edges):
            self._on_duplicate(order)
        elif order.stamp and order == self._refused[0]:
            self._refuse(*self._refused)
        else:
            self._waiting = (order, now + self.settings.location_timeout)
            self._consider_waiting(now)

    def _on_duplicate(self, order: RouteOrder) -> None:
        """Nothing is done; who orders a route once more that is over is told so, once."""
        if not self.running and self._told_over != order.route_id:
            self._told_over = order.route_id
            self._note(f'Route {order.route_id} was ordered again and is ignored: it is '
                       f'{self.route.phase.value}. Another drive needs another id.')

    def _on_empty_order(self, order: RouteOrder, now: float) -> None:
        """Stop. That is obeyed whenever it comes, late or twice."""
        self._waiting = None
        self._stop()
        self.route = self._run(order, None, now)

    def _consider_waiting(self, now: float) -> None:
        """Takes up the order that waits, or refuses it, once it can be judged."""
        if self._waiting is None or self._why_to_wait():
            return
        order, self._waiting = self._waiting[0], None
        restored, self._restored = self._restored, None
        reason = why_unfit(self.graph, order) or self._why_unable()
        if not reason and is_change(self.route, order):
            reason = why_no_change(self.route, order)
            if not reason:
                self.route.replace(order, now)
        elif not reason:
            current = None
            if restored and now < restored[1]:
                current = resumed_at(order, restored[0], self._here)
            if current is None:
                first, current = order.edges[0], 0
                driven = self.route is not None and self.route.is_on(first)
                reason = self._here.why_not_from(first, driven)
            if not reason:
                self._begin(order, current, now)
        if reason:
            self._refuse(order, reason)

    def _why_to_wait(self) -> str:
        """What must be known before an order can be judged, and is not."""
        if self.graph is None:
            return 'there is no graph'
        if self.seen.last is None:
            return 'the robot has not told where it is'
        return self._links.why_unknown()

    def _why_unable(self) -> str:
        """Why the robot cannot drive now."""
        return 'emergency stop' if self._emergency else self._links.why_down()

    def _begin(self, order: RouteOrder, current: int, now: float) -> None:
        """Drives a new route from edge index `current` on."""
        under_way = self.route.edges_under_way if self.running else ()
        dock = () if self.settings.dock_vertex is None else (self.settings.dock_vertex,)
        self.route = self._run(order, RouteProgress(
            self.graph, order.edges, self.settings.vertex_tolerance, dock, self._here.position,
            current), now)
        self.route.allow(under_way)
        self._owes_stop = False
        self._interrupted_at = None
        self._strange_goals = 0
        if self.route.progress.done:
            self.route.phase = Phase.COMPLETE
        else:
            self.route.drive()

    def _run(self, order: RouteOrder, progress: Optional[RouteProgress], now: float) -> RouteRun:
        return RouteRun(order, self.settings, self.errand, self.seen, progress, now)

    def _refuse(self, order: RouteOrder, reason: str) -> None:
        """One message with the order's id; a route that runs goes on."""
        self._refused = (order, reason)
        self._out.append(RouteReport(self._stamp, order.route_id, order.edges,
                                     (EdgeState.FAILED,) * len(order.edges), self._pose(), reason))
        self._note(f'Route {order.route_id} was refused: {reason}.')

    def _use_graph(self, graph: Graph, now: float) -> None:
        before, self.graph = self.graph, graph
        if self.running:
            if not all(is_same_edge(before, graph, edge) for edge in self.route.edges):
                raise RouteFailed(
                    'the graph was replaced, and edges of the route are not what they were')
            self.route.progress.graph = graph
        self._consider_waiting(now)

    # --- what the robot does and says -------------------------------------------------------------

    def _on_located(self, location: p.Located, now: float) -> None:
        if self.seen.update(location, now):
            if self.running:
                self._note(self.route.locate(self._here, now))
            self._consider_waiting(now)

    def _on_goal_started(self, event: p.GoalStarted, now: float) -> None:
        if self.running and not self.errand.started(event.goal):
            self._hand_over(f'The robot is going to {event.goal or "another place"}.')

    def _on_goal_reached(self, event: p.GoalReached, now: float) -> None:
        if self.running and self.errand.arrived(event.goal):
            self.route.arrive(now)

    def _on_goal_shown(self, event: p.GoalShown, now: float) -> None:
        """The status text may lag, so a strange goal counts when it is shown twice."""
        strange = self.running and not self.errand.shown(event.goal)
        self._strange_goals = self._strange_goals + 1 if strange else 0
        if self._strange_goals > 1:
            self._hand_over(f'The robot is going to {event.goal or "another place"}.')

    def _on_interrupted(self, event: p.MotionInterrupted, now: float) -> None:
        if self.running and not self.errand.interrupted(event.text):
            self._interrupted_at = now  # an emergency stop or an error may follow at once

    def _on_robot_failed(self, event: p.RobotFailed, now: float) -> None:
        if self.running:
            raise RouteFailed(event.text)

    def _on_rejected(self, event: p.CommandRejected, now: float) -> None:
        if self.running and self.errand.is_ours(event.command):
            raise RouteFailed(event.text)

    def _on_emergency_stop(self, event: p.EmergencyStop, now: float) -> None:
        self._emergency = event.active
        if self.running and event.active:
            raise RouteFailed('emergency stop')

    def _on_docking(self, state: p.Docking, now: float) -> None:
        before, was_reached = self.errand.docking, self.errand.reached
        asked = self.errand.docking_changed(state)
        if not self.running:
            return
        if not asked:
            self._hand_over('The robot is docking.')
        elif state is not before:
            self.route.count_as_progress(now)
        if self.errand.goal == DOCK and self.errand.reached and not was_reached:
            self.route.arrive(now)

    # --- what others do ---------------------------------------------------------------------------

    def _on_foreign_command(self, event: p.ForeignCommand, now: float) -> None:
        self._owes_stop = False
        if self.running:
            self._hand_over(f'{event.caller} sent {event.command!r}.')

    def _on_refused(self, event: p.CommandRefused, now: float) -> None:
        if self.running:
            raise RouteFailed(self._why_unable() or event.reason)

    def _on_link(self, event: p.LinkChanged, now: float) -> None:
        self._links.update(event, now)
        if self._owes_stop and self._links.all_stand:
            self._stop()
        self._consider_waiting(now)

    # --- the clock, and endings -------------------------------------------------------------------

    def _check_clock(self, now: float) -> None:
        if self._waiting and now > self._waiting[1]:
            order, self._waiting = self._waiting[0], None
            self._refuse(order, self._why_to_wait())
        if not self.running:
            return
        lost = self._links.why_down_since(now - self.settings.link_timeout)
        if lost:
            raise RouteFailed(lost)
        if now - self.seen.heard > self.settings.location_timeout:
            raise RouteFailed(
                f'the robot has not told where it is for {self.settings.location_timeout:.0f} s')
        if self._interrupted_at is not None and now - self._interrupted_at > PATIENCE:
            self._hand_over('The motion was interrupted.')
        else:
            self._note(self.route.check_clock(now))

    def _hand_over(self, how: str) -> None:
        """Ends the route without a stop: the robot obeys somebody else already."""
        self.errand.end()
        self._end(TAKEN_OVER, how)

    def _fail(self, reason: str) -> None:
        self._stop()
        self._end(reason)

    def _end(self, reason: str, detail: str = '') -> None:
        self.route.phase = Phase.FAILED
        self.route.reason = reason
        self._note(f'Route {self.route.order.route_id} failed: {reason.rstrip(".")}. '
                   f'{detail}'.rstrip())

    def _stop(self) -> None:
        self._owes_stop = not self._links.all_stand
        self.errand.stop()

    def _note(self, text: str) -> None:
        if text:
            self._out.append(p.Note(text))
