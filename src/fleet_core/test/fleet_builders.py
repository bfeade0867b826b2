"""Graphs and fleets for several tests."""
from __future__ import annotations

import math
from dataclasses import replace
from random import Random
from typing import Dict, List, Mapping, Optional, Sequence, Tuple

from fleet_core.fleet import RobotType
from fleet_core.interlocking.reports import Pose, point_of
from fleet_core.interlocking.route_record import RouteRecord
from route_protocol.master import give_route
from route_protocol.values import RouteReport, SymbolicPose, VehicleLocation
from trajectory_graph import CurveType, Edge, Graph, Vertex

AGV = RobotType('agv', 0.4, 1.0)


def graph_of(places: Mapping[int, Tuple[float, float]], ends: Mapping[int, Tuple[int, int]],
             speed: float = 1.0, one_way: Sequence[int] = ()) -> Graph:
    """Returns a graph with straight edges.

    places -- {id: (x, y)} of the vertices
    ends   -- {id: (from, to)} of the edges
    """
    return Graph([Vertex(id, x, y, 0.0) for id, (x, y) in places.items()],
                 [Edge(id, *pair, velocity_forward=speed,
                       velocity_backwards=0.0 if id in one_way else speed)
                  for id, pair in ends.items()])


def corridor(length: int, siding_at: Optional[int] = None, spacing: float = 2.0) -> Graph:
    """Returns a row of vertices 1 .. length, joined by edges 1 .. length - 1.

    siding_at -- edge 100 leads from this vertex to a siding, vertex 100; None: no siding
    """
    places: Dict[int, Tuple[float, float]] = {
        k: ((k - 1) * spacing, 0.0) for k in range(1, length + 1)}
    ends = {k: (k, k + 1) for k in range(1, length)}
    if siding_at is not None:
        places[100] = ((siding_at - 1) * spacing, spacing)
        ends[100] = (siding_at, 100)
    return graph_of(places, ends)


def ladder(length: int, spacing: float = 2.0) -> Graph:
    """Returns two rows of vertices, 1 .. length and 101 .. 100 + length.

    An edge joins each vertex k to vertex 100 + k.
    """
    places = {100 * row + k: ((k - 1) * spacing, row * spacing)
              for row in (0, 1) for k in range(1, length + 1)}
    ends = {100 * row + k: (100 * row + k, 100 * row + k + 1)
            for row in (0, 1) for k in range(1, length)}
    return graph_of(places, {**ends, **{200 + k: (k, 100 + k) for k in range(1, length + 1)}})


def random_graph(random: Random, vertices: int, extra: int, spacing: float) -> Graph:
    """A connected graph with lines, splines, near-parallel, crossing and one-way edges."""
    places: List[Tuple[float, float]] = []
    side = spacing * math.sqrt(vertices)
    while len(places) < vertices:
        place = random.uniform(0.0, side), random.uniform(0.0, side)
        if all(math.dist(place, other) > 0.05 for other in places):
            places.append(place)
    pairs = []
    for k in range(1, vertices):  # first a tree that joins near vertices, then further edges
        near = sorted(range(k), key=lambda j: math.dist(places[j], places[k]))
        pairs.append((random.choice(near[:2]), k))
    for _ in range(extra):
        one, other = random.sample(range(vertices), 2)
        pairs.append((one, other))
    edges = []
    for k, (one, other) in enumerate(pairs):
        forward, backwards = (random.choice((0.3, 0.7, 1.0)) for _ in range(2))
        if k >= vertices and random.random() < 0.4:
            backwards = 0.0
        kind = random.choice(list(CurveType))
        edges.append(Edge(k + 1, one + 1, other + 1, kind, random.uniform(0.0, 1.5),
                          random.uniform(0.0, 1.5), forward, backwards))
    return Graph([Vertex(k + 1, *place, random.uniform(-math.pi, math.pi))
                  for k, place in enumerate(places)], edges)


def with_docks(graph: Graph, *docks: int) -> Graph:
    """The same graph with charging docks at some vertices."""
    return Graph([replace(v, dock=v.id in docks) for v in graph.vertices.values()],
                 graph.edges.values())


def grant(record: RouteRecord, edges: Sequence[int]) -> None:
    """Orders the robot of this record to drive these edges after all that it already has ahead."""
    protocol = record.protocol
    record.protocol = give_route(protocol, protocol.number + 1, (*record.ahead, *edges), 1)


def complete(record: RouteRecord, number: int) -> None:
    """Notes that the robot of this record has driven, and left, all edges before this number."""
    driven = record.part(record.done, number)
    record.protocol = replace(record.protocol, done=number)
    record.passed(driven)


def at_place(said: RouteReport, graph: Graph, edge: int, fraction: float) -> RouteReport:
    """The same report, but with a place at this fraction of this edge."""
    x, y = point_of(graph, Pose(edge, fraction))
    return replace(said, pose=SymbolicPose(edge, 100.0 * fraction),
                   location=VehicleLocation(x, y, math.nan))


def as_files(graph: Graph, types: Sequence[RobotType], robots: Mapping[str, Tuple[str, int]],
             missions: Mapping[str, Sequence[int]], clearance: float) -> Tuple[dict, dict, dict]:
    """The contents of the three files of `plan_fleet`, as plain data."""
    return ({
        'Vertices': [{'Id': v.id, 'X': v.x, 'Y': v.y, 'Theta': v.theta, 'ThetaHolomonic': 0.0,
                      'Label': v.label, 'FrameId': 'map', 'Dock': v.dock}
                     for v in graph.vertices.values()],
        'Edges': [{'Id': e.id, 'Origin_ID': e.origin, 'Destination_ID': e.destination,
                   'CurveType': e.curve_type.value, 'ParamF': e.param_f, 'ParamB': e.param_b,
                   'VelocityForward': e.velocity_forward,
                   'VelocityBackwards': e.velocity_backwards} for e in graph.edges.values()],
    }, {
        'clearance': clearance,
        'robot_types': [{'name': t.name, 'radius': t.radius, 'speed': t.speed, 'play': t.play,
                         'obeys_edge_speed': t.obeys_edge_speed} for t in types],
        'robots': [{'name': name, 'type': kind, 'vertex': vertex}
                   for name, (kind, vertex) in robots.items()],
    }, {
        'missions': [{'robot': name, 'vertices': list(vertices)}
                     for name, vertices in missions.items()],
    })
