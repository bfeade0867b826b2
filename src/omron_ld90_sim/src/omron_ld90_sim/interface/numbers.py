"""Reads numbers from the command line, fleet files and faults, always with limits.

A single nan in a pose or a time would end the whole simulation with all of its robots.
"""
from __future__ import annotations

import math
from typing import Tuple

FARTHEST = 1e7              # mm, for places and distances
LONGEST = 1e6               # s, for times


def number(text: object, minimum: float, maximum: float) -> float:
    """Returns a number within the limits. Raises ValueError, with a sentence, for other texts."""
    try:
        value = float(str(text))
    except ValueError:
        value = math.nan
    if not minimum <= value <= maximum:
        raise ValueError(f"'{text}' is not a number from {minimum:g} to {maximum:g}")
    return value


def length(text: object) -> float:
    """Returns a length in mm, which may be negative."""
    return number(text, -FARTHEST, FARTHEST)


def angle(text: object) -> float:
    """Returns an angle from -360 to 360 degrees."""
    return number(text, -360.0, 360.0)


def seconds(text: object) -> float:
    """Returns a time (s), counted from now or from the start."""
    return number(text, 0.0, LONGEST)


def percent(text: object) -> float:
    """Returns a state of charge."""
    return number(text, 0.0, 100.0)


def speed_factor(text: object) -> float:
    """Returns the speed of the simulated clock, as a factor of real time."""
    return number(text, 0.1, 20.0)


def start_pose(x: object, y: object, theta: object) -> Tuple[float, float, float]:
    """Converts metres, metres, degrees to mm, mm, degrees."""
    limit = FARTHEST / 1000.0
    return (number(x, -limit, limit) * 1000.0, number(y, -limit, limit) * 1000.0, angle(theta))
