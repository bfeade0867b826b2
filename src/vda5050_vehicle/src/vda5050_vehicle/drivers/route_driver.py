"""Drives an order as one route over the trajectory graph, and extends it when the base grows.

The driver is a master of the route protocol. `route_protocol.master` says what the robot may still
do because of earlier orders, when the next order may be given, and which order is repeated. The
driver knows which edges of the route record are the legs of the VDA order: the edges of the record
are numbered, and `origin` is the number of leg 0.

    | the report                                          | the consequence                     |
    |-----------------------------------------------------|-------------------------------------|
    | shows edges as driven                               | these legs are passed               |
    | shows that a route of these legs is lost or refused | a failure: a master must decide     |
    | has a new epoch while the robot has a route         | a failure: a master must decide     |
    | has a new epoch of another giver during a stop      | a failure: a master must decide     |
    | has a new epoch of another giver at another time    | `epoch` changes, without a failure  |
    | shows an order that is not in the journal           | the robot is stopped                |
"""
from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Callable, Optional, Sequence, Tuple

from route_protocol.master import (
    REPEAT,
    MasterState,
    News,
    Order,
    give_route,
    give_stop,
    hear,
    label_of,
    next_number,
)
from route_protocol.order_rules import MAXIMUM_EDGES
from route_protocol.values import EdgeState, EpochCause, RouteReport, SymbolicPose
from trajectory_graph import Graph
from vda5050_protocol.values import OrderEdge, OrderNode
from vda5050_vehicle.drivers.driver import DriveProgress, Driver, DriverMemory, Leg, NotDrivable
from vda5050_vehicle.drivers.order_fields import (
    Abilities,
    check_deviations,
    check_headings,
    has_heading,
    heading_of,
    is_within,
)
from vda5050_vehicle.drivers.order_graph import Matching, OrderGraph
from vda5050_vehicle.drivers.robot_view import RobotPose, RobotSnapshot

ME = 'vda5050_vehicle'
"""The name of this master in its orders."""
PATIENCE = 25.0  # s until a robot that does not answer has failed; a bridge restarts in 20 s
# After an epoch with a cause that is not listed here, the robot does not know its orders any more.
_BY_OTHERS = (EpochCause.OTHER_GIVER, EpochCause.STOP, EpochCause.CANCEL, EpochCause.OTHER_CLIENT,
              EpochCause.ROBOT, EpochCause.EMERGENCY_STOP, EpochCause.OTHER_MASTER)


@dataclass(frozen=True)
class RouteDrive(DriveProgress):
    """The memory of the route driver.

    protocol -- what the robot may still do because of the orders of this adapter
    origin   -- number of leg 0 in the route record, for the last route of these legs; None: no leg
                was ordered yet
    """

    protocol: MasterState = MasterState()
    origin: Optional[int] = None

    @property
    def at_rest(self) -> bool:
        """See DriveProgress."""
        known = self.protocol
        return not (known.may_drive or known.is_stopping or known.unknown)

    @property
    def in_order(self) -> bool:
        """See DriveProgress."""
        return self.at_rest and not self.failure

    @property
    def route(self) -> Optional[Order]:
        """The route of these legs, if it is in force or was driven to its end; otherwise None."""
        return None if self.origin is None else self.protocol.farthest


class RouteDriver(Driver[RouteDrive]):
    """See the module's docstring. `clock` returns ms since 1970.

    The class has the methods of `Driver`, and `on_report`.
    """

    longest = MAXIMUM_EDGES - 1  # a route may begin with an edge that leads to the order

    def __init__(self, memory: DriverMemory, graph: Graph, abilities: Abilities, matching: Matching,
                 clock: Callable[[], int]) -> None:
        super().__init__(memory, RouteDrive())
        self._graph = OrderGraph(graph, matching)
        self._matching = matching
        self._abilities = abilities
        self._clock = clock
        self._pose: Optional[RobotPose] = None
        self._is_heard = False  # the robot has reported since the start
        self._given_at = self._sent_at = -math.inf

    # --- planning ---------------------------------------------------------------------------------

    def use_graph(self, graph: Graph) -> None:
        """Uses another graph for planning from now on."""
        self._graph = OrderGraph(graph, self._matching)

    def plan(self, nodes: Sequence[OrderNode], edges: Sequence[OrderEdge],
             pose: Optional[RobotPose]) -> Tuple[Leg, ...]:
        """See Driver."""
        check_headings(nodes, self._abilities, self._turns_there)
        legs = self._graph.legs(nodes, edges)
        check_deviations(nodes, self._graph.place, self._abilities)
        if pose is not None and legs:
            self._approach(legs[0].edge, pose)
        return legs

    def _approach(self, first: int, pose: RobotPose) -> Tuple[int, ...]:
        """Returns the edges that the robot drives before the first edge of an order.

        The robot may be anywhere within the deviation of the first node. Raises NotDrivable.
        """
        return self._graph.approach(first, pose, self._abilities.passing, self._abilities.corridor)

    def _turns_there(self, _: int, node: OrderNode) -> bool:
        """Returns whether the robot has the required heading at a node.

        Only an end vertex has a heading, and the robot turns to this heading there. At other
        vertices the robot may not turn.
        """
        vertex = self._graph.vertex(node)
        if vertex is None or not self._graph.graph.is_end_vertex(vertex.id):
            return False
        signed = self._graph.graph.edges_from(vertex.id)[0]
        taken = vertex.theta if signed > 0 else vertex.theta + math.pi
        wanted = heading_of(node, self._abilities)
        return wanted is None or has_heading(node, wanted, taken)

    def is_at(self, node: OrderNode, pose: RobotPose) -> bool:
        """See Driver."""
        return is_within(node, self._graph.place(node), pose, self._matching.near)

    def node_at(self, pose: RobotPose) -> str:
        """See Driver."""
        return self._graph.node_at(pose)

    def knows(self, node_id: str, pose: RobotPose) -> bool:
        """See Driver."""
        return self._graph.knows(node_id) or bool(self._graph.node_at(pose))

    # --- driving ----------------------------------------------------------------------------------

    def begin(self) -> None:
        """See Driver."""
        self._set(passed=0, along=0.0, failure='', origin=None)

    def drive(self, first: int, legs: Sequence[Leg], now: float) -> None:
        """See Driver; after a stop it waits until the robot has reported that it stands."""
        drive, known = self.drive_state, self.drive_state.protocol
        if drive.failure or not legs or not self._is_heard:
            return
        if not known.commands and not known.is_stopping:
            self.stop(now)  # after this stop, the robot counts the orders of this master
        elif known.is_ready:
            self._order(first, tuple(leg.edge for leg in legs), now)

    def _order(self, first: int, edges: Tuple[int, ...], now: float) -> None:
        """Orders these legs if this changes the route; `first` is the number of the first leg."""
        drive, known, number = self.drive_state, self.drive_state.protocol, self._next_number()
        route, origin, label = drive.route, drive.origin, label_of(number)
        if route is not None and origin is not None:
            edges = known.ahead[:max(origin + first - known.done, 0)] + edges
            label = route.route_id
        else:
            before = self._way_to(edges[0]) if first == 0 else ()
            edges, origin = before + edges, known.done + len(before) - first
        if edges != known.ahead:
            self._set(origin=origin)
            self._give(give_route(known, number, edges, label), now)

    def _way_to(self, first: int) -> Tuple[int, ...]:
        with suppress(NotDrivable):  # the robot's side knows more and refuses if necessary
            return () if self._pose is None else self._approach(first, self._pose)
        return ()

    def halt(self, now: float) -> None:
        """See Driver."""
        known = self.drive_state.protocol
        if known.ahead and not known.is_stopping:
            self.stop(now)

    def stop(self, now: float) -> None:
        """See Driver."""
        known, number = self.drive_state.protocol, self._next_number()
        if known.is_stopping:  # the new stop replaces the open one
            known = replace(known, open=known.open[:-1])
        self._give(give_stop(known, number, label_of(number)), now)

    def _next_number(self) -> int:
        known = self.drive_state.protocol
        return next_number(known, self._clock())

    def _give(self, protocol: MasterState, now: float) -> None:
        self._set(protocol=protocol)
        self._given_at = now
        self._send(now)

    def _send(self, now: float) -> None:
        self._commands.append(self.drive_state.protocol.pending)
        self._sent_at = now

    # --- reports ----------------------------------------------------------------------------------

    def robot_seen(self, robot: RobotSnapshot, now: float) -> None:
        """See Driver; only `on_report` decides whether the robot stands."""
        self._pose = robot.pose

    def on_report(self, said: RouteReport, now: float) -> None:
        """Evaluates a report. Raises WrongReport."""
        before = self.drive_state
        protocol, news = hear(before.protocol, said, ME, self._clock(),
                              said.location is not None or said.pose.edge != 0)
        if not news.is_new:
            return
        self._is_heard = True
        self._set(protocol=protocol, stands=news.stands)
        if before.origin is not None and before.route is not None and news.cause is None:
            self._set_passed(protocol.done - before.origin)
        elif self.drive_state.route is None and before.origin is not None:
            self._catch_up(said.pose)
        self._set_along(said.pose)
        if self.drive_state.at_rest and not before.at_rest:
            self._set(rest_since=now)
        self._judge_orders(before, said, news, now)

    def _judge_orders(self, before: RouteDrive, said: RouteReport, news: News, now: float) -> None:
        """Evaluates the consequences of a report for the orders."""
        is_ours = news.cause is EpochCause.OTHER_MASTER and said.master == ME
        by_others = news.cause in _BY_OTHERS and not is_ours
        if by_others or not before.protocol.epoch:
            self._set(epoch=said.epoch)
        if news.is_older:
            self.stop(now)
            if self._memory.leg(before.passed) is not None:
                self._fail('the journal of the adapter is an older one: the robot knows an order '
                           'that is not in it')
        elif news.failed or news.refused:
            self._fail((news.failed or news.refused).text or 'the robot gave no reason')
        elif news.cause is not None:
            self._judge_epoch(before, said, by_others)

    def _judge_epoch(self, before: RouteDrive, said: RouteReport, by_others: bool) -> None:
        """Notes a failure if a new epoch ended a route, or if another giver began the epoch during
        a stop.
        """
        known = before.protocol
        if known.ahead and not known.is_stopping or by_others and not before.at_rest:
            why = said.reason.text if EdgeState.FAILED in said.states else ''
            self._fail(why or ('another program or person has driven or stopped the robot'
                               if by_others else 'the robot does not know its route any more'))

    def _fail(self, reason: str) -> None:
        self._set(failure=reason)

    def _set_passed(self, passed: int) -> None:
        if passed > self.drive_state.passed:
            self._set(passed=passed, along=0.0)

    def _set_along(self, pose: SymbolicPose) -> None:
        drive = self.drive_state
        leg = None if drive.origin is None else self._memory.leg(drive.passed)
        along = leg.length * pose.percentage / 100.0 if leg and pose.edge == leg.edge else 0.0
        if along > drive.along:
            self._set(along=along)

    def _catch_up(self, pose: SymbolicPose) -> None:
        """Updates the progress: a stopped robot may have rolled to a vertex or past it."""
        drive = self.drive_state
        here, ahead = (self._memory.leg(drive.passed + step) for step in (0, 1))
        if here is None or not pose.edge:
            return
        is_past = (ahead is not None and abs(pose.edge) == abs(ahead.edge)
                   and abs(pose.edge) != abs(here.edge))
        if is_past or not drive.failure and self._is_at_end(here, pose):
            self._set_passed(drive.passed + 1)

    def _is_at_end(self, leg: Leg, pose: SymbolicPose) -> bool:
        """Returns whether the robot is so near to the leg's end that the bridge refuses the leg."""
        place = self._graph.place_on(pose.edge, pose.percentage)
        return place is not None and math.dist(place, (leg.x, leg.y)) <= self._abilities.passing

    def tick(self, now: float) -> None:
        """See Driver."""
        known = self.drive_state.protocol
        if known.pending is not None and now - self._sent_at >= REPEAT and (
                self._is_heard or known.is_stopping):
            self._send(now)
        waits = known.pending is not None or not self._is_heard
        if waits and known.ahead and not known.is_stopping and now - self._given_at > PATIENCE:
            self._fail('the robot does not acknowledge its route' if self._is_heard else
                       'the robot has not reported its route since the adapter was restarted')

    def restart(self, now: float) -> None:
        """See Driver; until the robot's side reports, only an owed stop is sent."""
        self._set(rest_since=now)
        self._given_at = now
        if self.drive_state.protocol.is_stopping:
            self._send(now)
