"""The fleet manager's side of the route protocol, for one robot: orders out, reports in.

What the robot holds by them is its record; a route is a part of that, under an id.
"""
from __future__ import annotations

from typing import Callable, Optional, Sequence

from graph_fleet_manager.supervision.ordered_routes import OrderedRoutes
from graph_fleet_manager.supervision.orders import Heard, Order, Sending, is_on
from graph_fleet_manager.supervision.reports import Place, Report, place_of
from graph_fleet_manager.supervision.route_record import RouteRecord
from trajectory_graph.route_protocol import Reason, ReasonCode, RouteRefusal

NEW_ID_AFTER = 50  # edges
_OVERTAKEN = 10.0  # s: a report that is older than the last by more tells of a clock set back
_SAID_NONE = Reason(ReasonCode.OTHER, 'it gave no reason')

NewId = Callable[[], int]
"""Gives a route id that was never used."""


class RouteClient(OrderedRoutes):
    """Orders routes, repeats what is not acknowledged, and follows the reports on a record."""

    def __init__(self, record: RouteRecord) -> None:
        super().__init__(record)
        self._awaits_report = False
        self._refused_at = 0.0  # by the robot's clock: reports of before do not tell what it has
        self._cut_refused = 0  # number behind the last edge of a shorter route that it refused
        self._stamp = 0.0

    @property
    def is_ready(self) -> bool:
        """May it be given more? Not while it is being shortened, or after a refusal."""
        return not self._awaits_report and (self.order is None or not self._is_shorter(self.order))

    # -- orders -----------------------------------------------------------------------------------

    def extend(self, edges: Sequence[int], new_id: NewId, renew: bool = False) -> None:
        """Lets the robot drive more edges; `renew`: under a new id, as for another mission."""
        if renew or self.over or self.record.end - self._bases[self.route_id] >= NEW_ID_AFTER:
            self._begin(new_id())
        self.record.append(edges)
        self._order_until(self.record.end)

    def shorten(self, new_id: NewId) -> bool:
        """Asks the robot to stop at the end of its edge; tells whether it may drive farther.

        Where it refuses, as it cannot brake in time, at the end of the next one.
        """
        if self.is_new_motion and self.record.told <= self.record.done:
            self.record.cut(self.record.done)  # it was never told of all this
            self._pending.drop()
            self.over = True
        if len(self.record.ahead) <= 1:
            return False
        if self._awaits_report or (self.order is not None and self._is_shorter(self.order)):
            return True
        end = max(self.record.done, self._cut_refused) + 1
        if end >= self.record.end:
            return True
        if self.over or self.order is not None:  # a report of before that order is no answer
            self._begin(new_id())
        self._order_until(end, takes_away=True)
        return True

    def halt(self, new_id: NewId) -> None:
        """Stops the robot wherever it is; what it holds stays its own until `settle`."""
        self._begin(new_id())
        self.over = True
        self._awaits_report = False
        self._pending.give(Order(self.route_id, self.record.done, ()), True)

    def try_again(self, new_id: NewId, count: int) -> None:
        """Orders once more, under a new id, so many of the edges ahead: an emergency stop kept the
        robot from driving them, or a restart from hearing of them."""
        self._begin(new_id())
        self._pending.give(Order(self.route_id, self.record.done, self.record.ahead[:count]))
        self.to_order_anew = 0

    def withdraw(self) -> None:
        """What the robot may not have heard yet is not ordered any more; a stop is."""
        self.over = True
        if self.order is not None and not self.is_stopping:
            self._withdrawn = self.order.route_id
            self._pending.drop()

    def drives_withdrawn(self, report: Report) -> bool:
        """Does the robot drive what was withdrawn, as it was under way already?"""
        return (report.is_running and report.route_id == self._withdrawn
                and not self.is_stopping)

    def settle(self, place: Optional[Place]) -> None:
        """The robot stands here, and holds nothing else any more."""
        self._ended = {*self._bases, self.route_id}
        self._bases = {}
        self.record.settle(place)
        self.over = True
        self._pending.drop()
        self._awaits_report = False

    def due(self, now: float) -> Optional[Sending]:
        """The order to send now, if there is one."""
        sending = None if self._awaits_report else self._pending.due(now)
        if sending is not None and self.order is not None:
            self.record.told = max(self.record.told, self.order.end)
        return sending

    def _order_again(self) -> None:
        """Repeats the order before a restart."""
        end = self.record.end if self._ordered is None else self._ordered
        if self._bases[self.route_id] < self.record.first:
            self.to_order_anew = end - self.record.first
        else:
            self._order_until(end)

    # -- after a restart --------------------------------------------------------------------------

    def adopt(self, report: Report) -> None:
        """The first report after a restart, to be taken next: what it has not driven is fixed.

        An order that may still be under way to the robot is repeated until it is acknowledged; to
        one that has obeyed a stop nothing is under way.
        """
        base = self._bases.get(report.route_id)
        if base is None:
            if report.route_id in self._ended:
                if self.record.ahead and self.route_id in self._bases and not self.is_stopping:
                    self._order_again()  # it did not reach the robot
            elif not self.record.ahead and is_on(self.record.graph, report.left):
                self._adopt_other(report)
            # In any other case `take` finds that the robot was taken over, or lost its route.
        else:
            self._acknowledged.add(report.route_id)
            has_stopped = report.route_id == self.route_id and not report.edges
            if report.is_failed or has_stopped or self.is_stopping or (
                    self.route_id not in self._bases):  # it was refused, so nothing is under way
                return
            end = base + len(report.edges)
            if self._ordered is not None or self.record.end > end or (
                    report.route_id != self.route_id):
                self._order_again()

    def _adopt_other(self, report: Report) -> None:
        """A route of which nothing is known here; a stop that is under way stays so.

        Of what is driven the graph may have lost edges: it does not count.
        """
        self.record.adopt(report.left)
        self._bases = {self.route_id: self.record.done} if self.order is not None else {}
        self._bases[report.route_id] = self.record.first - report.completed
        self._acknowledged.add(report.route_id)
        if self.order is None:
            self.route_id = report.route_id
            self.over = not report.is_running or report.completed > 0
        if not report.is_running:
            # One that is off the graph now is still nearest to where it was.
            self.record.place = place_of(report.pose, self.record.graph) or self.record.place

    # -- what the robot says ----------------------------------------------------------------------

    def take(self, report: Report) -> Heard:
        """Follows a report."""
        heard, record = Heard(), self.record
        if 0.0 < self._stamp - report.stamp < _OVERTAKEN:
            return heard
        self._stamp = report.stamp
        self._reported = report.route_id
        record.see(report.pose)
        awaited = self._awaits_report and not (
            0.0 < self._refused_at - report.stamp < _OVERTAKEN)
        is_known = report.route_id in self._bases
        if awaited and report.route_id != self.route_id and (is_known or not report.is_running):
            self._take_truth(report)
            awaited = False
        if not is_known:
            if report.is_running:
                heard.foreign = report.route_id not in self._ended
                return heard
            if report.route_id not in self._ended and (
                    self.order is None or self.route_id in self._acknowledged):
                self._forgotten(heard)
            if self.order is None:
                heard.left = record.is_standing and record.has_left()
            return heard
        base = self._bases[report.route_id]
        skipped = max(record.first - base, 0)
        mine = record.part(base + skipped, base + len(report.edges))
        if mine != report.edges[skipped:]:
            heard.foreign = report.is_running
            return heard
        if report.is_failed and report.completed == 0 and (
                report.route_id not in self._acknowledged
                and not (awaited and report.stamp != self._refused_at)):
            return self.refuse(RouteRefusal(report.route_id, report.edges, report.reason))
        self._acknowledged = {id for id in self._acknowledged if id in self._bases}
        self._acknowledged.add(report.route_id)
        if report.route_id:
            # It has taken up a route: who now tells of none, or of one before, has forgotten it.
            self._bases.pop(0, None)
            self._ended.clear()
        if awaited:
            self._take_truth(report)
        self._acknowledge(report)
        heard.passed = record.complete(base + report.completed)
        if report.is_running or record.is_standing:  # else a person may drive it back again
            record.leave(report.age)
        # What belongs to a route that may still be reported is kept.
        record.forget(min([*self._bases.values(), *([self.order.base] if self.order else [])]))
        if report.is_failed:
            self.withdraw()
            heard.failed = report.reason or _SAID_NONE
        elif record.is_standing and self.order is None:
            heard.left = record.has_left()
        return heard

    def _forgotten(self, heard: Heard) -> None:
        """It was switched off and on: it would drive an extended route from its beginning."""
        self._pending.drop()
        self.over = True
        if self.record.ahead:
            heard.failed = Reason(ReasonCode.OTHER, 'it has forgotten its route')

    def refuse(self, refusal: RouteRefusal, stamp: float = 0.0) -> Heard:
        """The robot did not take up an order: the next report tells what it really drives.

        stamp -- s, when it refused, by its clock: what it reported before may come later; 0: with
                 the last report
        """
        heard = Heard()
        if self.order is not None and (refusal.route_id, refusal.edges) == (
                self.order.route_id, self.order.edges):
            heard.was_shorter = self._pending.takes_away
            if heard.was_shorter:
                self._cut_refused = self.order.end
            self._pending.drop()
            self._awaits_report, self._refused_at = True, stamp or self._stamp
            heard.refused = refusal.reason or _SAID_NONE
        return heard

    def keep_after_refusal(self) -> None:
        """What was refused stays the robot's: it is to be ordered again."""
        self._awaits_report = False
        self.over = True

    def _take_truth(self, report: Report) -> None:
        """After a refusal: the robot holds what it reports, and nothing else of what was ordered.

        It stands somewhere on what has failed. Another order needs another id.
        """
        self._awaits_report = False
        self.over = True
        base = self._bases.get(report.route_id)
        end = self.record.done if base is None else base + len(report.edges)
        self.record.cut(min(max(end, self.record.done), self.record.end))
        if base is not None:
            self._bases = {report.route_id: base}

    def _acknowledge(self, report: Report) -> None:
        order = self.order
        if order and report.route_id == order.route_id and len(report.edges) == len(order.edges):
            self._pending.drop()
            if order.edges and self._is_shorter(order):
                self.record.cut(order.end)
