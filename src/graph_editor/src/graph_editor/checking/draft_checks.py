"""Findings about a whole draft: its connections, mutual blocking of robots, and unserved floor."""
from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Dict, FrozenSet, Iterable, List, Mapping, Sequence, Set, Tuple

import networkx as nx
import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree
from shapely.geometry import LineString, Point

from graph_editor.checking.edge_checks import GRAIN
from graph_editor.checking.findings import Finding, Severity
from graph_editor.checking.rules import CheckRules
from graph_editor.checking.served_floor import ServedFloor
from graph_editor.floor import EVERY_NEIGHBOUR, Floor
from graph_editor.robot import NEARLY_STRAIGHT
from graph_editor.site import NamedPlace, PlaceKind
from trajectory_graph.curves import Curve
from trajectory_graph.editing import Draft

KEPT = 20_000  # largest number of pairs of edges with cached crossings
NAMED_LIKE_PLACE = 1.0  # m; largest distance between a place of the map and its vertex


@dataclass(frozen=True, eq=False)
class DrawnEdge:
    """The curve of an edge, and the same curve as a shapely line. An unchanged edge keeps the same
    DrawnEdge object.
    """

    curve: Curve
    line: LineString
    bounds: Tuple[float, float, float, float]


Curves = Mapping[int, DrawnEdge]
"""For each edge id: its curve. An edge without a curve is left out; `check_edge` reports such an
edge.
"""


def check_together(draft: Draft, curves: Curves, rules: CheckRules) -> List[Finding]:
    """Returns the findings that do not depend on the floor."""
    return [*_parts(draft), *_one_way(draft), *_close(draft, rules), *_docks(draft),
            *_crossings(draft, curves), *_parking(draft, curves, rules)]


def check_corners(draft: Draft, curves: Curves, floor: Floor, rules: CheckRules) -> List[Finding]:
    """Returns findings for vertices at which robots must turn but do not have enough space."""
    findings = []
    for id, directions in _directions(draft, curves).items():
        vertex = draft.vertices[id]
        clearance = floor.clearance_of(vertex.position)
        if clearance >= rules.turning - GRAIN or clearance < rules.robot_width / 2.0:
            continue
        if len(directions) == 1 or any(
                abs(math.remainder(one + math.pi - other, 2.0 * math.pi)) > NEARLY_STRAIGHT
                for k, one in enumerate(directions) for other in directions[:k]):
            findings.append(Finding(
                Severity.WARNING, f'robots must turn here and have {clearance:.2f} m around them, '
                f'but need {rules.turning:.2f} m', 'vertex', id, vertex.position))
    return findings


def check_service(draft: Draft, curves: Curves, served: ServedFloor, places: Sequence[NamedPlace],
                  rules: CheckRules) -> List[Finding]:
    """Returns findings for floor far from all edges, and for places of the map that have no
    vertex.
    """
    findings = []
    positions = cKDTree(np.array([vertex.position for vertex in draft.vertices.values()]))
    for place in places:
        if place.kind is not PlaceKind.HOME:
            distance, _ = positions.query(place.position)
            if distance > NAMED_LIKE_PLACE:
                findings.append(Finding(
                    Severity.WARNING, f'{place.kind.value} {place.name!r} of the map has no vertex',
                    place=place.position))
    served.update([vertex.position for vertex in draft.vertices.values()],
                  {id: drawn.curve.points for id, drawn in curves.items()})
    grid, left = served.coverage, served.left()
    parts, _ = ndimage.label(left, EVERY_NEIGHBOUR)
    for part, window in enumerate(ndimage.find_objects(parts), 1):
        cells = np.argwhere(parts[window] == part)
        area = len(cells) * grid.cell_area
        if area >= rules.least_floor:
            middle = cells[int(np.argmin(((cells - cells.mean(axis=0)) ** 2).sum(axis=1)))]
            (x, y), = grid.points_of(np.array([middle[0] + window[0].start]),
                                     np.array([middle[1] + window[1].start]))
            findings.append(Finding(
                Severity.WARNING, f'{area:.1f} m2 of floor that robots can reach is farther than '
                f'{rules.reach:g} m from all edges', place=(float(x), float(y))))
    return findings


def _parts(draft: Draft) -> Iterable[Finding]:
    """Yields a finding for each part that no edges connect to the first part.

    A vertex without edges is an error. A larger part is a warning, because a graph may cover two
    halls or floors.
    """
    first, *others = draft.parts()
    for part in others:
        id, alone = min(part), len(part) == 1
        more = '' if alone else f' and {len(part) - 1} more'
        yield Finding(Severity.ERROR if alone else Severity.WARNING,
                      f'no edges lead from here{more} to vertex {min(first)}: '
                      + ('connect it' if alone else 'it is another part of the graph, and a '
                         'mission stays in one part'),
                      'vertex', id, draft.vertices[id].position)


def _one_way(draft: Draft) -> Iterable[Finding]:
    """Yields findings for vertices that robots cannot reach or cannot leave, because velocities are
    0.
    """
    ways = nx.DiGraph()
    ways.add_nodes_from(draft.vertices)
    for edge in draft.edges.values():
        if edge.velocity_forward > 0.0:
            ways.add_edge(edge.origin, edge.destination)
        if edge.velocity_backwards > 0.0:
            ways.add_edge(edge.destination, edge.origin)
    for part in draft.parts():
        core = max(nx.strongly_connected_components(ways.subgraph(part)),
                   key=lambda each: (len(each), -min(each)))
        start = min(core)
        reached, left = nx.descendants(ways, start), nx.ancestors(ways, start)
        for id in sorted(part - core):
            problem = ('cannot reach this vertex' if id not in reached else
                       'cannot leave this vertex' if id not in left else None)
            if problem:
                yield Finding(Severity.ERROR, f'robots {problem}: one-way edges lead '
                              f'{"away" if id not in reached else "here"} only', 'vertex', id,
                              draft.vertices[id].position)


def _close(draft: Draft, rules: CheckRules) -> Iterable[Finding]:
    ids = list(draft.vertices)
    tree = cKDTree(np.array([draft.vertices[id].position for id in ids]))
    for i, j in sorted(tree.query_pairs(rules.least_distance)):
        a, b = sorted((ids[i], ids[j]))
        yield Finding(Severity.WARNING, f'vertex {a} is less than {rules.least_distance:g} m away: '
                      'robots cannot distinguish them', 'vertex', b, draft.vertices[b].position)


def _docks(draft: Draft) -> Iterable[Finding]:
    for vertex in draft.vertices.values():
        edges = len(draft.edges_at(vertex.id)) if vertex.dock else 1
        if edges > 1:
            yield Finding(Severity.ERROR, f'{edges} edges lead to this dock, but robots never pass '
                          'through a dock: keep one edge', 'vertex', vertex.id, vertex.position)


def _crossings(draft: Draft, curves: Curves) -> Iterable[Finding]:
    """Yields findings for edges that cross at a point without a vertex."""
    for a, b in _near_pairs(curves):
        one, other = draft.edges[a], draft.edges[b]
        shared = {one.origin, one.destination} & {other.origin, other.destination}
        for place in _meetings(curves[a], curves[b], frozenset(
                draft.vertices[id].position for id in shared)):
            yield Finding(Severity.WARNING, f'it crosses edge {a} without a vertex there', 'edge',
                          b, place)


@lru_cache(maxsize=KEPT)
def _meetings(one: DrawnEdge, other: DrawnEdge, shared: FrozenSet[Tuple[float, float]]
              ) -> Tuple[Tuple[float, float], ...]:
    """Returns the points at which two edges meet, except at the vertices that they share."""
    if shared and _are_lines_at_an_angle(one.curve, other.curve):
        return ()
    ends = [Point(place) for place in shared]
    meeting = one.line.intersection(other.line)
    return tuple((part.centroid.x, part.centroid.y) for part in getattr(meeting, 'geoms', [meeting])
                 if not part.is_empty and all(part.distance(end) >= 0.1 for end in ends))


def _are_lines_at_an_angle(one: Curve, other: Curve) -> bool:
    return len(one.points) == len(other.points) == 2 and abs(math.sin(
        one.heading_at(0.0) - other.heading_at(0.0))) > 0.01


def _near_pairs(curves: Curves) -> Iterable[Tuple[int, int]]:
    """Yields the pairs of edges with overlapping bounding boxes."""
    ids = sorted(curves)
    boxes = np.array([curves[id].bounds for id in ids]).reshape(-1, 4)
    for k, id in enumerate(ids):
        left, bottom, right, top = boxes[k]
        rest = boxes[k + 1:]
        near = ((rest[:, 0] <= right) & (rest[:, 2] >= left)
                & (rest[:, 1] <= top) & (rest[:, 3] >= bottom))
        for other in np.flatnonzero(near):
            yield id, ids[k + 1 + int(other)]


def _parking(draft: Draft, curves: Curves, rules: CheckRules) -> Iterable[Finding]:
    """Yields findings for parking places at which a robot blocks others."""
    for vertex in draft.vertices.values():
        if not vertex.parking:
            continue
        own = set(draft.edges_at(vertex.id))
        here = Point(vertex.position)
        near = [id for id, drawn in curves.items()
                if id not in own and drawn.line.distance(here) < 2.0 * rules.turning]
        if near:
            yield Finding(Severity.WARNING, f'a robot that parks here blocks edge '
                          f'{", ".join(map(str, sorted(near)))}', 'vertex', vertex.id,
                          vertex.position)
        if len(own) > 1 and _separates(draft, vertex.id):
            yield Finding(Severity.ERROR, 'a robot that parks here cuts the graph in two',
                          'vertex', vertex.id, vertex.position)


def _separates(draft: Draft, id: int) -> bool:
    rest: Set[int] = set(draft.vertices) - {id}
    joined = nx.Graph()
    joined.add_nodes_from(rest)
    joined.add_edges_from((edge.origin, edge.destination) for edge in draft.edges.values()
                          if id not in (edge.origin, edge.destination))
    together = next(part for part in draft.parts() if id in part)
    return nx.number_connected_components(joined.subgraph(together - {id})) > 1


def _directions(draft: Draft, curves: Curves) -> Dict[int, List[float]]:
    """Returns the directions (rad) in which edges leave each vertex."""
    directions: Dict[int, List[float]] = {id: [] for id in draft.vertices}
    for id, drawn in curves.items():
        edge, curve = draft.edges[id], drawn.curve
        directions[edge.origin].append(curve.heading_at(0.0))
        directions[edge.destination].append(curve.heading_at(curve.length) + math.pi)
    return directions
