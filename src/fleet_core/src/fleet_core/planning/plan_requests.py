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

    tasks       -- one for each robot for which the planner can plan; names are unique
    obstacles   -- robots for which the planner cannot plan
    closed      -- ids of the edges that no robot may use
    edge_times  -- learned seconds, by type name and signed edge id; they replace length / speed
    alone       -- groups of places; at any time only one robot may be in a group, however far
                   apart its places are
    parking     -- ids of the vertices at which robots may be parked
    time_limit  -- s for the search, from the beginning of planning
    improvement -- s after the beginning of planning at which the improvement of the plan ends
    seed        -- for all random choices; 0: the planner's own seed
    reserved    -- ids of the vertices at which no robot is parked if there is enough other parking
    laden       -- types of robots with loads, in addition to the types of the fleet
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
