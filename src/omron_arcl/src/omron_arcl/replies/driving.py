"""The robot drives, docks, stops, and finds its place."""
from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from omron_arcl.replies.reply import Reply


@dataclass(frozen=True)
class GoingTo(Reply):
    """The robot set out for a goal."""

    goal: str


@dataclass(frozen=True)
class GoingToPoint(Reply):
    """The robot set out for a point given by coordinates."""


@dataclass(frozen=True)
class ArrivedAt(Reply):
    """The robot stands at a goal."""

    goal: str


@dataclass(frozen=True)
class ArrivedAtPoint(Reply):
    """The robot stands at the point that it was sent to."""


@dataclass(frozen=True)
class FailedGoingTo(Reply):
    """The robot gave up driving to a goal."""

    goal: str


@dataclass(frozen=True)
class Stopping(Reply):
    """The robot slows down to a halt."""


@dataclass(frozen=True)
class Stopped(Reply):
    """The robot halted. No proof of one's own `stop`: undocking and enabling motors end so too."""


@dataclass(frozen=True)
class Parking(Reply):
    """The robot is parking (`parked`: has parked) of its own accord."""

    parked: bool


@dataclass(frozen=True)
class Interrupted(Reply):
    """What ran was replaced or stopped; `text` is the status text it had, e.g. `Going to 12`."""

    text: str


@dataclass(frozen=True)
class RobotError(Reply):
    """`Error: <text>`: something failed while running; names no command."""

    text: str


@dataclass(frozen=True)
class Failure(Reply):
    """Something could not be done, said in free words: `Cannot find path`, `Failed to localize`."""

    text: str


@dataclass(frozen=True)
class Patrolling(Reply):
    """The robot drives the goals of a route, for ever or (`once`) one time."""

    route: str
    once: bool


@dataclass(frozen=True)
class FinishedPatrolling(Reply):
    """The last goal of a route patrolled once was reached."""

    route: str


@dataclass(frozen=True)
class LapCompleted(Reply):
    """A patrol begins again (older robots say so)."""


class DockingState(Enum):
    """Where the robot is between its path and its charging station."""

    UNDOCKED = 'Undocked'
    DOCKING = 'Docking'
    DOCKED = 'Docked'
    UNDOCKING = 'Undocking'


@dataclass(frozen=True)
class DockingStatus(Reply):
    """Docking state; `charge` is the charger's word: Not, Bulk, Overcharge, Float, Unknowable.

    Only `docking` tells whether the robot is docked: `charge` wavers while undocking.
    """

    docking: DockingState
    forced: bool
    charge: str


@dataclass(frozen=True)
class Localizing(Reply):
    """The robot looks for its place (`done`: has found it) where it was told."""

    done: bool
    text: str
