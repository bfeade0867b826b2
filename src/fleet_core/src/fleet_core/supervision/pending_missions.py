"""Missions that wait for a robot, in the order in which they are to be served.

There may be thousands, so the work for each event must not depend on their number.
"""
from __future__ import annotations

from bisect import bisect_left, bisect_right, insort
from typing import Dict, List, Mapping, Tuple

from fleet_core.supervision.missions import Mission

Key = Tuple[int, int]
"""The negative priority and the serial. The least key is served first."""
Kind = Tuple[str, str]
"""Type and name of the robot that a mission wants; empty: any."""

FIRST: Key = (-2 ** 63, 0)


def key_of(mission: Mission) -> Key:
    """Returns the sort key of a mission: higher priorities come first, then older missions."""
    return -mission.request.priority, mission.serial


class PendingMissions:
    """All waiting missions, also sorted by kind."""

    def __init__(self) -> None:
        self.changes = 0
        """Number of times that a mission was added or removed."""
        self._missions: Dict[Key, Mission] = {}
        self._order: List[Key] = []
        self._kinds: Dict[Kind, List[Key]] = {}

    def __len__(self) -> int:
        return len(self._order)

    def __contains__(self, mission: Mission) -> bool:
        return key_of(mission) in self._missions

    def add(self, mission: Mission) -> None:
        """Adds a mission that waits now."""
        key, kind = key_of(mission), _kind_of(mission)
        self._missions[key] = mission
        insort(self._order, key)
        insort(self._kinds.setdefault(kind, []), key)
        self.changes += 1

    def remove(self, mission: Mission) -> None:
        """Removes a mission that does not wait any more."""
        key, kind = key_of(mission), _kind_of(mission)
        del self._missions[key]
        keys = self._kinds[kind]
        for order in (self._order, keys):
            del order[bisect_left(order, key)]
        if not keys:
            del self._kinds[kind]
        self.changes += 1

    def first(self, free: Mapping[str, str]) -> List[Mission]:
        """Returns the first missions of each kind: as many as there are free robots for this kind.

        free -- types of the free robots, by name
        """
        of_type: Dict[str, int] = {'': len(free)}
        for kind in free.values():
            of_type[kind] = of_type.get(kind, 0) + 1
        found: List[Mission] = []
        for (kind, name), keys in self._kinds.items():
            count = int(name in free) if name else of_type.get(kind, 0)
            found += [self._missions[key] for key in keys[:count]]
        return found

    def behind(self, key: Key, count: int) -> List[Mission]:
        """Returns the next `count` missions after a key; the last mission is followed by the first.
        """
        start = bisect_right(self._order, key)
        keys = self._order[start:start + count]
        keys += self._order[:min(start, count - len(keys))]
        return [self._missions[key] for key in keys]


def _kind_of(mission: Mission) -> Kind:
    return mission.request.robot_type, mission.request.robot
