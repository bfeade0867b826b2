"""The common base of all kinds of lines.

Lengths are in mm, angles in degrees, in the robot's map frame, as in ARCL (the ROS nodes convert
them to SI). Names (goals, routes, ...) are spelt as the robot spelt them. Compare them with
`same_name`, because the robot ignores case.
"""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Tuple


class Reply:
    """Base of every kind of line. Distinguish them with `isinstance`."""

    __slots__ = ()


def readable(name: str) -> str:
    """A name as people read it, and as the robot's lines contain it.

    Names from files may contain bytes that are not valid UTF-8 as surrogates (`surrogateescape`).
    Such a name is read as Latin-1, as in `framing.decode`.
    """
    if name.isascii():
        return name
    try:
        return name.encode('utf-8', 'surrogateescape').decode('utf-8')
    except UnicodeDecodeError:
        return name.encode('utf-8', 'surrogateescape').decode('latin-1')
    except UnicodeEncodeError:  # other surrogates, which represent no bytes
        return name


def same_name(one: str, other: str) -> bool:
    """Whether two names mean the same object to the robot, which ignores case and outer blanks."""
    return readable(one).strip().casefold() == readable(other).strip().casefold()


def coordinates(name: str) -> Tuple[float, ...]:
    """The two or three numbers (mm, mm, degrees) that `name` consists of; else empty."""
    words = name.replace(',', ' ').split()
    try:
        numbers = tuple(map(float, words)) if len(words) in (2, 3) and '_' not in name else ()
    except ValueError:
        return ()
    return numbers if all(map(math.isfinite, numbers)) else ()


@dataclass(frozen=True)
class UnknownLine(Reply):
    """A line of no known kind: text of another client, a line of a newer robot, or garbage."""

    text: str
