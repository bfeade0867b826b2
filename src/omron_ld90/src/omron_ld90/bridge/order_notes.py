"""Notes for people about the orders of the fleet manager, each of them once."""
from __future__ import annotations

from typing import Callable

from route_protocol.values import Reason, RouteOrder, RouteRefusal


class OrderNotes:
    """Notes which orders are ignored and refused, and why."""

    def __init__(self, note: Callable[[str], None]) -> None:
        self._note = note
        self._ignored = ''  # the last note about an order that was ignored
        self._emergency_told = False  # whether a refusal in the emergency stop was noted

    def ignored(self, order: RouteOrder, reason: Reason) -> None:
        """Notes once why an order is ignored, if a person should know it."""
        note = f'Route {order.route_id} is ignored: {reason}.'
        if reason and note != self._ignored:
            self._ignored = note
            self._note(note)

    def refused(self, refusal: RouteRefusal, emergency: bool) -> None:
        """Notes a refusal; in an emergency stop only the first one, as givers repeat."""
        if not (emergency and self._emergency_told):
            self._note(f'Route {refusal.route_id} was refused: {refusal.reason}.')
        self._emergency_told = emergency

    def taken(self, order: RouteOrder) -> None:
        """Notes the first route that is driven after refusals in an emergency stop."""
        if self._emergency_told:
            self._emergency_told = False
            self._note(f'Route {order.route_id} is driven: the emergency stop is over.')
