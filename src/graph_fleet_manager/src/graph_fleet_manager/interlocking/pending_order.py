"""The order that a robot has not acknowledged yet: sent, and repeated unchanged until it has."""
from __future__ import annotations

from typing import Optional

from graph_fleet_manager.interlocking.orders import Order, Sending

REPEAT = 1.0  # s after which an order that was not acknowledged is repeated


class PendingOrder:
    """At most one order of one robot.

    takes_away -- it stops the robot, or cuts its route short, regardless of its driver by now
    """

    def __init__(self) -> None:
        self.order: Optional[Order] = None
        self.takes_away = False
        self._known_epoch = 0
        self._sent_at: Optional[float] = None

    @property
    def is_stop(self) -> bool:
        """Is the robot to stop where it is?"""
        return self.order is not None and not self.order.edges

    @property
    def is_new_motion(self) -> bool:
        """Was it never sent, and does it let the robot drive?"""
        return self.order is not None and self._sent_at is None and not self.takes_away

    def give(self, order: Order, takes_away: bool = False, known_epoch: int = 0) -> None:
        """This is ordered now, and nothing of before any more.

        known_epoch -- of the robot's motion, in which it makes sense; 0: none is known
        """
        self.order, self.takes_away = order, takes_away
        self._known_epoch = 0 if takes_away else known_epoch
        self._sent_at = None

    def drop(self) -> None:
        """It is acknowledged, refused, or not to be sent any more."""
        self.order = None

    def due(self, now: float) -> Optional[Sending]:
        """What is to be sent now, if anything."""
        if self.order is None:
            return None
        is_repeat = self._sent_at is not None
        if self._sent_at is not None and now - self._sent_at < REPEAT:
            return None
        self._sent_at = now
        return Sending(self.order.route_id, self.order.edges, is_repeat, self._known_epoch)
