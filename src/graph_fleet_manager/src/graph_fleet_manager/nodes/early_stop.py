"""Stops all robots while no supervisor can do it: before there is a graph, or while it hangs.

Each robot gets an empty route under an id that no journal gives. As soon as the supervisor can, it
stops the robots again by its own rules. If a supervisor hung and was killed, its successor stops
the fleet when robots report such an id.
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
        """Begins to stop all robots. Returns the orders to send; `now` in s, monotonic."""
        self._route_id, self._sent = past_id(), now
        return self._orders(repeated=False)

    def due(self, now: float) -> Sequence[SendRoute]:
        """The orders to repeat at `now`, for robots that were not connected yet; empty if none."""
        if self._route_id is None or now - self._sent < REPEAT:
            return ()
        self._sent = now
        return self._orders(repeated=True)

    def hand_over(self) -> bool:
        """Ends the repetition, because a supervisor takes over. Returns whether it must stop the
        fleet."""
        is_stopped, self._route_id = self._route_id is not None, None
        return is_stopped

    def _orders(self, repeated: bool) -> List[SendRoute]:
        assert self._route_id is not None
        return [SendRoute(robot, self._route_id, (), repeated) for robot in self._robots]
