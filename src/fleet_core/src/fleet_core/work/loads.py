"""Types of load: what a robot needs more, and where it may not go, while it carries one.

A robot with a load is a robot of another type (`fleet.RobotType`): it has another radius and
another speed, and edges that are closed to it. So the planner and the interlocking need no rule of
their own for loads, and a site without types of load has no such types of robots.
"""
from __future__ import annotations

from dataclasses import dataclass, replace
from typing import AbstractSet, Collection, Dict, FrozenSet, Iterable, Mapping, Optional, Tuple

from fleet_core.fleet import RobotType
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


class LadenTypes:
    """The robot types of a fleet, with each load.

    A robot that may carry several types of load, or one whose type is not known, has the
    largest radius, the lowest speed, and the closed edges of all.

    loads -- by name, those of the site
    types -- of the fleet, without loads
    """

    def __init__(self, loads: Mapping[str, LoadType], types: Iterable[RobotType]) -> None:
        self._loads = loads
        self._laden: Dict[Tuple[str, str], RobotType] = {}
        self._ready: Dict[Tuple[str, str], RobotType] = {}
        for kind in dict.fromkeys(types):
            for name, load in loads.items():
                self._add(kind, name, load)
            if len(loads) > 1:
                self._add(kind, _ANY, _strictest(loads.values()))
        self.types: Tuple[RobotType, ...] = tuple(dict.fromkeys(
            kind for kind in (*self._laden.values(), *self._ready.values()) if kind.without_load))
        """All of them, besides those of the fleet."""

    def __bool__(self) -> bool:
        """Returns whether the site has any type of load."""
        return bool(self._loads)

    def _add(self, kind: RobotType, name: str, load: LoadType) -> None:
        radius = max(kind.radius, load.radius or 0.0)
        speed = min(kind.speed, load.speed or kind.speed)
        self._laden[kind.name, name] = replace(
            kind, name=f'{kind.name} with {name}', radius=radius, speed=speed,
            without_load=kind.name, own_speed=kind.speed, closed=load.closed)
        self._ready[kind.name, name] = kind if radius == kind.radius else replace(
            kind, name=f'{kind.name} ready for {name}', radius=radius, without_load=kind.name,
            own_speed=kind.speed)

    def laden(self, kind: RobotType, loads: AbstractSet[str]) -> RobotType:
        """Returns the type of a robot that may carry these types of load.

        kind -- its type without load
        """
        return self._of(self._laden, kind, loads)

    def ready(self, kind: RobotType, loads: AbstractSet[str]) -> RobotType:
        """Returns the type of an empty robot that has room to take each of these types of load."""
        return self._of(self._ready, kind, loads)

    def _of(self, types: Mapping[Tuple[str, str], RobotType], kind: RobotType,
            loads: AbstractSet[str]) -> RobotType:
        if not (loads and self._loads):
            return kind
        some = loads if loads <= self._loads.keys() else self._loads.keys()
        return types[kind.name, next(iter(some)) if len(some) == 1 else _ANY]


_ANY = 'any load'


def _strictest(loads: Iterable[LoadType]) -> LoadType:
    some = tuple(loads)
    return LoadType(_ANY, max(load.radius or 0.0 for load in some),
                    min((load.speed for load in some if load.speed), default=None),
                    frozenset().union(*(load.closed for load in some)))
