"""Chooses where the label of each robot is drawn, so that labels stay readable when robots meet.

A label is drawn on the side of its robot where it covers the least area of other labels and of
robots. If sides are equal, it is drawn above the robot. A label changes its side only if that
reduces the covered area clearly, so that it does not flicker.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, Mapping, Tuple

import numpy as np

from trajectory_graph.text_places import text_size

GAP = 0.12          # m between a robot and its label
SIDE_COST = 0.005   # m2 less that each of SIDES must cover to win over the one before
CHANGE_COST = 0.05  # m2 less that a label must cover to change its side: less than one letter
SWEEPS = 2          # rounds in which each label chooses its side, given those of the others
#: In order of preference; x, y: 1 and -1 beyond the robot's outline, 0 in its middle.
SIDES = np.array([(0, 1), (0, -1), (1, 0), (-1, 0), (1, 1), (-1, 1), (1, -1), (-1, -1)], float)


@dataclass(frozen=True)
class Label:
    """The label of a robot: the robot's position and radius (m), the text, its height (m)."""

    x: float
    y: float
    radius: float
    words: str
    height: float

    @property
    def size(self) -> Tuple[float, float]:
        """The approximate width and height of the text, in m."""
        return text_size(self.words, self.height)

    def middle(self, side: int) -> Tuple[float, float]:
        """The centre of the text (m) if it is drawn on this one of SIDES."""
        x, y = map(float, self.middles()[side])
        return x, y

    def middles(self) -> np.ndarray:
        """The centres of the text for all SIDES, (8, 2), in m."""
        away = self.radius + GAP + np.array(self.size) / 2.0
        return np.array((self.x, self.y)) + SIDES * away


class LabelPlaces:
    """Remembers the side of each robot on which its label is drawn."""

    def __init__(self) -> None:
        self._sides: Dict[str, int] = {}

    def side(self, name: str) -> int:
        """The index in SIDES for this robot's label."""
        return self._sides.get(name, 0)

    def choose(self, labels: Mapping[str, Label]) -> None:
        """Chooses the sides again, for the present positions. `labels` maps names of robots."""
        names = list(labels)
        if not names:
            return
        sides = np.array([self.side(name) for name in names], int)
        halves = np.array([one.size for one in labels.values()]) / 2.0
        middles = np.array([one.middles() for one in labels.values()])
        robots = np.array([(one.x, one.y) for one in labels.values()])
        radii = np.array([(one.radius, one.radius) for one in labels.values()])
        before = sides.copy()
        for _ in range(SWEEPS):
            for number in range(len(names)):
                others = np.arange(len(names)) != number
                words = middles[others, sides[others]]
                cost = (SIDE_COST * np.arange(len(SIDES))
                        + CHANGE_COST * (np.arange(len(SIDES)) != before[number])
                        + _overlap(middles[number], halves[number], words, halves[others])
                        + _overlap(middles[number], halves[number], robots[others], radii[others]))
                sides[number] = int(np.argmin(cost))
        self._sides = dict(zip(names, map(int, sides)))


def _overlap(middles: np.ndarray, half: np.ndarray, others: np.ndarray,
             other_halves: np.ndarray) -> np.ndarray:
    """Area (m2) that a rectangle at each of `middles` (N, 2) shares with all others (M, 2)."""
    apart = np.abs(middles[:, None] - others[None])
    shared = np.clip(half + other_halves[None] - apart, 0.0, 2.0 * np.minimum(half, other_halves))
    area: np.ndarray = shared.prod(axis=2).sum(axis=1)
    return area
