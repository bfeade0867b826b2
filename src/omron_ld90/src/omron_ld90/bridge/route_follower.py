"""The core of the bridge: turns orders and robot events into commands and reports.

The module uses neither ROS nor sockets: every event comes with its time (s, monotonic), and every
answer is a list of actions. Lengths are in m, in the map frame. Events update the known state of
the robot (`robot_monitor`). `route_protocol.intake` decides which orders count, and which order
waits. This module makes routes of the orders, and `route_run` drives the running route. The fleet
manager gets reports.

The reports carry an epoch of the vehicle; the commands carry an epoch of the controller
(`RobotMonitor.epoch`). The vehicle's epoch ends when
- another giver, a person or an emergency stop began a new epoch of the controller,
- a route ended because another giver drives the robot, or because the link was lost,
- a stop without a number came, or an order of another master was taken,
- the bridge started without its memory.

    event                            no route runs                 a route runs
    a stop                           the robot is stopped          the robot is stopped, the route
                                                                   becomes STOPPED
    an order                         begins a route, waits, or is  changes the route, waits, or is
                                     refused                       refused
    another giver or person drives   a new epoch begins            FAILED, the robot is left alone
    a command of the master itself   a COMPLETE route becomes      FAILED if the controller had a
    moves or stops the robot         STOPPED                       drive of the route; else nothing
    a failure (`RouteFailed`)        -                             FAILED, the robot is stopped
    the last edge is complete        -                             COMPLETE
    a restart                        the place is restored         the route goes on as soon as the
                                                                   robot's state is known, or is
                                                                   FAILED

Invariants: if the robot obeys a drive of ours and no route runs, the robot is stopped. An order is
taken only while the robot's place is known, its links are up, and it is not coming to rest.
Commands come before the reports about them.
"""
from __future__ import annotations

import math
from functools import partial
from typing import Callable, Iterable, List, Optional, Tuple

from omron_ld90.bridge import events as p
from omron_ld90.bridge.goal_tracker import RouteFailed, TakenOver
from omron_ld90.bridge.graph_location import GraphLocation
from omron_ld90.bridge.motion_judge import MotionJudge
from omron_ld90.bridge.order_notes import OrderNotes
from omron_ld90.bridge.robot_monitor import RobotMonitor
from omron_ld90.bridge.robot_state import MapLocation
from omron_ld90.bridge.route_orders import (
    check_braking,
    check_change,
    check_edges,
    check_start,
    first_change,
)
from omron_ld90.bridge.route_progress import RouteProgress
from omron_ld90.bridge.route_restart import continued_route
from omron_ld90.bridge.route_run import RouteRun
from omron_ld90.bridge.route_strategies import RouteSettings
from route_protocol.intake import DueOrder, Intake, NotYet, messages_of
from route_protocol.order_rules import RouteRefused, check_order
from route_protocol.values import (
    EMERGENCY_STOP,
    NO_REASON,
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
from route_protocol.vehicle import Answer, Vehicle, draw_epoch, milliseconds
from trajectory_graph import Graph

_SILENT = Reason(ReasonCode.NO_LOCATION, 'the robot has sent no status')
_ROLLS = Reason(ReasonCode.NOT_READY, 'the robot is still coming to rest')
_FORGOTTEN = Reason(ReasonCode.RESTARTED, 'the bridge was started without a sure memory')
_WAS_AWAY = Reason(ReasonCode.RESTARTED, 'the bridge was away for too long')
_STOPS = {EpochCause.STOP, EpochCause.CANCEL, EpochCause.EMERGENCY_STOP}
"""After a new epoch with one of these causes, the robot only rolls on along our route."""


class RouteFollower:
    """Drives one robot along the routes of a fleet manager.

    The class has many attributes because it connects the parts of the bridge.
    """

    def __init__(self, settings: RouteSettings, graph: Optional[Graph] = None,
                 links: Iterable[p.RobotLink] = (), draw: Callable[[], int] = draw_epoch,
                 clock: Callable[[], int] = milliseconds) -> None:
        """links -- the links that must be up before an order is accepted

        draw, clock -- see `Vehicle`
        """
        self.settings = settings
        self.graph = graph
        self._next_graph: Optional[Graph] = None  # it waits until the running route has ended
        self.vehicle = Vehicle(draw, clock)
        """The vehicle's end of the route protocol."""
        self.robot = RobotMonitor(settings, links, clock(),
                                  lambda: self.vehicle.state.master or '')
        self.route: Optional[RouteRun] = None
        """The driving of the vehicle's present or last route; None: no such route on this graph."""
        # the record of a route to continue, and the time after which this route is given up
        self._restored: Optional[Tuple[p.BridgeMemory, float]] = None
        self.orders = Intake(self.vehicle, self._begin_route, self._report_refusal,
                             settings.location_timeout)
        self._order_notes = OrderNotes(self._note)
        self._motion = MotionJudge()
        self._now = 0.0
        self._last_reported = self._reported
        self._out: List[p.Action] = []

    # --- interface --------------------------------------------------------------------------------

    def handle(self, event: p.Event, now: float) -> List[p.Action]:
        """Takes an event. In the answer, commands come before the notes and reports about them."""
        if isinstance(event, RouteOrder):
            return self._answer(partial(self._on_order, event, now), now)
        return self._answer(partial(self._on_event, event, now), now)

    def tick(self, now: float) -> List[p.Action]:
        """Notes that time has passed; to be called about ten times a second."""
        return self._answer(partial(self._drive_on, now), now)

    def use_graph(self, graph: Graph, now: float) -> List[p.Action]:
        """Replaces the graph. If the new graph changes edges of the running route, it is used only
        when the route has ended.
        """
        return self._answer(partial(self._use_graph, graph, now), now)

    def restore(self, record: p.BridgeMemory, is_recent: bool, now: float,
                is_sure: bool = True) -> None:
        """Takes the record from before a restart.

        The bridge continues a route that was running, unless the bridge was away for too long.

        is_recent -- the bridge was not away for too long
        is_sure -- no later record can have been lost
        """
        self.orders.old_masters.last = record.last
        self.robot.resume(record.epoch, record.foreign_epoch, record.number)
        owes_stop = record.owes_stop
        if not is_sure:
            owes_stop = owes_stop or record.vehicle.is_running
            self.vehicle.forget(record.vehicle, _FORGOTTEN)
        else:
            self.vehicle.resume(record.vehicle)
            if self.running and not is_recent:
                owes_stop = True
                self.vehicle.fail(_WAS_AWAY)
        if owes_stop:
            self.robot.stop(record.epoch)
        if self.vehicle.state.phase in (Phase.RUNNING, Phase.COMPLETE):
            self._restored = (record, now + self.settings.restart_timeout)
        elif is_sure:
            self._motion.route_ended(self.vehicle.state.phase)
        self._last_reported = self._reported

    @property
    def running(self) -> bool:
        """Whether a route is being driven."""
        return self.vehicle.state.is_running

    @property
    def record(self) -> p.BridgeMemory:
        """The record that `restore` takes after a restart."""
        if self._restored:  # nothing newer is known yet
            target, number = self._restored[0].target, self._restored[0].number
        else:
            target = self.route.target if self.route else None
            number = self.robot.tracker.word.number
        return p.BridgeMemory(self.vehicle.state, target, number, self.robot.must_stop,
                              self.robot.epoch, self.robot.foreign_epoch,
                              self.orders.old_masters.last)

    def report(self) -> RouteReport:
        """Returns the next report for the fleet manager."""
        last = self.robot.location.last
        return self.vehicle.report(
            last.stamp if last else 0, self.pose, _location_of(last), self.motion,
            self._stop_problem, self._unready)

    @property
    def _unready(self) -> ReasonCode:
        """The reason why the robot would refuse any route now."""
        if self.robot.emergency:
            return ReasonCode.EMERGENCY_STOP
        return self._why_unknown(self._now).code

    @property
    def reason(self) -> Reason:
        """The reason why the route has failed, or why a stop has not been obeyed yet."""
        return self.vehicle.state.reason or self._stop_problem

    @property
    def pose(self) -> SymbolicPose:
        """The robot's place on the graph."""
        if self.graph is None or self.robot.location.last is None:
            return SymbolicPose()
        if self.route and self.route.decides_pose(self._here):
            return self.route.progress.pose
        return self._here.symbolic_pose()

    @property
    def motion(self) -> Motion:
        """What the robot does."""
        return self._motion.motion(self.running, self.robot.is_heard(self._now),
                                   self.robot.owes_stop)

    def _answer(self, handle: Callable[[], None], now: float) -> List[p.Action]:
        """Runs a handler. Returns commands and notes, and a report if a value of `_reported` has
        changed.
        """
        self._now = now
        try:
            handle()
            if self._next_graph is not None and not self.running:
                self._use_graph(self._next_graph, now)
        except RouteFailed as failure:
            self._fail(failure, now)
        self._end_epoch(now)
        actions: List[p.Action] = [*self.robot.due_commands(now), *self._out]
        self._out = []
        reported = self._reported
        if reported != self._last_reported:
            self._last_reported = reported
            actions.append(self.report())
        return actions

    @property
    def _reported(self) -> Tuple[object, ...]:
        """The values whose changes are reported at once. They include each edge on which a stopped
        robot rolls on, so that the master knows which vertices the robot has passed.
        """
        motion = self.motion
        edge = self.pose.edge if motion is Motion.COMING_TO_REST else 0
        return self.vehicle.state, self._stop_problem, motion, self.robot.emergency, edge

    @property
    def _stop_problem(self) -> Reason:
        problem = self.robot.stop_problem
        return Reason(ReasonCode.STOP_OWED,
                      f'the robot has not obeyed the stop yet: {problem}') if problem else NO_REASON

    @property
    def _here(self) -> GraphLocation:
        """The robot's location on the graph. The location and the graph must be known."""
        last = self.robot.location.last
        assert self.graph is not None and last is not None
        return GraphLocation(self.graph, last.position, self.robot.docking,
                             self.settings.dock_vertex, self.settings.vertex_tolerance,
                             self.settings.corridor_width)

    def _note(self, text: str) -> None:
        if text:
            self._out.append(p.BridgeNote(text))

    # --- orders -----------------------------------------------------------------------------------

    def _on_order(self, order: RouteOrder, now: float) -> None:
        was_running = self.running
        judgement = self.orders.arrived(order, now)
        if judgement.answer is Answer.IGNORED:
            self._order_notes.ignored(order, judgement.reason)
        elif judgement.answer is Answer.STOP:
            self._restored = self.route = None
            self.robot.stop(0)
            if was_running:
                self._motion.route_ended(Phase.STOPPED)
        if judgement.answer in (Answer.STOP, Answer.ROUTE):
            self._drive_on(now)

    def _why_order_waits(self, now: float) -> Reason:
        motion = self.motion
        rolls = motion is Motion.COMING_TO_REST or (
            motion is Motion.UNKNOWN and self.robot.owes_stop)
        return self._why_unknown(now) or (_ROLLS if rolls else NO_REASON)

    def _why_unknown(self, now: float) -> Reason:
        if self.graph is None:
            return Reason(ReasonCode.NOT_READY, 'there is no graph')
        return self.robot.why_unknown(now)

    def _begin_route(self, due: DueOrder) -> None:
        """Changes the route, or begins a new route. Raises RouteRefused or NotYet."""
        now = self._now
        check_order(due.given, 'the robot')
        if self.robot.emergency:
            raise RouteRefused(EMERGENCY_STOP)
        unknown = self._why_order_waits(now)
        if unknown:
            raise NotYet(unknown)
        was_running, route, graph = self.running, self.route, self._here.graph
        self._check_way(due)
        under_way = route.edges_under_way if route is not None and was_running else ()
        self.orders.take_order(due, now)
        self._order_notes.taken(due.given)
        self._restored = None
        if due.goes_on and route is not None and route.progress.graph is graph:
            if not was_running:
                self.robot.route_extended()
            route.replace(now)
        else:
            self.robot.begin()
            self.route = route = self._run(due.done - due.order.first, now)
            route.allow(under_way)
            route.drive()

    def _check_way(self, due: DueOrder) -> None:
        """Raises RouteRefused if the robot cannot drive the order from its place."""
        here, route = self._here, self.route
        check_edges(here.graph, due.order.edges)
        if due.goes_on and not due.given.order:
            check_change(due.order, self.vehicle.state, route, here)
        elif due.rest and not (due.goes_on and self.running):
            check_start(due.rest[0], route, here)
        if self.running and due.goes_on and route is not None:
            check_braking(due, self.vehicle.state, route, self._now)

    def _run(self, current: int, now: float) -> RouteRun:
        """Returns an object that drives the vehicle's route, beginning with the edge `current`."""
        dock = () if self.settings.dock_vertex is None else (self.settings.dock_vertex,)
        here = self._here
        progress = RouteProgress(here.graph, self.vehicle.state.edges,
                                 self.settings.vertex_tolerance, dock, here.position, current)
        return RouteRun(self.vehicle, self.settings, self.robot.tracker, self.robot.location,
                        progress, now)

    def _report_refusal(self, refusal: RouteRefusal) -> None:
        self._out += messages_of(refusal, self.vehicle.state, self.report)
        self._order_notes.refused(refusal, self.robot.emergency)

    # --- progress of the route --------------------------------------------------------------------

    @property
    def _driven(self) -> Optional[RouteRun]:
        """The route if it is running and its edges belong to a graph, otherwise None."""
        return self.route if self.running else None

    def _on_event(self, event: p.Event, now: float) -> None:
        known = self.robot.epoch
        moved, driven = self.robot.update(event, now), self._driven
        if isinstance(event, p.RobotSeen):
            self._motion.seen(event, self.robot.location.last if moved else None, self.running)
        elif isinstance(event, p.MotionTold):
            self._motion.told(event)
            self._leave_route_for_master()
        if self.robot.epoch != known and self._drives_without_route():
            self.robot.stop(self.robot.epoch)
            self._note('The robot obeys a drive of a route that has ended, and is stopped.')
        if moved and driven:
            self._note(driven.locate(self._here, now))
        self._drive_on(now)

    def _leave_route_for_master(self) -> None:
        """Ends a complete route if a command of the master itself has moved the robot. The next
        route begins where the robot is then.
        """
        if self.robot.was_moved_by_master:
            self.robot.was_moved_by_master = False
            self.vehicle.leave_route()

    def _drives_without_route(self) -> bool:
        """Returns whether the robot obeys a drive of ours that no route needs."""
        return (self.robot.drives_for_us and not self.running and self._restored is None
                and not self.robot.must_stop and not self.robot.stop_problem)

    def _drive_on(self, now: float) -> None:
        """Checks the known state, and continues the route.

        If another giver has acted, the route ends before a waiting order is taken: its master did
        not know of this giver.
        """
        self._end_epoch(now)
        if self.robot.overruled is not None:
            self._restored = None
            self.robot.check_giver()
        self._consider_restored(now)
        self.orders.answer(now)
        driven = self._driven
        if driven:
            self.robot.check(now)
            self._note(driven.drive_on(now, self.robot.docking_changed))
            if not self.running:
                self._motion.route_ended(Phase.COMPLETE)

    def _end_epoch(self, now: float) -> None:
        """Begins a new epoch if another giver has acted and no route runs."""
        cause = self.robot.overruled
        if cause is not None and not self.running:
            self.robot.overruled = None
            self.orders.begin_epoch(cause, NO_REASON, now)

    def _consider_restored(self, now: float) -> None:
        """Continues the route from before a restart, once the robot's state is known."""
        seen = self.robot.seen
        if self._restored is None:
            return
        record, give_up = self._restored
        unknown = self._why_unknown(now) or (NO_REASON if seen else _SILENT)
        if unknown and now <= give_up:
            return
        self._restored = None
        if seen and not unknown:
            if self.running:
                self.robot.check(now)
            self.route = continued_route(record, self._here,
                                         lambda current: self._run(current, now), now)
            if self.running:
                self._note(f'Route {self.vehicle.state.route_id} goes on after a restart of the '
                           'bridge.')
        elif self.running:
            raise RouteFailed(unknown)

    def _use_graph(self, graph: Graph, now: float) -> None:
        self._next_graph = None
        if graph.is_same(self.graph):
            return
        route = self.route
        changed = route and first_change(graph, route.progress.graph, route.progress.edges)
        if self._driven and changed:
            self._next_graph = graph
            self._note(f'A /graph is refused until route {self.vehicle.state.route_id} has ended: '
                       f'{changed}')
            return
        self.graph = graph
        if route and not changed:
            route.use_graph(graph)
        self._drive_on(now)

    def _fail(self, failure: RouteFailed, now: float) -> None:
        """Ends the route, and stops the robot unless it already obeys another giver.

        After a take-over the robot may still obey us; then it is stopped as well.
        """
        cause = self.robot.overruled
        self.robot.overruled = None
        if isinstance(failure, TakenOver) and not self.robot.drives_for_us:
            self.robot.leave()
        else:
            self.robot.stop(self.robot.epoch)
        if isinstance(failure, TakenOver):
            cause = cause or EpochCause.OTHER_GIVER
        elif failure.reason.code is ReasonCode.LOST_LINK:
            cause = cause or EpochCause.LOST_LINK
        if isinstance(failure, TakenOver) and cause not in _STOPS:
            self._motion.taken_over()
        else:
            self._motion.route_ended(Phase.FAILED)
        self.vehicle.fail(failure.reason)
        if cause is not None:
            self.orders.begin_epoch(cause, NO_REASON, now)
        self._note(f'Route {self.vehicle.state.route_id} failed: {failure}')


def _location_of(last: Optional[MapLocation]) -> Optional[VehicleLocation]:
    """Returns the location in the form of a report."""
    if last is None:
        return None
    return VehicleLocation(last.x, last.y, math.nan if last.heading is None else last.heading)
