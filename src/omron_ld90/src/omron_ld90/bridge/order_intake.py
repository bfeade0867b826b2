"""Decides which orders of the fleet manager are accepted, and when.

These orders are not accepted: one that came late, one that was under way when another giver took
the robot over, and one that was refused before. An order waits until the robot's state is known.
`route_orders` checks an order against the graph and the running route.
"""
from __future__ import annotations

import math
import zlib
from typing import Callable, Optional, Tuple

from omron_ld90.bridge.robot_monitor import RobotMonitor
from omron_ld90.bridge.route_orders import is_change
from omron_ld90.bridge.route_run import RouteRun
from route_protocol.old_masters import is_late
from route_protocol.order_rules import RouteRefused, check_order
from route_protocol.values import (
    ANSWERED_WITHIN,
    EMERGENCY_STOP,
    OVERRULED,
    TAKEN_OVER,
    Reason,
    ReasonCode,
    RouteOrder,
)

LATE_ORDER = 2.0  # s that an order may take to arrive
_LATCHED = Reason(ReasonCode.OTHER, 'it has no stamp, and was published before its connection '
                                    'began: send it again')
_KEPT_ORDERS = 200


def key_of(order: RouteOrder) -> Tuple[int, int]:
    """The key by which a repeated order is recognised, however long afterwards."""
    return order.route_id, zlib.crc32(repr(order.edges).encode())


class OrderIntake:
    """Sorts orders, and keeps the one that waits.

    patience -- s that an order may wait; the route protocol limits it
    tell_refusal -- called with a refused order and the reason
    note -- called with a message for a person
    knows -- whether an order of this epoch is still valid
    """

    def __init__(self, robot: RobotMonitor, patience: float,
                 tell_refusal: Callable[[RouteOrder, Reason], None],
                 note: Callable[[str], None],
                 knows: Optional[Callable[[int], bool]] = None) -> None:
        self._robot = robot
        self._knows = knows or robot.knows
        self._patience = min(patience, ANSWERED_WITHIN)
        self._tell_refusal = tell_refusal
        self._note = note
        self._waiting: Optional[Tuple[RouteOrder, float]] = None  # the order; time to give it up
        self._refused: Optional[Tuple[RouteOrder, Reason]] = None    # the last one, and the reason
        self._overruled_at = -math.inf  # when another giver last stopped or drove the robot
        self.past: Tuple[Tuple[int, int], ...] = ()
        """The orders that were driven, the latest at the end; see `key_of`."""
        self._explained: Optional[int] = None  # the route whose duplicate was already noted
        self._emergency_told = False  # whether a refusal in the emergency stop was noted

    # --- incoming orders -------------------------------------------------------------------------

    def take(self, order: RouteOrder, route: Optional[RouteRun], now: float) -> bool:
        """Takes an order of edges and returns whether it may be driven later.

        `route` is the last route.
        """
        if route and is_late(order, route.order):
            self._note(f'Route {order.route_id} came late and is ignored: route '
                       f'{route.order.route_id} was sent after it.')
        elif route and order.is_repeat_of(route.order):
            self._explain_duplicate(route)
        elif key_of(order) in self.past and not (route and is_change(route, order)):
            self._note(f'Route {order.route_id} was ordered again and is ignored: another drive '
                       'needs another id.')
        elif order.stamp and self._refused and order == self._refused[0]:
            self.refuse(*self._refused)
        elif order.comes_again and not order.stamp and not order.known_epoch:
            self.refuse(order, _LATCHED)
        elif order.known_epoch and not self._knows(order.known_epoch):
            self.refuse(order, OVERRULED)
        elif not order.known_epoch and self._is_overruled(order, now):
            self.refuse(order, TAKEN_OVER)
        elif self._waiting and order.is_repeat_of(self._waiting[0]):
            return True  # a repeated order does not prolong the wait of the first one
        else:
            self._waiting = (order, now + self._patience)
            return True
        return False

    def wait(self, order: RouteOrder, now: float) -> None:
        """Keeps a numbered order that the protocol lets pass until it can be judged."""
        if self._waiting is None or self._waiting[0].order != order.order:
            self._waiting = (order, now + self._patience)

    def drop(self) -> None:
        """Drops the order that waits: it was cancelled."""
        self._waiting = None

    def overrule(self, now: float) -> None:
        """Another giver stops or drives the robot: refuses all orders given before that."""
        self._overruled_at = now
        if self._waiting:
            order, _ = self._waiting
            self._waiting = None
            self.refuse(order, OVERRULED if order.known_epoch else TAKEN_OVER)

    def _is_overruled(self, order: RouteOrder, now: float) -> bool:
        """Whether the sender could not yet know of a take-over when it sent the order."""
        age = (order.received - order.stamp) / 1e9 if order.stamp and order.received else 0.0
        return now - age < self._overruled_at and now < self._overruled_at + LATE_ORDER

    def _explain_duplicate(self, route: RouteRun) -> None:
        """Notes once that a route which is over was ordered again; does nothing else."""
        if not route.running and self._explained != route.order.route_id:
            self._explained = route.order.route_id
            self._note(f'Route {route.order.route_id} was ordered again and is ignored: it is '
                       f'{route.phase.value}. Another drive needs another id.')

    # --- accepting and refusing ------------------------------------------------------------------

    def due(self, why_unknown: Callable[[float], Reason], now: float) -> Optional[RouteOrder]:
        """The waiting order if it can be judged now; refuses it here if it waited too long.

        `why_unknown` returns why it is unknown whether the robot could drive it, or no reason.
        """
        if self._waiting is None:
            return None
        order, give_up = self._waiting
        emergency = self._robot.emergency
        try:
            check_order(order, 'the robot')
            unknown = why_unknown(now)
            if unknown and now <= give_up and not emergency:
                return None
            if emergency or unknown:
                raise RouteRefused(EMERGENCY_STOP if emergency else unknown)
        except RouteRefused as refusal:
            self._waiting = None
            self.refuse(order, refusal.reason)
            return None
        self._waiting = None
        return order

    def refuse(self, order: RouteOrder, reason: Reason) -> None:
        """Reports the refusal. In an emergency stop it is noted only once, as givers repeat."""
        self._refused = (order, reason)
        self._tell_refusal(order, reason)
        if not (self._robot.emergency and self._emergency_told):
            self._note(f'Route {order.route_id} was refused: {reason}.')
        self._emergency_told = self._robot.emergency

    def accepted(self, order: RouteOrder) -> None:
        """The order that was due is driven now."""
        if not order.order:
            self.past = (*self.past, key_of(order))[-_KEPT_ORDERS:]
        if self._emergency_told:
            self._emergency_told = False
            self._note(f'Route {order.route_id} is driven: the emergency stop is over.')
