"""What a click on the map means: which goal or dock it hits, and whether it may move the robot.

No ROS here; metres in the map frame, and seconds of any steady clock.
"""
from __future__ import annotations

import enum
import math
from dataclasses import dataclass
from typing import Iterable, List, Optional, Sequence

from omron_ld90.arcl import quote
from omron_ld90.maps import MapDocument
from omron_ld90.nodes.units import metres


class TargetKind(enum.Enum):
    """What stands at a place the robot can be sent to by name."""

    GOAL = 'goal'
    DOCK = 'dock'


@dataclass(frozen=True)
class Target:
    """A goal or dock of the map, in metres and degrees; `heading` is None where any will do."""

    kind: TargetKind
    name: str
    x: float
    y: float
    heading: Optional[float] = None

    @property
    def command(self) -> str:
        """The ARCL command that brings the robot here; a dock is reached with `dock` only."""
        return 'dock' if self.kind is TargetKind.DOCK else f'goto {quote(self.name)}'

    def __str__(self) -> str:
        return f'{self.kind.value} {self.name}' if self.name else self.kind.value


def targets_of(document: MapDocument) -> List[Target]:
    """Every goal and dock of a map, in file order."""
    return [
        Target(TargetKind.DOCK if item.is_dock else TargetKind.GOAL, item.name,
               metres(item.x), metres(item.y), item.theta if item.has_heading else None)
        for item in document.objects if item.is_goal or item.is_dock]


@dataclass(frozen=True)
class Click:
    """The target nearest to a click, and whether the click was near enough to mean it."""

    target: Optional[Target]
    distance: float
    hit: bool


def resolve_click(targets: Iterable[Target], x: float, y: float, tolerance: float) -> Click:
    """The target that a click at (x, y) means: the nearest, if within `tolerance` (inclusive)."""
    nearest = min(targets, key=lambda t: math.hypot(t.x - x, t.y - y), default=None)
    if nearest is None:
        return Click(None, math.inf, False)
    distance = math.hypot(nearest.x - x, nearest.y - y)
    return Click(nearest, distance, distance <= tolerance)


def explain_miss(click: Click, tolerance: float) -> str:
    """Why a click did nothing, for people."""
    if click.target is None:
        return 'Nothing there: the map has no goal and no dock.'
    return (f'Nothing within {tolerance:.2f} m of the click: '
            f'{click.target} is the nearest, {click.distance:.2f} m away.')


class RouteWatch:
    """Tells from the states of routes whether the fleet is driving the robot.

    A running route is reported ten times a second, so one that was not heard of for `SILENCE`
    seconds is over: the bridge is gone, or its link to this computer is.
    """

    SILENCE = 3.0
    COMPLETE = 2
    FAILED = 3

    def __init__(self) -> None:
        self._running: Optional[int] = None
        self._heard = -math.inf

    def update(self, route_id: int, edge_states: Sequence[int], now: float) -> None:
        """Take in one message: the state of every edge, in order, heard at `now`."""
        failed = any(state == self.FAILED for state in edge_states)
        finished = all(state == self.COMPLETE for state in edge_states)
        if not failed and not finished:
            self._running, self._heard = route_id, now
        elif route_id == self._running or not failed:
            self._running = None
        # What is left is another route's refusal, which leaves the running one alone.

    def running(self, now: float) -> Optional[int]:
        """The id of the route being driven at `now`, or None."""
        return self._running if now - self._heard <= self.SILENCE else None
