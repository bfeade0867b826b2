"""Replaces a winding chain by a few free, straight lanes, as a person would draw them.

Dynamic programming finds the cheapest division of the chain into straight pieces. Each piece costs
1. A piece that deviates from the chain by half a metre, along one metre, costs 1 more.
"""
from __future__ import annotations

from typing import List

import numpy as np

from graph_editor.floor import Floor
from graph_editor.making.chains import ChainGraph
from graph_editor.making.lanes import LaneNet
from graph_editor.making.options import MakingOptions
from graph_editor.making.sight import in_sight

STEP = 0.2  # m; distance between the points of a chain at which a piece may end
STRAYING = 4.0  # cost per m3 of the squared deviation, integrated along the path
LONGEST = 150  # largest number of steps in a piece


def straighten(graph: ChainGraph, options: MakingOptions) -> LaneNet:
    """Returns each chain as straight lanes; the nodes of the chains do not move."""
    net = LaneNet(graph.floor)
    nodes = {node: net.add_node(graph.position(node)) for node in graph.nodes}
    for chain in graph.chains:
        corners = straight_pieces(graph.floor, chain.path, options.wide)
        inner = [net.add_node(chain.path[index]) for index in corners[1:-1]]
        way = [nodes[chain.start], *inner, nodes[chain.end]]
        for k, (first, last) in enumerate(zip(corners, corners[1:])):
            need = min(options.wide, float(chain.clearances[first:last + 1].min()))
            net.add_lane(way[k], way[k + 1], need, chain.path[first:last + 1])
    return net


def straight_pieces(floor: Floor, path: np.ndarray, wide: float) -> List[int]:
    """Returns the indices of the points of `path` (N,2) at which straight pieces begin and end.

    A piece must have the clearance of its part of the path, or `wide` (m) if `wide` is less. A path
    that returns to its start gets at least three pieces.
    """
    stops = _stops(path)
    near = path - path[0]  # small numbers increase the precision
    moments = _moments(near)[stops]
    clearances = np.minimum(floor.clearance_at(path), wide)
    lows = np.minimum.reduceat(clearances, stops)  # from each stop to the next
    closed = bool(np.allclose(path[0], path[-1]))
    costs = np.zeros(len(stops))
    before = np.zeros(len(stops), int)
    for j in range(1, len(stops)):
        first = max(0, j - LONGEST, j - len(stops) // 2 if closed else 0)
        needs = np.minimum(np.minimum.accumulate(lows[first:j][::-1])[::-1], clearances[stops[j]])
        straying = _straying(near[stops[first:j]], near[stops[j]], moments[j] - moments[first:j])
        totals = costs[first:j] + 1.0 + STRAYING * straying
        for k in np.argsort(totals, kind='stable'):
            if k == j - first - 1 or in_sight(floor, path[stops[first + k]], path[stops[j]],
                                              float(needs[k])):
                costs[j], before[j] = totals[k], first + k
                break
    chosen = [len(stops) - 1]
    while chosen[-1]:
        chosen.append(int(before[chosen[-1]]))
    return [stops[k] for k in reversed(chosen)]


def _stops(path: np.ndarray) -> List[int]:
    """Returns the indices of points about STEP apart, including both ends."""
    arc = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))))
    count = max(int(round(arc[-1] / STEP)), 1)
    at = np.searchsorted(arc, np.linspace(0.0, arc[-1], count + 1) - 1e-9)
    return [int(k) for k in np.unique(at)]


def _moments(path: np.ndarray) -> np.ndarray:
    """Returns the integrals (N,6) of 1, x, y, x2, xy, y2 from the start of the path to each of its
    N points.
    """
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    x, y = ((path[1:] + path[:-1]) / 2.0).T
    parts = np.column_stack((np.ones_like(x), x, y, x * x, x * y, y * y)) * steps[:, None]
    return np.vstack((np.zeros(6), np.cumsum(parts, axis=0)))


def _straying(starts: np.ndarray, end: np.ndarray, moments: np.ndarray) -> np.ndarray:
    """Returns how far a path strays from each of N straight lines, as N integrals (m3).

    The lines lead from `starts` (N,2) to `end`. The squared distance between path and line is
    integrated along the path. The integral is infinite if start and end coincide.

    moments -- (N,6): the moments of the path between these points
    """
    along = end - starts
    length = np.hypot(*along.T)
    safe = np.maximum(length, 1e-9)
    a, b = -along[:, 1] / safe, along[:, 0] / safe  # the line's normal
    c = -(a * end[0] + b * end[1])
    one, x, y, xx, xy, yy = moments.T
    squares = (a * a * xx + b * b * yy + c * c * one
               + 2.0 * (a * b * xy + a * c * x + b * c * y))
    return np.where(length > 1e-6, np.maximum(squares, 0.0), np.inf)
