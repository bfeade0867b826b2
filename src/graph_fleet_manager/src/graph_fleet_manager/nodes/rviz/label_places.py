"""Where the labels of robots stand, so that they can be read where robots meet.

A label stands beside its robot, above it if it can: on the side where it covers least of other
labels and of robots. It changes sides only where that gains something, so that it does not flicker.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, Mapping, Tuple

import numpy as np

LETTER_WIDTH, LINE_HEIGHT = 0.52, 1.05  # of the height of the text, in RViz's font
GAP = 0.12          # m between a robot and its label
SIDE_COST = 0.005   # m2 that the next of SIDES must gain over the one before
CHANGE_COST = 0.05  # m2 that a change of sides must gain: less than one letter
SWEEPS = 2          # times that all labels look for a place, each knowing those of the others
#: In order of preference; x, y: 1 and -1 beyond the robot's edges, 0 in its middle.
SIDES = np.array([(0, 1), (0, -1), (1, 0), (-1, 0), (1, 1), (-1, 1), (1, -1), (-1, -1)], float)


@dataclass(frozen=True)
class Label:
    """What is written on a robot: where that is and its radius (m), the words, their height (m)."""

    x: float
    y: float
    radius: float
    words: str
    height: float

    @property
    def size(self) -> Tuple[float, float]:
        """About how wide and high the words are, in m."""
        lines = self.words.split('\n')
        return (LETTER_WIDTH * self.height * max(map(len, lines)),
                LINE_HEIGHT * self.height * len(lines))

    def middle(self, side: int) -> Tuple[float, float]:
        """The middle of the words where they stand on one of SIDES."""
        x, y = self.middles()[side].tolist()
        return x, y

    def middles(self) -> np.ndarray:
        """The middles for all sides (8, 2)."""
        away = self.radius + GAP + np.array(self.size) / 2.0
        return np.array((self.x, self.y)) + SIDES * away


class LabelPlaces:
    """Remembers on which side the label of each robot stands."""

    def __init__(self) -> None:
        self._sides: Dict[str, int] = {}

    def side(self, name: str) -> int:
        """The side of this robot's label."""
        return self._sides.get(name, 0)

    def choose(self, labels: Mapping[str, Label]) -> None:
        """Chooses the sides anew, for where the robots are now; labels are known by their robot."""
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
        self._sides = dict(zip(names, sides.tolist()))


def _overlap(middles: np.ndarray, half: np.ndarray, others: np.ndarray,
             other_halves: np.ndarray) -> np.ndarray:
    """Area (m2) that a rectangle at each of `middles` (N, 2) shares with all others (M, 2)."""
    apart = np.abs(middles[:, None] - others[None])
    shared = np.clip(half + other_halves[None] - apart, 0.0, 2.0 * np.minimum(half, other_halves))
    area: np.ndarray = shared.prod(axis=2).sum(axis=1)
    return area
