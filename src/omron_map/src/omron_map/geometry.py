"""Rectangles, which maps store turned about their origin, and what places span."""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Optional, Tuple

import numpy as np

_EDGE = 1e-6  # mm; rounding of the rotation must not take a point off the edge


@dataclass(frozen=True)
class Extent:
    """The from and to corner of an area, or the end points of a line, as stored (mm)."""

    from_x: int
    from_y: int
    to_x: int
    to_y: int


def bounds_of(*places: np.ndarray) -> Optional[Tuple[np.ndarray, np.ndarray]]:
    """Lowest and highest x, y of arrays (N, 2), or (N, 4) of two points each; None without any."""
    everything = np.concatenate(
        [np.empty((0, 2)), *(np.reshape(block, (-1, 2)) for block in places)])
    return (everything.min(axis=0), everything.max(axis=0)) if len(everything) else None


def normalise_degrees(angle: float) -> float:
    """`angle` in (-180, 180], never -0; nan for what is not finite."""
    if not math.isfinite(angle):
        return math.nan
    turned = math.fmod(angle, 360.0)
    if turned > 180.0:
        turned -= 360.0
    elif turned <= -180.0:
        turned += 360.0
    return turned + 0.0


def _rotation(degrees: float) -> np.ndarray:
    """Matrix that turns column vectors by `degrees`; exact at quarter turns."""
    quarter, rest = divmod(degrees, 90.0)
    if rest == 0.0:
        c, s = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[int(quarter) % 4]
    else:
        c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return np.array(((c, -s), (s, c)))


@dataclass(frozen=True)
class RotatedRectangle:
    """A rectangle in the map frame: centre and size in mm, yaw in degrees."""

    centre_x: float
    centre_y: float
    width: float
    height: float
    yaw: float

    @classmethod
    def from_extent(cls, extent: Extent, theta: float) -> RotatedRectangle:
        """The rectangle that a map stores as `extent` and `theta` (degrees).

        The file holds an axis-parallel rectangle in a frame turned by `theta` about the *map's
        origin*, so its corners are turned about (0, 0), not about its own centre.
        """
        middle = ((extent.from_x + extent.to_x) / 2.0, (extent.from_y + extent.to_y) / 2.0)
        centre_x, centre_y = _rotation(theta) @ middle
        return cls(float(centre_x), float(centre_y), float(abs(extent.to_x - extent.from_x)),
                   float(abs(extent.to_y - extent.from_y)), normalise_degrees(theta))

    def to_extent(self) -> Extent:
        """The corners to store beside theta = `yaw`, rounded to whole mm."""
        x, y = (_rotation(-self.yaw) @ (self.centre_x, self.centre_y)).tolist()
        half_width, half_height = self.width / 2.0, self.height / 2.0
        return Extent(round(x - half_width), round(y - half_height),
                      round(x + half_width), round(y + half_height))

    @property
    def corners(self) -> np.ndarray:
        """(4, 2) corners in mm, counter-clockwise, beginning with the turned lower left one."""
        half = np.array((self.width, self.height)) / 2.0
        around = np.array(((-1, -1), (1, -1), (1, 1), (-1, 1))) * half
        return around @ _rotation(self.yaw).T + (self.centre_x, self.centre_y)

    def contains(self, points: np.ndarray) -> np.ndarray:
        """Which of `points` (N, 2) in mm lie inside; edges count as inside."""
        own = (np.asarray(points, float) - (self.centre_x, self.centre_y)) @ _rotation(self.yaw)
        half = np.array((self.width, self.height)) / 2.0 + _EDGE
        return np.all(np.abs(own) <= half, axis=-1)
