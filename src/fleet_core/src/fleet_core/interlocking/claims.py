"""Claims: the places of the site's geometry that robots hold, and which of them exclude each other.
"""
from __future__ import annotations

from typing import Dict, Iterator, List, NamedTuple, Sequence, Tuple

from fleet_core.fleet import RobotType
from fleet_core.geometry.site_geometry import SiteGeometry
from fleet_core.interlocking.allocation import Allocation


class Claim(NamedTuple):
    """A place of the site's geometry that a robot may be on.

    forward -- for an edge: the robot drives it in the edge's own direction
    cleared -- for an edge: the fraction of it, in driving direction, that lies behind the robot
    """

    place: int
    forward: bool = True
    cleared: float = 0.0


class ClaimIndex:
    """The claims of many robots, found by their places.

    clearance -- m that stays free between any two robots
    """

    def __init__(self, geometry: SiteGeometry, clearance: float) -> None:
        self._geometry, self._clearance = geometry, clearance
        self._claims: Dict[str, List[Claim]] = {}
        self._kinds: Dict[str, RobotType] = {}
        self._at: Dict[RobotType, Dict[int, List[Tuple[str, Claim]]]] = {}

    def claims(self, name: str) -> Sequence[Claim]:
        """The claims of a robot by its edges and its vertex, but not by its areas."""
        return self._claims.get(name, ())

    def _claims_of(self, allocation: Allocation) -> List[Claim]:
        claims = [Claim(self._geometry.edge_place(hold.edge), hold.edge > 0, hold.cleared)
                  for hold in allocation.holds]
        if allocation.vertex is not None:
            claims.append(Claim(self._geometry.index[allocation.vertex]))
        return claims

    def put(self, name: str, allocation: Allocation) -> None:
        """Replaces the claims of a robot."""
        self.remove(name)
        self.add(name, allocation.kind, self._claims_of(allocation))

    def add(self, name: str, kind: RobotType, claims: Sequence[Claim]) -> None:
        """Adds the claims of a robot that has none."""
        self._claims[name] = list(claims)
        self._kinds[name] = kind
        at = self._at.setdefault(kind, {})
        for claim in claims:
            at.setdefault(claim.place, []).append((name, claim))

    def remove(self, name: str) -> None:
        """Removes the claims of a robot, if there are any."""
        claims = self._claims.pop(name, [])
        if claims:
            at = self._at[self._kinds[name]]
            for place in {claim.place for claim in claims}:
                at[place] = [held for held in at[place] if held[0] != name]

    def excluding(self, robot: str, kind: RobotType, claim: Claim) -> Iterator[str]:
        """Names of other robots with a claim that excludes this claim of `robot`."""
        exclusions = self._geometry.exclusions
        for other_kind, at in self._at.items():
            distance = kind.reach + other_kind.reach + self._clearance
            for conflict in exclusions.excluding(claim.place, distance):
                held = at.get(conflict.other)
                if not held:
                    continue
                clear = conflict.forward if claim.forward else conflict.backward
                if claim.cleared and clear <= claim.cleared:
                    continue
                for name, other in held:
                    clear = conflict.other_forward if other.forward else conflict.other_backward
                    if name != robot and not (other.cleared and clear <= other.cleared):
                        yield name
