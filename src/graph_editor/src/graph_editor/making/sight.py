"""Whether a lane can lead straight from one place to another."""
from __future__ import annotations

import math

import numpy as np

from graph_editor.floor import Floor

TOLERANCE = 0.01  # m, that interpolation between cells may take off a clearance


def in_sight(floor: Floor, start: np.ndarray, end: np.ndarray, clearance: float) -> bool:
    """Is there at least `clearance` everywhere on the straight line?"""
    return bool(floor.clearance_at(straight(floor, start, end)).min() >= clearance - TOLERANCE)


def straight(floor: Floor, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Points (N,2) on the line, not farther apart than cells."""
    count = int(math.ceil(math.hypot(*(end - start)) / floor.resolution)) + 1
    return start + np.linspace(0.0, 1.0, max(count, 2))[:, None] * (end - start)
