"""Predicts from past standstills how many more seconds a robot will stand on its route."""
from __future__ import annotations

from collections import deque
from statistics import fmean
from typing import Deque, Dict

from fleet_core.supervision.robots import ManagedRobot

COUNTS = 3.0  # s; if a robot stands for less, it only turns or is starting to drive
KEPT = 100    # number of standstills that are remembered
ENOUGH = 5    # number of longer remembered standstills that a prediction needs


class Standstills:
    """The standstills of robots that had something to drive. Waiting for a turn does not count."""

    def __init__(self) -> None:
        self._lasted: Deque[float] = deque(maxlen=KEPT)
        self._stands: Dict[str, float] = {}
        self._let_go: Dict[str, float] = {}
        """Time since which each robot has had something to drive."""

    def further(self, robot: ManagedRobot, now: float) -> float:
        """Returns how many more seconds a robot will probably stand.

        0: it drives, or has nothing to drive.
        """
        if not robot.record.ahead:
            self._let_go.pop(robot.name, None)
            self._stands.pop(robot.name, None)
            return 0.0
        let_go = self._let_go.setdefault(robot.name, now)
        stands = min(robot.liveness.stands_for(now), now - let_go)
        before = self._stands.get(robot.name, 0.0)
        self._stands[robot.name] = stands
        if before >= COUNTS and stands < before:
            self._lasted.append(before)
        if stands < COUNTS:
            return 0.0
        longer = [lasted - stands for lasted in self._lasted if lasted > stands]
        return fmean(longer) if len(longer) >= ENOUGH else stands
