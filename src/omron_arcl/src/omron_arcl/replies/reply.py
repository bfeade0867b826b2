"""What every kind of line has in common.

Lengths are mm, angles degrees, in the robot's map frame, as ARCL gives them (the ROS nodes turn
them into SI). Names (goals, routes, ...) are spelt as the robot spelt them: compare them with
`same_name`, for the robot itself does not respect case.
"""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Tuple


class Reply:
    """Base of every kind of line. `isinstance` tells them apart."""

    __slots__ = ()


def readable(name: str) -> str:
    """A name as people read it, and as the robot's lines give it.

    Names out of files may hold bytes that are no UTF-8 as surrogates (`surrogateescape`): such a
    name is read as Latin-1, as `framing.decode` does.
    """
    if name.isascii():
        return name
    try:
        return name.encode('utf-8', 'surrogateescape').decode('utf-8')
    except UnicodeDecodeError:
        return name.encode('utf-8', 'surrogateescape').decode('latin-1')
    except UnicodeEncodeError:  # surrogates of another kind, which stand for nothing
        return name


def same_name(one: str, other: str) -> bool:
    """Whether two names mean the same object to the robot, which respects neither case nor ends."""
    return readable(one).strip().casefold() == readable(other).strip().casefold()


def coordinates(name: str) -> Tuple[float, ...]:
    """The two or three numbers (mm, mm, degrees) that `name` consists of; empty if it does not."""
    words = name.replace(',', ' ').split()
    try:
        numbers = tuple(map(float, words)) if len(words) in (2, 3) and '_' not in name else ()
    except ValueError:
        return ()
    return numbers if all(map(math.isfinite, numbers)) else ()


@dataclass(frozen=True)
class UnknownLine(Reply):
    """A line of no known kind: free text of another client, of a newer robot, or garbage."""

    text: str
