"""What one robot was ordered: its record, the ids of its routes, the order under way.

And all of it as it outlives a restart.
"""
from __future__ import annotations

from typing import Dict, Optional, Set

from graph_fleet_manager.supervision.orders import Memory, Order
from graph_fleet_manager.supervision.pending_order import PendingOrder
from graph_fleet_manager.supervision.route_record import RouteRecord


class OrderedRoutes:
    """The routes of one robot: each is a part of its record, from its *base* on, under an id."""

    def __init__(self, record: RouteRecord) -> None:
        self.record = record
        self.route_id = 0
        self.over = True
        """The last route cannot be extended: another one needs another id."""
        self.to_order_anew = 0
        """So many edges were under way before a restart, on a route that cannot be repeated."""
        self._pending = PendingOrder()
        self._bases: Dict[int, int] = {}
        self._acknowledged: Set[int] = set()
        self._ended: Set[int] = set()
        self._reported = 0
        self._withdrawn: Optional[int] = None  # id of an order that may reach the robot yet
        self._ordered: Optional[int] = None  # before a restart, if it was less than the record

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

    def _begin(self, route_id: int) -> None:
        kept = (self.route_id, self._reported)
        self._bases = {id: base for id, base in self._bases.items() if id in kept}
        self._bases[route_id] = self.record.done
        self.route_id = route_id
        self.over = False
        self._withdrawn = None

    def _order_until(self, end: int, takes_away: bool = False) -> None:
        """Orders the record up to there, from where the route begins."""
        base = self._bases[self.route_id]
        self._pending.give(Order(self.route_id, base, self.record.part(base, end)), takes_away)

    def _is_shorter(self, order: Order) -> bool:
        return order.end < self.record.end

    # -- what outlives a restart ------------------------------------------------------------------

    @property
    def memory(self) -> Memory:
        """What `restore` needs after a restart; it is to be stored before an order is sent."""
        record = self.record
        bases = {id: base - record.first for id, base in self._bases.items()}
        return Memory(self.route_id, tuple(record.edges), record.done - record.first, bases,
                      record.place, self.over, tuple(sorted(self._ended)), self.is_stopping,
                      self._shortened, record.lost_at)

    @property
    def _shortened(self) -> Optional[int]:
        order = self.order
        if order is None or not order.edges or not self._is_shorter(order):
            return None
        return order.end - self.record.first

    def restore(self, memory: Memory) -> None:
        """What was known before: the robot may hold all of these edges."""
        self.route_id, self._bases = memory.route_id, dict(memory.bases)
        self.over, self._ended = memory.over, set(memory.ended)
        self.record.restore(memory.record, memory.done, memory.place, memory.lost_at)
        self._ordered = memory.shortened
        if memory.is_stopping:
            self._pending.give(Order(self.route_id, self.record.done, ()), True)
