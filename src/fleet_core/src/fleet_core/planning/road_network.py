"""The graph in the form that the searches use: numbered vertices and drives, times, shortest paths.

A *drive* is an edge in one direction: drive 2 e is edge e forward, drive 2 e + 1 is the same edge
backward. Edges are numbered in the graph's order. A *slot* is what is booked: first come the slots
of the drives, then the slots of the vertices.
"""
from __future__ import annotations

import math
from array import array
from types import MappingProxyType
from typing import Dict, FrozenSet, Iterable, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from fleet_core.fleet import DOCK_APPROACH, RobotType
from fleet_core.geometry.exclusions import Exclusions
from fleet_core.geometry.site_geometry import SiteGeometry
from fleet_core.planning.shortest_paths import ShortestPaths
from trajectory_graph import Graph

_GUIDED = 1.0 + 1e-9
_NEAREST_KEPT = 64
Roads = List[List[Tuple[int, int, float]]]
"""For each vertex the roads away from it: (drive, vertex at its end, seconds)."""


def estimated(seconds: np.ndarray) -> Sequence[float]:
    """Returns the seconds (V,) as the searches use them: Python's numbers, larger by a tiny factor.

    So among equally good paths, a search first follows the path that is nearest to its end.
    """
    return array('d', (seconds * _GUIDED).tobytes())


class RoadNetwork:
    """A graph, and its edges that are closed now.

    All searches use this form of the graph. They read half of its attributes in their inner loops.
    The other attributes keep results for each robot type.

    graph         -- the trajectory graph
    closed        -- ids of edges that no robot may use
    dock_approach -- m in front of a dock that belong to a robot while it docks or leaves
    learned       -- seconds, by type name and signed edge id, which replace length / speed
    geometry      -- geometry of the same graph, if it is known already
    """

    def __init__(self, graph: Graph, closed: Iterable[int] = (),
                 dock_approach: float = DOCK_APPROACH,
                 learned: Mapping[Tuple[str, int], float] = MappingProxyType({}),
                 geometry: Optional[SiteGeometry] = None) -> None:
        self.graph = graph
        self.geometry = geometry or SiteGeometry(graph, dock_approach)
        self.closed: FrozenSet[int] = frozenset(closed)
        self.dock_approach = dock_approach
        self.learned = learned
        self.vertex_ids: Tuple[int, ...] = self.geometry.vertex_ids
        self.edge_ids: Tuple[int, ...] = self.geometry.edge_ids
        self.index: Dict[int, int] = self.geometry.index
        self.edge_index: Dict[int, int] = self.geometry.edge_index
        edges = graph.edges.values()
        self.origin: List[int] = self.geometry.ends.ravel().tolist()
        """The vertex at which each drive begins."""
        self.signed_ids: Tuple[int, ...] = tuple(id for edge in edges for id in (edge.id, -edge.id))
        """The signed edge id of each drive."""
        self.vertices = len(self.vertex_ids)
        self.drives = len(self.origin)
        self.docks = frozenset(self.index[v.id] for v in graph.vertices.values() if v.dock)
        self._lengths = self.geometry.lengths
        self._times: Dict[RobotType, List[float]] = {}
        self._roads: Dict[RobotType, Roads] = {}
        self._shortest: Dict[RobotType, ShortestPaths] = {}
        self._paths: Dict[RobotType, Dict[int, np.ndarray]] = {}
        self._estimates: Dict[RobotType, Dict[int, Sequence[float]]] = {}
        self._nearest: Dict[Tuple[RobotType, FrozenSet[int]], np.ndarray] = {}

    def with_closed(self, closed: Iterable[int],
                    learned: Mapping[Tuple[str, int], float] = MappingProxyType({})) -> RoadNetwork:
        """Returns the same graph with other closed edges. The geometry is not computed again."""
        return RoadNetwork(self.graph, closed, self.dock_approach, learned, self.geometry)

    # -- ids and numbers --------------------------------------------------------------------------

    def drive(self, signed_id: int) -> int:
        """Returns the drive of a signed edge id, which the graph must have."""
        edge = self.edge_index[abs(signed_id)]
        return 2 * edge + (signed_id < 0)

    def signed_id(self, drive: int) -> int:
        """Returns the signed edge id of a drive."""
        return self.signed_ids[drive]

    def destination(self, drive: int) -> int:
        """Returns the vertex at which a drive ends."""
        return self.origin[drive ^ 1]

    def vertex_slot(self, vertex: int) -> int:
        """Returns the slot for waiting at a vertex."""
        return self.drives + vertex

    def length(self, drive: int) -> float:
        """Returns the arc length of a drive in m."""
        return float(self._lengths[drive >> 1])

    # -- times ------------------------------------------------------------------------------------

    def times(self, kind: RobotType) -> List[float]:
        """Returns the seconds that each drive takes; infinite: forbidden.

        Closed edges have their normal time.
        """
        if kind not in self._times:
            times: List[float] = []
            for edge, length in zip(self.graph.edges.values(), map(float, self._lengths)):
                for id, edge_speed in ((edge.id, edge.velocity_forward),
                                       (-edge.id, edge.velocity_backwards)):
                    speed = kind.drives_at(edge_speed)
                    times.append(self.learned.get((kind.name, id), length / speed)
                                 if speed > 0.0 else math.inf)
            self._times[kind] = times
        return self._times[kind]

    def roads(self, kind: RobotType, docks: Iterable[int] = ()) -> Roads:
        """Returns the roads away from each vertex.

        A road into a dock is included only if the dock is one of `docks`.
        """
        if kind not in self._roads:
            closed = {self.edge_index[id] for id in self.closed_to(kind) if id in self.edge_index}
            roads: Roads = [[] for _ in range(self.vertices)]
            for drive, (begin, seconds) in enumerate(zip(self.origin, self.times(kind))):
                end = self.origin[drive ^ 1]
                if seconds < math.inf and drive >> 1 not in closed and end not in self.docks:
                    roads[begin].append((drive, end, seconds))
            self._roads[kind] = roads
        wanted = self.docks.intersection(docks)
        if not wanted:
            return self._roads[kind]
        roads = list(self._roads[kind])
        for drive, seconds in enumerate(self.times(kind)):
            if self._open(kind, drive, seconds) and self.destination(drive) in wanted:
                begin = self.origin[drive]
                roads[begin] = [*roads[begin], (drive, self.destination(drive), seconds)]
        return roads

    def paths_to(self, kind: RobotType, targets: Sequence[int]) -> List[np.ndarray]:
        """Returns for each target the seconds (V,) from each vertex to the target, without traffic;
        inf: no path.

        The results are kept, so that repeated targets cost nothing.
        """
        known = self._paths.setdefault(kind, {})
        missing = [t for t in dict.fromkeys(targets) if t not in known]
        if missing:
            docks = {dock: self._roads_into(kind, dock)
                     for dock in self.docks.intersection(missing)}
            plain = dict.fromkeys(
                vertex for vertex in (*missing, *(begin for roads in docks.values()
                                                  for begin, _ in roads))
                if vertex not in self.docks and vertex not in known)
            if plain:
                known.update(zip(plain, self.prepared(kind).to(list(plain))))
            for dock, roads in docks.items():
                known[dock] = self._paths_to_dock(known, dock, roads)
        return [known[target] for target in targets]

    def seconds_over(self, kind: RobotType, vertices: Sequence[int]) -> float:
        """Returns the seconds from the first of these vertices (ids) over all others in order.

        Infinite: there is no path, or one of these vertices is not in the graph.
        """
        if any(vertex not in self.index for vertex in vertices):
            return math.inf
        return sum(float(self.paths_to(kind, (self.index[other],))[0][self.index[one]])
                   for one, other in zip(vertices, vertices[1:]))

    def paths_to_nearest(self, kind: RobotType, targets: FrozenSet[int]) -> np.ndarray:
        """Returns the seconds (V,) from each vertex to the nearest of some targets; inf: none is
        reachable.

        The last results are kept, because many robots park at the same places.
        """
        nearest = self._nearest.pop((kind, targets), None)
        if nearest is None:
            nearest = self._to_nearest(kind, targets)
            while len(self._nearest) >= _NEAREST_KEPT:
                del self._nearest[next(iter(self._nearest))]
        self._nearest[kind, targets] = nearest
        return nearest

    def _to_nearest(self, kind: RobotType, targets: FrozenSet[int]) -> np.ndarray:
        paths = [np.full(self.vertices, math.inf)]
        if targets:
            paths += self.paths_to(kind, sorted(targets & self.docks))
            paths.append(self.prepared(kind).to_nearest(sorted(targets - self.docks)))
        nearest: np.ndarray = np.minimum.reduce(paths)
        return nearest

    def _roads_into(self, kind: RobotType, dock: int) -> List[Tuple[int, float]]:
        """Returns the open roads into a dock as (vertex where the road begins, seconds)."""
        return [(self.origin[drive], seconds) for drive, seconds in enumerate(self.times(kind))
                if self.destination(drive) == dock and self._open(kind, drive, seconds)]

    def _paths_to_dock(self, known: Mapping[int, np.ndarray], dock: int,
                       roads: Sequence[Tuple[int, float]]) -> np.ndarray:
        """Returns the seconds (V,) from each vertex to a dock, through no other dock.

        roads -- the drives into the dock: (vertex where the drive begins, seconds)
        """
        paths = np.full(self.vertices, math.inf)
        for begin, seconds in roads:
            if begin in self.docks:
                paths[begin] = min(paths[begin], seconds)
            else:
                paths = np.minimum(paths, known[begin] + seconds)
        paths[dock] = 0.0
        return paths

    def prepared(self, kind: RobotType) -> ShortestPaths:
        """Returns the roads of a robot type, prepared for shortest paths at first use."""
        if kind not in self._shortest:
            self._shortest[kind] = ShortestPaths(self.vertices, (
                (begin, end, seconds) for begin, away in enumerate(self.roads(kind))
                for _, end, seconds in away))
        return self._shortest[kind]

    def estimates(self, kind: RobotType, target: int) -> Sequence[float]:
        """Returns the seconds of `paths_to` for one target, in the form that the searches use."""
        known = self._estimates.setdefault(kind, {})
        if target not in known:
            known[target] = estimated(self.paths_to(kind, (target,))[0])
        return known[target]

    def _open(self, kind: RobotType, drive: int, seconds: float) -> bool:
        return seconds < math.inf and self.edge_ids[drive >> 1] not in self.closed_to(kind)

    def closed_to(self, kind: RobotType) -> FrozenSet[int]:
        """Returns the ids of the edges that are closed now, for all robots or for this type."""
        return self.closed | kind.closed if kind.closed else self.closed

    # -- geometry ---------------------------------------------------------------------------------

    @property
    def exclusions(self) -> Exclusions:
        """The places that exclude each other, including edges that are closed now."""
        return self.geometry.exclusions
