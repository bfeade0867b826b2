"""Rectangles along a direction, and how far they can grow. In mm.

A *frame* has its origin on the offset outline, with u along a direction and v away from the floor.
In its frame a fence is axis-parallel, and it can grow along u or v up to the next edge.
"""
from __future__ import annotations

from typing import NamedTuple, Optional, Tuple

import numpy as np

from omron_map import RotatedRectangle
from omron_map_converter.corridors import ROBOT_HALF_WIDTH
from omron_map_converter.outer_regions import STEP

REACH = ROBOT_HALF_WIDTH - STEP / 2 - 10.0
"""A fence or wall within this distance covers a point of the offset outline: the robot cannot pass
between two covered points, with 10 mm to spare."""
LONGEST = 10000.0  # largest length of a fence to either side of its origin, and largest depth
THICKNESS = 200.0  # depth of a fence along a corridor
SHORTEST = 18.0
LONGEST_GAP = 1000.0  # a fence ends before a longer gap without points to cover
DIGITS = 6  # digits of degrees in a map file


class Frame(NamedTuple):
    """An origin and a unit direction in the map."""

    origin: np.ndarray
    direction: np.ndarray

    @property
    def _axes(self) -> np.ndarray:
        c, s = self.direction
        return np.array(((c, s), (-s, c)))

    @property
    def degrees(self) -> float:
        """Direction of u in the map frame, in degrees."""
        return float(np.degrees(np.arctan2(self.direction[1], self.direction[0])))

    def of(self, points: np.ndarray) -> np.ndarray:
        """Returns points (..., 2) of the map frame in this frame."""
        return (points - self.origin) @ self._axes.T

    def to_map(self, points: np.ndarray) -> np.ndarray:
        """Returns points (..., 2) of this frame in the map frame."""
        return points @ self._axes + self.origin


class Fence(NamedTuple):
    """A rectangle in a frame: `left..right` along u, `near..far` along v."""

    frame: Frame
    left: float
    right: float
    near: float
    far: float

    def covers(self, points: np.ndarray) -> np.ndarray:
        """Returns which of the points (N,2) in the fence's frame are within REACH of it."""
        u, v = points[:, 0], points[:, 1]
        beside = np.maximum(np.maximum(self.left - u, u - self.right), 0.0)
        before = np.maximum(np.maximum(self.near - v, v - self.far), 0.0)
        return beside ** 2 + before ** 2 <= REACH ** 2

    def trimmed(self, points: np.ndarray) -> Fence:
        """Returns the fence, reduced in length and depth to the `points` (N,2) that it covers.

        It contains the frame's origin, and ends on either side before a long gap without points.
        """
        covered = points[self.covers(points)]
        along = np.sort(np.append(np.clip(covered[:, 0], self.left, self.right), 0.0))
        gaps = np.flatnonzero(np.diff(along) > LONGEST_GAP)
        origin = np.searchsorted(along, 0.0)
        left = along[gaps[gaps < origin].max(initial=-1) + 1]
        right = along[gaps[gaps >= origin].min(initial=len(along) - 1)]
        if right - left < SHORTEST:
            left = max(self.left, left - SHORTEST / 2.0)
            right = min(self.right, right + SHORTEST / 2.0)
        least = min(self.far, self.near + THICKNESS)
        return self._replace(left=float(left), right=float(right),
                             far=max(least, min(self.far, float(covered[:, 1].max()))))

    @property
    def rectangle(self) -> RotatedRectangle:
        """The fence in the map frame, with the smallest possible rotation."""
        middle = self.frame.to_map(np.array(((self.left + self.right) / 2.0,
                                             (self.near + self.far) / 2.0)))
        width, height = self.right - self.left, self.far - self.near
        quarters = round(self.frame.degrees / 90.0)
        if quarters % 2:
            width, height = height, width
        yaw = round(self.frame.degrees - 90.0 * quarters, DIGITS)
        return RotatedRectangle(float(middle[0]), float(middle[1]), width, height, yaw)

    @property
    def line(self) -> Tuple[float, float, float, float]:
        """x1, y1, x2, y2 of the side that faces the floor, in the map frame."""
        ends = np.array(((self.left, self.near), (self.right, self.near)))
        x1, y1, x2, y2 = map(float, self.frame.to_map(ends).ravel())
        return x1, y1, x2, y2


def free_span(edges: np.ndarray, near: float, far: float) -> Optional[Tuple[float, float]]:
    """Returns the range (left, right) of u around 0 in which no edge is in the strip v = near..far.

    `edges` is (M,2,2). The range is at most LONGEST to either side. None: an edge is at u = 0.
    """
    u, v = edges[..., 0], edges[..., 1]
    within = (v.min(axis=1) < far) & (v.max(axis=1) > near)
    low, high = _clipped(v[within], u[within], near, far)
    if np.any((low <= 0.0) & (high >= 0.0)):
        return None
    return high[high < 0.0].max(initial=-LONGEST), low[low > 0.0].min(initial=LONGEST)


def first_beyond(edges: np.ndarray, left: float, right: float, beyond: float) -> float:
    """Returns the smallest v of `edges` (M,2,2) in the strip u = left..right.

    Only edges count that extend beyond v = `beyond` in this strip.
    """
    u, v = edges[..., 0], edges[..., 1]
    within = (u.min(axis=1) <= right) & (u.max(axis=1) >= left)
    low, high = _clipped(u[within], v[within], left, right)
    return float(low[high > beyond].min(initial=2.0 * LONGEST))


def _clipped(across: np.ndarray, along: np.ndarray, low: float,
             high: float) -> Tuple[np.ndarray, np.ndarray]:
    """Cuts segments to the strip low..high of one coordinate. Returns the lowest and the highest
    value of the other coordinate of each cut segment.

    across -- the coordinate of the segments' ends (M,2) that the strip limits
    along  -- their other coordinate (M,2)
    """
    run = across[:, 1] - across[:, 0]
    flat = run == 0.0
    run = np.where(flat, 1.0, run)
    start = np.where(flat, 0.0, np.minimum(np.maximum((low - across[:, 0]) / run, 0.0), 1.0))
    end = np.where(flat, 1.0, np.minimum(np.maximum((high - across[:, 0]) / run, 0.0), 1.0))
    rise = along[:, 1] - along[:, 0]
    ends = along[:, :1] + np.stack((start, end), axis=1) * rise[:, None]
    return ends.min(axis=1), ends.max(axis=1)
