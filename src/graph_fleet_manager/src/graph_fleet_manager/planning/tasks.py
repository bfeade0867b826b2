"""What the planner is asked and what it answers, in the ids of the graph."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Mapping, NamedTuple, Optional, Tuple

from graph_fleet_manager.fleet import RobotType
from graph_fleet_manager.geometry.areas import Area
from graph_fleet_manager.planning.precedence import Constraint


class PlannedDrive(NamedTuple):
    """One edge of a plan, driven from `start` to `end` (s from the planning's zero)."""

    edge: int
    """Signed id."""
    start: float
    end: float


@dataclass(frozen=True)
class Task:
    """One robot: where it is, what it will do in any case, and what it is to do next.

    name, type    -- of the robot
    vertex        -- the vertex on which it stands; None where it is on an edge
    released      -- signed ids of the edges that it will drive under every plan, in order
    begun         -- the fraction of the first of them that lies behind it
    mid_edge      -- signed id and fraction of the edge on which it stands, free to go either way;
                     None where it stands on a vertex or is driving
    ready         -- s before it can go on behind what is released, in a dwell or held up
    destinations  -- ids of the vertices that it is to visit after what is released, in order
    dwells        -- s to stay at each; empty: none anywhere
    stays         -- it is to stay at its last destination for ever; otherwise it goes on to parking
    kept          -- the plan behind what is released that it owns by now: edges and old times,
                     compared with those of all other robots; None: it has none
    priority      -- the higher is planned first
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
    """A robot that goes nowhere by a plan: it may be anywhere on these vertices, edges and areas.
    """

    name: str
    type: RobotType
    vertices: Tuple[int, ...] = ()
    edges: Tuple[int, ...] = ()
    areas: Tuple[Area, ...] = ()


@dataclass(frozen=True)
class Outcome:
    """The plans of all robots, and what makes them safe.

    drives       -- for each robot all that it is to drive, what was released included
    precedence   -- the order of use; drives are counted from 0 in `drives`
    unserved     -- robots whose destinations are in no plan now, and why, in words
    cost         -- sum over the robots of the time at which all is done
    lower_bound  -- the same, were each alone
    rounds       -- neighbourhoods tried to make it better
    """

    drives: Mapping[str, Tuple[PlannedDrive, ...]]
    precedence: Tuple[Constraint, ...]
    unserved: Mapping[str, str] = field(default_factory=dict)
    cost: float = 0.0
    lower_bound: float = 0.0
    rounds: int = 0


class CannotPlan(Exception):
    """What was asked makes no sense; the text is one sentence that says what to do."""
