"""The orders that reach a vehicle: which order waits, when it is answered, and what is sent back.

`vehicle` judges orders with a number, and `old_masters` judges orders without one. A route that the
vehicle might drive waits here until the vehicle can decide. At most one route waits.

    | event                      | the route that waits             | answer                       |
    |----------------------------|----------------------------------|------------------------------|
    | route that can be answered |                                  | taken or refused at once     |
    | route that must wait       | none                             | waits                        |
    | such a route, numbered     | of the same master, lower number | waits; its answer counts for |
    |                            |                                  | the other route, too         |
    | such a route, not numbered | not numbered, another route that | waits; the other route is    |
    |                            | was not sent later               | forgotten                    |
    | such a route               | of another master                | waits; the other is refused  |
    | such a route               | any other                        | ignored: the other waits on  |
    | stop                       | numbered                         | that route is judged again   |
    | stop                       | not numbered                     | that route is forgotten      |
    | new epoch                  | any                              | that route is refused        |
    | the vehicle can decide     | any                              | that route is taken, or it   |
    |                            |                                  | is refused                   |
    | `patience` is over         | any                              | that route is refused        |

So if two masters order routes, the vehicle follows the later order. The result is the same as if
each order had been answered when it came. The earlier master is told that its route is refused.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, List, NamedTuple, Optional, Tuple, Union

from route_protocol.old_masters import OldMasters, as_failed_route, is_late
from route_protocol.order_rules import RouteRefused
from route_protocol.values import (
    ANSWERED_WITHIN,
    NO_REASON,
    OVERRULED,
    TAKEN_OVER,
    EpochCause,
    Reason,
    ReasonCode,
    RouteOrder,
    RouteRefusal,
    RouteReport,
)
from route_protocol.vehicle import OLD_MASTER, Answer, Judgement, Vehicle, VehicleState

DISPLACED = Reason(ReasonCode.OVERRULED, 'another master ordered a route while this one waited')


class NotYet(Exception):
    """The vehicle cannot decide yet whether it drives the route; `reason` says why."""

    def __init__(self, reason: Reason) -> None:
        super().__init__(reason.text)
        self.reason = reason


@dataclass(frozen=True)
class DueOrder:
    """A route that can be driven now, as far as the protocol knows.

    given  -- the order as it arrived
    order  -- the same order with a number
    done   -- number of the first edge of `rest` in the route record
    rest   -- the edges that the vehicle would still drive
    goes_on -- `rest` continues the route that the vehicle drives or has completed
    """

    given: RouteOrder
    order: RouteOrder
    done: int
    rest: Tuple[int, ...]
    goes_on: bool


class WaitingRoute(NamedTuple):
    """The route that waits, and the time (s) at which it arrived."""

    order: RouteOrder
    arrived: float


class Intake:
    """Receives the orders for a vehicle; see the docstring of the module.

    take_up -- checks a due order against what only the vehicle knows, and takes the order with
               `take_order`; raises RouteRefused or NotYet
    tell    -- is called with each refusal
    patience -- s that a route may wait, at most ANSWERED_WITHIN
    """

    def __init__(self, vehicle: Vehicle, take_up: Callable[[DueOrder], None],
                 tell: Callable[[RouteRefusal], None], patience: float = ANSWERED_WITHIN) -> None:
        self.vehicle = vehicle
        self.old_masters = OldMasters()
        self.waiting: Optional[WaitingRoute] = None
        self._take_up, self._tell = take_up, tell
        self._patience = min(patience, ANSWERED_WITHIN)

    def arrived(self, order: RouteOrder, now: float) -> Judgement:
        """Obeys, refuses or ignores an order, or lets it wait. Returns the protocol's judgement."""
        judgement = self.old_masters.answer(order, self.vehicle, now)
        if judgement.answer is Answer.STOP:
            self._stop(order, now)
        elif judgement.answer is not Answer.IGNORED:
            route = WaitingRoute(order, now)
            if self._why_not_yet(route):
                self._let_wait(route)
        return judgement

    def answer(self, now: float) -> None:
        """Takes or refuses the route that waits, if the vehicle can decide, or if it waited too
        long.
        """
        route = self.waiting
        if route is not None:
            why = self._why_not_yet(route)
            if why and now > route.arrived + self._patience:
                self._refuse(route.order, why)
            elif why:
                return
            self.waiting = None

    def _why_not_yet(self, route: WaitingRoute) -> Reason:
        """Takes, refuses or ignores a route, or returns why the vehicle cannot decide yet."""
        order, arrived = route
        judgement = self.old_masters.answer(order, self.vehicle, arrived)
        if judgement.answer is Answer.REFUSED:
            self._refuse(order, judgement.reason)
        elif judgement.answer is Answer.ROUTE:
            try:
                self._take_up(self._due(order, judgement))
            except NotYet as not_yet:
                return not_yet.reason
            except RouteRefused as refusal:
                self._refuse(order, refusal.reason)
        return NO_REASON

    def take_order(self, due: DueOrder, now: float) -> None:
        """Takes a due order."""
        before = self.vehicle.state.epoch
        self.vehicle.take_order(due.order, due.done)
        self._passed(due.given, before, now)

    def begin_epoch(self, cause: EpochCause, reason: Reason, now: float) -> None:
        """Begins a new epoch that no order has caused.

        reason -- why a running route fails
        """
        self.vehicle.begin_epoch(cause, reason)
        self.old_masters.epoch_began(now)
        if self.waiting is not None:
            (order, _), self.waiting = self.waiting, None
            self._refuse(order, OVERRULED if order.known_epoch else TAKEN_OVER)

    def _stop(self, order: RouteOrder, now: float) -> None:
        before = self.vehicle.state.epoch
        self.vehicle.stop(order)
        self._passed(order, before, now)
        if self.waiting is not None and not self.waiting.order.order:
            self.waiting = None

    def _passed(self, order: RouteOrder, before: int, now: float) -> None:
        """Notes that an order was taken. `before`: the epoch before it was taken."""
        self.old_masters.passed(order)
        if order.order and self.vehicle.state.epoch != before:
            self.old_masters.epoch_began(now)

    def _let_wait(self, route: WaitingRoute) -> None:
        if self.waiting is not None:
            other = self.waiting.order
            if _master(route.order) != _master(other):
                self._refuse(other, DISPLACED)
            elif not _is_newer(route.order, other):
                return
        self.waiting = route

    def _due(self, order: RouteOrder, judgement: Judgement) -> DueOrder:
        if order.order:
            return DueOrder(order, order, judgement.done, judgement.rest, judgement.goes_on)
        numbered = self.old_masters.numbered(order, self.vehicle.state)
        return DueOrder(order, numbered, judgement.done,
                        order.edges[judgement.done - numbered.first:], judgement.goes_on)

    def _refuse(self, order: RouteOrder, reason: Reason) -> None:
        if not order.order:
            self.old_masters.refused(order, reason)
        self._tell(self.vehicle.refuse(order, reason))


def messages_of(refusal: RouteRefusal, state: VehicleState, report: Callable[[], RouteReport],
                ) -> List[Union[RouteRefusal, RouteReport]]:
    """Returns what a vehicle sends about a refusal.

    A master that does not number its orders reads a refusal in a report that shows its route as
    failed. This report is not sent if the vehicle's reports go to a master with numbers, or if they
    show a route with the same id, because the shown route goes on.
    """
    shows_route = bool(state.edges) and state.route_id == refusal.route_id
    if refusal.order or shows_route or state.master not in (None, OLD_MASTER):
        return [refusal]
    return [refusal, as_failed_route(report(), refusal)]


def _master(order: RouteOrder) -> str:
    return order.master if order.order else OLD_MASTER


def _is_newer(order: RouteOrder, waiting: RouteOrder) -> bool:
    """Returns whether an order replaces the waiting order of the same master."""
    if order.order:
        return order.order > waiting.order
    return not (order.is_repeat_of(waiting) or is_late(order, waiting))
