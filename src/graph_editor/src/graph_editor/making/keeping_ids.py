"""Keeps ids: a vertex or edge of an old graph keeps its id if it still exists in the new graph."""
from __future__ import annotations

from dataclasses import replace
from typing import Dict, List, Set, Tuple

import numpy as np
from scipy.spatial import cKDTree

from trajectory_graph import CurveType, Edge, Graph

SAME_PLACE = 0.75  # m; largest distance between an old vertex and the new one with its id


def with_ids_of(old: Graph, new: Graph) -> Graph:
    """Returns `new` with the ids of `old`.

    Vertices are matched by position, the nearest pairs first. Edges are matched by their ends. New
    elements get ids above all old ids, so that an id never changes its meaning.
    """
    vertex_ids = _vertex_ids(old, new)
    vertices = [replace(vertex, id=vertex_ids[vertex.id]) for vertex in new.vertices.values()]
    edges = [replace(edge, origin=vertex_ids[edge.origin], destination=vertex_ids[edge.destination])
             for edge in new.edges.values()]
    return Graph(sorted(vertices, key=lambda vertex: vertex.id),
                 sorted(_with_edge_ids(old, new, edges), key=lambda edge: edge.id))


def _vertex_ids(old: Graph, new: Graph) -> Dict[int, int]:
    old_ids = list(old.vertices)
    old_places = cKDTree(np.array([vertex.position for vertex in old.vertices.values()]))
    pairs: List[Tuple[float, int, int]] = []
    for vertex in new.vertices.values():
        for index in old_places.query_ball_point(vertex.position, SAME_PLACE):
            distance = float(np.hypot(*(old_places.data[index] - vertex.position)))
            pairs.append((round(distance, 6), vertex.id, old_ids[index]))
    ids: Dict[int, int] = {}
    taken: Set[int] = set()
    for _, id, old_id in sorted(pairs):
        if id not in ids and old_id not in taken:
            ids[id] = old_id
            taken.add(old_id)
    next_id = max(old.vertices) + 1
    for id in new.vertices:
        if id not in ids:
            ids[id] = next_id
            next_id += 1
    return ids


def _with_edge_ids(old: Graph, new: Graph, edges: List[Edge]) -> List[Edge]:
    """Returns the edges with their old ids.

    A line may be turned round to keep its id, if no heading of a vertex depends on the line's
    direction.
    """
    waiting: Dict[Tuple[int, int], List[int]] = {}
    for edge in old.edges.values():
        waiting.setdefault((edge.origin, edge.destination), []).append(edge.id)
    next_id = max(old.edges, default=0) + 1
    ends = {edge.id: any(new.is_end_vertex(id) for id in (edge.origin, edge.destination))
            for edge in new.edges.values()}
    result = []
    for edge in edges:
        same = waiting.get((edge.origin, edge.destination))
        turned = waiting.get((edge.destination, edge.origin))
        if same:
            result.append(replace(edge, id=same.pop(0)))
        elif turned and edge.curve_type is CurveType.LINE and not ends[edge.id]:
            result.append(replace(
                edge, id=turned.pop(0), origin=edge.destination, destination=edge.origin,
                velocity_forward=edge.velocity_backwards, velocity_backwards=edge.velocity_forward))
        else:
            result.append(replace(edge, id=next_id))
            next_id += 1
    return result
