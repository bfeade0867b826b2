"""Which route is to be seen: the one being driven, and for a while the one that just ended."""
from __future__ import annotations

from typing import Optional, Sequence, Tuple

from itrci_nav_msgs.msg import EdgeState

SHOWN_AFTER_THE_END = 15.0  # s


class RouteView:
    """The route on display, out of the messages about all of them. Times in s of a steady clock."""

    def __init__(self) -> None:
        self.shown: Tuple[EdgeState, ...] = ()
        self._id: Optional[int] = None
        self._running = False
        self._ended = 0.0
        self._over: Optional[int] = None

    def update(self, route_id: int, edges: Sequence[EdgeState], now: float) -> bool:
        """Take in one message; True when there is something else to see.

        A route that is refused while another runs is not shown.
        """
        failed = any(edge.state == EdgeState.FAILED for edge in edges)
        running = not failed and any(edge.state != EdgeState.COMPLETE for edge in edges)
        if not running and (route_id == self._over or (self._running and failed
                                                       and route_id != self._id)):
            return False
        if running:
            self._over = None
        elif self._running or route_id != self._id:
            self._ended = now
        route = tuple(edges)
        changed = _key(route) != _key(self.shown)
        self.shown, self._id, self._running = route, route_id, running
        return changed

    def expire(self, now: float) -> bool:
        """Take the route away that ended a while ago; True when it just went."""
        if not self.shown or self._running or now - self._ended < SHOWN_AFTER_THE_END:
            return False
        self.shown, self._over = (), self._id
        return True


def _key(route: Sequence[EdgeState]) -> list:
    return [(edge.edge_id, edge.state) for edge in route]
