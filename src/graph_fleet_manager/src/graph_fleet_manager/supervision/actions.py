"""What the supervisor wants done; its caller does this in the order given."""
from __future__ import annotations

from dataclasses import dataclass
from typing import FrozenSet, Tuple, Union

from graph_fleet_manager.plan_requests import Times
from graph_fleet_manager.planning.tasks import Obstacle, Task
from graph_fleet_manager.supervision.missions import Status


@dataclass(frozen=True)
class SendRoute:
    """Publish a target route; a `repeated` one with the stamp that it had before.

    known_epoch -- of the robot's motion, that it reported when the order was decided; 0: none
    """

    robot: str
    route_id: int
    edges: Tuple[int, ...]
    repeated: bool = False
    known_epoch: int = 0


@dataclass(frozen=True)
class TellStatus:
    """Publish what became of a request."""

    status: Status


@dataclass(frozen=True)
class AskPlanner:
    """Ask the planner; its answer comes back with this number.

    edge_times -- learned ones, instead of length / speed
    seed       -- of the planner's chance; another one where the last answer served not all
    """

    number: int
    tasks: Tuple[Task, ...]
    obstacles: Tuple[Obstacle, ...]
    closed: FrozenSet[int]
    edge_times: Times
    seed: int = 0


@dataclass(frozen=True)
class Note:
    """Tell the people who watch."""

    text: str
    is_warning: bool = False


Action = Union[SendRoute, TellStatus, AskPlanner, Note]
"""Anything that the supervisor may want done."""
