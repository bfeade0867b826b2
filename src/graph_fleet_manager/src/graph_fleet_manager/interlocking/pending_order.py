"""The order that a robot has not acknowledged yet. It is repeated unchanged until then."""
from __future__ import annotations

from typing import Optional

from graph_fleet_manager.interlocking.orders import Order, Sending

REPEAT = 1.0  # s after which an order that was not acknowledged is repeated


class PendingOrder:
    """At most one unacknowledged order of one robot.

    takes_away -- the order stops the robot or shortens its route; it is valid in each epoch
    """

    def __init__(self) -> None:
        self.order: Optional[Order] = None
        self.takes_away = False
        self._known_epoch = 0
        self._sent_at: Optional[float] = None

    @property
    def is_stop(self) -> bool:
        """Is the order a stop?"""
        return self.order is not None and not self.order.edges

    @property
    def is_new_motion(self) -> bool:
        """Does the order let the robot drive, and was it never sent?"""
        return self.order is not None and self._sent_at is None and not self.takes_away

    def give(self, order: Order, takes_away: bool = False, known_epoch: int = 0) -> None:
        """Sets the order, in place of any order before it.

        known_epoch -- epoch of the robot's motion in which the order is valid; 0: none is known
        """
        self.order, self.takes_away = order, takes_away
        self._known_epoch = 0 if takes_away else known_epoch
        self._sent_at = None

    def drop(self) -> None:
        """Removes the order: it is acknowledged, refused, or not to be sent any more."""
        self.order = None

    def due(self, now: float) -> Optional[Sending]:
        """The message to send now; None: nothing is due."""
        if self.order is None:
            return None
        is_repeat = self._sent_at is not None
        if self._sent_at is not None and now - self._sent_at < REPEAT:
            return None
        self._sent_at = now
        return Sending(self.order.route_id, self.order.edges, is_repeat, self._known_epoch)
