"""Decides whether a lane can lead straight from one place to another."""
from __future__ import annotations

import math

import numpy as np

from graph_editor.floor import Floor

TOLERANCE = 0.01  # m; error of a clearance, caused by the interpolation between cells


def in_sight(floor: Floor, start: np.ndarray, end: np.ndarray, clearance: float) -> bool:
    """Returns whether the straight line has at least this `clearance` (m) at each point."""
    return bool(floor.clearance_at(straight(floor, start, end)).min() >= clearance - TOLERANCE)


def straight(floor: Floor, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Returns points (N,2) on the line, at most one cell apart."""
    count = int(math.ceil(math.hypot(*(end - start)) / floor.resolution)) + 1
    return start + np.linspace(0.0, 1.0, max(count, 2))[:, None] * (end - start)
