"""The fleet manager's side of the route protocol, for one robot: orders out, reports in.

What the robot holds by them is its route record; a route is a part of that, from its *base* on,
under an id. With what else reports tell they make the robot's allocation.
"""
from __future__ import annotations

from typing import Callable, Dict, Optional, Sequence, Set, Tuple

from graph_fleet_manager.geometry.areas import Area
from graph_fleet_manager.interlocking.allocation import Allocation, Hold, Knowledge
from graph_fleet_manager.interlocking.evidence import Evidence
from graph_fleet_manager.interlocking.orders import Heard, Memory, Order, Sending, is_on
from graph_fleet_manager.interlocking.pending_order import PendingOrder
from graph_fleet_manager.interlocking.reports import (
    TREMBLE,
    GraphPosition,
    Pose,
    Report,
    is_overtaken,
    point_of,
    position_of,
)
from graph_fleet_manager.interlocking.route_record import RouteRecord
from trajectory_graph.route_protocol import Reason, ReasonCode, RouteRefusal

NEW_ID_AFTER = 50  # edges
_SAID_NONE = Reason(ReasonCode.OTHER, 'it gave no reason')

NewId = Callable[[], int]
"""Gives a route id that was never used."""


class RouteClient:
    """Orders routes, repeats what is not acknowledged, and follows the reports on a record."""

    def __init__(self, record: RouteRecord) -> None:
        self.record = record
        self.evidence = Evidence(record.kind)
        self.route_id = 0
        self.over = True
        """The last route cannot be extended: another one needs another id."""
        self.to_order_anew = 0
        """So many edges were under way before a restart, on a route that cannot be repeated."""
        self._pending = PendingOrder()
        self._epoch = 0  # of the robot's motion, as it reported last
        self._bases: Dict[int, int] = {}  # of routes by id, in the order in which they were given
        self._acknowledged: Set[int] = set()
        self._since_loss: Set[int] = set()
        """Ids of routes that were given since the robot has lost edges of its record."""
        self._ended: Set[int] = set()
        self.withdrawn: Optional[int] = None
        """Id of an order that is not given any more, but may reach the robot yet."""
        self._ordered: Optional[int] = None  # before a restart, if it was less than the record
        self._awaits_report = False
        self._refused_at = 0.0  # by the robot's clock: reports of before do not tell what it has
        self._cut_refused = 0  # number behind the last edge of a shorter route that it refused
        self._stamp = 0.0
        self.is_heard = False
        """Has the robot reported since the start?"""
        self._allocation: Optional[Allocation] = None

    # -- what is known ----------------------------------------------------------------------------

    @property
    def order(self) -> Optional[Order]:
        """What is not acknowledged yet."""
        return self._pending.order

    @property
    def is_stopping(self) -> bool:
        """Was it told to stop, without an answer yet?"""
        return self._pending.is_stop

    @property
    def is_new_motion(self) -> bool:
        """Is the order one that was never sent, and lets the robot drive?"""
        return self._pending.is_new_motion

    @property
    def takes_away(self) -> bool:
        """Does the order stop the robot, or cut its route short?"""
        return self._pending.takes_away

    @property
    def is_ready(self) -> bool:
        """May it be given more? Not while it is being shortened, or after a refusal."""
        return not self._awaits_report and (self.order is None or not self._is_shorter(self.order))

    @property
    def clock_is_off(self) -> bool:
        """Is the robot's clock so far ahead that the age of its locations is not known?"""
        return self.evidence.clock_is_off

    @property
    def allocation(self) -> Allocation:
        """All that the robot may occupy or still reach; the same object until that changes."""
        if self._allocation is None:
            self._allocation = self._allocated()
        return self._allocation

    @property
    def is_by_evidence(self) -> bool:
        """Does anything but grants tell where the robot is?"""
        return bool(self.evidence.areas or self.evidence.foreign) or (
            self.record.position is not None and self.record.position.vertex is None)

    @property
    def progress(self) -> Tuple[object, ...]:
        """What of a report must outlive a restart: when it changes, all is to be stored."""
        record = self.record
        return (record.done, record.end, record.generation, record.tail, self.over,
                self.is_stopping, self.evidence.memory._replace(location=None))

    def _allocated(self) -> Allocation:
        record, evidence = self.record, self.evidence
        if evidence.is_absent:
            return Allocation(record.kind, Knowledge.ABSENT)
        areas, holds = list(evidence.areas), record.holds(self._turns_back_to)
        standing = None if record.ahead else record.position
        if standing is not None and standing.vertex is None:
            areas.append(Area((standing.point(record.graph),)))
        holds += tuple(Hold(edge) for edge in evidence.foreign if abs(edge) in record.graph.edges)
        is_known = bool(holds or areas or standing is not None)
        return Allocation(record.kind, Knowledge.KNOWN if is_known else Knowledge.UNKNOWN, holds,
                          standing.vertex if standing is not None else None, tuple(areas))

    @property
    def _turns_back_to(self) -> Optional[int]:
        """Number of the edge to which an order that is under way under a new id may lead back.

        The robot may have driven on by then, to where it takes that order for the next round.
        """
        return min((base for id, base in self._bases.items()
                    if id not in self._acknowledged and self._returns_to(base)), default=None)

    def _returns_to(self, number: int) -> bool:
        """Does the record come back to where one of its edges begins?"""
        record = self.record
        first, *later = record.part(number, record.end) or (0,)
        return any(abs(edge) == abs(first) or record.graph.end_vertex(edge).id
                   == record.graph.start_vertex(first).id for edge in later)

    def _changed(self) -> None:
        self._allocation = None

    # -- routes and their ids ---------------------------------------------------------------------

    def _begin(self, route_id: int) -> None:
        self._bases[route_id] = self.record.done
        if self.evidence.lost:
            self._since_loss.add(route_id)
        self.route_id = route_id
        self.over = False
        self.withdrawn = None

    def _order_until(self, end: int, takes_away: bool = False) -> None:
        """Orders the track up to there, from where the route begins."""
        base = self._bases[self.route_id]
        self._pending.give(Order(self.route_id, base, self.record.part(base, end)), takes_away,
                           self._epoch)

    def _is_shorter(self, order: Order) -> bool:
        return order.end < self.record.end

    # -- orders -----------------------------------------------------------------------------------

    def extend(self, edges: Sequence[int], new_id: NewId, renew: bool = False) -> None:
        """Lets the robot drive more edges; `renew`: under a new id, as for another mission."""
        self._changed()
        if renew or self.over or self.record.end - self._bases[self.route_id] >= NEW_ID_AFTER:
            self._begin(new_id())
        self.record.append(edges)
        self._order_until(self.record.end)

    def shorten(self, new_id: NewId) -> bool:
        """Asks the robot to stop at the end of its edge; tells whether it may drive farther.

        Where it refuses, as it cannot brake in time, at the end of the next one.
        """
        self._changed()
        if self.is_new_motion and self.record.told <= self.record.done:
            self.record.cut(self.record.done)  # it was never told of all this
            self._pending.drop()
            self.over = True
            if self.record.has_left():  # while it was thought to be on what it would be told of
                self.evidence.uncover()
        if len(self.record.ahead) <= 1:
            return False
        if not self.is_heard or self._awaits_report or (
                self.order is not None and self._is_shorter(self.order)):
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
        self._pending.give(Order(self.route_id, self.record.done, self.record.ahead[:count]),
                           known_epoch=self._epoch)
        self.to_order_anew = 0

    def withdraw(self) -> None:
        """What the robot may not have heard yet is not ordered any more; a stop is."""
        self.over = True
        if self.is_stopping:
            return
        is_unheard = self.route_id in self._bases and self.route_id not in self._acknowledged
        if self.order is not None or is_unheard:
            self.withdrawn = self.route_id
        self._pending.drop()

    def drives_withdrawn(self, report: Report) -> bool:
        """Does the robot drive what was withdrawn, as it was under way already?"""
        return (report.is_running and report.route_id == self.withdrawn
                and not self.is_stopping)

    def settle(self, position: Optional[GraphPosition]) -> None:
        """The robot stands here, and holds nothing else any more."""
        self._changed()
        self.evidence.settle()
        self._ended = {*self._bases, self.route_id}
        self._bases = {}
        self.record.settle(position)
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

    def _adopt(self, report: Report) -> None:
        """The first report after a restart: what it has not driven is fixed.

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
        self._bases = {report.route_id: self.record.first - report.completed}
        if self.order is not None:
            self._bases[self.route_id] = self.record.done
        self._acknowledged.add(report.route_id)
        if self.order is None:
            self.route_id = report.route_id
            self.over = not report.is_running or report.completed > 0
        if not report.is_running:
            # One that is off the graph now is still nearest to where it was.
            record = self.record
            record.position = position_of(report.pose, record.graph, record.near) or record.position

    # -- what the robot says ----------------------------------------------------------------------

    def take(self, report: Report) -> Heard:
        """Follows a report."""
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
        self.evidence.see(report, record.graph, is_covered, not heard.foreign)
        if self.evidence.lost and is_covered and self._is_after_loss(report):
            self.evidence.leave_lost(record.margin(report.age))
        heard.left = (record.is_standing and self.order is None and record.has_left()
                      and self.evidence.is_confirmed
                      and not (heard.failed or heard.foreign or heard.refused))
        return heard

    def _is_after_loss(self, report: Report) -> bool:
        """Can no order of before the loss of edges reach the robot any more?

        Orders come in order, and it has acknowledged one that was given since.
        """
        return report.route_id in self._since_loss

    def _follow(self, report: Report, is_new: bool) -> Heard:
        """What a report tells of the routes; `is_new`: it has a later location than the last."""
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
        base = self._bases[report.route_id]
        skipped = max(record.first - base, 0)
        mine = record.part(base + skipped, base + len(report.edges))
        if mine != report.edges[skipped:] or report.is_running and report.completed < skipped:
            heard.foreign = report.is_running
            return heard
        if report.is_failed and report.completed == 0 and (
                report.route_id not in self._acknowledged
                and not (awaited and report.stamp != self._refused_at)):
            return self.refuse(RouteRefusal(report.route_id, report.edges, report.reason))
        is_taken_up = report.route_id in self._acknowledged or not report.is_failed
        self._acknowledged = {id for id in self._acknowledged if id in self._bases}
        self._acknowledged.add(report.route_id)
        if report.route_id:
            # It has taken up a route: one that tells of none, or of one before, has forgotten it.
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
        if report.is_running or record.is_standing:  # else a person may drive it back again
            record.leave(report.age)
        # What belongs to a route that may still be reported is kept.
        record.forget(min([*self._bases.values(), *([self.order.base] if self.order else [])]))
        if report.is_failed:
            self.withdraw()
            heard.failed = report.reason or _SAID_NONE
        return heard

    def _covers(self, report: Report) -> bool:
        """Is the robot where its record has it, as near as it follows its edges?"""
        record, pose = self.record, report.pose
        if not pose.edge:
            return False
        position = None if record.ahead else record.position
        if position is not None and (
                position.distance(record.graph, pose) <= record.near + TREMBLE):
            return True
        holds = sorted(record.holds(), key=lambda hold: abs(hold.edge) != abs(pose.edge))
        return any(self._is_on(hold, pose) for hold in holds)  # its own edge costs least

    def _is_on(self, hold: Hold, pose: Pose) -> bool:
        """Is a pose on what is left of an edge, as near as the robot follows it?

        One that strays is told on the edge that is nearest, which may be another one.
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
        """What was refused stays the robot's: it is to be ordered again."""
        self._awaits_report = False
        self.over = True

    def _take_truth(self, report: Report, is_taken_up: bool = True) -> None:
        """After a refusal: the robot holds what it reports, and nothing else of what was ordered.

        It stands somewhere on what has failed. Another order needs another id. A route that was
        never taken up may have been refused once more, so that the robot drives the one before.
        """
        self._awaits_report = False
        self.over = True
        base = self._bases.get(report.route_id)
        end = self.record.done if base is None else base + len(report.edges)
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

    # -- what outlives a restart ------------------------------------------------------------------

    @property
    def memory(self) -> Memory:
        """What `restore` needs after a restart; it is to be stored before an order is sent."""
        record = self.record
        bases = {id: base - record.first for id, base in self._bases.items()}
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
        """What was known before: the robot may hold all of these edges."""
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

    # -- what else is known of where it is --------------------------------------------------------

    def grow(self, silence: float) -> bool:
        """Nothing was heard for so many seconds; tells whether its allocation has grown by that."""
        grows = self.evidence.grow(silence)
        if grows:
            self._changed()
        return grows

    def lose(self, areas: Sequence[Area]) -> None:
        """The graph in force lacks what the robot held, which lies there."""
        self.evidence.lose(tuple(areas))
        if self.is_stopping:
            self._since_loss.add(self.route_id)
        self._changed()

    def stop_after_loss(self, new_id: NewId) -> None:
        """Stops a robot that should stand: what it held on another graph is free once it says so.
        """
        if self.evidence.lost and self.record.is_standing and not self.is_stopping:
            self.halt(new_id)

    def declare_absent(self, now: float) -> None:
        """A person says that the robot is not on the site."""
        self.settle(None)
        self.evidence.declare_absent(now)

    def is_back(self, report: Report, now: float) -> bool:
        """Ends the absence of a robot by a location that was taken since; tells whether it does."""
        if not (self.evidence.is_absent and self.evidence.is_back(report, now)):
            return False
        self.evidence.is_absent = False
        self._changed()
        return True
