"""What is asked of the fleet's planner, as the supervisor asks it and the node answers it."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import FrozenSet, Mapping, Tuple

from graph_fleet_manager.planning.tasks import Obstacle, Task

Times = Mapping[Tuple[str, int], float]
"""Seconds by robot type's name and signed edge id."""


@dataclass(frozen=True)
class PlanRequest:
    """Everything that is to be planned; the planner remembers nothing of the fleet.

    tasks       -- one for each robot that obeys, names unique
    obstacles   -- robots that do not
    closed      -- ids of the edges that no robot may use
    edge_times  -- learned seconds by robot type's name and signed edge; they replace length / speed
    parking     -- ids of the vertices at which robots may be parked
    time_limit  -- s in which ways are searched for
    improvement -- s until which the plan is made better; both count from when planning begins
    seed        -- of all that is random; 0: the planner's own
    """

    tasks: Tuple[Task, ...]
    obstacles: Tuple[Obstacle, ...] = ()
    closed: FrozenSet[int] = frozenset()
    edge_times: Times = field(default_factory=dict)
    parking: FrozenSet[int] = frozenset()
    time_limit: float = 2.0
    improvement: float = 0.0
    seed: int = 0
