"""Numbers that people write: on the command line, in fleet files and in faults; always bounded.

A single nan in a pose or a time would end the whole simulation, all of its robots with it.
"""
from __future__ import annotations

import math
from typing import Tuple

FARTHEST = 1e7              # mm, of places and distances
LONGEST = 1e6               # s, of times


def number(text: object, minimum: float, maximum: float) -> float:
    """A number within the limits; ValueError, with a sentence, for anything else."""
    try:
        value = float(str(text))
    except ValueError:
        value = math.nan
    if not minimum <= value <= maximum:
        raise ValueError(f"'{text}' is not a number from {minimum:g} to {maximum:g}")
    return value


def length(text: object) -> float:
    """Millimetres, in either direction."""
    return number(text, -FARTHEST, FARTHEST)


def angle(text: object) -> float:
    """Degrees, up to a whole turn in either direction."""
    return number(text, -360.0, 360.0)


def seconds(text: object) -> float:
    """A time from now, or since the start."""
    return number(text, 0.0, LONGEST)


def percent(text: object) -> float:
    """A state of charge."""
    return number(text, 0.0, 100.0)


def speed_factor(text: object) -> float:
    """How many times as fast as ours the simulated clock runs."""
    return number(text, 0.1, 20.0)


def start_pose(x: object, y: object, theta: object) -> Tuple[float, float, float]:
    """Metres, metres, degrees in; mm, mm, degrees out."""
    limit = FARTHEST / 1000.0
    return (number(x, -limit, limit) * 1000.0, number(y, -limit, limit) * 1000.0, angle(theta))
