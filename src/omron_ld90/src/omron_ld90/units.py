"""Converts between the robot's millimetres (ARCL, `.map`) and the metres of ROS and graphs."""
from __future__ import annotations

MM_PER_M = 1000.0


def metres(millimetres: float) -> float:
    """Returns the length in metres."""
    return millimetres / MM_PER_M


def millimetres(length: float) -> int:
    """Returns the length in metres as the whole millimetres of ARCL and `.map` files."""
    return int(round(length * MM_PER_M))
