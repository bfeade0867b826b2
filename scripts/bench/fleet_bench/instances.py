"""Graphs and fleets for the benchmark. A seed determines everything."""
from __future__ import annotations

import math
from random import Random
from typing import Dict, List, NamedTuple, Sequence, Tuple

from scipy.spatial import cKDTree

from fleet_core.fleet import RobotType
from fleet_core.planning.tasks import Task
from trajectory_graph import CurveType, Edge, Graph, Vertex

AGV = RobotType('agv', 0.43, 1.0)
CLEARANCE = 0.1


class Instance(NamedTuple):
    """Robots by name, each with its start vertex and its goal vertex."""

    starts: Dict[str, int]
    goals: Dict[str, int]

    def tasks(self, kind: RobotType = AGV) -> List[Task]:
        """Returns the robots and goals as tasks for the planner."""
        return [Task(name, kind, start, destinations=(self.goals[name],), stays=True)
                for name, start in self.starts.items()]


class _Drawing:
    """A graph under construction: vertices and edges are added to it."""

    def __init__(self) -> None:
        self.vertices: List[Vertex] = []
        self.edges: List[Edge] = []

    def vertex(self, x: float, y: float, theta: float = 0.0) -> int:
        self.vertices.append(Vertex(len(self.vertices) + 1, x, y, theta))
        return len(self.vertices)

    def edge(self, one: int, other: int, speed: float = 1.0,
             kind: CurveType = CurveType.LINE, reach: float = 0.0) -> None:
        self.edges.append(Edge(len(self.edges) + 1, one, other, kind, reach, reach, speed, speed))

    def graph(self) -> Graph:
        return Graph(self.vertices, self.edges)


def aisles(vertices: int) -> Tuple[Graph, List[int]]:
    """Returns a warehouse with about this number of vertices, and its stations.

    The aisles are 6 m apart, with a vertex every 2.4 m. A cross lane joins them at every fourth
    vertex. At each other vertex, a spur of 1.8 m leads to a station. Robots drive a spur at half
    speed, and a station has no other exit.
    """
    columns = int(math.sqrt(vertices) * 0.9)
    rows = int(vertices / (columns * 1.9)) + 1
    drawing = _Drawing()
    grid: Dict[Tuple[int, int], int] = {}
    for row in range(rows):
        for column in range(columns):
            grid[row, column] = drawing.vertex(column * 2.4, row * 6.0)
            if column:
                drawing.edge(grid[row, column - 1], grid[row, column])
    lanes = {*range(0, columns, 4), columns - 1}
    for row in range(rows - 1):
        for column in sorted(lanes):
            middle = drawing.vertex(column * 2.4, row * 6.0 + 3.0)
            drawing.edge(grid[row, column], middle)
            drawing.edge(middle, grid[row + 1, column])
    stations = []
    for (row, column), vertex in grid.items():
        if column not in lanes and len(drawing.vertices) < vertices:
            stations.append(drawing.vertex(column * 2.4, row * 6.0 + 1.8))
            drawing.edge(vertex, stations[-1], 0.5)
    return drawing.graph(), stations


def sparse_roadmap(seed: int, vertices: int = 170, spacing: float = 6.0) -> Graph:
    """Returns a roadmap with few, long edges (a relative neighbourhood graph).

    Points are at least `spacing` m apart. Two points are joined if no third point is nearer to both
    of them than the two points are to each other.
    """
    random = Random(seed)
    side = spacing * math.sqrt(vertices) * 1.3
    points: List[Tuple[float, float]] = []
    while len(points) < vertices:
        point = random.uniform(0.0, side), random.uniform(0.0, side)
        if all(math.dist(point, other) >= spacing for other in points):
            points.append(point)
    drawing = _Drawing()
    for point in points:
        drawing.vertex(*point)
    for i, one in enumerate(points):
        for j in range(i):
            apart = math.dist(one, points[j])
            if not any(math.dist(one, third) < apart and math.dist(points[j], third) < apart
                       for third in points):
                drawing.edge(j + 1, i + 1)
    return drawing.graph()


def dense_moves(vertices: int, edges: int, seed: int = 0) -> Graph:
    """Returns a graph with `edges` edges between neighbours on an irregular grid; half are splines.
    """
    random = Random(seed)
    columns = math.ceil(math.sqrt(vertices))
    drawing = _Drawing()
    for k in range(vertices):
        drawing.vertex(2.0 * (k % columns) + random.uniform(-0.5, 0.5),
                       2.0 * (k // columns) + random.uniform(-0.5, 0.5),
                       random.uniform(-math.pi, math.pi))
    places = [vertex.position for vertex in drawing.vertices]
    near = cKDTree(places).query_pairs(4.5)
    pairs = sorted((math.dist(places[i], places[j]), i, j) for i, j in near)[:edges]
    for _, i, j in pairs:
        spline = random.random() < 0.5
        drawing.edge(i + 1, j + 1, 1.0, CurveType.SPLINE if spline else CurveType.LINE,
                     0.5 if spline else 0.0)
    return drawing.graph()


def draw(pool: Sequence[int], robots: int, seed: int) -> Instance:
    """Returns robots with different starts and different goals, drawn from `pool`."""
    random = Random(seed)
    starts, goals = random.sample(pool, robots), random.sample(pool, robots)
    names = [f'r{k}' for k in range(robots)]
    return Instance(dict(zip(names, starts)), dict(zip(names, goals)))
