"""Resources: what places need in addition to room, such as a door that must be open.

A door, an air lock, a light, a zone, a station or a charger is a resource. A robot may be in a
place that needs a resource only with a claim to it (`claims`).
"""
from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import AbstractSet, Dict, FrozenSet, Iterable, Mapping, NamedTuple, Set, Tuple

from fleet_core.geometry.site_geometry import SiteGeometry
from fleet_core.interlocking.allocation import Allocation

NOTHING: FrozenSet[str] = frozenset()


class ResourceKind(Enum):
    """The kind of a resource. The values are shown to people."""

    DOOR = 'door'
    AIR_LOCK = 'air lock'  # its doors are one resource: a robot enters only if it may also leave
    LIGHT = 'light'
    ZONE = 'zone'
    STATION = 'station'
    CHARGER = 'charger'


@dataclass(frozen=True)
class Resource:
    """A resource of a site.

    edges      -- ids of the edges that need it
    vertices   -- ids of the vertices that need it; the edges at these vertices need it, too
    capacity   -- number of robots that may claim it at once
    has_device -- a device must report that the resource is ready; False: it is always ready
    """

    name: str
    kind: ResourceKind
    edges: FrozenSet[int] = frozenset()
    vertices: FrozenSet[int] = frozenset()
    capacity: int = 1
    has_device: bool = False

    def __str__(self) -> str:
        return f'{self.kind.value} {self.name}'

    @property
    def orders_plans(self) -> bool:
        """Whether plans keep an order of use for this resource.

        They do if only one robot may claim the resource and it has several places. Without the
        order of use, two robots could be at these places at once.
        """
        return self.capacity == 1 and (bool(self.edges) or len(self.vertices) > 1)


class Rest(NamedTuple):
    """The part of an edge that a robot has still to drive.

    behind -- the fraction of the edge, in driving direction, that lies behind the robot's centre
    reach  -- m around its centre that the robot may cover
    """

    behind: float = 0.0
    reach: float = 0.0


WHOLE = Rest()


class Needs:
    """The resources that the places of one graph need.

    An edge also needs what the vertices at its ends need, because a robot on the edge may stand
    there. But if no part of the robot covers the vertex behind it any more, the part of the edge
    ahead of the robot does not need the resources of that vertex. So if a person puts a robot down
    on the edge, it may drive on while another robot claims these resources. If a robot claims them
    already, it keeps the claim until it has left the edge.
    """

    def __init__(self, resources: Iterable[Resource], geometry: SiteGeometry) -> None:
        self.resources: Mapping[str, Resource] = {one.name: one for one in resources}
        self.has_devices = any(one.has_device for one in self.resources.values())
        """Whether any resource is ready only if a device reports so."""
        self._geometry = geometry
        self._at: Dict[int, FrozenSet[str]] = {}  # by place
        self._vertices: Set[int] = set()  # places of vertices that need anything
        self._of_edge: Dict[int, FrozenSet[str]] = {}  # computed once, because each grant needs it
        self._covered: Dict[Tuple[int, float], float] = {}
        for one in self.resources.values():
            vertices = [geometry.index[vertex] for vertex in one.vertices & geometry.index.keys()]
            self._vertices.update(vertices)
            for place in (*vertices, *(geometry.edge_place(edge) for edge in
                                       one.edges & geometry.edge_index.keys())):
                self._at[place] = self._at.get(place, NOTHING) | {one.name}

    def of_vertex(self, vertex: int) -> FrozenSet[str]:
        """Returns the names of the resources that a vertex needs."""
        return self._at.get(self._geometry.index[vertex], NOTHING)

    def of_edge(self, edge: int, rest: Rest = WHOLE) -> FrozenSet[str]:
        """Returns the names of the resources that a signed edge and the vertices at its ends need.

        rest -- the part of the edge that counts; the vertex at its start counts, too, if the robot
                still covers it
        """
        known = self._of_edge.get(edge)
        if known is None:
            one, other = self._ends(edge)
            known = self._of_edge[edge] = (
                self._inside(edge) | self.of_vertex(one) | self.of_vertex(other))
        if not (rest.behind and known) or rest.behind <= self._covers_start(edge, rest.reach):
            return known
        return self._inside(edge) | self.of_vertex(self._ends(edge)[1])

    def _covers_start(self, edge: int, reach: float) -> float:
        """Returns the fraction of a signed edge up to which a robot still covers the edge's start.
        """
        known = self._covered.get((edge, reach))
        if known is None:
            start = self._geometry.graph.start_vertex(edge).position
            low, high = self._geometry.exclusions.near((start,), reach).get(
                self._geometry.edge_place(edge), (0.0, 1.0))
            known = self._covered[edge, reach] = high if edge > 0 else 1.0 - low
        return known

    def on_entry(self, edge: int, is_inside: bool) -> FrozenSet[str]:
        """Returns the names of the resources that a robot enters when it drives a signed edge.

        is_inside -- the robot stands on the edge already, between its ends
        """
        _, end = self._ends(edge)
        return self.of_vertex(end) | (NOTHING if is_inside else self._inside(edge))

    def of(self, allocation: Allocation, claimed: AbstractSet[str] = NOTHING) -> FrozenSet[str]:
        """Returns the names of the resources that the places of an allocation need.

        For resources in `claimed`, whole edges count, not only the rest of each edge.

        A robot that may stand between vertices needs what an edge needs if its centre may be on
        that edge. It needs what a vertex needs if any part of it covers the vertex.
        """
        if not self._at:
            return NOTHING
        needs = NOTHING
        for hold in allocation.holds:
            needs |= self.of_edge(hold.edge, Rest(hold.cleared, allocation.kind.reach)) | (
                self.of_edge(hold.edge) & claimed)
        if allocation.vertex is not None:
            needs |= self.of_vertex(allocation.vertex)
        for area in allocation.areas:
            near, kind = self._geometry.exclusions.near, allocation.kind
            met = {*near(area.line, area.radius + kind.nearness),
                   *(near(area.line, area.radius + kind.reach).keys() & self._vertices)}
            needs = needs.union(*(self._at.get(place, NOTHING) for place in met))
        return needs

    def _inside(self, edge: int) -> FrozenSet[str]:
        return self._at.get(self._geometry.edge_place(edge), NOTHING)

    def _ends(self, edge: int) -> Tuple[int, int]:
        graph = self._geometry.graph
        return graph.start_vertex(edge).id, graph.end_vertex(edge).id
