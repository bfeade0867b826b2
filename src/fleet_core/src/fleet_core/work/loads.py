"""Types of load: what a robot needs more, and where it may not go, while it carries one."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Collection, FrozenSet, Optional

from fleet_core.work.stops import LoadEffect, WorkStep


@dataclass(frozen=True)
class LoadType:
    """A type of load.

    radius -- m, of the disc that contains the robot and its load; None: that of the robot
    speed  -- m/s, at most; None: as without it
    closed -- ids of the edges onto which no robot is sent with it
    """

    name: str
    radius: Optional[float] = None
    speed: Optional[float] = None
    closed: FrozenSet[int] = frozenset()


def fault_of_load(step: WorkStep, loads: Collection[str]) -> str:
    """Returns why a step does not fit the types of load of a site, as words after its name.

    Empty: it does.
    """
    known = ', '.join(loads) or 'none'
    if step.load_type and step.load_type not in loads:
        return f'takes {step.load_type[:40]!r}, but the loads of the work file are: {known}'
    if step.load is LoadEffect.TAKES and loads and not step.load_type:
        return (f'takes a load, so it needs a load_type: the loads of the work file are: {known}')
    return ''
