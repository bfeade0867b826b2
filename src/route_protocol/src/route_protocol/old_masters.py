"""Masters that do not number their orders: `rostopic pub`, and managers of the first protocol.

Only this module has rules for them. It gives each of their routes a number, so that `vehicle` gets
only numbered routes. All of these masters count as one master, OLD_MASTER.

    | order without a number                                     | answer                          |
    |------------------------------------------------------------|---------------------------------|
    | stamped before an order, of any master, that was taken     | ignored: it came late           |
    | same route_id and edges as the last such order taken       | ignored: it is a repeat         |
    | same stamp and route as the last such order refused        | refused again                   |
    | neither stamp nor epoch, and it came with a new connection | refused: it was latched         |
    | names an epoch that is over                                | refused: OVERRULED              |
    | no epoch, and sent before the present epoch began          | refused: TAKEN_OVER             |
    | same route_id as the route in force                        | changes that route              |
    | any other                                                  | begins a new route              |
"""
from __future__ import annotations

import math
from dataclasses import replace
from typing import Optional, Tuple

from route_protocol.order_rules import CLOCK_TOLERANCE
from route_protocol.values import (
    LARGEST_NUMBER,
    OVERRULED,
    TAKEN_OVER,
    EdgeState,
    Phase,
    Reason,
    ReasonCode,
    RouteOrder,
    RouteRefusal,
    RouteReport,
)
from route_protocol.vehicle import OLD_MASTER, Answer, Judgement, Vehicle, VehicleState

LATE_ORDER = 2.0  # s that an order may need to arrive
_LATCHED = Reason(ReasonCode.OTHER, 'it has no stamp, and was published before its connection '
                                    'began: send it again')


class OldMasters:
    """Judges and numbers the routes of masters that do not number them."""

    def __init__(self, last: Optional[RouteOrder] = None) -> None:
        self.last = last
        """The last taken order without a number; its stamp is the newest of all taken orders."""
        self._refused: Optional[Tuple[RouteOrder, Reason]] = None
        self._epoch_began = -math.inf

    def passed(self, order: RouteOrder) -> None:
        """Notes that an order of any master was taken. From now on, older orders count as late.

        The stamp of `last` never goes back.
        """
        last = self.last or RouteOrder(0, ())
        stamp = last.stamp if not order.stamp or is_late(order, last) else order.stamp
        self.last = replace(last if order.order else order, stamp=stamp)

    def refused(self, order: RouteOrder, reason: Reason) -> None:
        """Notes that a route was refused. If the same route arrives again, it is refused again."""
        self._refused = (order, reason)

    def epoch_began(self, now: float) -> None:
        """Notes that a new epoch began at `now` (s) that no order of an old master has caused."""
        self._epoch_began = now

    def answer(self, order: RouteOrder, vehicle: Vehicle, now: float) -> Judgement:
        """Returns the answer to any order, with a number or without."""
        if order.order or order.is_stop:
            return vehicle.judge(order)
        return self.judge(order, vehicle.state, now)

    def judge(self, order: RouteOrder, state: VehicleState, now: float) -> Judgement:
        """Returns the answer to a route without a number that arrives at `now` (s)."""
        last = self.last
        if last is not None and is_late(order, last):
            return _ignored(f'it came late, route {last.route_id} was sent after it')
        if last is not None and order.is_repeat_of(last):
            return Judgement(Answer.IGNORED) if state.is_running else _ignored(
                f'it is {state.phase.value}. Another drive needs another id')
        why_not = self._why_not(order, state, now)
        if why_not is not None:
            return Judgement(Answer.REFUSED, why_not)
        changes = self.changes_route(order, state)
        return Judgement(Answer.ROUTE, done=state.done, rest=order.edges, goes_on=changes)

    def _why_not(self, order: RouteOrder, state: VehicleState, now: float) -> Optional[Reason]:
        """Returns why a new route is refused; None: it is not refused."""
        if order.stamp and self._refused is not None and order == self._refused[0]:
            return self._refused[1]
        if order.known_epoch:
            return OVERRULED if order.known_epoch != state.epoch else None
        if order.comes_again and not order.stamp:
            return _LATCHED
        return TAKEN_OVER if self._is_overruled(order, now) else None

    def _is_overruled(self, order: RouteOrder, now: float) -> bool:
        """Returns whether the sender could not know the present epoch when it sent the order."""
        age = (order.received - order.stamp) / 1e9 if order.stamp and order.received else 0.0
        return now - age < self._epoch_began and now < self._epoch_began + LATE_ORDER

    @staticmethod
    def changes_route(order: RouteOrder, state: VehicleState) -> bool:
        """Returns whether the order changes the route in force; False: it begins another route."""
        return (order.route_id == state.route_id and bool(state.edges)
                and state.phase is not Phase.STOPPED and state.master == OLD_MASTER)

    def numbered(self, order: RouteOrder, state: VehicleState) -> RouteOrder:
        """Returns this route as the numbered order that the vehicle can take in this state."""
        is_counted = state.master == OLD_MASTER
        number = max(state.order, state.refused) + 1 if is_counted else 1
        first = state.first if self.changes_route(order, state) else state.done
        return replace(order, order=min(number, LARGEST_NUMBER), known_epoch=state.epoch,
                       first=first, master=OLD_MASTER)


def as_failed_route(report: RouteReport, refusal: RouteRefusal) -> RouteReport:
    """Returns the report that shows a refusal to a master that does not number its orders."""
    return replace(report, route_id=refusal.route_id, edges=refusal.edges,
                   states=(EdgeState.FAILED,) * len(refusal.edges), reason=refusal.reason)


def _ignored(why: str) -> Judgement:
    return Judgement(Answer.IGNORED, Reason(ReasonCode.OTHER, why))


def is_late(order: RouteOrder, last: RouteOrder) -> bool:
    """Returns whether the order was sent before the last accepted order, but arrived after it.

    If the clock of this computer is behind the stamp of the last accepted order, the clock was set
    back. Then the stamps cannot be compared.
    """
    is_set_back = 0 < order.received < last.stamp - CLOCK_TOLERANCE
    return 0 < order.stamp < last.stamp and not is_set_back
