"""What every kind of line has in common.

Lengths are mm, angles degrees, in the robot's map frame, as ARCL gives them (the ROS nodes turn
them into SI). Names (goals, routes, ...) are spelt as the robot spelt them: compare them with
`same_name`, for the robot itself does not respect case.
"""
from __future__ import annotations

from dataclasses import dataclass


class Reply:
    """Base of every kind of line. `isinstance` tells them apart."""

    __slots__ = ()


def same_name(one: str, other: str) -> bool:
    """Whether two names mean the same object to the robot, which respects neither case nor ends."""
    return one.strip().casefold() == other.strip().casefold()


@dataclass(frozen=True)
class UnknownLine(Reply):
    """A line of no known kind: free text of another client, of a newer robot, or garbage."""

    text: str
