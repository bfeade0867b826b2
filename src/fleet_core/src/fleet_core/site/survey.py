"""A survey of a graph for a fleet: room for robots, and places where they block each other."""
from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from typing import Dict, FrozenSet, List, Optional, Sequence, Set, Tuple

import networkx as nx

from fleet_core.fleet import Fleet, RobotType
from fleet_core.planning.parking import WellFormedSets, named_parking
from fleet_core.planning.road_network import RoadNetwork

LONG = 3.0
"""The length of a long edge, in following distances. The next robot waits until the whole edge is
free. So less than half as many robots pass as on edges of one following distance."""
_SAMPLES = 100  # number of vertices from which paths are counted: it limits the time


@dataclass(frozen=True)
class Capacity:
    """The number of robots that a graph has room for, if all are of one type.

    robots -- number of robots while all docks stay free
    docks  -- number of further robots, which stand at docks
    """

    type: str
    robots: int
    docks: int


@dataclass(frozen=True)
class DeadEnd:
    """A part of the graph with one entry and no loop: two robots cannot pass each other in it.

    entry -- the vertex that joins it to the rest of the graph; None: the whole graph has no loop
    """

    entry: Optional[int]
    vertices: Tuple[int, ...]
    length: float  # m


@dataclass(frozen=True)
class LongEdge:
    """A long edge that costs throughput.

    share -- fraction of all shortest paths that lead over it (0..1)
    """

    id: int
    length: float  # m
    share: float


@dataclass(frozen=True)
class Stranded:
    """Vertices that robots of a type cannot reach, or from which they cannot return.

    vertices     -- vertices without a path to the rest of the graph, or without a path back
    behind_docks -- vertices to which edges lead only through a dock; no route leads through a dock
    """

    type: str
    vertices: Tuple[int, ...]
    behind_docks: Tuple[int, ...] = ()


@dataclass(frozen=True)
class Survey:
    """The results of a survey.

    following_distance -- m between two robots of the largest type
    parking            -- ids of vertices: even if robots of any types stand on all of them, no
                          robot is cut off
    near_edges         -- pairs of edges that exclude each other although they share no vertex
    """

    following_distance: float
    parking: FrozenSet[int]
    capacities: Tuple[Capacity, ...]
    dead_ends: Tuple[DeadEnd, ...]
    stranded: Tuple[Stranded, ...]
    long_edges: Tuple[LongEdge, ...]
    near_edges: Tuple[Tuple[int, int], ...]


def survey(network: RoadNetwork, fleet: Fleet) -> Survey:
    """Surveys a graph for a fleet; takes some seconds."""
    largest = max(fleet.types, key=lambda kind: kind.reach)
    distance = 2.0 * largest.reach + fleet.clearance
    parking, capacities = _parking(network, fleet, largest)
    stranded = (_stranded(network, kind) for kind in fleet.types)
    return Survey(distance, parking, capacities, dead_ends(network),
                  tuple(one for one in stranded if one.vertices or one.behind_docks),
                  long_edges(network, largest, distance), near_edges(network, distance))


def _parking(network: RoadNetwork, fleet: Fleet,
             largest: RobotType) -> Tuple[FrozenSet[int], Tuple[Capacity, ...]]:
    """Returns the parking vertices for robots of all types together, and the capacity for each type
    alone.

    The parking vertices of the largest type serve for all types, because a smaller robot blocks
    less there.
    """
    anywhere = _anywhere(network, fleet)
    for_all = WellFormedSets(network, largest, fleet.clearance, anywhere).largest()
    known: Dict[Tuple[float, FrozenSet[int], Tuple[bool, ...]], FrozenSet[int]] = {}
    capacities = []
    for kind in fleet.types:
        same = (kind.reach, frozenset(named_parking(network, kind)),
                tuple(map(isfinite, network.times(kind))))
        if same not in known:
            alone = kind is largest and same[1] == anywhere
            known[same] = for_all if alone else WellFormedSets(
                network, kind, fleet.clearance).largest()
        docks = known[same] & network.docks
        capacities.append(Capacity(kind.name, len(known[same] - docks), len(docks)))
    return frozenset(network.vertex_ids[vertex] for vertex in for_all), tuple(capacities)


def parking_for_all(network: RoadNetwork, fleet: Fleet) -> FrozenSet[int]:
    """Returns only `Survey.parking`, for the closed edges of `network`."""
    largest = max(fleet.types, key=lambda kind: kind.reach)
    parking = WellFormedSets(network, largest, fleet.clearance, _anywhere(network, fleet))
    return frozenset(network.vertex_ids[vertex] for vertex in parking.largest())


def _anywhere(network: RoadNetwork, fleet: Fleet) -> Set[int]:
    """Returns the vertices at which the graph allows a robot of at least one type to park."""
    return {vertex for kind in fleet.types for vertex in named_parking(network, kind)}


def dead_ends(network: RoadNetwork) -> Tuple[DeadEnd, ...]:
    """Returns the parts of the graph that are joined to the rest by one vertex and have no loop.

    The part with the most vertices is first. In the incidence graph edges are nodes too, so that
    two edges between the same vertices count as a loop.
    """
    incidence = nx.Graph()
    for edge in network.graph.edges.values():
        for vertex in (edge.origin, edge.destination):
            incidence.add_edge(('vertex', vertex), ('edge', edge.id))
    core = nx.k_core(incidence, 2)
    outside = incidence.subgraph(node for node in incidence if node not in core)
    found = []
    for part in nx.connected_components(outside):
        entries = [other[1] for node in part for other in incidence[node] if other in core]
        found.append(DeadEnd(
            entries[0] if entries else None,
            tuple(sorted(id for kind, id in part if kind == 'vertex')),
            sum(network.graph.curve(id).length for kind, id in part if kind == 'edge')))
    return tuple(sorted(found, key=lambda end: (-len(end.vertices), end.entry or 0)))


def _stranded(network: RoadNetwork, kind: RobotType) -> Stranded:
    """Returns the vertices outside of the largest strongly connected set in each part of the graph.

    Within such a set a robot can drive from each vertex to each other one.
    """
    roads = _roads(network, kind)
    docks = {network.vertex_ids[dock] for dock in network.docks}
    joined = _joined(network, roads)
    passed = _joined(network, roads.subgraph(set(roads) - docks))  # joined by routes
    ends = {dock for dock in docks if passed & set(roads.predecessors(dock))
            and passed & set(roads.successors(dock))}
    alone = {dock for dock in docks if network.graph.part_of(dock) <= docks}
    return Stranded(kind.name, tuple(sorted(set(roads) - joined)),
                    tuple(sorted(joined - passed - ends - alone)))


def _joined(network: RoadNetwork, roads: nx.DiGraph) -> Set[int]:
    """Returns the vertices of the largest strongly connected set in each part of the graph."""
    homes: Dict[FrozenSet[int], Set[int]] = {}
    for home in sorted(nx.strongly_connected_components(roads), key=len):
        homes[network.graph.part_of(min(home))] = home  # the largest one comes last, and stays
    return set().union(*homes.values())


def long_edges(network: RoadNetwork, kind: RobotType, distance: float) -> Tuple[LongEdge, ...]:
    """Returns edges longer than `LONG` following distances; the most costly edge comes first."""
    graph = network.graph
    lengths = {id: graph.curve(id).length for id in graph.edges}
    long = [id for id, length in lengths.items() if length > LONG * distance]
    if not long:
        return ()
    roads = _roads(network, kind)
    starts = sorted(roads)[::max(len(roads) // _SAMPLES, 1)]
    paths = nx.edge_betweenness_centrality_subset(roads, starts, list(roads), weight='seconds')
    shares = dict.fromkeys(graph.edges, 0.0)
    for begin, end, edge in roads.edges(data='id'):
        shares[edge] += paths[begin, end] / (len(starts) * (len(roads) - 1))
    found = [LongEdge(id, lengths[id], shares[id]) for id in long]
    return tuple(sorted(found, key=lambda edge: (-edge.share * edge.length, -edge.length)))


def _roads(network: RoadNetwork, kind: RobotType) -> nx.DiGraph:
    """Returns a directed graph of vertex ids. If a robot of this type may drive from one vertex to
    another, the graph has the fastest such edge.
    """
    roads = nx.DiGraph()
    roads.add_nodes_from(network.vertex_ids)
    ids = network.vertex_ids
    for drive, seconds in enumerate(network.times(kind)):
        begin, end = ids[network.origin[drive]], ids[network.destination(drive)]
        known = roads.get_edge_data(begin, end)
        if isfinite(seconds) and (known is None or seconds < known['seconds']):
            roads.add_edge(begin, end, seconds=seconds, id=network.edge_ids[drive >> 1])
    return roads


def near_edges(network: RoadNetwork, distance: float) -> Tuple[Tuple[int, int], ...]:
    """Returns pairs of edges, ids ascending, whose curves come nearer than `distance` (m).

    Pairs with a common vertex, and pairs that a single edge joins, are omitted.
    """
    conflicts = network.exclusions.at(distance)
    ends: List[Set[int]] = [set(network.origin[2 * edge:2 * edge + 2])
                            for edge in range(len(network.edge_ids))]
    around = _neighbours(network)
    found: List[Tuple[int, int]] = []
    for edge, (one, other) in enumerate(map(sorted, ends)):
        close = ends[edge] | around[one] | around[other]
        for place in conflicts.row(network.vertices + edge):
            second = place - network.vertices
            if second > edge and not ends[second] & close:
                pair = network.edge_ids[edge], network.edge_ids[second]
                found.append((min(pair), max(pair)))
    return tuple(sorted(found))


def _neighbours(network: RoadNetwork) -> Sequence[Set[int]]:
    """Returns for each vertex its neighbours."""
    around: List[Set[int]] = [set() for _ in range(network.vertices)]
    for drive in range(network.drives):
        around[network.origin[drive]].add(network.destination(drive))
    return around
