"""Drives an order as one route over the trajectory graph, and extends it when the base grows.

The driver uses the route protocol: it sends routes of signed edge ids, and receives the states of
all edges. An extension has the id of the route that it extends, so the robot does not brake.
"""
from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Optional, Sequence, Tuple

from trajectory_graph import Graph
from trajectory_graph.order_rules import MAXIMUM_EDGES
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

REPEAT = 1.0           # s; a route is sent again after this time without an acknowledgement
PATIENCE = 10.0        # s; a route must be acknowledged within this time
RESTART_PATIENCE = 25.0  # s; the robot's side must report within this time after our restart
LARGEST_ID = 2 ** 31 - 1
# Refusals because another program or person drives the robot. This driver must not stop it then.
_NOT_OURS = (ReasonCode.TAKEN_OVER, ReasonCode.OVERRULED, ReasonCode.EMERGENCY_STOP)


@dataclass(frozen=True)
class RouteDrive(Drive):
    """The memory of the route driver.

    route         -- the last route that was sent; None after the robot has obeyed a stop
    stop          -- id of a stop that the robot has perhaps not obeyed yet
    stopped_at    -- s; time of the acknowledgement of the stop
    waiting_since -- s; the driver waits for an acknowledgement since then
    restarted_at  -- s; time of a restart after which the route was not reported yet
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
    """See the module's docstring. `first_id` is the id of the first route."""

    longest = MAXIMUM_EDGES - 1  # a route may begin with an edge that leads to the order

    def __init__(self, memory: Memory, graph: Graph, abilities: Abilities, matching: Matching,
                 first_id: int = 1) -> None:
        super().__init__(memory, RouteDrive(next_id=first_id))
        self._graph = OrderGraph(graph, matching)
        self._matching = matching
        self._abilities = abilities
        self._first_id = first_id
        self._epoch = 0  # the robot's present epoch
        self._pose: Optional[Pose] = None

    # --- planning ---------------------------------------------------------------------------------

    def use_graph(self, graph: Graph) -> None:
        """Uses another graph for planning from now on."""
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
        """Returns the edges that the robot drives before the first edge of an order.

        The robot may be anywhere within the deviation of the first node. Raises NotDrivable.
        """
        return self._graph.approach(first, pose, self._abilities.passing, self._abilities.corridor)

    def _turns_there(self, _: int, node: Node) -> bool:
        """Returns whether the robot has the required heading at a node.

        Only an end vertex has a heading: the robot turns to it there. At other vertices it may not
        turn.
        """
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
        """See Driver; after a stop it waits until the robot has stopped."""
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
            with suppress(NotDrivable):  # the robot's side knows more and refuses if necessary
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

    # --- reports ----------------------------------------------------------------------------------

    def see(self, robot: RobotView, now: float) -> None:
        """See Driver; a stop counts as obeyed when the robot is known to stand after it."""
        self._epoch, self._pose = robot.epoch, robot.pose
        at = self.drive_state.stopped_at
        if at is not None and robot.stands and min(now, robot.seen_at) >= at + SETTLING:
            self._set(stop=None, stopped_at=None, rest_since=at)

    def on_report(self, report: RouteReport, now: float) -> None:
        """Evaluates a message of execution_route_states."""
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
        if route.complete:  # another program may use the robot now
            self._set(route=None)
        elif self.drive_state.restarted_at is not None:
            self._fail('the adapter was restarted, and the robot no longer drives its route', now)
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
        if self.drive_state.restarted_at is not None:  # send the edges that were perhaps not sent
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
        """Evaluates a message of route_refused.

        A route that the robot has driven to its end cannot be extended if the robot has moved
        since then. In that case the driver sends the remaining edges as a new route.
        """
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
        """Updates the progress: a stopped robot may have rolled to a vertex or past it."""
        drive = self.drive_state
        here, ahead = (self._memory.leg(drive.passed + step) for step in (0, 1))
        if here is None or not report.edge:
            return
        is_past = (ahead is not None and abs(report.edge) == abs(ahead.edge)
                   and abs(report.edge) != abs(here.edge))
        if is_past or not drive.failure and self._is_at_end(here, report):
            self._set_passed(drive.passed + 1, 0.0)

    def _is_at_end(self, leg: Leg, report: RouteReport) -> bool:
        """Returns whether the robot is so near to the leg's end that its side refuses the leg."""
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
                self._fail('the robot has not reported the route since the adapter was restarted',
                           now)
        elif drive.waiting_since is not None and now - drive.sent_at >= REPEAT:
            if drive.stop is None and now - drive.waiting_since > PATIENCE:
                self.stop(now)  # in case the robot begins the route after all
                self._fail('the robot does not acknowledge its route', now)
            else:
                self._send(now)

    def restart(self, now: float) -> None:
        """See Driver; until the robot's side reports, only an owed stop is sent."""
        drive = self.drive_state
        self._set(next_id=max(drive.next_id, self._first_id), stopped_at=None, rest_since=now,
                  waiting_since=None)
        if drive.stop is not None:
            self._set(waiting_since=now)
            self._send(now)
        elif not drive.at_rest:
            self._set(restarted_at=now)
