"""Finds the goal or dock that a click on the map hits. Metres, in the map frame."""
from __future__ import annotations

import enum
import math
from dataclasses import dataclass
from typing import Iterable, List, Optional, Tuple

import numpy as np

from omron_arcl import quote, same_name
from omron_ld90.units import metres
from omron_map import MapDocument


class TargetKind(enum.Enum):
    """The kind of a place to which the robot can be sent by name."""

    GOAL = 'goal'
    DOCK = 'dock'


@dataclass(frozen=True)
class Target:
    """A goal or dock of the map, in m and degrees; `heading` is None if any heading is allowed.

    `name` is the readable name, regardless of the encoding of the map file.
    """

    kind: TargetKind
    name: str
    x: float
    y: float
    heading: Optional[float] = None

    @property
    def command(self) -> str:
        """The ARCL command that drives the robot here. For a dock it is `dock`, without a name.

        Raises InvalidCommand if no ARCL command can contain the name, for example because of a
        quote in the name.
        """
        return 'dock' if self.kind is TargetKind.DOCK else f'goto {quote(self.name)}'

    @property
    def place(self) -> Tuple[float, float]:
        """x and y."""
        return self.x, self.y

    def __str__(self) -> str:
        return f'{self.kind.value} {self.name}' if self.name else self.kind.value


def targets_of(document: MapDocument) -> List[Target]:
    """Returns every goal and dock of a map, in file order."""
    return [
        Target(TargetKind.DOCK if item.is_dock else TargetKind.GOAL, item.label,
               metres(item.x), metres(item.y), item.theta if item.has_heading else None)
        for item in document.objects if item.is_goal or item.is_dock]


def target_named(name: str, targets: Iterable[Target]) -> Optional[Target]:
    """Returns the target that the robot calls `name`, or None."""
    return next((target for target in targets if same_name(target.name, name)), None)


def extent_in_x(document: MapDocument) -> Tuple[float, float]:
    """Returns the smallest and largest x (m) of the points and lines in a map.

    Without points and lines, returns infinite values.
    """
    xs = np.concatenate([document.points[:, 0], document.lines[:, ::2].ravel()])
    return (metres(xs.min()), metres(xs.max())) if xs.size else (-math.inf, math.inf)


@dataclass(frozen=True)
class Click:
    """The target nearest to a click, and whether the click was near enough to hit it."""

    target: Optional[Target]
    distance: float
    hit: bool


def resolve_click(targets: Iterable[Target], x: float, y: float, tolerance: float) -> Click:
    """Returns the target nearest to a click at (x, y), and whether it is within `tolerance` (m)."""
    nearest = min(targets, key=lambda t: math.hypot(t.x - x, t.y - y), default=None)
    if nearest is None:
        return Click(None, math.inf, False)
    distance = math.hypot(nearest.x - x, nearest.y - y)
    return Click(nearest, distance, distance <= tolerance)


def explain_miss(click: Click, tolerance: float) -> str:
    """Returns a sentence that tells a person why a click had no effect."""
    if click.target is None:
        return 'Nothing there: the map has no goal and no dock.'
    return (f'Nothing within {tolerance:.2f} m of the click: '
            f'{click.target} is the nearest, {click.distance:.2f} m away.')
