"""Makes the trajectory graph from paths and places: vertices, directions, speeds, parking."""
from __future__ import annotations

import math
from dataclasses import replace
from typing import Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np
from shapely.geometry import LineString, Point

from graph_editor.floor import Floor
from graph_editor.making.bends import LaneWay, Piece
from graph_editor.making.lanes import LaneNet
from graph_editor.making.options import MakingOptions
from graph_editor.site import NamedPlace, PlaceKind
from trajectory_graph import CurveType, Edge, Graph, Vertex, split_edges

PASS, PARKING = 'pass', 'parking'
"""The labels of vertices that are not places of the map."""
LINE_PARAMETER = 0.25  # m; these parameters have no effect on a line, but the file requires them
SLOWEST = 0.3  # m/s; speed at the narrowest places and towards docks
FULL_SPEED_ROOM = 1.0  # m; clearance for the full speed
SPLINE_SPEED = 0.5  # m/s; the highest speed on splines with a large turn
TURN_RATE = 1.0  # rad/s; the highest turning rate of a robot in a bend


def assemble(net: LaneNet, ways: Sequence[LaneWay], places: Mapping[int, NamedPlace],
             frame_id: str, options: MakingOptions) -> Graph:
    """Returns the graph. Its vertices and edges are numbered from 1, row by row from the top."""
    positions = {node: net.positions[node] for way in ways for node in (way.first, way.last)}
    positions = positions or {node: net.positions[node] for node in net.nodes}
    vertices: Dict[int, Vertex] = {}
    edges: List[Edge] = []
    thetas: Dict[int, Tuple[float, float]] = {}  # length, direction of a node's longest piece
    next_id = max(net.nodes) + 1
    for way in (_in_order(net, way, places) for way in ways):
        here = way.first
        for number, piece in enumerate(way.pieces, 1):
            last = number == len(way.pieces)
            there = way.last if last else next_id
            if not last:
                next_id += 1
                positions[there] = piece.end
            length, start, end = _directions(piece)
            for node, direction in ((here, start), (there, end)):
                if length > thetas.get(node, (0.0, 0.0))[0]:
                    thetas[node] = length, math.atan2(direction[1], direction[0])
            edges.append(_edge(len(edges) + 1, here, there, piece.control))
            here = there
    for node, position in positions.items():
        vertices[node] = _vertex(node, position, thetas.get(node, (0.0, 0.0))[1],
                                 places.get(node), frame_id)
    graph = split_edges(Graph(vertices.values(), edges), options.longest_edge)
    graph = Graph([vertex if id in places else replace(vertex, label=PASS, parking=None)
                   for id, vertex in graph.vertices.items()], graph.edges.values())
    graph = _with_headings(_with_speeds(graph, net.floor, options), places)
    return numbered(_with_parking(graph, places, net.floor, options))


def _directions(piece: Piece) -> Tuple[float, np.ndarray, np.ndarray]:
    """Returns the length of a piece, and the directions at its start and its end.

    The length of a spline counts as infinite.
    """
    if piece.control is None:
        along = piece.end - piece.start
        return float(np.hypot(*along)), along, along
    start, _, end = np.diff(piece.control, axis=0)
    return math.inf, start, end


def _in_order(net: LaneNet, way: LaneWay, places: Mapping[int, NamedPlace]) -> LaneWay:
    """Returns the path in the direction that its edges get.

    Edges lead towards docks and other dead ends, but away from goals at a dead end. All other edges
    lead eastwards or northwards.
    """
    def weight(node: int) -> int:
        place = places.get(node)
        if place is not None and place.kind is PlaceKind.DOCK:
            return 2
        if net.degree(node) == 1:
            return 1 if place is None else -1
        return 0
    first, last = weight(way.first), weight(way.last)
    if first == last:
        first = -1 if tuple(way.pieces[0].start) < tuple(way.pieces[-1].end) else 1
        last = 0
    return way if first < last else way.turned_round()


def _vertex(node: int, position: np.ndarray, theta: float, place: Optional[NamedPlace],
            frame_id: str) -> Vertex:
    x, y = (float(value) for value in position)
    return Vertex(node, x, y, theta, theta, PASS if place is None else place.name, frame_id,
                  place is not None and place.kind is PlaceKind.DOCK)


def _edge(id: int, origin: int, destination: int, control: Optional[np.ndarray]) -> Edge:
    if control is None:
        return Edge(id, origin, destination, CurveType.LINE, LINE_PARAMETER, LINE_PARAMETER)
    return Edge(id, origin, destination, CurveType.SPLINE,
                float(np.hypot(*(control[1] - control[0]))),
                float(np.hypot(*(control[3] - control[2]))))


def _with_headings(graph: Graph, places: Mapping[int, NamedPlace]) -> Graph:
    """Returns the graph with the headings of goals and docks.

    A robot that waits in a dead end faces out of the dead end. A robot that docks faces into it.
    Theta is the heading of the place if the edge leads in the direction in which the robot faces;
    otherwise theta is the opposite.
    """
    vertices = dict(graph.vertices)
    for id, place in places.items():
        if place.heading is None:
            continue
        theta = place.heading
        if graph.is_end_vertex(id):
            faces_out = graph.edges_from(id)[0] > 0
            if faces_out == (place.kind is PlaceKind.DOCK):
                theta += math.pi
        theta = math.remainder(theta, 2.0 * math.pi)
        vertices[id] = replace(vertices[id], theta=theta, theta_holonomic=theta)
    return Graph(vertices.values(), graph.edges.values())


def _with_speeds(graph: Graph, floor: Floor, options: MakingOptions) -> Graph:
    return Graph(graph.vertices.values(), [
        replace(edge, velocity_forward=speed, velocity_backwards=speed)
        for edge in graph.edges.values()
        for speed in [_speed(graph, edge, floor, options)]])


def _speed(graph: Graph, edge: Edge, floor: Floor, options: MakingOptions) -> float:
    """Returns the speed of an edge, m/s: lower in narrow places, in bends and towards docks."""
    curve = graph.curve(edge.id)
    room = float(floor.clearance_at(curve.sample(0.1)).min())
    share = (room - options.tight) / max(FULL_SPEED_ROOM - options.tight, 0.1)
    speed = SLOWEST + min(max(share, 0.0), 1.0) * (options.speed - SLOWEST)
    if edge.curve_type is CurveType.SPLINE:
        turned = float(curve.turned(np.array([curve.length]))[0])
        speed = min(speed, SPLINE_SPEED if turned > 0.5 else options.speed,
                    TURN_RATE * curve.length / max(turned, 1e-3))
    if graph.vertices[edge.origin].dock or graph.vertices[edge.destination].dock:
        speed = SLOWEST
    return round(min(max(speed, min(SLOWEST, options.speed)), options.speed), 1)


def _with_parking(graph: Graph, places: Mapping[int, NamedPlace], floor: Floor,
                  options: MakingOptions) -> Graph:
    """Returns the graph with parking vertices.

    These are the dead ends at which a robot can turn and does not block another robot.
    """
    curves = {id: LineString(graph.curve(id).points) for id in graph.edges}
    vertices = dict(graph.vertices)
    for id, vertex in graph.vertices.items():
        if id in places or not graph.is_end_vertex(id):
            continue
        own, = graph.edges_at(id)
        room = floor.clearance_of(vertex.position)
        here = Point(vertex.position)
        away = min((curve.distance(here) for other, curve in curves.items() if other != own),
                   default=math.inf)
        if room >= options.turning and away >= 2.0 * options.turning:
            vertices[id] = replace(vertex, label=PARKING, parking=True)
    return Graph(vertices.values(), graph.edges.values())


def numbered(graph: Graph) -> Graph:
    """Returns the graph with ids from 1. Vertices are numbered row by row from the top left of the
    map, edges in the order of their ends.
    """
    order = sorted(graph.vertices.values(), key=lambda v: (-round(v.y, 1), v.x, v.id))
    ids = {vertex.id: number for number, vertex in enumerate(order, 1)}
    edges = sorted((replace(edge, origin=ids[edge.origin], destination=ids[edge.destination])
                    for edge in graph.edges.values()),
                   key=lambda edge: (*sorted((edge.origin, edge.destination)), edge.id))
    return Graph([_rounded(vertex, ids[vertex.id]) for vertex in order],
                 [replace(edge, id=number, param_f=round(edge.param_f, 3),
                          param_b=round(edge.param_b, 3)) for number, edge in enumerate(edges, 1)])


def _rounded(vertex: Vertex, id: int) -> Vertex:
    """Rounds a vertex to 1 mm and about 0.001 degrees; no value becomes -0."""
    theta = round(vertex.theta, 5) + 0.0
    return replace(vertex, id=id, x=round(vertex.x, 3) + 0.0, y=round(vertex.y, 3) + 0.0,
                   theta=theta, theta_holonomic=theta)
