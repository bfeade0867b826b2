"""Gives robots enough space: lanes lead straight through narrow places, between wider places.

A robot is wider across its corners than across its sides. So there are places that a robot can
pass, but where it cannot turn. If a lane bends at such a place, or is hardly wider than the robot,
new lanes replace it, between places nearby where the robot can turn. The new lanes have the largest
possible margin. If no margin is possible, no lane leads through the place.
"""
from __future__ import annotations

from itertools import combinations
from typing import Collection, Dict, Iterator, List, NamedTuple, Sequence, Set, Tuple

import numpy as np
from scipy import ndimage
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from graph_editor.floor import EVERY_NEIGHBOUR
from graph_editor.making.bends import turn_of
from graph_editor.making.coverage import CLOSED
from graph_editor.making.lanes import LaneNet
from graph_editor.making.options import MakingOptions
from graph_editor.making.sight import straight
from graph_editor.making.straights import (
    Margin,
    margins_of,
    places_to_turn,
    straights,
    ways_to_drive,
)
from graph_editor.robot import NEARLY_STRAIGHT
from graph_editor.site import NamedPlace

NEAR = 1.5  # m; lanes within this distance of a narrow corner may be replaced
ASIDE = 0.8  # m; places to turn are searched within this distance of the lanes
PLACES = 120  # number of places to turn that are tried: those nearest to the narrow places


class Gap(NamedTuple):
    """A place through which no lane leads, and the lanes and places that were lost behind it."""

    position: Tuple[float, float]
    clearance: float
    """The clearance at the position, m."""
    length: float
    """The length of the lanes behind the gap, m."""
    places: Tuple[NamedPlace, ...]
    """The places behind the gap."""

    def note(self, found: Collection[NamedPlace]) -> str:
        """Returns a note for people about the gap; `found`: the places to which other lanes lead.
        """
        x, y = self.position
        behind = f', nor to {self.length:.0f} m of lanes behind it' if self.length else ''
        names = ', '.join(place.name for place in self.places if place not in found)
        return (f'At {x:.2f} {y:.2f} the nearest obstacle is {self.clearance:.2f} m away, too near '
                f'for a robot to turn or to pass: no lane leads through{behind}'
                f'{", with " if names else ""}{names}.')


def widen(net: LaneNet, options: MakingOptions, places: Dict[int, NamedPlace],
          homes: Sequence[Tuple[float, float]]) -> List[Gap]:
    """Replaces lanes that are too narrow, except at the nodes of `places`.

    If no path is found, the lanes are removed. If the net then has several parts, only one part
    stays: the part with the largest number of places. If this number is equal, the number of
    `homes` (m) from which robots reach the part decides; then its length decides. The places of
    other parts are removed.

    Returns the gaps.
    """
    margins = margins_of(options)
    _split_narrow_lanes(net, margins[-1])
    gaps: List[Gap] = []
    seen = set(places)
    while True:
        node = next((node for node in _too_narrow(net, margins[-1]) if node not in seen), None)
        if node is None:
            return gaps
        cluster = _cluster(net, node, margins[-1], set(places))
        seen |= cluster
        x, y = net.positions[node]
        if not any(_redraw(net, cluster, margin, options) for margin in margins):
            for each in cluster & set(_too_narrow(net, margins[-1])):
                net.remove_node(each)
            gaps.append(Gap((x, y), net.floor.clearance_of((x, y)),
                            *_leave_out(net, places, homes, options)))


def _split_narrow_lanes(net: LaneNet, least: Margin) -> None:
    """Adds a node at the narrowest place of each lane that is too narrow."""
    for lane in net.lanes:
        points = straight(net.floor, *net.ends(lane))
        room = net.floor.clearance_at(points)
        narrowest = int(np.argmin(room))
        if room[narrowest] < least.straight and 0 < narrowest < len(points) - 1:
            net.split(lane, points[narrowest])


def _too_narrow(net: LaneNet, least: Margin) -> Iterator[int]:
    """Yields nodes that a robot cannot pass, and nodes at which it must turn but cannot."""
    for node in net.nodes:
        room = net.floor.clearance_of(net.positions[node])
        if room < least.straight and net.degree(node) > 1 or (
                room < least.turning and _bends(net, node)):
            yield node


def _leave_out(net: LaneNet, places: Dict[int, NamedPlace], homes: Sequence[Tuple[float, float]],
               options: MakingOptions) -> Tuple[float, Tuple[NamedPlace, ...]]:
    """Removes all parts of the net except one. Returns the length of the removed lanes (m), and the
    removed places.
    """
    parts = list(net.components())
    if len(parts) == 1:
        return 0.0, ()
    worth = [(len(part & set(places)), started,
              sum(net.length(lane) for lane in net.lanes if lane.nodes[0] in part))
             for part, started in zip(parts, _started_at(net, parts, homes, options))]
    stays = worth.index(max(worth))
    del parts[stays], worth[stays]
    gone = set().union(*parts)
    left_out = tuple(places.pop(node) for node in sorted(gone & set(places)))
    for node in gone:
        net.remove_node(node)
    return sum(length for _, _, length in worth), left_out


def _started_at(net: LaneNet, parts: Sequence[Set[int]], homes: Sequence[Tuple[float, float]],
                options: MakingOptions) -> List[int]:
    """Returns for each part of the net the number of `homes` (m) from which robots can drive to
    it.
    """
    costs = ways_to_drive(net.floor, margins_of(options)[1], options,
                          np.vstack((*homes, *net.positions.values())))
    floor, _ = ndimage.label(costs != CLOSED, EVERY_NEIGHBOUR)
    started = [net.floor.part_near(floor, home) for home in homes]
    ends = {node: net.floor.part_near(floor, (x, y)) for node, (x, y) in net.positions.items()}
    reached = [{ends[node] for node in part} - {0} for part in parts]
    return [sum(home in there for home in started) for there in reached]


def _bends(net: LaneNet, node: int) -> bool:
    return any(turn_of([net.positions[each] for each in (one, node, other)]) > NEARLY_STRAIGHT
               for one, other in combinations(net.neighbours(node), 2))


def _cluster(net: LaneNet, corner: int, least: Margin, held: Set[int]) -> Set[int]:
    """Returns the nodes to replace: a corner, and those nodes near the corner that are too narrow
    or have only two lanes.
    """
    tight = set(_too_narrow(net, least)) - held
    cluster, ahead = {corner}, [corner]
    while ahead:
        here = ahead.pop()
        for node in net.neighbours(here):
            near = np.hypot(*(net.positions[node] - net.positions[corner])) < NEAR
            if near and node not in cluster | held and (node in tight or net.degree(node) == 2):
                cluster.add(node)
                ahead.append(node)
    return cluster


def _redraw(net: LaneNet, cluster: Set[int], margin: Margin, options: MakingOptions) -> bool:
    """Replaces the lanes of the cluster; returns False if there is no path."""
    lanes = {net.lane(node, other).nodes for node in cluster for other in net.neighbours(node)}
    ends = sorted({node for key in lanes for node in key} - cluster)
    along = np.vstack([straight(net.floor, *(net.positions[node] for node in key))
                       for key in sorted(lanes)])
    places = np.vstack([[net.positions[end] for end in ends],
                        _places_along(net, along, margin, options)])
    costs, clearances = straights(net.floor, places, len(ends), margin, options)
    totals, before = dijkstra(costs, directed=False, indices=range(len(ends)),
                              return_predecessors=True)
    middle = int(np.argmin(totals.sum(axis=0)))
    if not np.isfinite(totals[:, middle].sum()):
        return False
    for node in cluster:
        net.remove_node(node)
    nodes: Dict[int, int] = dict(enumerate(ends))
    for row in range(len(ends)):
        here = middle
        while here != row:
            onward = int(before[row, here])
            for place in (here, onward):
                if place not in nodes:
                    nodes[place] = net.add_node(places[place])
            net.add_lane(nodes[here], nodes[onward],
                         min(options.wide, float(clearances[here, onward])),
                         places[[here, onward]])
            here = onward
    return True


def _places_along(net: LaneNet, along: np.ndarray, margin: Margin,
                  options: MakingOptions) -> np.ndarray:
    """Returns the places to turn (N,2) that are nearest to those parts of the lanes where robots
    cannot turn.
    """
    places = places_to_turn(net.floor, along.min(axis=0) - ASIDE, along.max(axis=0) + ASIDE, margin)
    narrow = along[net.floor.clearance_at(along) < options.turning]
    if not len(places) or not len(narrow):
        return np.zeros((0, 2))
    away, _ = cKDTree(narrow).query(places)
    return places[np.argsort(away, kind='stable')[:PLACES]]
