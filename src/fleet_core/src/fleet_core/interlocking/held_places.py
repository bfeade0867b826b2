"""Held places: the places of the geometry that robots hold, and which of them exclude each other.
"""
from __future__ import annotations

from typing import Dict, Iterator, List, NamedTuple, Sequence, Tuple

from fleet_core.fleet import RobotType
from fleet_core.geometry.site_geometry import SiteGeometry
from fleet_core.interlocking.allocation import Allocation


class HeldPlace(NamedTuple):
    """A place of the site's geometry that a robot may be on.

    forward -- for an edge: the robot drives it in the edge's own direction
    cleared -- for an edge: the fraction of it, in driving direction, that lies behind the robot
    """

    place: int
    forward: bool = True
    cleared: float = 0.0


class HeldPlaces:
    """The places that robots hold, found by the numbers of the places.

    clearance -- m that stays free between any two robots
    """

    def __init__(self, geometry: SiteGeometry, clearance: float) -> None:
        self._geometry, self._clearance = geometry, clearance
        self._held: Dict[str, List[HeldPlace]] = {}
        self._kinds: Dict[str, RobotType] = {}
        self._at: Dict[RobotType, Dict[int, List[Tuple[str, HeldPlace]]]] = {}

    def places(self, name: str) -> Sequence[HeldPlace]:
        """Returns the places of a robot's edges and vertex. The places in its areas are omitted."""
        return self._held.get(name, ())

    def _places_of(self, allocation: Allocation) -> List[HeldPlace]:
        places = [HeldPlace(self._geometry.edge_place(hold.edge), hold.edge > 0, hold.cleared)
                  for hold in allocation.holds]
        if allocation.vertex is not None:
            places.append(HeldPlace(self._geometry.index[allocation.vertex]))
        return places

    def put(self, name: str, allocation: Allocation) -> None:
        """Replaces the places that a robot holds."""
        self.remove(name)
        self.add(name, allocation.kind, self._places_of(allocation))

    def add(self, name: str, kind: RobotType, places: Sequence[HeldPlace]) -> None:
        """Adds the places of a robot that holds none yet."""
        self._held[name] = list(places)
        self._kinds[name] = kind
        at = self._at.setdefault(kind, {})
        for held in places:
            at.setdefault(held.place, []).append((name, held))

    def remove(self, name: str) -> None:
        """Removes the places that a robot holds, if there are any."""
        places = self._held.pop(name, [])
        if places:
            at = self._at[self._kinds[name]]
            for place in {held.place for held in places}:
                at[place] = [pair for pair in at[place] if pair[0] != name]

    def excluding(self, robot: str, kind: RobotType, held: HeldPlace) -> Iterator[str]:
        """Yields the names of other robots that hold a place which excludes this place of `robot`.
        """
        exclusions = self._geometry.exclusions
        for other_kind, at in self._at.items():
            distance = kind.reach + other_kind.reach + self._clearance
            for conflict in exclusions.excluding(held.place, distance):
                others = at.get(conflict.other)
                if not others:
                    continue
                clear = conflict.forward if held.forward else conflict.backward
                if held.cleared and clear <= held.cleared:
                    continue
                for name, other in others:
                    clear = conflict.other_forward if other.forward else conflict.other_backward
                    if name != robot and not (other.cleared and clear <= other.cleared):
                        yield name
