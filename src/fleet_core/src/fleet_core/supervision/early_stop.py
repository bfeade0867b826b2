"""Stops all robots while no supervisor can stop them: there is no graph, or the supervisor hangs.

Each robot gets a stop with the number 0. Such a stop begins a new epoch, so the robot obeys no
order that is still on its way. As soon as the supervisor works, it stops the robots once more in
its usual way. If it is killed instead, its successor stops the fleet when robots report such an
epoch.
"""
from __future__ import annotations

from math import inf
from typing import Iterable, List, Optional, Sequence

from fleet_core.supervision.actions import SendRoute
from fleet_core.supervision.fleet_stop import FleetStop
from route_protocol.master import REPEAT, Order

STOP = Order(0, 0, 0, ())
"""A stop that bypasses the supervisor."""


class EarlyStop:
    """An empty route for every robot, repeated until a supervisor takes over."""

    def __init__(self, robots: Iterable[str]) -> None:
        self._robots = tuple(robots)
        self._stop: Optional[FleetStop] = None
        self._sent = -inf

    def stop(self, now: float, stop: FleetStop) -> List[SendRoute]:
        """Begins to stop all robots. Returns the orders to send; `now` in s, monotonic."""
        self._stop, self._sent = self._stop or stop, now
        return self._orders(repeated=False)

    def due(self, now: float) -> Sequence[SendRoute]:
        """Returns the orders to repeat at `now`, for robots that were not connected before.

        Empty if none.
        """
        if self._stop is None or now - self._sent < REPEAT:
            return ()
        self._sent = now
        return self._orders(repeated=True)

    def hand_over(self) -> Optional[FleetStop]:
        """Ends the repetition, because a supervisor takes over.

        Returns the stop that the supervisor must now carry out; None: there was none.
        """
        stop, self._stop = self._stop, None
        return stop

    def _orders(self, repeated: bool) -> List[SendRoute]:
        return [SendRoute(robot, STOP, repeated) for robot in self._robots]
