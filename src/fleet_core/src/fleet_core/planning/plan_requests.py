"""Requests to the planner, as the supervisor sends them and the planner node answers them."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import FrozenSet, Mapping, Tuple

from fleet_core.fleet import RobotType
from fleet_core.geometry.site_geometry import Alone
from fleet_core.planning.tasks import Obstacle, Task

Times = Mapping[Tuple[str, int], float]
"""Seconds by the name of the robot type and the signed edge id."""


@dataclass(frozen=True)
class PlanRequest:
    """All data for one plan. The planner keeps no state of the fleet.

    tasks       -- one for each robot that obeys; names are unique
    obstacles   -- robots that cannot be planned for
    closed      -- ids of the edges that no robot may use
    edge_times  -- learned seconds by robot type's name and signed edge; they replace length / speed
    alone       -- places on which one robot may be at once, however far apart they are
    parking     -- ids of the vertices at which robots may be parked
    time_limit  -- s for the search, from the beginning of planning
    improvement -- s until which the plan is improved, from the beginning of planning
    seed        -- of all random choices; 0: the planner's own
    reserved    -- ids of the vertices at which no robot is parked if there is enough other parking
    laden       -- types of robots with loads, besides those of the fleet
    """

    tasks: Tuple[Task, ...]
    obstacles: Tuple[Obstacle, ...] = ()
    closed: FrozenSet[int] = frozenset()
    edge_times: Times = field(default_factory=dict)
    alone: Tuple[Alone, ...] = ()
    parking: FrozenSet[int] = frozenset()
    time_limit: float = 2.0
    improvement: float = 0.0
    seed: int = 0
    reserved: FrozenSet[int] = frozenset()
    laden: Tuple[RobotType, ...] = ()
