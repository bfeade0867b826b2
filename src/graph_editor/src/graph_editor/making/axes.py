"""Finds the directions of a building's walls. Lanes that nearly follow a wall are aligned to it."""
from __future__ import annotations

import math
from typing import List

import numpy as np
from scipy import ndimage

from graph_editor.floor import Floor

NEAR_WALLS = (0.25, 1.0)  # m; in this range the clearance increases at right angles to the wall
BINS = 180  # number of bins of half a degree
SHARE = 0.12  # least length of walls along a further axis, as a share of those along the first
APART = 20.0  # deg; least angle between axes


def axes_of(floor: Floor) -> List[float]:
    """Returns the directions of the walls (rad, 0..pi/2), the most frequent first.

    There is at least one direction.
    """
    down, right = np.gradient(ndimage.gaussian_filter(floor.clearance, 1.0))
    steep = np.hypot(down, right) > 0.8 * floor.resolution
    near = (floor.clearance > NEAR_WALLS[0]) & (floor.clearance < NEAR_WALLS[1]) & steep
    quarter = np.arctan2(down[near], right[near]) % (math.pi / 2.0)
    counts = np.bincount((quarter / (math.pi / 2.0) * BINS).astype(int) % BINS, minlength=BINS)
    smooth = ndimage.gaussian_filter1d(counts.astype(float), 3.0, mode='wrap')
    axes: List[float] = []
    first = 0.0
    for peak in np.argsort(-smooth, kind='stable'):
        angle = (peak + 0.5) / BINS * 90.0
        around = counts[(peak + np.arange(-8, 9)) % BINS]
        walls = float(around.sum() - len(around) * np.median(counts))
        if axes and walls < SHARE * first:
            break
        first = first or max(walls, 1.0)
        if all(_apart(angle, math.degrees(axis)) > APART for axis in axes):
            axes.append(_refined(quarter, math.radians(angle)))
    return axes


def _apart(one: float, other: float) -> float:
    """Returns the angle (deg, 0..45) between two directions, modulo a right angle."""
    return abs((one - other + 45.0) % 90.0 - 45.0)


def _refined(quarter: np.ndarray, peak: float) -> float:
    """Returns the mean of all wall directions within 5 degrees of a peak of the histogram.

    Returns exactly 0 if this mean is almost along x or y.
    """
    offsets = (quarter - peak + math.pi / 4.0) % (math.pi / 2.0) - math.pi / 4.0
    around = offsets[np.abs(offsets) < math.radians(5.0)]
    axis = (peak + (float(around.mean()) if len(around) else 0.0)) % (math.pi / 2.0)
    if abs((axis + math.pi / 4.0) % (math.pi / 2.0) - math.pi / 4.0) < math.radians(0.4):
        return 0.0
    return axis
