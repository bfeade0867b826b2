"""Stop all where there is no supervisor to do it: before it has a graph, or while it hangs.

The robots get an empty route under an id that no journal gives; the supervisor stops them once more
by its own rules as soon as it can. One that begins after another that hung was killed stops the
fleet when robots report such an id.
"""
from __future__ import annotations

from math import inf
from typing import Iterable, List, Optional, Sequence

from graph_fleet_manager.interlocking.pending_order import REPEAT
from graph_fleet_manager.supervision.actions import SendRoute
from graph_fleet_manager.supervision.route_ids import past_id


class EarlyStop:
    """An empty route for every robot, repeated until a supervisor takes over."""

    def __init__(self, robots: Iterable[str]) -> None:
        self._robots = tuple(robots)
        self._route_id: Optional[int] = None
        self._sent = -inf

    def stop(self, now: float) -> List[SendRoute]:
        """Every robot is to stop; what is to be sent for that."""
        self._route_id, self._sent = past_id(), now
        return self._orders(repeated=False)

    def due(self, now: float) -> Sequence[SendRoute]:
        """What is to be sent again, for robots that are not connected yet."""
        if self._route_id is None or now - self._sent < REPEAT:
            return ()
        self._sent = now
        return self._orders(repeated=True)

    def hand_over(self) -> bool:
        """The supervisor takes over; tells whether it is to stop the fleet."""
        is_stopped, self._route_id = self._route_id is not None, None
        return is_stopped

    def _orders(self, repeated: bool) -> List[SendRoute]:
        assert self._route_id is not None
        return [SendRoute(robot, self._route_id, (), repeated) for robot in self._robots]
