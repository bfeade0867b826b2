"""The types of robots with loads.

A robot with a load counts as a robot of another type (`fleet.RobotType`). This type has another
radius and another speed, and edges that are closed to it. So the planner and the interlocking need
no rules for loads. A site without types of load has no such types of robots.
"""
from __future__ import annotations

from dataclasses import replace
from typing import AbstractSet, Dict, Iterable, Mapping, Tuple

from fleet_core.fleet import RobotType
from fleet_core.work.loads import LoadType


class LadenTypes:
    """For each robot type and each type of load, the type of a robot that carries such a load.

    A robot that may carry one of several types of load, or a load of unknown type, has the largest
    radius, the lowest speed, and all closed edges of these types of load.

    loads -- the types of load of the site, by name
    types -- the robot types of the fleet, without loads
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
        """All types that were made for loads, without the types of the fleet."""

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
        """Returns the type of a robot that may carry any of these types of load.

        kind -- its type without load
        """
        return self._of(self._laden, kind, loads)

    def ready(self, kind: RobotType, loads: AbstractSet[str]) -> RobotType:
        """Returns the type of a robot that is empty, but is to take one of these types of load.

        Its radius is already that of the robot with the load.
        """
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
                    frozenset(edge for load in some for edge in load.closed))
