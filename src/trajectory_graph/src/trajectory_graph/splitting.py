"""Cuts long edges into sections with new vertices between them, so that more robots share a graph.

A robot on an edge blocks the whole edge, and many robots cannot stop in the middle of an edge. If
an edge is cut, a robot is granted one section after the other. The sections lie exactly on the old
curve, because a part of a Bezier curve is a Bezier curve.
"""
from __future__ import annotations

import math
from dataclasses import replace
from typing import List, Tuple

import numpy as np

from trajectory_graph.curves import (
    bezier_arc_lengths,
    bezier_section,
    bezier_speeds,
    fine_parameters,
)
from trajectory_graph.graph import CurveType, Edge, Graph, Vertex


def split_edges(graph: Graph, longest: float) -> Graph:
    """Returns the graph with each edge longer than `longest` (m) cut into equal sections.

    - No section is longer than `longest`.
    - Edges that are short enough keep their ids.
    - Sections and new vertices get ids above all old ids, in the sequence of the edges, from
      origin to destination.
    - `section_of` of a section is the id of the drawn edge.
    - A new vertex has the heading of the edge there. Its label is the edge's id and the number of
      the section that ends there, e.g. `7/2`. It is not a parking vertex.
    """
    if not longest > 0.0:
        raise ValueError(f'longest is {longest}, but must be positive')
    vertices: List[Vertex] = list(graph.vertices.values())
    edges: List[Edge] = []
    next_vertex, next_edge = max(graph.vertices) + 1, max(graph.edges, default=0) + 1
    for edge in graph.edges.values():
        count = math.ceil(graph.curve(edge.id).length / longest - 1e-9)
        if count <= 1:
            edges.append(edge)
            continue
        between, sections = _cut(graph, edge, count, next_vertex, next_edge)
        vertices += between
        edges += sections
        next_vertex += len(between)
        next_edge += len(sections)
    return Graph(vertices, edges)


def _cut(graph: Graph, edge: Edge, count: int, first_vertex: int,
         first_edge: int) -> Tuple[List[Vertex], List[Edge]]:
    """Returns the `count` - 1 new vertices on the edge, and its `count` sections."""
    control = graph.control_points(edge.id)
    cuts = _equal_parts(control, count)
    origin = graph.vertices[edge.origin]
    vertices, sections = [], []
    start = edge.origin
    for k in range(count):
        part = bezier_section(control, cuts[k], cuts[k + 1])
        end = edge.destination if k == count - 1 else first_vertex + k
        if end != edge.destination:
            x, y = map(float, part[3])
            theta = _direction(part)
            vertices.append(Vertex(end, x, y, theta, theta, f'{edge.id}/{k + 1}', origin.frame_id,
                                   parking=False))
        section = replace(edge, id=first_edge + k, origin=start, destination=end,
                          section_of=edge.drawn_id)
        if edge.curve_type is CurveType.SPLINE:
            section = replace(section, param_f=math.dist(part[0], part[1]),
                              param_b=math.dist(part[2], part[3]))
        sections.append(section)
        start = end
    return vertices, sections


def _equal_parts(control: np.ndarray, count: int) -> List[float]:
    """Returns the parameters, from 0 to 1, that cut the curve into `count` equally long parts."""
    t = fine_parameters(control, 64 * count)
    arc = bezier_arc_lengths(control, t)
    wanted = arc[-1] * np.arange(1, count) / count
    before = np.clip(np.searchsorted(arc, wanted, side='right') - 1, 0, len(t) - 2)
    low, high = t[before], t[before + 1]
    cuts = np.interp(wanted, arc, t)
    for _ in range(3):  # Newton's method, limited to the step that contains the cut
        here = arc[before] + [bezier_arc_lengths(control, np.array(step))[1]
                              for step in zip(low, cuts)]
        speed = np.maximum(bezier_speeds(control, cuts), 1e-9)
        cuts = np.clip(cuts - (here - wanted) / speed, low, high)
    return [0.0, *cuts.tolist(), 1.0]


def _direction(part: np.ndarray) -> float:
    """Returns the driving direction (rad) at the end of a section."""
    for before in part[2::-1]:
        dx, dy = part[3] - before
        if math.hypot(dx, dy) > 1e-9:
            return math.atan2(dy, dx)
    return 0.0
