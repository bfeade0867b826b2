"""Drives an order as one route over the trajectory graph, made longer as its base grows.

What it says and hears is the route protocol: routes of signed edge ids in, states of every edge
out. An extension has the id of the route that it extends, so the robot does not brake for it.
"""
from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Optional, Sequence, Tuple

from trajectory_graph import Graph
from trajectory_graph.route_protocol import EdgeState, Reason, ReasonCode
from vda5050_vehicle.drivers.driver import SETTLING, Drive, Driver, Leg, Memory, NotDrivable
from vda5050_vehicle.drivers.order_fields import (
    Abilities,
    check_deviations,
    check_headings,
    has_heading,
    heading_of,
    is_within,
)
from vda5050_vehicle.drivers.order_graph import Matching, OrderGraph
from vda5050_vehicle.drivers.robot_view import Pose, RobotView
from vda5050_vehicle.drivers.route_messages import RouteCommand, RouteReport, SentRoute
from vda5050_vehicle.protocol.values import Edge, Node

REPEAT = 1.0           # s between two sendings of a route without an acknowledgement
PATIENCE = 10.0        # s until it must be acknowledged
RESTART_PATIENCE = 25.0  # s in which the robot's side must be heard after our restart
LARGEST_ID = 2 ** 31 - 1
# Refusals because another program or person has the robot: it is not ours to stop unasked.
_NOT_OURS = (ReasonCode.TAKEN_OVER, ReasonCode.OVERRULED, ReasonCode.EMERGENCY_STOP)


@dataclass(frozen=True)
class RouteDrive(Drive):
    """What the route driver remembers.

    route         -- the last one that was sent; None: the robot has obeyed a stop since
    stop          -- id of a stop that the robot is not known to have obeyed
    stopped_at    -- s; when it was acknowledged
    waiting_since -- s; for an acknowledgement
    restarted_at  -- s; the route's reports are awaited since a restart
    """

    next_id: int = 1
    route: Optional[SentRoute] = None
    stop: Optional[int] = None
    stopped_at: Optional[float] = None
    sent_at: float = 0.0
    waiting_since: Optional[float] = None
    restarted_at: Optional[float] = None

    @property
    def at_rest(self) -> bool:
        """See Drive."""
        route = self.route
        return self.stop is None and (route is None or route.complete or route.lost)

    @property
    def in_order(self) -> bool:
        """See Drive."""
        return self.at_rest and (self.route is None or self.route.complete)


class RouteDriver(Driver[RouteDrive]):
    """See the module's text. `first_id` is the id of the first route; later ones count on."""

    def __init__(self, memory: Memory, graph: Graph, abilities: Abilities, matching: Matching,
                 first_id: int = 1) -> None:
        super().__init__(memory, RouteDrive(next_id=first_id))
        self._graph = OrderGraph(graph, matching)
        self._matching = matching
        self._abilities = abilities
        self._first_id = first_id
        self._epoch = 0  # the robot's now
        self._pose: Optional[Pose] = None

    # --- planning ---------------------------------------------------------------------------------

    def use_graph(self, graph: Graph) -> None:
        """Plans on another graph from now on."""
        self._graph = OrderGraph(graph, self._matching)

    def plan(self, nodes: Sequence[Node], edges: Sequence[Edge], pose: Optional[Pose],
             ) -> Tuple[Leg, ...]:
        """See Driver."""
        check_headings(nodes, self._abilities, self._turns_there)
        legs = self._graph.legs(nodes, edges)
        check_deviations(nodes, self._graph.place, self._abilities)
        if pose is not None and legs:
            self._approach(legs[0].edge, pose)
        return legs

    def _approach(self, first: int, pose: Pose) -> Tuple[int, ...]:
        """Edges before the first one of an order, which begins within the deviation of its first
        node. Raises NotDrivable."""
        return self._graph.approach(first, pose, self._abilities.passing, self._abilities.corridor)

    def _turns_there(self, _: int, node: Node) -> bool:
        """An end vertex has a heading; a robot that may not turn elsewhere takes it there."""
        vertex = self._graph.vertex(node)
        if vertex is None or not self._graph.graph.is_end_vertex(vertex.id):
            return False
        signed = self._graph.graph.edges_from(vertex.id)[0]
        taken = vertex.theta if signed > 0 else vertex.theta + math.pi
        wanted = heading_of(node, self._abilities)
        return wanted is None or has_heading(node, wanted, taken)

    def is_at(self, node: Node, pose: Pose) -> bool:
        """See Driver."""
        return is_within(node, self._graph.place(node), pose, self._matching.near)

    def node_at(self, pose: Pose) -> str:
        """See Driver."""
        return self._graph.node_at(pose)

    def knows(self, node_id: str, pose: Pose) -> bool:
        """See Driver."""
        return self._graph.knows(node_id) or bool(self._graph.node_at(pose))

    # --- driving ----------------------------------------------------------------------------------

    def begin(self) -> None:
        """See Driver."""
        before = self.drive_state
        self._memory.drive = RouteDrive(
            rest_since=before.rest_since, next_id=before.next_id, stop=before.stop,
            stopped_at=before.stopped_at, sent_at=before.sent_at,
            waiting_since=before.waiting_since)

    def drive(self, first: int, legs: Sequence[Leg], now: float) -> None:
        """See Driver. First the robot stops, where it was told to."""
        drive = self.drive_state
        settled = drive.stopped_at is not None and now >= drive.stopped_at + SETTLING
        if drive.failure or not legs or drive.restarted_at is not None or (
                drive.stop is not None and not settled):
            return
        route, edges = drive.route, tuple(leg.edge for leg in legs)
        if route is None or route.lost:
            self._begin(first, edges, now)
            return
        edges = route.edges[:first - route.first] + edges
        if edges != route.edges:
            self._follow(replace(route, edges=edges, complete=False), now)

    def _begin(self, first: int, edges: Tuple[int, ...], now: float) -> None:
        before: Tuple[int, ...] = ()
        if first == 0 and self._pose is not None:
            with suppress(NotDrivable):  # the robot's side says what it knows better
                before = self._approach(edges[0], self._pose)
        self._follow(SentRoute(self._new_id(), before + edges, first - len(before)), now)

    def _follow(self, route: SentRoute, now: float) -> None:
        self._set(route=replace(route, epoch=self._epoch), stop=None, stopped_at=None,
                  waiting_since=now)
        self._send(now)

    def halt(self, now: float) -> None:
        """See Driver."""
        if self.drive_state.stop is None and not self.drive_state.at_rest:
            self.stop(now)

    def stop(self, now: float) -> None:
        """See Driver."""
        drive = self.drive_state
        if drive.stop is None or drive.stopped_at is not None:
            self._set(route=None, stop=self._new_id(), stopped_at=None, waiting_since=now,
                      restarted_at=None)
        self._send(now)

    def _new_id(self) -> int:
        number = self.drive_state.next_id
        self._set(next_id=number % LARGEST_ID + 1)
        return number

    def _send(self, now: float) -> None:
        drive = self.drive_state
        if drive.stop is not None:
            self._commands.append(RouteCommand(drive.stop, ()))
        elif drive.route is not None:
            self._commands.append(RouteCommand(drive.route.id, drive.route.edges,
                                               drive.route.epoch))
        self._set(sent_at=now)

    # --- hearing ----------------------------------------------------------------------------------

    def see(self, robot: RobotView, now: float) -> None:
        """See Driver. A stop is obeyed once the robot is known to stand after it."""
        self._epoch, self._pose = robot.epoch, robot.pose
        at = self.drive_state.stopped_at
        if at is not None and robot.stands and min(now, robot.seen_at) >= at + SETTLING:
            self._set(stop=None, stopped_at=None, rest_since=at)

    def on_report(self, report: RouteReport, now: float) -> None:
        """What execution_route_states tells."""
        drive = self.drive_state
        if drive.stop is not None and report.route_id == drive.stop:
            at = None if report.reason else drive.stopped_at or now
            self._set(stopped_at=at, waiting_since=now if at is None else None)
        if drive.route is None or drive.route.lost:
            self._catch_up(report)
        if drive.route is not None and report.route_id == drive.route.id:
            self._on_route_report(drive.route, report, now)
        elif drive.route is not None and not drive.route.lost:
            self._on_other_report(drive.route, now)

    def _on_other_report(self, route: SentRoute, now: float) -> None:
        if route.complete:  # others may use the robot now
            self._set(route=None)
        elif self.drive_state.restarted_at is not None:
            self._fail('the adapter was restarted, and the robot does not drive its route any more',
                       now)
        elif route.taken:
            self._fail('the robot drives another route', now)

    def _on_route_report(self, route: SentRoute, report: RouteReport, now: float) -> None:
        done = report.states.count(EdgeState.COMPLETE)
        failed = EdgeState.FAILED in report.states
        leg = self._memory.leg(route.first + done)
        along = leg.length * report.percentage / 100.0 if leg and report.edge == leg.edge else 0.0
        self._set_passed(route.first + done, along)
        if route.lost:
            if route.unwanted and not failed and done < len(report.states):
                self.stop(now)
            return
        if self.drive_state.restarted_at is not None:  # what it lacks was not sent any more
            self._set(restarted_at=None, waiting_since=now)
        taken, complete = len(report.states), done == len(route.edges)
        if (taken, complete) != (route.taken, route.complete):
            self._set(route=replace(route, taken=taken, complete=complete),
                      **({'rest_since': now} if complete else {}))
        if failed:
            self._fail(report.reason.text or 'the route failed', now)
        elif taken == len(route.edges) and self.drive_state.waiting_since is not None:
            self._set(waiting_since=None)

    def on_refused(self, refused_id: int, edges: Tuple[int, ...], reason: Reason,
                   now: float) -> None:
        """What route_refused tells. A route that was driven to its end cannot be made longer where
        the robot is elsewhere since: what is left is a route of its own."""
        route, drive = self.drive_state.route, self.drive_state
        if route is None or route.lost or (refused_id, edges) != (route.id, route.edges):
            return
        if (reason.code is ReasonCode.STARTS_ELSEWHERE and route.taken
                and drive.passed == route.first + route.taken):
            self._begin(drive.passed, edges[route.taken:], now)
            return
        self._fail(reason.text or 'the route was refused', now,
                   unwanted=route.taken > 0 and reason.code not in _NOT_OURS)

    def _set_passed(self, passed: int, along: float) -> None:
        before = self.drive_state
        if passed == before.passed:
            along = max(along, before.along)
        if passed >= before.passed and (passed, along) != (before.passed, before.along):
            self._set(passed=passed, along=along)

    def _catch_up(self, report: RouteReport) -> None:
        """A robot that was stopped may have rolled on to a vertex, or past it onto the next leg."""
        drive = self.drive_state
        here, ahead = (self._memory.leg(drive.passed + step) for step in (0, 1))
        if here is None or not report.edge:
            return
        is_past = (ahead is not None and abs(report.edge) == abs(ahead.edge)
                   and abs(report.edge) != abs(here.edge))
        if is_past or not drive.failure and self._is_at_end(here, report):
            self._set_passed(drive.passed + 1, 0.0)

    def _is_at_end(self, leg: Leg, report: RouteReport) -> bool:
        """From where the robot's side takes no route over the leg any more."""
        place = self._graph.place_on(report.edge, report.percentage)
        return place is not None and math.dist(place, (leg.x, leg.y)) <= self._abilities.passing

    def _fail(self, reason: str, now: float, unwanted: bool = False) -> None:
        route = self.drive_state.route
        if route is not None:
            self._set(route=replace(route, lost=True, unwanted=unwanted), waiting_since=None)
        self._set(failure=reason, restarted_at=None, rest_since=now)

    def tick(self, now: float) -> None:
        """See Driver."""
        drive = self.drive_state
        if drive.restarted_at is not None:
            if now - drive.restarted_at > RESTART_PATIENCE:
                self._fail('nothing was heard of the route since the adapter was restarted', now)
        elif drive.waiting_since is not None and now - drive.sent_at >= REPEAT:
            if drive.stop is None and now - drive.waiting_since > PATIENCE:
                self.stop(now)  # should it take the route up after all
                self._fail('the robot does not answer to its route', now)
            else:
                self._send(now)

    def restart(self, now: float) -> None:
        """See Driver. Nothing is sent before the robot's side was heard, but a stop that is owed.
        """
        drive = self.drive_state
        self._set(next_id=max(drive.next_id, self._first_id), stopped_at=None, rest_since=now,
                  waiting_since=None)
        if drive.stop is not None:
            self._set(waiting_since=now)
            self._send(now)
        elif not drive.at_rest:
            self._set(restarted_at=now)
