"""An AGV obeys the route protocol, under all orders and events."""
from __future__ import annotations

import math
from random import Random
from typing import List, Optional, Tuple

from agv_builders import TICK, vehicle_at
from fleet_builders import random_graph
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from route_protocol.values import EdgeState, Reason, ReasonCode, RouteOrder, RouteReport
from trajectory_graph import split_edges

COMPLETE, FAILED = EdgeState.COMPLETE, EdgeState.FAILED


class ObedientAgv(RuleBasedStateMachine):
    """A fleet manager that sends right and wrong orders, and checks reports and motion."""

    @initialize(seed=st.integers(0, 2 ** 32), vertices=st.integers(2, 6))
    def build(self, seed: int, vertices: int) -> None:
        self.random = Random(seed)
        self.graph = split_edges(random_graph(self.random, vertices, vertices, 3.0), 0.8)
        self.vehicle = vehicle_at(self.random.choice(list(self.graph.vertices)), self.graph)
        self.next_id, self.stamp = 1, 0
        self.last: RouteReport = self.vehicle.report()
        self.order: Optional[RouteOrder] = None

    # --- orders -----------------------------------------------------------------------------------

    @rule(length=st.integers(1, 5))
    def order_another_route_from_here(self, length: int) -> None:
        self._order(self._new_id(), self._walk((), length))

    @rule(length=st.integers(0, 5))
    def order_a_route_that_goes_on(self, length: int) -> None:
        left = [edge for edge, state in zip(self.last.edges, self.last.states)
                if state is not COMPLETE]
        self._order(self._new_id(), self._walk(tuple(left[:1]), length))

    @precondition(lambda self: self.last.edges)
    @rule(length=st.integers(1, 5))
    def make_the_route_longer(self, length: int) -> None:
        self._order(self.last.route_id, self._walk(self.last.edges, length))

    @precondition(lambda self: self.last.edges)
    @rule(length=st.integers(1, 5))
    def leave_out_what_is_done(self, length: int) -> None:
        self._order(self.last.route_id, self._walk(self.last.edges[-1:], length))

    @precondition(lambda self: self.last.edges)
    @rule(more=st.integers(0, 2), ticks=st.integers(0, 25), another=st.booleans())
    def make_the_route_shorter(self, more: int, ticks: int, another: bool) -> None:
        self.wait(ticks)
        done = self._done(self.last)
        if another:
            self._order(self._new_id(), self.last.edges[done:done + more])
        else:
            self._order(self.last.route_id, self.last.edges[:done + more])

    @rule(edges=st.lists(st.integers(-9, 9), min_size=1, max_size=4), new=st.booleans())
    def order_anything(self, edges: List[int], new: bool) -> None:
        self._order(self._new_id() if new else self.last.route_id or 1, tuple(edges))

    @rule()
    def stop(self) -> None:
        self._order(self._new_id(), ())

    @precondition(lambda self: self.order)
    @rule()
    def order_the_same_again(self) -> None:
        before = self.vehicle.report()
        self.vehicle.handle(self.order)
        if self.order.is_stop:
            assert self.vehicle.report().epoch != before.epoch, (
                'each stop without a number ends what is on its way')
        elif (self.order.route_id, self.order.edges) == (before.route_id, before.edges):
            assert self.vehicle.new_messages() == []
        self._listen()

    # --- events
    # ---------------------------------------------------------------------------------------

    @rule(ticks=st.integers(1, 80))
    def wait(self, ticks: int) -> None:
        for _ in range(ticks):
            before, speed = self.vehicle.pose, self.vehicle.drive.speed
            self.stamp += 1
            self.vehicle.advance(TICK, self.stamp)
            self._listen()
            x, y, _ = self.vehicle.pose
            fastest = max(speed, self.vehicle.drive.speed) + 0.5 * TICK
            assert math.dist(before[:2], (x, y)) <= fastest * TICK + 1e-3, 'the AGV jumped'
            self._check_report()

    @rule(seconds=st.floats(0.5, 5.0))
    def stall(self, seconds: float) -> None:
        self.vehicle.stall(seconds)

    @rule()
    def fail(self) -> None:
        self.vehicle.fail(Reason(ReasonCode.OTHER, 'a broken belt'))
        self._listen()

    # --- invariants
    # -----------------------------------------------------------------------------------

    @invariant()
    def what_it_reports_is_true(self) -> None:
        if hasattr(self, 'vehicle'):
            self._check_report()

    def _check_report(self) -> None:
        report = self.vehicle.report()
        assert len(report.states) == len(report.edges)
        done = self._done(report)
        assert all(state is not COMPLETE for state in report.states[done:])
        pose = report.pose
        curve = self.graph.curve(pose.edge)
        place = curve.point_at(curve.length * pose.percentage / 100.0)
        # at most 99.9 % are reported before an edge is complete
        allowed = 1e-3 + curve.length * 0.001
        assert math.dist(place, self.vehicle.pose[:2]) <= allowed, (
            'the AGV is not at its reported place')
        if report.edges and FAILED not in report.states:
            assert pose.edge == report.edges[min(done, len(report.edges) - 1)]
            assert (pose.percentage == 100.0) == (done == len(report.edges))
        if self.vehicle.running:
            left = sum(self.graph.curve(edge).length for edge in report.edges[done:])
            left -= self.vehicle.drive.arc
            needed = self.vehicle.drive.speed ** 2 / (2 * 0.5)
            assert needed <= left + 0.01, 'the AGV cannot stop in time'
        if report.edges == self.last.edges and report.route_id == self.last.route_id:
            assert done >= self._done(self.last), 'a COMPLETE edge is no longer COMPLETE'
            if FAILED in self.last.states:
                assert report.states == self.last.states
            elif pose.edge == self.last.pose.edge and done == self._done(self.last) < len(
                    report.edges) and FAILED not in report.states:
                assert pose.percentage >= self.last.pose.percentage
        self.last = report

    def _order(self, route_id: int, edges: Tuple[int, ...]) -> None:
        before = self.vehicle.report()
        running, waited = self.vehicle.running, self.vehicle._intake.waiting
        self.order = RouteOrder(route_id, edges)
        self.vehicle.handle(self.order)
        messages = self.vehicle.new_messages()
        after = self.vehicle.report()
        refusals = [message for message in messages if not isinstance(message, RouteReport)]
        if (route_id, edges) == (before.route_id, before.edges):
            assert messages == [] or not edges
        elif refusals:
            assert [(one.route_id, one.edges) for one in refusals] == [(route_id, edges)]
            assert all(one.reason for one in refusals)
            assert (after.route_id, after.edges, after.states) == (
                before.route_id, before.edges, before.states), 'a refusal changed the route'
            assert self.vehicle.running == running
            told = [message for message in messages if isinstance(message, RouteReport)]
            goes_on = bool(before.edges) and route_id == before.route_id
            assert [one.route_id for one in told] == ([] if goes_on else [route_id])
            assert all(set(one.states) == {FAILED} for one in told)
        elif self.vehicle._intake.waiting is None or not edges:
            assert (messages[0].route_id, messages[0].edges) == (route_id, edges), (
                'the first report with its id acknowledges a route')
            kept = before.edges[:self._done(before) + 1]
            assert not edges or route_id != before.route_id or edges[:len(kept)] == kept, (
                'a changed route lacks an edge that is complete or being driven')
        else:
            assert not running and waited is not self.vehicle._intake.waiting, (
                'only a braking vehicle may delay an order')
        self.last = after

    def _listen(self) -> None:
        for message in self.vehicle.new_messages():
            if isinstance(message, RouteReport) and message.route_id != self.last.route_id:
                self.last = message
        self.last = self.vehicle.report()

    @staticmethod
    def _done(report: RouteReport) -> int:
        return next((index for index, state in enumerate(report.states) if state is not COMPLETE),
                    len(report.states))

    def _new_id(self) -> int:
        self.next_id += 1
        return self.next_id

    def _walk(self, edges: Tuple[int, ...], length: int) -> Tuple[int, ...]:
        """Returns a connected walk. It begins with `edges`, or if there are none, at the AGV's
        place.
        """
        drive = self.vehicle.drive
        if edges:
            at = self.graph.end_vertex(edges[-1]).id
        elif drive.vertex is not None:
            at = drive.vertex
        else:
            edges = (self.random.choice((drive.edge, -drive.edge)),)
            at = self.graph.end_vertex(edges[-1]).id
        walk = list(edges)
        for _ in range(length):
            open_edges = self.graph.edges_from(at)
            onwards = [edge for edge in open_edges if walk and edge != -walk[-1]]
            walk.append(self.random.choice(onwards * 4 + list(open_edges)))
            at = self.graph.end_vertex(walk[-1]).id
        return tuple(walk)


TestObedientAgv = ObedientAgv.TestCase
TestObedientAgv.settings = settings(stateful_step_count=30, deadline=None,
                                    max_examples=settings.default.max_examples * 3 // 5)
