"""Writes notes for people about ignored and refused orders, each note once."""
from __future__ import annotations

from typing import Callable

from route_protocol.values import Reason, RouteOrder, RouteRefusal


class OrderNotes:
    """Writes notes about orders that are ignored or refused, with the reasons."""

    def __init__(self, note: Callable[[str], None]) -> None:
        self._note = note
        self._ignored = ''  # the last note about an order that was ignored
        self._emergency_told = False  # whether a refusal in the emergency stop was noted

    def ignored(self, order: RouteOrder, reason: Reason) -> None:
        """Writes once why an order is ignored, if there is a reason that a person should know."""
        note = f'Route {order.route_id} is ignored: {reason}.'
        if reason and note != self._ignored:
            self._ignored = note
            self._note(note)

    def refused(self, refusal: RouteRefusal, emergency: bool) -> None:
        """Writes a note about a refusal. In an emergency stop, only the first refusal is noted,
        because givers repeat their orders.
        """
        if not (emergency and self._emergency_told):
            self._note(f'Route {refusal.route_id} was refused: {refusal.reason}.')
        self._emergency_told = emergency

    def taken(self, order: RouteOrder) -> None:
        """Writes a note about the first route that is driven after an emergency stop."""
        if self._emergency_told:
            self._emergency_told = False
            self._note(f'Route {order.route_id} is driven: the emergency stop is over.')
