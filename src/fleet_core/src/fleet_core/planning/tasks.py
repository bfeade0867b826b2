"""The input and the answer of the planner, in the ids of the graph."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Mapping, NamedTuple, Optional, Tuple

from fleet_core.fleet import RobotType
from fleet_core.geometry.areas import Area
from fleet_core.planning.precedence import Constraint


class PlannedDrive(NamedTuple):
    """One edge of a plan, driven from `start` to `end` (s from the beginning of planning)."""

    edge: int
    """Signed id."""
    start: float
    end: float


@dataclass(frozen=True)
class Task:
    """The task of one robot: where it is, which edges are released, and what it is to do next.

    It is the planner's whole input about this robot, one field for each fact.

    name, type    -- of the robot
    vertex        -- the vertex on which it stands; None: it is on an edge
    released      -- signed ids of the edges that it was ordered to drive; each plan begins with
                     them
    begun         -- the fraction of the first released edge that lies behind the robot
    mid_edge      -- signed id and fraction of the edge on which it stands and which it may leave in
                     both directions; None: it stands on a vertex or is driving
    ready         -- s that it waits after the released edges, because of a dwell or a delay
    destinations  -- ids of the vertices that it is to visit after the released edges, in order
    dwells        -- s to stay at each destination; empty: no stays
    stays         -- it is to stay at its last destination for ever; otherwise it goes on to parking
    kept          -- its present plan after the released edges, with the old times; they can be
                     compared with the old times of other robots. None: it has no plan
    priority      -- robots with a higher priority are planned first
    """

    name: str
    type: RobotType
    vertex: Optional[int] = None
    released: Tuple[int, ...] = ()
    begun: float = 0.0
    mid_edge: Optional[Tuple[int, float]] = None
    ready: float = 0.0
    destinations: Tuple[int, ...] = ()
    dwells: Tuple[float, ...] = ()
    stays: bool = False
    kept: Optional[Tuple[PlannedDrive, ...]] = None
    priority: int = 0


@dataclass(frozen=True)
class Obstacle:
    """A robot without a plan: it may be anywhere on these vertices, edges and areas."""

    name: str
    type: RobotType
    vertices: Tuple[int, ...] = ()
    edges: Tuple[int, ...] = ()
    areas: Tuple[Area, ...] = ()


@dataclass(frozen=True)
class PlanningOutcome:
    """The answer of the planner: the plans of all robots, and the order that makes them safe.

    drives       -- for each robot all of its drives, including the released ones
    precedence   -- the order of use; drives are counted from 0 in `drives`
    unserved     -- the robots whose plans do not reach their destinations, each with the reason
    cost         -- sum of the costs of the robots whose plans reach their destinations
    lower_bound  -- the sum of the costs that these robots would have without traffic
    rounds       -- number of neighbourhoods that were tried for improvement
    """

    drives: Mapping[str, Tuple[PlannedDrive, ...]]
    precedence: Tuple[Constraint, ...]
    unserved: Mapping[str, str] = field(default_factory=dict)
    cost: float = 0.0
    lower_bound: float = 0.0
    rounds: int = 0


class CannotPlan(Exception):
    """An invalid request to the planner. The text is one sentence that says what to do."""
