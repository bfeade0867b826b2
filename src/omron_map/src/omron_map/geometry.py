"""Rectangles and bounds of points. In a map file, a rectangle is rotated about the map's origin."""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Optional, Tuple

import numpy as np

_EDGE = 1e-6  # mm; tolerance, so that rounding does not move a point out of a rectangle


@dataclass(frozen=True)
class Extent:
    """The from and to corners of an area, or the end points of a line, as stored (mm)."""

    from_x: int
    from_y: int
    to_x: int
    to_y: int


def bounds_of(*places: np.ndarray) -> Optional[Tuple[np.ndarray, np.ndarray]]:
    """Returns the lowest and highest x, y of arrays (N, 2) or (N, 4); None without points."""
    everything = np.concatenate(
        [np.empty((0, 2)), *(np.reshape(block, (-1, 2)) for block in places)])
    return (everything.min(axis=0), everything.max(axis=0)) if len(everything) else None


def normalise_degrees(angle: float) -> float:
    """Returns `angle` in (-180, 180], never -0; NaN if it is not finite."""
    if not math.isfinite(angle):
        return math.nan
    turned = math.fmod(angle, 360.0)
    if turned > 180.0:
        turned -= 360.0
    elif turned <= -180.0:
        turned += 360.0
    return turned + 0.0


def _rotation(degrees: float) -> np.ndarray:
    """Returns the matrix that rotates column vectors by `degrees`; exact at quarter turns."""
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
        """Returns the rectangle that a map stores as `extent` and `theta` (degrees).

        The file has an axis-parallel rectangle in a frame that is rotated by `theta` about the
        *map's origin*. So the corners are rotated about (0, 0), not about the rectangle's centre.
        """
        middle = ((extent.from_x + extent.to_x) / 2.0, (extent.from_y + extent.to_y) / 2.0)
        centre_x, centre_y = _rotation(theta) @ middle
        return cls(float(centre_x), float(centre_y), float(abs(extent.to_x - extent.from_x)),
                   float(abs(extent.to_y - extent.from_y)), normalise_degrees(theta))

    def to_extent(self) -> Extent:
        """Returns the corners to store together with theta = `yaw`, rounded to whole mm."""
        x, y = map(float, _rotation(-self.yaw) @ (self.centre_x, self.centre_y))
        half_width, half_height = self.width / 2.0, self.height / 2.0
        return Extent(round(x - half_width), round(y - half_height),
                      round(x + half_width), round(y + half_height))

    @property
    def corners(self) -> np.ndarray:
        """(4, 2) corners in mm, counter-clockwise, starting with the rotated lower left corner."""
        half = np.array((self.width, self.height)) / 2.0
        around = np.array(((-1, -1), (1, -1), (1, 1), (-1, 1))) * half
        return around @ _rotation(self.yaw).T + (self.centre_x, self.centre_y)

    def contains(self, points: np.ndarray) -> np.ndarray:
        """Returns which of `points` (N, 2), mm, are inside; the edges count as inside."""
        own = (np.asarray(points, float) - (self.centre_x, self.centre_y)) @ _rotation(self.yaw)
        half = np.array((self.width, self.height)) / 2.0 + _EDGE
        return np.all(np.abs(own) <= half, axis=-1)
