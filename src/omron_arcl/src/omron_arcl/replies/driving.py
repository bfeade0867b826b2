"""Replies about driving, docking, stopping and localizing."""
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
    """The robot halted. This does not prove that a `stop` was obeyed: undocking and enabling the
    motors end in the same way."""


@dataclass(frozen=True)
class Parking(Reply):
    """The robot parks by its own decision (`parked`: it has parked)."""

    parked: bool


@dataclass(frozen=True)
class Interrupted(Reply):
    """A motion was replaced or stopped; `text` is the status text it had, e.g. `Going to 12`."""

    text: str


@dataclass(frozen=True)
class RobotError(Reply):
    """`Error: <text>`: something failed while it ran; the line names no command."""

    text: str


@dataclass(frozen=True)
class Failure(Reply):
    """A failure in free words: `Cannot find path`, `Failed to localize`."""

    text: str


@dataclass(frozen=True)
class Patrolling(Reply):
    """The robot drives to the goals of a route, endlessly or (`once`) one time."""

    route: str
    once: bool


@dataclass(frozen=True)
class FinishedPatrolling(Reply):
    """The robot reached the last goal of a route that it patrolled once."""

    route: str


@dataclass(frozen=True)
class LapCompleted(Reply):
    """A patrol begins again (sent by older robots)."""


class DockingState(Enum):
    """The state of the robot between its path and its charging station."""

    UNDOCKED = 'Undocked'
    DOCKING = 'Docking'
    DOCKED = 'Docked'
    UNDOCKING = 'Undocking'


@dataclass(frozen=True)
class DockingStatus(Reply):
    """The docking state; `charge`: the charger's state, Not, Bulk, Overcharge, Float, Unknowable.

    Only `docking` says whether the robot is docked: `charge` is unreliable while undocking.
    """

    docking: DockingState
    forced: bool
    charge: str


@dataclass(frozen=True)
class Localizing(Reply):
    """The robot searches for its position (`done`: it has found it) at the given place."""

    done: bool
    text: str
