"""The fleet manager's side of the route protocol for one robot: it orders and reads reports.

The edges that the robot was ordered to drive are its route record. A route is the part of the
record from its *base* on, under one id. The record and the evidence in the reports result in the
robot's allocation.
"""
from __future__ import annotations

import math
from typing import Callable, Dict, Optional, Sequence, Set, Tuple

from graph_fleet_manager.geometry.areas import Area
from graph_fleet_manager.interlocking.allocation import Allocation, Hold, Knowledge
from graph_fleet_manager.interlocking.evidence import Evidence
from graph_fleet_manager.interlocking.orders import Base, Heard, Memory, Order, Sending, is_on
from graph_fleet_manager.interlocking.pending_order import PendingOrder
from graph_fleet_manager.interlocking.reports import (
    AT_VERTEX,
    TREMBLE,
    GraphPosition,
    Pose,
    Report,
    is_overtaken,
    point_of,
    position_of,
)
from graph_fleet_manager.interlocking.route_record import RouteRecord
from route_protocol.values import Reason, ReasonCode, RouteRefusal

NEW_ID_AFTER = 50  # number of edges in a route after which the next order gets a new id
_SAID_NONE = Reason(ReasonCode.OTHER, 'it gave no reason')

NewId = Callable[[], int]
"""Returns a route id that was never used."""


class RouteClient:
    """Orders routes, repeats unacknowledged orders, and updates the route record from reports.

    It also keeps the evidence of the robot's place. `allocation` combines the record and the
    evidence. Only the interlocking extends a route.
    """

    def __init__(self, record: RouteRecord) -> None:
        self.record = record
        self.evidence = Evidence(record.kind, record.stopping)
        self.route_id = 0
        self.over = True
        """The last route cannot be extended: the next one needs another id."""
        self.to_order_anew = 0
        """Number of edges ordered before a restart, on a route that cannot be repeated."""
        self._pending = PendingOrder()
        self._epoch = 0  # epoch of the robot's motion, as last reported
        # base of each route by id, in the order in which they were given
        self._bases: Dict[int, Base] = {}
        self._acknowledged: Set[int] = set()
        self._since_loss: Set[int] = set()
        """Ids of the routes that were given after the robot lost edges of its record."""
        self._ended: Set[int] = set()
        self.withdrawn: Optional[int] = None
        """Id of an order that was withdrawn, but may still reach the robot."""
        # end of the order before a restart, if it was shorter than the record
        self._ordered: Optional[int] = None
        self._awaits_report = False
        # by the robot's clock; earlier reports do not show what the robot drives after the refusal
        self._refused_at = 0.0
        # number behind the last edge of a shorter route that the robot refused
        self._cut_refused = 0
        self._stamp = 0.0
        self.is_heard = False
        """Has the robot reported since the start?"""
        self.is_doubted = False
        """The stored place may be an old one, and the robot has not reported its place since."""
        self._allocation: Optional[Allocation] = None

    # -- state ------------------------------------------------------------------------------------

    @property
    def order(self) -> Optional[Order]:
        """The order that is not acknowledged yet."""
        return self._pending.order

    @property
    def is_stopping(self) -> bool:
        """Was the robot told to stop, and has not answered yet?"""
        return self._pending.is_stop

    @property
    def is_new_motion(self) -> bool:
        """Does the order let the robot drive, and was it never sent?"""
        return self._pending.is_new_motion

    @property
    def takes_away(self) -> bool:
        """Does the order stop the robot, or shorten its route?"""
        return self._pending.takes_away

    @property
    def is_ready(self) -> bool:
        """May the robot be given more? Not while its route is shortened, nor after a refusal."""
        return not self._awaits_report and (self.order is None or not self._is_shorter(self.order))

    @property
    def clock_is_off(self) -> bool:
        """Is the robot's clock so far ahead that the age of its locations is not known?"""
        return self.evidence.clock_is_off

    @property
    def allocation(self) -> Allocation:
        """All places that the robot may occupy or still reach. A new object whenever it changes."""
        if self._allocation is None:
            self._allocation = self._allocated()
        return self._allocation

    @property
    def is_by_evidence(self) -> bool:
        """Does anything except grants determine where the robot may be?"""
        return bool(self.evidence.areas or self.evidence.foreign) or (
            self.record.position is not None and self.record.position.vertex is None)

    @property
    def progress(self) -> Tuple[object, ...]:
        """The part of the state that must be stored as soon as a report changes it."""
        record = self.record
        return (record.done, record.end, record.generation, record.tail, self.over,
                self.is_stopping, self.evidence.progress)

    def _allocated(self) -> Allocation:
        record, evidence = self.record, self.evidence
        if evidence.is_absent:
            return Allocation(record.kind, Knowledge.ABSENT)
        areas, holds = list(evidence.areas), record.holds(self._turns_back_to)
        standing = None if record.ahead else record.position
        if standing is not None and standing.vertex is None:
            areas.append(Area((standing.point(record.graph),)))
        holds += tuple(Hold(edge) for edge in evidence.foreign if abs(edge) in record.graph.edges)
        is_known = bool(holds or areas or standing is not None) and not self.is_doubted
        return Allocation(record.kind, Knowledge.KNOWN if is_known else Knowledge.UNKNOWN, holds,
                          standing.vertex if standing is not None else None, tuple(areas))

    @property
    def _turns_back_to(self) -> Optional[int]:
        """Number of the edge to which an unacknowledged order under a new id may lead back.

        The record may pass the beginning of that order's route again. The robot may already be
        there when the order arrives. It then takes the order as one for the next round.
        """
        return min((base.number for id, base in self._bases.items()
                    if id not in self._acknowledged and self._returns(base)), default=None)

    def turns_back_if_renewed(self, renew: bool) -> bool:
        """Would an order of more edges under a new id let the robot turn back?

        renew -- the order needs a new id in any case
        """
        record = self.record
        return self._needs_new_id(renew) and self._returns(Base(record.done, record.end))

    def _returns(self, base: Base) -> bool:
        """Does the record come back to a route's beginning on edges that need not this route?"""
        record = self.record
        begin = max(base.number, record.first)
        first, *later = record.part(begin, min(base.before, record.end)) or (0,)
        return any(abs(edge) == abs(first) or record.graph.end_vertex(edge).id
                   == record.graph.start_vertex(first).id for edge in later)

    def _changed(self) -> None:
        self._allocation = None

    # -- routes and their ids ---------------------------------------------------------------------

    def _begin(self, route_id: int, is_driving: bool = True) -> None:
        """Begins a route with the edge that is being driven.

        is_driving -- the robot may drive the edges ahead of it before it takes up this route
        """
        self._changed()
        done = self.record.done
        self._bases[route_id] = Base(done, self.record.end if is_driving else done)
        if self.evidence.lost:
            self._since_loss.add(route_id)
        self.route_id = route_id
        self.over = False
        self.withdrawn = None

    def _order_until(self, end: int, takes_away: bool = False) -> None:
        """Orders the record up to edge number `end`, from the base of the route."""
        base = self._bases[self.route_id].number
        self._pending.give(Order(self.route_id, base, self.record.part(base, end)), takes_away,
                           self._epoch)

    def _is_shorter(self, order: Order) -> bool:
        return order.end < self.record.end

    # -- orders -----------------------------------------------------------------------------------

    def extend(self, edges: Sequence[int], new_id: NewId, renew: bool = False) -> None:
        """Lets the robot drive more edges; `renew`: under a new id (for another mission)."""
        self._changed()
        if self._needs_new_id(renew):
            self._begin(new_id())
        self.record.append(edges)
        self._order_until(self.record.end)

    def _needs_new_id(self, renew: bool) -> bool:
        return renew or self.over or (
            self.record.end - self._bases[self.route_id].number >= NEW_ID_AFTER)

    def shorten(self, new_id: NewId) -> bool:
        """Asks the robot to stop at the end of its edge. Returns whether it may drive farther.

        If the robot refuses because it cannot brake in time, the next call asks it to stop at the
        end of the following edge.
        """
        self._changed()
        if self.is_new_motion and self.record.told <= self.record.done:
            self.record.cut(self.record.done)  # the robot was never told of these edges
            self._pending.drop()
            self.over = True
            if self.record.has_left():  # the record had covered its location only by these edges
                self.evidence.uncover()
        if len(self.record.ahead) <= 1:
            return False
        if not self.is_heard or self._awaits_report or (
                self.order is not None and self._is_shorter(self.order)):
            return True
        end = max(self.record.done, self._cut_refused) + 1
        if end >= self.record.end:
            return True
        # a report from before that order must not count as its acknowledgement
        if self.over or self.order is not None:
            self._begin(new_id())
        self._order_until(end, takes_away=True)
        return True

    def halt(self, new_id: NewId) -> None:
        """Stops the robot wherever it is. It keeps its allocation until `settle`."""
        self._begin(new_id(), is_driving=False)  # a stop leads nowhere
        self.over = True
        self._awaits_report = False
        self._pending.give(Order(self.route_id, self.record.done, ()), True)

    def try_again(self, new_id: NewId, count: int, has_stopped: bool = False) -> None:
        """Orders `count` of the edges ahead once more, under a new id.

        It is used after an emergency stop kept the robot from driving them, or after a restart lost
        their order.

        has_stopped -- the robot has reported that it does not drive these edges now
        """
        is_heard = all(id in self._acknowledged for id in self._bases)
        self._begin(new_id(), is_driving=not (has_stopped and is_heard))
        self._pending.give(Order(self.route_id, self.record.done, self.record.ahead[:count]),
                           known_epoch=self._epoch)
        self.to_order_anew = 0

    def withdraw(self) -> None:
        """Stops ordering what the robot may not have received yet, except a stop."""
        self.over = True
        if self.is_stopping:
            return
        is_unheard = self.route_id in self._bases and self.route_id not in self._acknowledged
        if self.order is not None or is_unheard:
            self.withdrawn = self.route_id
        self._pending.drop()

    def drives_withdrawn(self, report: Report) -> bool:
        """Does the robot drive a withdrawn order, because it was on its way already?"""
        return (report.is_running and report.route_id == self.withdrawn
                and not self.is_stopping)

    def settle(self, position: Optional[GraphPosition]) -> None:
        """The robot stands at this position and holds nothing else."""
        self._changed()
        self.evidence.settle()
        self._ended = {*self._bases, self.route_id}
        self._bases = {}
        self.record.settle(position)
        self.over = True
        self._pending.drop()
        self._awaits_report = False

    def settle_beside(self, position: GraphPosition) -> None:
        """The robot begins its next route at this position, but may stand a little beside it."""
        self.settle(position)
        here = self.evidence.location
        if here is not None and math.dist(here, position.point(self.record.graph)) > AT_VERTEX:
            self.evidence.uncover()

    def due(self, now: float) -> Optional[Sending]:
        """The order to send now, if there is one."""
        sending = None if self._awaits_report else self._pending.due(now)
        if sending is not None and self.order is not None:
            self.record.told = max(self.record.told, self.order.end)
        return sending

    def _order_again(self) -> None:
        """Repeats the order that was given before a restart, unless it was withdrawn since."""
        if self.withdrawn == self.route_id:
            return
        end = self.record.end if self._ordered is None else self._ordered
        if self._bases[self.route_id].number < self.record.first:
            self.to_order_anew = end - self.record.first
        else:
            self._order_until(end)

    # -- after a restart --------------------------------------------------------------------------

    def _adopt(self, report: Report) -> None:
        """Compares the first report after a restart with the restored record.

        An order that may still be on its way to the robot is repeated until it is acknowledged.
        Nothing is on its way to a robot that has obeyed a stop.
        """
        base = self._bases.get(report.route_id)
        if base is None:
            if report.route_id in self._ended:
                if self.record.ahead and self.route_id in self._bases and not self.is_stopping:
                    self._order_again()  # the last order did not reach the robot
            elif not self.record.ahead and is_on(self.record.graph, report.left):
                self._adopt_other(report)
            # In any other case `take` finds that another giver took the robot over, or that it lost
            # its route.
        elif (report.route_id == self.route_id and base.number >= self.record.first
                and self._may_be_refusal(report)):
            if not self.is_stopping:
                self._order_again()  # another copy, or a longer order, may be on its way
        else:
            self._acknowledged.add(report.route_id)
            has_stopped = report.route_id == self.route_id and not report.edges
            if report.is_failed or has_stopped or self.is_stopping or (
                    # the last order was refused, so none is on its way
                    self.route_id not in self._bases):
                return
            end = base.number + len(report.edges)
            if self._ordered is not None or self.record.end > end or (
                    report.route_id != self.route_id):
                self._order_again()

    def _adopt_other(self, report: Report) -> None:
        """Takes over a route of which nothing is known here. A stop on its way stays in force.

        Edges that are already driven do not count: the graph may not have them any more.
        """
        self.record.adopt(report.left)
        self._bases = {report.route_id: Base(self.record.first - report.completed,
                                             self.record.end)}
        if self.order is not None:
            self._bases[self.route_id] = Base(self.record.done, self.record.end)
        self._acknowledged.add(report.route_id)
        if self.order is None:
            self.route_id = report.route_id
            self.over = not report.is_running or report.completed > 0
        if not report.is_running:
            # A robot that is off the graph now is still nearest to the position where it was.
            record = self.record
            record.position = position_of(report.pose, record.graph, record.near) or record.position

    # -- reports ----------------------------------------------------------------------------------

    def take(self, report: Report) -> Heard:
        """Updates the record and the evidence from a report, and returns the results."""
        if is_overtaken(report.stamp, self._stamp):
            return Heard()
        self._changed()
        is_new = report.stamp > self._stamp or not report.stamp
        self._stamp, self._epoch = report.stamp, report.epoch
        if not self.is_heard:
            self.is_heard = True
            self._adopt(report)
        record = self.record
        record.pose = report.pose
        if record.position is None and record.is_standing:
            record.position = position_of(report.pose, record.graph, record.near)
        heard = self._follow(report, is_new)
        is_covered = self._covers(report)
        drives = report.is_running or bool(heard.passed and not report.is_failed)
        heard.is_located = self.evidence.see(
            report, record.graph, is_covered, not heard.foreign, drives and not heard.foreign,
            is_covered and bool(record.ahead))
        self.is_doubted &= not heard.is_located
        if self.evidence.lost and is_covered and self._is_after_loss(report):
            self.evidence.leave_lost(record.margin(report.age))
        heard.left = (record.is_standing and self.order is None and record.has_left()
                      and self.evidence.is_confirmed
                      and not (heard.failed or heard.foreign or heard.refused))
        return heard

    def _is_after_loss(self, report: Report) -> bool:
        """Is it impossible that an order from before the loss of edges still reaches the robot?

        Orders arrive in the sequence of their sending, and the robot has acknowledged a later one.
        """
        return report.route_id in self._since_loss

    def _follow(self, report: Report, is_new: bool) -> Heard:
        """The results of a report about routes. `is_new`: its location is later than the last one.
        """
        heard, record = Heard(), self.record
        awaited = self._awaits_report and not is_overtaken(report.stamp, self._refused_at)
        is_known = report.route_id in self._bases
        if awaited and report.route_id != self.route_id and (is_known or not report.is_running):
            self._take_truth(report)
            awaited = False
        if not is_known:
            if report.is_running:
                heard.foreign = report.route_id not in self._ended
            elif report.route_id not in self._ended and (
                    self.order is None or self.route_id in self._acknowledged):
                self._forgotten(heard)
            return heard
        base = self._bases[report.route_id].number
        skipped = max(record.first - base, 0)
        mine = record.part(base + skipped, base + len(report.edges))
        if mine != report.edges[skipped:] or report.is_running and report.completed < skipped:
            heard.foreign = report.is_running
            return heard
        is_later = not report.stamp or report.stamp != self._refused_at
        if self._may_be_refusal(report) and not (awaited and is_later):
            return self.refuse(RouteRefusal(report.route_id, report.edges, report.reason))
        is_taken_up = report.route_id in self._acknowledged or not report.is_failed
        self._acknowledged = {id for id in self._acknowledged if id in self._bases}
        self._acknowledged.add(report.route_id)
        if report.route_id:
            # The robot has taken up a route. If it later reports no route, or an earlier one, it
            # has forgotten this route.
            given = list(self._bases)
            for before in given[:given.index(report.route_id)]:
                del self._bases[before]
            self._ended.clear()
        if awaited:
            self._take_truth(report, is_taken_up)
        number = base + report.completed
        if is_new and report.edges and record.first <= number < record.done:
            record.turn_back(number)
        heard.passed = record.complete(number)
        self._acknowledge(report)
        # otherwise a person may drive the robot back again
        if report.is_running or record.is_standing:
            record.leave(report.age)
        # Edges of a route that may still be reported are kept.
        record.forget(min([*(base.number for base in self._bases.values()),
                           *([self.order.base] if self.order else [])]))
        if report.is_failed:
            self.withdraw()
            heard.failed = report.reason or _SAID_NONE
        return heard

    def _may_be_refusal(self, report: Report) -> bool:
        """May a failed route mean that the robot has refused it, and has never taken it up?"""
        return (report.is_failed and report.completed == 0
                and report.route_id not in self._acknowledged)

    def _covers(self, report: Report) -> bool:
        """Is the robot within its record, as exactly as it follows its edges?"""
        record, pose = self.record, report.pose
        if not pose.edge:
            return False
        position = None if record.ahead else record.position
        if position is not None and (
                position.distance(record.graph, pose) <= record.near + TREMBLE):
            return True
        holds = sorted(record.holds(), key=lambda hold: abs(hold.edge) != abs(pose.edge))
        # the check is cheapest on the robot's own edge
        return any(self._is_on(hold, pose) for hold in holds)

    def _is_on(self, hold: Hold, pose: Pose) -> bool:
        """Is a pose on the part of an edge that is not cleared, as exactly as the robot follows it?

        A robot that strays reports the nearest edge, which may be another edge.
        """
        graph, play = self.record.graph, self.record.kind.play
        curve = graph.curve(hold.edge)
        if abs(pose.edge) == abs(hold.edge):
            fraction = pose.fraction if pose.edge == hold.edge else 1.0 - pose.fraction
            return (hold.cleared - fraction) * curve.length <= TREMBLE
        nearest = curve.project(*point_of(graph, pose))
        return (nearest.distance <= 2.0 * play + TREMBLE
                and hold.cleared * curve.length - nearest.arc_length <= TREMBLE)

    def _forgotten(self, heard: Heard) -> None:
        """The robot has lost its routes, for example because it was switched off and on.

        It would drive an extended route from its beginning.
        """
        if self.record.ahead:  # a copy of its order may be on the way, and would begin it anew
            self._acknowledged.clear()
            self._bases = {id: base._replace(before=self.record.end)
                           for id, base in self._bases.items()}
        self.withdraw()
        if self.record.ahead:
            heard.failed = Reason(ReasonCode.OTHER, 'it has forgotten its route')

    def refuse(self, refusal: RouteRefusal, stamp: float = 0.0) -> Heard:
        """The robot refused an order. The next report shows what it really drives.

        stamp -- time of the refusal, in s by the robot's clock; an earlier report may arrive later;
                 0: the time of the last report
        """
        heard = Heard()
        self._changed()
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
        """The robot keeps the refused edges. They are to be ordered again."""
        self._awaits_report = False
        self.over = True

    def _take_truth(self, report: Report, is_taken_up: bool = True) -> None:
        """After a refusal: cuts the record to what the robot reports.

        The robot stands somewhere on the failed part. The next order needs another id. If the robot
        never took up the reported route, it may have refused that one, too, and drive the route
        before it. Then the record is not cut.
        """
        self._awaits_report = False
        self.over = True
        base = self._bases.get(report.route_id)
        end = self.record.done if base is None else base.number + len(report.edges)
        if is_taken_up:
            self.record.cut(min(max(end, self.record.done), self.record.end))
        if base is not None:
            self._bases = {report.route_id: base}

    def _acknowledge(self, report: Report) -> None:
        order = self.order
        if order and report.route_id == order.route_id and len(report.edges) == len(order.edges):
            self._pending.drop()
            if order.edges and self._is_shorter(order):
                self.record.shorten(order.end, report.age)

    # -- storing and restoring --------------------------------------------------------------------

    @property
    def memory(self) -> Memory:
        """The state for `restore` after a restart. It must be stored before an order is sent."""
        record = self.record
        bases = {id: base.moved(-record.first) for id, base in self._bases.items()}
        number, fraction = record.begin_of_holds(self._turns_back_to)
        return Memory(self.route_id, tuple(record.edges), record.done - record.first, bases,
                      record.position, self.over, tuple(sorted(self._ended)), self.is_stopping,
                      self._shortened, (number - record.first, fraction),
                      record.tail, self.evidence.memory, self._stamp, self.withdrawn,
                      tuple(sorted(self._acknowledged)))

    @property
    def _shortened(self) -> Optional[int]:
        order = self.order
        if order is None or not order.edges or not self._is_shorter(order):
            return None
        return order.end - self.record.first

    def restore(self, memory: Memory, now: float = 0.0) -> None:
        """Sets the state from before a restart. The robot may hold all of its edges."""
        self._changed()
        self.route_id, self._bases = memory.route_id, dict(memory.bases)
        self.over, self._ended = memory.over, set(memory.ended)
        self._acknowledged = set(memory.acknowledged)
        self.record.restore(memory.edges, memory.done, memory.position, memory.cleared,
                            memory.tail)
        self.evidence.restore(memory.evidence, now)
        self._ordered, self._stamp = memory.shortened, memory.stamp
        self.withdrawn = memory.withdrawn
        if memory.is_stopping:
            self._since_loss.add(self.route_id)
            self._pending.give(Order(self.route_id, self.record.done, ()), True)

    def doubt(self) -> None:
        """The restored state is that of an old journal: until it is located, it may be anywhere."""
        self.is_doubted, self.evidence.is_absent = True, False
        self._changed()

    def knows(self, route_id: int) -> bool:
        """Was the robot given this route, as far as is known here?"""
        return route_id == self.route_id or route_id in self._bases or route_id in self._ended

    # -- other evidence ---------------------------------------------------------------------------

    def grow(self, age: float) -> bool:
        """Grows the allocation of a robot that another giver moves. Returns whether it grew.

        age -- s since its last location
        """
        grows = self.evidence.grow(age)
        if grows:
            self._changed()
        return grows

    def lose(self, areas: Sequence[Area]) -> None:
        """Adds areas that the robot held on edges which the graph in force does not have."""
        self.evidence.lose(tuple(areas))
        if self.is_stopping:
            self._since_loss.add(self.route_id)
        self._changed()

    def stop_after_loss(self, new_id: NewId) -> None:
        """Stops a robot that should stand and that may be on lost areas.

        The lost areas become free when the robot has acknowledged the stop.
        """
        if self.evidence.lost and self.record.is_standing and not self.is_stopping:
            self.halt(new_id)

    def declare_absent(self, now: float) -> None:
        """A person declares that the robot is not on the site."""
        self.settle(None)
        self.is_doubted = False
        self.evidence.declare_absent(now)

    def is_back(self, report: Report, now: float) -> bool:
        """Ends the absence of a robot if its location was taken later. Returns whether it does."""
        if not (self.evidence.is_absent and self.evidence.is_back(report, now)):
            return False
        self.evidence.is_absent = False
        self._changed()
        return True
