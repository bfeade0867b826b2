"""Drives an order as one route over the trajectory graph, made longer as its base grows.

What it says and hears is the route protocol: routes of signed edge ids in, states of every edge
out. An extension has the id of the route that it extends, so the robot does not brake for it.
"""
from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, Dict, Optional, Sequence, Tuple

from trajectory_graph import Graph
from trajectory_graph.route_protocol import EdgeState, Reason
from vda5050_vehicle.drivers.driver import Driver, Leg, Pose, Progress
from vda5050_vehicle.drivers.order_fields import (
    Abilities,
    check_deviations,
    check_headings,
    has_heading,
    heading_of,
    is_within,
)
from vda5050_vehicle.drivers.order_graph import Matching, OrderGraph
from vda5050_vehicle.drivers.route_messages import (
    RouteCommand,
    RouteReport,
    SentRoute,
)
from vda5050_vehicle.protocol.values import Edge, Node

REPEAT = 1.0           # s between two sendings of what nobody has acknowledged
PATIENCE = 10.0        # s until somebody must have
SETTLING = 1.0         # s from the acknowledgement of a stop to a robot that may be seen to stand
RESTART_PATIENCE = 25.0  # s in which the robot's side must be heard after our restart
LARGEST_ID = 2 ** 31 - 1


class RouteDriver(Driver):
    """See the module's text. `first_id` is the id of the first route; later ones count on."""

    def __init__(self, graph: Graph, abilities: Abilities, matching: Matching,
                 first_id: int = 1) -> None:
        super().__init__()
        self._graph = OrderGraph(graph, matching)
        self._matching = matching
        self._abilities = abilities
        self._next_id = first_id
        self._route: Optional[SentRoute] = None
        self._legs: Dict[int, Leg] = {}       # by number, from the one being driven on
        self._stop: Optional[int] = None      # id of a stop that is not acknowledged
        self._stopped_at: Optional[float] = None  # when it was
        self._sent_at = -math.inf
        self._waiting_since = math.inf        # for an acknowledgement
        self._refused: Optional[Tuple[int, ...]] = None  # edges of an extension tried under its id
        self._restarted: Optional[float] = None

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
        return legs

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
        self._route = self._restarted = None
        self._legs = {}
        self.progress = Progress(halted=self._stop is None)

    def drive(self, first: int, legs: Sequence[Leg], now: float) -> None:
        """See Driver."""
        if self._restarted is not None or self.progress.failure or not legs:
            return
        if self._stop is not None or not self.progress.halted and self._route is None:
            return  # first the robot stops, as it was told to
        route, edges = self._route, tuple(leg.edge for leg in legs)
        if route is None:
            self._begin(first, edges, now)
        else:
            whole = route.edges[:first - route.first] + edges
            if whole == route.edges:
                return
            self._route = replace(route, edges=whole)
            self._send(now)
        self._legs.update(enumerate(legs, first))
        self.progress = replace(self.progress, halted=False, complete=False)

    def _begin(self, first: int, edges: Tuple[int, ...], now: float) -> None:
        self._route = SentRoute(self._new_id(), edges, first)
        self._send(now)

    def halt(self, now: float) -> None:
        """See Driver."""
        if self._stop is not None or self._route is None or self.progress.complete:
            return
        self._restarted = None
        self._route = None
        self._stop = self._new_id()
        self._stopped_at = None
        self.progress = replace(self.progress, halted=False, complete=False)
        self._send(now)

    def forgive(self) -> None:
        """See Driver."""
        self.progress = replace(self.progress, failure='')

    def _new_id(self) -> int:
        number = self._next_id
        self._next_id = number % LARGEST_ID + 1
        return number

    def _send(self, now: float, again: bool = False) -> None:
        if self._stop is not None:
            self._commands.append(RouteCommand(self._stop, ()))
        elif self._route is not None:
            self._commands.append(RouteCommand(self._route.id, self._route.edges))
        self._sent_at = now
        if not again:
            self._waiting_since = now

    # --- hearing ----------------------------------------------------------------------------------

    def on_report(self, report: RouteReport, now: float) -> None:
        """What execution_route_states tells."""
        self._check_restart(report)
        if self._stop is not None:
            self._on_stop_report(report, now)
        elif self._route is not None:
            self._on_route_report(self._route, report, now)
        else:
            self._catch_up(report)

    def _on_stop_report(self, report: RouteReport, now: float) -> None:
        if report.route_id == self._stop and not report.reason and self._stopped_at is None:
            self._stopped_at = now
        self._catch_up(report)

    def _on_route_report(self, route: SentRoute, report: RouteReport, now: float) -> None:
        if report.route_id != route.id:
            if self.progress.complete:  # somebody else may use the robot now
                self._route = None
                self.progress = replace(self.progress, halted=True)
            elif route.seen:
                self._fail('the robot drives another route')
            return
        self._route = replace(route, seen=True)
        if self._refused == route.edges:  # its own id was refused: what is left, under another
            self._begin_anew(route, report, now)
            return
        done = report.states.count(EdgeState.COMPLETE)
        passed = route.first + done
        leg = self._legs.get(passed)
        along = leg.length * report.percentage / 100.0 if leg and report.edge == leg.edge else 0.0
        self._set_passed(passed, along)
        if EdgeState.FAILED in report.states:
            self._fail(report.reason.text or 'the route failed')
        elif len(report.states) == len(route.edges):
            self._waiting_since = math.inf
            self.progress = replace(self.progress, complete=done == len(route.edges))

    def _begin_anew(self, route: SentRoute, report: RouteReport, now: float) -> None:
        done = report.states.count(EdgeState.COMPLETE)
        self._set_passed(route.first + done, 0.0)
        self._begin(route.first + done, route.edges[done:], now)

    def on_refused(self, refused_id: int, edges: Tuple[int, ...], reason: Reason,
                   now: float) -> None:
        """What route_refused tells. An extension is tried once more, as a route of its own."""
        route = self._route
        if route is None or refused_id != route.id or edges != route.edges:
            return
        if route.seen and self._refused != edges:
            self._refused = edges
            return
        if route.seen:
            self.halt(now)
        self._fail(reason.text or 'the route was refused')

    def _set_passed(self, passed: int, along: float) -> None:
        before = self.progress
        if passed == before.passed:
            along = max(along, before.along)
        if passed >= before.passed:
            self.progress = replace(before, passed=passed, along=along)
            self._legs = {number: leg for number, leg in self._legs.items() if number >= passed}

    def _catch_up(self, report: RouteReport) -> None:
        """A robot that was stopped may have rolled on to a vertex, or past it onto the next leg."""
        here, ahead = (self._legs.get(self.progress.passed + step) for step in (0, 1))
        if here is None or not report.edge:
            return
        is_past = (ahead is not None and abs(report.edge) == abs(ahead.edge)
                   and abs(report.edge) != abs(here.edge))
        if is_past or not self.progress.failure and self._is_at_end(here, report):
            self._set_passed(self.progress.passed + 1, 0.0)

    def _is_at_end(self, leg: Leg, report: RouteReport) -> bool:
        """From where the robot's side takes no route over the leg any more."""
        place = self._graph.place_on(report.edge, report.percentage)
        return place is not None and math.dist(place, (leg.x, leg.y)) <= self._abilities.passing

    def _fail(self, reason: str) -> None:
        self._route = None
        self._waiting_since = math.inf
        self.progress = replace(self.progress, failure=reason, halted=self._stop is None,
                                complete=False)

    def tick(self, now: float) -> None:
        """See Driver."""
        if self._stop is not None and self._stopped_at is not None:
            if now - self._stopped_at >= SETTLING:
                self._stop = self._stopped_at = None
                self._waiting_since = math.inf
                self.progress = replace(self.progress, halted=True)
        elif self._restarted is not None:
            if now - self._restarted > RESTART_PATIENCE:
                self._restarted = None
                self._fail('nothing was heard of the route since the adapter was restarted')
        elif self._waiting_since < math.inf and now - self._sent_at >= REPEAT:
            if self._stop is None and now - self._waiting_since > PATIENCE:
                self.halt(now)  # should it take the route up after all
                self._fail('the robot does not answer to its route')
            else:
                self._send(now, again=True)

    # --- restarts ---------------------------------------------------------------------------------

    @property
    def record(self) -> Dict[str, Any]:
        """See Driver."""
        route = self._route
        return {'next_id': self._next_id, 'stop': self._stop,
                'passed': self.progress.passed, 'failure': self.progress.failure,
                'route': route and {'id': route.id, 'first': route.first,
                                    'edges': list(route.edges)}}

    def restore(self, record: Dict[str, Any], now: float) -> None:
        """See Driver. Nothing is sent before the robot's side was heard, but a stop that is owed.
        """
        route = record['route'] and SentRoute(
            int(record['route']['id']), tuple(map(int, record['route']['edges'])),
            int(record['route']['first']))
        self._next_id = max(int(record['next_id']), self._next_id)
        self._stop = record['stop']
        self.progress = Progress(int(record['passed']), failure=str(record['failure']))
        if self._stop is not None:
            self.progress = replace(self.progress, halted=False, complete=False)
            self._send(now)
        elif route is not None and self.progress.passed < route.first + len(route.edges):
            self._route = route  # one that was driven to its end is over
            self._restarted = now
            self.progress = replace(self.progress, halted=False, complete=False)

    def know_legs(self, first: int, legs: Sequence[Leg]) -> None:
        """See Driver."""
        self._legs = dict(enumerate(legs, first))

    def _check_restart(self, report: RouteReport) -> None:
        route = self._route
        if self._restarted is None or route is None:
            return
        self._restarted = None
        if report.route_id != route.id:
            self._fail('the adapter was restarted, and the robot does not drive its route any more')
            return
        self._route = replace(route, seen=True)
