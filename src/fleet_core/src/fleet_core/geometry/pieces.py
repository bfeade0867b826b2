"""All curves of a graph as straight pieces, each with its largest distance from the true curve.

A *place* is where a robot can be while it waits or drives: a vertex, or an edge with its two ends.
Places are numbered: first the vertices, then the edges, both in the graph's order.
"""
from __future__ import annotations

from typing import NamedTuple

import numpy as np

from trajectory_graph import CurveType, Graph
from trajectory_graph.curves import bezier_arc_lengths, bezier_lengths, bezier_points

# m: the largest permitted distance of a curve from its pieces; `margin` has the actual distance
TOLERANCE = 5e-3
_FINE = 64  # number of fine parts of a spline, from which pieces are made; a power of two
_COARSE = 16  # number of fine parts in one piece if the curve is nearly straight
# number of splines computed in one step, so that their arrays stay in the processor's cache
_AT_ONCE = 256
# upper bound of a part's distance from its chord, as a multiple of the distance at its middle
_BULGE = 1.5


class Pieces(NamedTuple):
    """N straight pieces. The pieces of a place follow its curve in order."""

    place: np.ndarray   # (N,)
    start: np.ndarray   # (2, N) m
    end: np.ndarray     # (2, N) m, equal to the start for a vertex
    begins: np.ndarray  # (N,) 0..1, fraction of the edge's arc length at `start`
    ends: np.ndarray    # (N,) the same at `end`; in between, the fraction grows evenly
    margin: np.ndarray  # (N,) m: the largest distance between a point of the curve and the point
                        # of the piece at the same fraction of the length


class Splines(NamedTuple):
    """All S splines of a graph."""

    edges: np.ndarray    # (S,) counted in the graph's order
    control: np.ndarray  # (S,4,2) m, their control points


def splines_of(graph: Graph) -> Splines:
    """Returns the splines with their control points.

    Computing these is slow, so it is done once.
    """
    edges = [k for k, edge in enumerate(graph.edges.values())
             if edge.curve_type is CurveType.SPLINE]
    ids = list(graph.edges)
    control = np.array([graph.control_points(ids[k]) for k in edges], dtype=float)
    return Splines(np.array(edges, dtype=np.int64), control.reshape(-1, 4, 2))


def pieces_of(graph: Graph, splines: Splines) -> Pieces:
    """Returns the pieces of all vertices, then of all edges."""
    positions = np.array([vertex.position for vertex in graph.vertices.values()], dtype=float).T
    index = {id: k for k, id in enumerate(graph.vertices)}
    count = len(index)
    nothing = np.zeros(count)
    parts = [Pieces(np.arange(count), positions, positions, nothing, nothing, nothing)]
    edges = list(graph.edges.values())
    lines = [k for k, edge in enumerate(edges) if edge.curve_type is CurveType.LINE]
    if lines:
        ends = np.array([(index[edges[k].origin], index[edges[k].destination]) for k in lines])
        parts.append(Pieces(count + np.array(lines), positions[:, ends[:, 0]],
                            positions[:, ends[:, 1]], np.zeros(len(lines)), np.ones(len(lines)),
                            np.zeros(len(lines))))
    for k in range(0, len(splines.edges), _AT_ONCE):
        some = slice(k, k + _AT_ONCE)
        parts.append(_spline_pieces(count + splines.edges[some], splines.control[some]))
    return Pieces(*(np.concatenate(columns, axis=-1) for columns in zip(*parts)))


def edge_lengths(graph: Graph, splines: Splines) -> np.ndarray:
    """Returns the arc length (m) of each edge, in the graph's order."""
    lengths = np.zeros(len(graph.edges))
    for k, edge in enumerate(graph.edges.values()):
        if edge.curve_type is CurveType.LINE:
            ends = graph.vertices[edge.origin].position, graph.vertices[edge.destination].position
            lengths[k] = np.hypot(ends[1][0] - ends[0][0], ends[1][1] - ends[0][1])
    for k in range(0, len(splines.edges), _AT_ONCE):
        some = slice(k, k + _AT_ONCE)
        lengths[splines.edges[some]] = bezier_lengths(splines.control[some])
    return lengths


def _spline_pieces(places: np.ndarray, control: np.ndarray) -> Pieces:
    """Returns the pieces of splines: chords, halved until no point of the curve is too far
    from its chord.
    """
    t = np.linspace(0.0, 1.0, 2 * _FINE + 1)
    points, arcs = bezier_points(control, t), bezier_arc_lengths(control, t)
    arcs /= arcs[:, -1:]
    # The distance of a fine part from its chord, at its middle, bounds the distance everywhere.
    which, begins = np.repeat(np.arange(len(places)), _FINE), np.tile(np.arange(_FINE), len(places))
    bulge = _strayed(points, arcs, which, 2 * begins, 2).reshape(len(places), _FINE).max(axis=1)
    bulge *= _BULGE
    points, arcs = points[:, ::2], arcs[:, ::2]
    pieces = _FINE // _COARSE
    which, step = np.repeat(np.arange(len(places)), pieces), _COARSE
    begins = np.tile(np.arange(pieces) * step, len(places))
    done = []
    while len(which):
        strayed = _strayed(points, arcs, which, begins, step) + bulge[which]
        good = (strayed <= TOLERANCE) | (step == 1)
        done.append((which[good], begins[good], np.full(int(good.sum()), step), strayed[good]))
        which, begins = np.repeat(which[~good], 2), np.repeat(begins[~good], 2)
        step //= 2
        begins[1::2] += step
    which, begins, steps, strayed = map(np.concatenate, zip(*done))
    order = np.lexsort((begins, which))
    which, begins, strayed = which[order], begins[order], strayed[order]
    ends = begins + steps[order]
    return Pieces(places[which], points[which, begins].T, points[which, ends].T,
                  arcs[which, begins], arcs[which, ends], strayed)


def _strayed(points: np.ndarray, arcs: np.ndarray, which: np.ndarray, begins: np.ndarray,
             step: int) -> np.ndarray:
    """Returns how far (m) each chord is from its part of the curve: the largest distance between
    two points that lie at the same fraction of the chord and of the arc.

    A chord leads from point `begins` to point `begins` + `step` of curve `which`.
    """
    at = (which * arcs.shape[1] + begins)[:, None] + np.arange(step + 1)
    arc: np.ndarray = arcs.ravel().take(at)
    share = (arc - arc[:, :1]) / np.maximum(arc[:, -1:] - arc[:, :1], 1e-12)
    square = np.zeros_like(share)
    for k in (0, 1):
        curve: np.ndarray = points[..., k].ravel().take(at)
        off = curve - curve[:, :1] - share * (curve[:, -1:] - curve[:, :1])
        square += off * off
    return np.sqrt(square.max(axis=1))
