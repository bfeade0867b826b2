"""Types of load: how much room a robot with a load needs, how fast it is, and where it may go."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Collection, FrozenSet, Optional

from fleet_core.work.stops import LoadEffect, WorkStep


@dataclass(frozen=True)
class LoadType:
    """A type of load.

    radius -- m, of the disc that contains the robot and its load; None: the radius of the robot
    speed  -- m/s that a robot with this load does not exceed; None: the load sets no limit
    closed -- ids of the edges onto which no robot is sent with this load
    """

    name: str
    radius: Optional[float] = None
    speed: Optional[float] = None
    closed: FrozenSet[int] = frozenset()


def fault_of_load(step: WorkStep, loads: Collection[str]) -> str:
    """Returns why a step does not fit a site's types of load, in words that follow the step's name.

    Empty: it fits.
    """
    known = ', '.join(loads) or 'none'
    if step.load_type and step.load_type not in loads:
        return f'takes {step.load_type[:40]!r}, but the loads of the work file are: {known}'
    if step.load is LoadEffect.TAKES and loads and not step.load_type:
        return (f'takes a load, so it needs a load_type: the loads of the work file are: {known}')
    return ''
