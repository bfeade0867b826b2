"""The bridge's mind: routes and robot events in, commands and reports out.

Neither ROS nor sockets nor a clock: every event comes with the time at which it happened (s,
monotonic), and every answer is a list of actions. Metres, the map frame.
"""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, List, Optional, Tuple

from omron_ld90.graph import route_protocol as p
from omron_ld90.graph.robot_errand import RobotErrand
from omron_ld90.graph.robot_place import RobotPlace
from omron_ld90.graph.route_place import PlaceOnGraph
from omron_ld90.graph.route_progress import RouteProgress
from omron_ld90.graph.route_protocol import EdgeState, RouteOrder, RouteReport, SymbolicPose
from omron_ld90.graph.route_run import Phase, RouteRun
from omron_ld90.graph.route_strategies import Outlook, Strategy, native, vertex_by_vertex
from trajectory_graph import Graph, TrajectoryGraphError, check_route

LONGEST_ROUTE = 10_000  # edges
PATIENCE = 0.5          # s for the robot to say why its motion was interrupted
ARRIVAL_PATIENCE = 2.0  # s for a location to show what the robot said
LATENCY = 0.1           # s from our command to the robot's obeying it


@dataclass(frozen=True)
class Settings:
    """What a user can set; metres and seconds."""

    dock_vertex: Optional[int] = None
    strategy: Strategy = vertex_by_vertex
    native_command: str = ''  # of strategy native, with {goals} and {last}
    vertex_tolerance: float = 0.3
    corridor_width: float = 0.9
    stall_timeout: float = 30.0
    location_timeout: float = 5.0
    link_timeout: float = 2.0
    top_speed: float = 1.35
    acceleration: float = 0.5
    braking: float = 0.2      # m/s2, deceleration towards a goal


class RouteFollower:
    """Drives one robot along the routes of a fleet manager."""

    def __init__(self, settings: Settings, graph: Optional[Graph] = None) -> None:
        self.settings = settings
        self.graph = graph
        self.seen = RobotPlace()
        self.errand = RobotErrand()
        self.route: Optional[RouteRun] = None
        """The running route, or the last one."""
        self._restored: Optional[Tuple[p.RouteRecord, float]] = None  # with the time to forget
        self._waiting: Optional[Tuple[RouteOrder, float]] = None  # with the time to give up
        self._down: Dict[str, Tuple[float, str]] = {}  # link: since when, why
        self._emergency = False
        self._owes_stop = False  # a stop could not reach the robot
        self._interrupted_at: Optional[float] = None
        self._strange_goals = 0  # status texts in a row that name a goal we do not know
        self._reported: Tuple = ()
        self._out: List[p.Action] = []
        self._handlers = {
            RouteOrder: self._on_order, p.Located: self._on_located,
            p.GoalStarted: self._on_goal_started, p.GoalReached: self._on_goal_reached,
            p.GoalShown: self._on_goal_shown, p.MotionInterrupted: self._on_interrupted,
            p.RobotFailed: self._on_robot_failed, p.CommandRejected: self._on_rejected,
            p.EmergencyStop: self._on_emergency_stop, p.Docking: self._on_docking,
            p.ForeignCommand: self._on_foreign_command, p.CommandRefused: self._on_refused,
            p.LinkChanged: self._on_link,
        }

    # --- what goes in and out ----------------------------------------------------------------

    def handle(self, event: p.Event, now: float) -> List[p.Action]:
        """Takes an event; commands in the answer come before reports about them."""
        self._handlers[type(event)](event, now)
        return self._actions()

    def tick(self, now: float) -> List[p.Action]:
        """Looks at the clock; to be called about ten times a second."""
        if self._waiting and now > self._waiting[1]:
            order, self._waiting = self._waiting[0], None
            self._refuse(order, 'there is no graph' if self.graph is None
                         else 'the robot has not told where it is')
        if self.running:
            self._check_clock(now)
        return self._actions()

    def use_graph(self, graph: Graph, now: float) -> List[p.Action]:
        """Replaces the graph; a running route goes on when its edges are what they were."""
        if self.running:
            if all(_same_edge(self.graph, graph, edge) for edge in self.route.edges):
                self.route.progress.graph = graph
            else:
                self._fail('the graph was replaced, and edges of the route are not what they were')
        self.graph = graph
        self._consider_waiting(now)
        return self._actions()

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

    def _actions(self) -> List[p.Action]:
        """What has gathered, with a report where more than a percentage has changed."""
        if self.route is not None:
            report = self.report()
            changed = (report.route_id, report.edges, report.states, report.reason)
            if changed != self._reported:
                self._out.append(report)
                self._reported = changed
        actions, self._out = self._out, []
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
        if self.running:
            return self.route.progress.pose
        if self.graph is None or self.seen.last is None:
            return SymbolicPose()
        if self.route and self.route.phase is Phase.COMPLETE and self._stands_at_the_end():
            return self.route.progress.pose
        return self._here.symbolic_pose()

    def _stands_at_the_end(self) -> bool:
        """Has the robot stayed where its last route ended?"""
        end = self.graph.vertices.get(self.route.progress.end(-1).id)
        if end is None:
            return False
        if self._here.is_docked:
            return end.id == self.settings.dock_vertex
        here = (self.seen.last.x, self.seen.last.y)
        return math.dist(here, end.position) <= self.settings.vertex_tolerance

    # --- orders --------------------------------------------------------------------------------

    def _on_order(self, order: RouteOrder, now: float) -> None:
        route = self.route
        if not order.edges:
            self._on_empty_order(order, now)
        elif route and 0 < order.stamp < route.order.stamp:
            self._note(f'Route {order.route_id} came late and was left out: route '
                       f'{route.order.route_id} was sent after it.')
        elif route and (order.route_id, order.edges) == (route.order.route_id, route.edges):
            pass  # a duplicate
        else:
            self._waiting = (order, now + self.settings.location_timeout)
            self._consider_waiting(now)

    def _on_empty_order(self, order: RouteOrder, now: float) -> None:
        """Stop. That is obeyed whenever it comes, late or twice."""
        self._waiting = None
        self._send_stop()
        self.route = RouteRun(order, None, now)

    def _consider_waiting(self, now: float) -> None:
        """Takes up the order that waits, or refuses it, once graph and place are known."""
        if self._waiting is None or self.graph is None or self.seen.last is None:
            return
        order, self._waiting = self._waiting[0], None
        restored, self._restored = self._restored, None
        reason = self._why_not(order)
        if reason:
            self._refuse(order, reason)
        elif self._is_change(order):
            self._change(order, now)
        elif not (restored and now < restored[1] and self._resume(order, restored[0], now)):
            first = order.edges[0]
            reason = self._here.why_not_from(first, self._is_being_driven(first))
            if reason:
                self._refuse(order, reason)
            else:
                self._begin(order, 0, now)

    def _why_not(self, order: RouteOrder) -> str:
        """Why the order cannot be driven by this robot now, wherever it is; empty if it can."""
        if len(order.edges) > LONGEST_ROUTE:
            return f'the route has more than {LONGEST_ROUTE} edges'
        try:
            check_route(self.graph, order.edges)
        except TrajectoryGraphError as error:
            return str(error)
        if self._emergency:
            return 'emergency stop'
        for link, (_, why) in self._down.items():
            return f'lost link: {link}: {why}'
        if not self._is_change(order):
            return ''
        done = len(self.route.states) if not self.running else self.route.progress.current + 1
        if self.route.phase is Phase.FAILED:
            return f'route {order.route_id} has failed: another one needs another id'
        if order.edges[:done] != self.route.edges[:done]:
            return (f'route {order.route_id} must go on with the edges done and the current one, '
                    f'{list(self.route.edges[:done])}')
        return ''

    def _is_change(self, order: RouteOrder) -> bool:
        return (self.route is not None and self.route.order.route_id == order.route_id
                and self.route.phase is not Phase.STOPPED)

    def _is_being_driven(self, edge: int) -> bool:
        """Is the robot on this edge, or just past it, or did it fail on it?"""
        route = self.route
        if route is None or route.phase not in (Phase.RUNNING, Phase.FAILED):
            return False
        current = route.progress.current
        first = max(current - 1, 0) if route.running else current
        return edge in route.edges[first:current + 1]

    def _begin(self, order: RouteOrder, current: int, now: float) -> None:
        """Drives a new route from edge index `current` on."""
        leeway = self._edges_ahead() if self.running else ()
        self.route = RouteRun(order, self._progress(order, current), now)
        self.route.allow(leeway)
        self._owes_stop = False
        self._interrupted_at = None
        self._drive()

    def _progress(self, order: RouteOrder, current: int) -> RouteProgress:
        dock = () if self.settings.dock_vertex is None else (self.settings.dock_vertex,)
        return RouteProgress(self.graph, order.edges, self.settings.vertex_tolerance, dock,
                             (self.seen.last.x, self.seen.last.y), current)

    def _change(self, order: RouteOrder, now: float) -> None:
        """Extends or shortens the route."""
        route = self.route
        route.allow(self._edges_ahead())
        route.order = order
        route.progress.replace_edges(order.edges)
        if not route.progress.done:
            route.phase = Phase.RUNNING
            route.target = None
            route.count_as_progress(now)
            self._drive()

    def _resume(self, order: RouteOrder, record: p.RouteRecord, now: float) -> bool:
        """Goes on with the route that ran before a restart of this program; False if it is another.

        Meanwhile the robot went on to the vertex that it had been sent to. Nothing else sent it
        anywhere as long as it is found on the edges that lead there; those behind it were driven.
        """
        kept = record.edges[:record.completed + 1]
        if record.route_id != order.route_id or order.edges[:len(kept)] != kept:
            return False
        if record.completed >= len(order.edges):
            self.route = RouteRun(order, self._progress(order, record.completed), now)
            self.route.phase = Phase.COMPLETE
            return True
        ahead = order.edges[record.completed:record.target + 1]
        found = 0 if self._here.is_about_the_dock else self._here.nearest_of(ahead)
        if found is None:
            return False
        self._begin(order, record.completed + found, now)
        return True

    def _refuse(self, order: RouteOrder, reason: str) -> None:
        """One message with the order's id; a route that runs goes on."""
        self._out.append(RouteReport(self._stamp, order.route_id, order.edges,
                                     (EdgeState.FAILED,) * len(order.edges), self._pose(), reason))
        self._note(f'Route {order.route_id} was refused: {reason}.')

    # --- driving ---------------------------------------------------------------------------------

    def _drive(self) -> None:
        """Sends the robot where the strategy wants it, unless it is on its way there."""
        route = self.route
        if route.progress.done or route.going_back():
            return
        index = self.settings.strategy(Outlook(
            route.progress, route.target, self.errand.reached, self._horizon(),
            self.settings.corridor_width))
        if index != route.target:
            route.target = index
            self._send_to(index)

    def _horizon(self) -> float:
        """Distance in m at which the robot may begin to brake before it is looked at again."""
        settings, seconds = self.settings, self.seen.period + LATENCY
        speed = min(settings.top_speed, self.seen.speed + settings.acceleration * seconds)
        return speed * speed / (2.0 * settings.braking) + speed * seconds

    def _send_to(self, index: int) -> None:
        progress = self.route.progress
        vertex = progress.end(index).id
        goal = p.DOCK if vertex == self.settings.dock_vertex else str(vertex)
        if goal == self.errand.goal and not self.errand.reached:
            return  # it is on its way there: no motion command is repeated
        via: List[str] = []
        if goal == p.DOCK:
            command = p.DOCK
        elif self.settings.strategy is native and self.settings.native_command:
            via = [str(progress.end(i).id) for i in range(progress.current, index)]
            command = self.settings.native_command.format(goals=' '.join([*via, goal]), last=goal)
        else:
            command = f'goto {goal}'
        self.errand.sent(command, goal, via)
        self._strange_goals = 0
        self._out.append(p.Send(command))

    def _on_located(self, location: p.Located, now: float) -> None:
        if not self.seen.update(location, now):
            return
        self._consider_waiting(now)
        if not self.running:
            return
        route = self.route
        route.progress.move_to(location.x, location.y)
        if self._has_strayed():
            self._fail('off the corridor')
        elif route.progress.current < route.target and route.progress.has_overshot():
            self._send_back(now)
        else:
            self._settle()

    def _has_strayed(self) -> bool:
        """Twice in a row outside the corridors of the edges on the way to the target?"""
        route, here = self.route, (self.seen.last.x, self.seen.last.y)
        until = max(route.progress.current, route.target)
        distance = min([route.progress.distance_from_route(*here, until)] + [
            self.graph.curve(edge).project(*here).distance for edge in route.leeway])
        strays = (distance > self.settings.corridor_width / 2.0
                  and not self._here.is_about_the_dock)
        twice, route.strayed = strays and route.strayed, strays
        return twice

    def _settle(self) -> None:
        """Takes the robot's word that it has arrived, once it is seen there, and goes on."""
        route = self.route
        progress = route.progress
        if (self.errand.reached and progress.current == route.target
                and (self.errand.goal == p.DOCK
                     or self._distance_to_target() <= self.settings.vertex_tolerance)):
            progress.complete_current()
        if progress.done:
            route.phase = Phase.COMPLETE
            self.errand.ended()
        else:
            self._drive()

    def _distance_to_target(self) -> float:
        route = self.route
        return math.dist((self.seen.last.x, self.seen.last.y),
                         route.progress.end(route.target).position)

    def _send_back(self, now: float) -> None:
        """The robot cut a corner so far that it missed a vertex: back to that, once."""
        route, current = self.route, self.route.progress.current
        vertex = route.progress.end(current).id
        if current in route.sent_back or self.errand.goal == p.DOCK:
            self._fail(f'the robot went by vertex {vertex} without coming near it')
            return
        self._note(f'The robot missed vertex {vertex} and is sent back to it.')
        route.sent_back.append(current)
        route.allow(self._edges_ahead())
        route.target = current
        route.count_as_progress(now)
        self._send_to(current)

    def _doubt_arrival(self, now: float) -> None:
        """The robot has said that it is at the target, but was not seen to get there."""
        if self.route.progress.current < self.route.target:
            self._send_back(now)
        else:
            self._fail(f'the robot says that it is at {self.errand.goal}, but is '
                       f'{self._distance_to_target():.1f} m away from it')

    def _edges_ahead(self) -> Tuple[int, ...]:
        route = self.route
        current = route.progress.current
        return route.edges[max(current - 1, 0):max(current, route.target or 0) + 2]

    # --- what the robot says ---------------------------------------------------------------------

    def _on_goal_started(self, event: p.GoalStarted, now: float) -> None:
        if self.running and not self.errand.started(event.goal):
            self._fail(p.TAKEN_OVER, f'The robot is going to {event.goal or "another place"}.')

    def _on_goal_reached(self, event: p.GoalReached, now: float) -> None:
        if self.running and self.errand.arrived(event.goal):
            self.route.arrived_at = now
            self._settle()

    def _on_goal_shown(self, event: p.GoalShown, now: float) -> None:
        """The status text may lag, so a strange goal counts when it is shown twice."""
        if self.running and not self.errand.shown(event.goal):
            self._strange_goals += 1
            if self._strange_goals > 1:
                self._fail(p.TAKEN_OVER, f'The robot is going to {event.goal or "another place"}.')
        else:
            self._strange_goals = 0

    def _on_interrupted(self, event: p.MotionInterrupted, now: float) -> None:
        if self.running and not self.errand.interrupted(event.text):
            self._interrupted_at = now  # an emergency stop or an error may follow at once

    def _on_robot_failed(self, event: p.RobotFailed, now: float) -> None:
        if self.running:
            self._fail(event.text)

    def _on_rejected(self, event: p.CommandRejected, now: float) -> None:
        if self.running and self.errand.is_ours(event.command):
            self._fail(event.text)

    def _on_emergency_stop(self, event: p.EmergencyStop, now: float) -> None:
        self._emergency = event.active
        if self.running and event.active:
            self._fail('emergency stop')

    def _on_docking(self, state: p.Docking, now: float) -> None:
        before = self.errand.docking
        asked = self.errand.docking_changed(state)
        if not self.running:
            return
        if state is not before:
            self.route.count_as_progress(now)
        if not asked:
            self._fail(p.TAKEN_OVER, 'The robot is docking.')
        elif self.errand.reached and self.errand.goal == p.DOCK:
            self.route.arrived_at = now
            self._settle()

    # --- what others do --------------------------------------------------------------------------

    def _on_foreign_command(self, event: p.ForeignCommand, now: float) -> None:
        self._owes_stop = False
        if self.running:
            self._fail(p.TAKEN_OVER, f'{event.caller} sent {event.command!r}.')

    def _on_refused(self, event: p.CommandRefused, now: float) -> None:
        if self.running:
            self._fail(event.reason)

    def _on_link(self, event: p.LinkChanged, now: float) -> None:
        if not event.up:
            self._down.setdefault(event.link, (now, event.reason))
            return
        self._down.pop(event.link, None)
        if self._owes_stop and not self._down:
            self._owes_stop = False
            self._send_stop()

    def _check_clock(self, now: float) -> None:
        settings = self.settings
        for link, (since, why) in self._down.items():
            if now - since > settings.link_timeout:
                self._fail(f'lost link: {link}: {why}')
                return
        if now - self.seen.heard > settings.location_timeout:
            self._fail(f'the robot has not told where it is for {settings.location_timeout:.0f} s')
        elif self.errand.reached and now - self.route.arrived_at > ARRIVAL_PATIENCE:
            self._doubt_arrival(now)
        elif self._interrupted_at is not None and now - self._interrupted_at > PATIENCE:
            self._fail(p.TAKEN_OVER, 'The motion was interrupted.')
        elif self.route.seconds_without_progress(now) > settings.stall_timeout:
            self._fail(f'no progress for {settings.stall_timeout:.0f} s')

    # --- endings ---------------------------------------------------------------------------------

    def _fail(self, reason: str, detail: str = '') -> None:
        """Ends the route. The robot is stopped, unless it obeys somebody else already."""
        if reason != p.TAKEN_OVER:
            self._send_stop()
        self.errand.ended()
        self.route.phase = Phase.FAILED
        self.route.reason = reason
        self._note(f'Route {self.route.order.route_id} failed: {reason}. {detail}'.rstrip())

    def _send_stop(self) -> None:
        self._owes_stop = bool(self._down)
        self.errand.ended()
        self._out.append(p.Send(p.STOP))

    def _note(self, text: str) -> None:
        self._out.append(p.Note(text))


def _same_edge(one: Graph, other: Graph, edge: int) -> bool:
    """Is an edge the same in both graphs, its vertices included?"""
    return (abs(edge) in other.edges and one.edge(edge) == other.edge(edge)
            and one.start_vertex(edge) == other.start_vertex(edge)
            and one.end_vertex(edge) == other.end_vertex(edge))
