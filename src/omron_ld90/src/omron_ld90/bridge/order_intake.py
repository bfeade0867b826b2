"""Decides when an order of the fleet manager is judged, and remembers the one that waits.

`Vehicle` judges orders with a number, `OldMasters` those without one. An order that the robot might
drive waits until the robot's state is known, and until it stands after a route that it lost.
`route_orders` then checks it against the graph and the robot's place.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Optional, Tuple

from omron_ld90.bridge.robot_monitor import RobotMonitor
from route_protocol.old_masters import OldMasters, is_late
from route_protocol.order_rules import RouteRefused, check_order
from route_protocol.values import (
    ANSWERED_WITHIN,
    EMERGENCY_STOP,
    OVERRULED,
    TAKEN_OVER,
    EpochCause,
    Reason,
    RouteOrder,
    RouteRefusal,
)
from route_protocol.vehicle import Answer, Judgement, Vehicle


@dataclass(frozen=True)
class DueOrder:
    """An order that can be driven now, as far as the protocol knows.

    given  -- as it arrived
    order  -- the same with a number
    done   -- number, in the route record, of the first edge of `rest`
    rest   -- the edges that the robot would still drive
    goes_on -- they go on with the route that runs or is complete
    """

    given: RouteOrder
    order: RouteOrder
    done: int
    rest: Tuple[int, ...]
    goes_on: bool


class OrderIntake:
    """Sorts orders, and keeps the one that waits.

    patience -- s that an order may wait; the route protocol limits it
    tell_refusal -- called with each refusal
    note -- called with a message for a person
    """

    def __init__(self, vehicle: Vehicle, robot: RobotMonitor, patience: float,
                 tell_refusal: Callable[[RouteRefusal], None],
                 note: Callable[[str], None]) -> None:
        self.old_masters = OldMasters()
        self._vehicle, self._robot = vehicle, robot
        self._patience = min(patience, ANSWERED_WITHIN)
        self._tell_refusal = tell_refusal
        self._note = note
        self._waiting: Optional[Tuple[RouteOrder, float]] = None  # the order; time to give it up
        self._explained = ''  # the last note about an order that was ignored
        self._emergency_told = False  # whether a refusal in the emergency stop was noted

    @property
    def waits(self) -> bool:
        """Whether an order waits."""
        return self._waiting is not None

    # --- incoming orders -------------------------------------------------------------------------

    def arrived(self, order: RouteOrder, now: float) -> bool:
        """Answers an order that has arrived; returns whether it is a stop to obey, or waits."""
        judgement = self.old_masters.answer(order, self._vehicle, now)
        if judgement.answer is Answer.STOP:
            self._waiting = None
            return True
        if judgement.answer is Answer.REFUSED:
            self.refuse(order, judgement.reason)
        elif judgement.answer is Answer.IGNORED:
            self._explain(order, judgement.reason)
        elif self._waiting is None or _is_newer(order, self._waiting[0]):
            self._waiting = (order, now + self._patience)
        return judgement.answer is Answer.ROUTE

    def epoch_began(self, now: float) -> None:
        """Another giver stops or drives the robot: refuses all orders given before that."""
        self.old_masters.epoch_began(now)
        if self._waiting:
            order, _ = self._waiting
            self._waiting = None
            self.refuse(order, OVERRULED if order.known_epoch else TAKEN_OVER)

    def _explain(self, order: RouteOrder, reason: Reason) -> None:
        """Notes once why an order is ignored, if a person should know it."""
        note = f'Route {order.route_id} is ignored: {reason}.'
        if reason and note != self._explained:
            self._explained = note
            self._note(note)

    # --- accepting and refusing ------------------------------------------------------------------

    def due(self, why_unknown: Callable[[float], Reason], now: float) -> Optional[DueOrder]:
        """The waiting order if it can be judged now; refuses it here if it waited too long.

        `why_unknown` returns why it is unknown whether the robot could drive it, or no reason.
        """
        if self._waiting is None:
            return None
        order, give_up = self._waiting
        # again: the route may have gone on meanwhile
        judgement = self.old_masters.answer(order, self._vehicle, now)
        if judgement.answer is Answer.ROUTE:
            try:
                check_order(order, 'the robot')
                unknown = why_unknown(now)
                if unknown and now <= give_up and not self._robot.emergency:
                    return None
                self._waiting = None
                if self._robot.emergency or unknown:
                    raise RouteRefused(EMERGENCY_STOP if self._robot.emergency else unknown)
                return self._numbered(order, judgement)
            except RouteRefused as refusal:
                judgement = Judgement(Answer.REFUSED, refusal.reason)
        self._waiting = None
        if judgement.answer is Answer.REFUSED:
            self.refuse(order, judgement.reason)
        return None

    def _numbered(self, order: RouteOrder, judgement: Judgement) -> DueOrder:
        if order.order:
            return DueOrder(order, order, judgement.done, judgement.rest, judgement.goes_on)
        numbered = self.old_masters.numbered(order, self._vehicle.state)
        return DueOrder(order, numbered, judgement.done,
                        order.edges[judgement.done - numbered.first:], judgement.goes_on)

    def refuse(self, order: RouteOrder, reason: Reason) -> None:
        """Reports the refusal. In an emergency stop it is noted only once, as givers repeat."""
        if not order.order:
            self.old_masters.refused(order, reason)
        self._tell_refusal(self._vehicle.refuse(order, reason))
        if not (self._robot.emergency and self._emergency_told):
            self._note(f'Route {order.route_id} was refused: {reason}.')
        self._emergency_told = self._robot.emergency

    def taken(self, order: RouteOrder, now: float) -> None:
        """The order is obeyed now."""
        self.old_masters.passed(order)
        if self._vehicle.state.cause is EpochCause.OTHER_MASTER and order.order:
            self.old_masters.epoch_began(now)
        if self._emergency_told and not order.is_stop:
            self._emergency_told = False
            self._note(f'Route {order.route_id} is driven: the emergency stop is over.')


def _is_newer(order: RouteOrder, waiting: RouteOrder) -> bool:
    """Whether it takes the place of the order that waits; a repeat does not prolong that wait."""
    if order.order and (order.master, bool(waiting.order)) == (waiting.master, True):
        return order.order > waiting.order
    return not (order.is_repeat_of(waiting) or is_late(order, waiting))
