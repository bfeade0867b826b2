"""Adds lanes to floor that no lane serves yet: straight lanes between places at which robots can
turn.

The earlier steps may leave out floor that robots can reach. The floor on which robots can turn
consists of several parts. From one part to another, robots drive straight.
"""
from __future__ import annotations

from typing import Dict, List, NamedTuple, Optional, Tuple

import numpy as np
from scipy import ndimage
from scipy.sparse.csgraph import dijkstra
from skimage.graph import MCP_Geometric

from graph_editor.floor import EVERY_NEIGHBOUR, Floor
from graph_editor.making.coverage import CLOSED, Coverage, dense
from graph_editor.making.lanes import LaneNet, LaneOrNode
from graph_editor.making.options import MakingOptions
from graph_editor.making.straights import Margin, margins_of, straights, ways_to_drive
from graph_editor.making.tidying import LEAST_FLOOR

STEP = 0.25  # m; distance between the places at which lanes may begin, bend and end
ENOUGH = 0.9  # a path is shortened to a part that serves this share of the path's floor
MIDDLE = 2.0  # m; 1 m of clearance at a path's end is worth this length of path

Cell = Tuple[int, int]


class Joint(NamedTuple):
    """A place at which a lane can begin."""

    root: LaneOrNode
    position: np.ndarray


class WayToFloor(NamedTuple):
    """Lanes that lead from a joint through `places` (N,2), at which robots can turn. The first
    place is the joint itself.
    """

    joint: Joint
    places: np.ndarray
    clearances: List[float]
    """The clearance of each lane, m."""


def reach_out(net: LaneNet, options: MakingOptions) -> None:
    """Adds lanes to those parts of the floor that are far from lanes but have space for robots to
    turn.

    The largest part comes first. Parts are ignored if they have less than LEAST_FLOOR m2, or if no
    path leads to them.
    """
    floor = net.floor
    coverage = Coverage(floor, floor.clearance >= options.tight, options.reach)
    lanes = [dense(np.array(net.ends(lane)), coverage.pitch) for lane in net.lanes]
    away = coverage.distances(np.vstack([*net.positions.values(), *lanes]))
    turning = Coverage(floor, floor.clearance >= options.turning, options.reach).mask
    far = turning & (away > options.reach)
    while True:
        parts, _ = ndimage.label(far, EVERY_NEIGHBOUR)
        sizes = np.bincount(parts.ravel())[1:]
        if sizes.max(initial=0) * coverage.cell_area < LEAST_FLOOR:
            return
        part = parts == int(np.argmax(sizes)) + 1
        way = _way_to(net, part, coverage, options)
        served = np.zeros(0, int) if way is None else coverage.covered_by(way.places)
        if way is None or not part.flat[served].any():
            far[part] = False
        else:
            _draw(net, way, options)
            far.flat[served] = False


def _way_to(net: LaneNet, part: np.ndarray, coverage: Coverage,
            options: MakingOptions) -> Optional[WayToFloor]:
    """Returns a path into a `part` of the floor (a mask of the coverage's cells), or None."""
    floor, margin = net.floor, margins_of(options)[1]
    goals = coverage.points_of(*np.nonzero(part))
    costs = ways_to_drive(floor, margin, options, goals)
    joints = {cell: joint for cell, joint in _joints(net, margin).items()
              if costs[cell] != CLOSED}
    if not joints:
        return None
    search = MCP_Geometric(costs)
    ways, _ = search.find_costs(list(joints))
    rows, columns = floor.cells_of(goals)
    reached = np.isfinite(ways[rows, columns])
    if not reached.any():
        return None
    rows, columns = rows[reached], columns[reached]
    end = int(np.argmax(ways[rows, columns] + MIDDLE * floor.clearance[rows, columns]))
    cells = np.array(search.traceback((rows[end], columns[end])))
    points = floor.centres(*cells.T)
    joint = joints[tuple(cells[0])]
    points[0] = joint.position
    points = points[:_enough(points, part, coverage, options, floor)]
    return _straightened(joint, points, floor, margin, options)


def _joints(net: LaneNet, margin: Margin) -> Dict[Cell, Joint]:
    """Returns the joints with space to turn, by their cells. If a cell has several joints, a node
    is preferred.
    """
    joints = []
    for lane in net.lanes:
        a, b = net.ends(lane)
        length = net.length(lane)
        joints += [Joint(lane, a + s / length * (b - a)) for s in np.arange(STEP, length, STEP)]
    joints += [Joint(node, net.positions[node]) for node in net.nodes]
    positions = np.array([joint.position for joint in joints]).reshape(-1, 2)
    roomy = net.floor.clearance_at(positions) >= margin.turning
    cells = zip(*(each.tolist() for each in net.floor.cells_of(positions)))
    return {cell: joint for cell, joint, enough in zip(cells, joints, roomy) if enough}


def _enough(points: np.ndarray, part: np.ndarray, coverage: Coverage, options: MakingOptions,
            floor: Floor) -> int:
    """Returns the number of points at the start of a path that serve enough of the path's floor.

    ENOUGH is the share of this floor that they must serve.
    """
    def served(count: int) -> int:
        return int(np.count_nonzero(part.flat[coverage.covered_by(points[:count])]))
    wanted = ENOUGH * served(len(points))
    roomy = np.flatnonzero(floor.clearance_at(points) >= options.turning) + 1
    step = max(1, int(round(STEP / floor.resolution)))
    return next((int(count) for count in roomy[1::step] if served(count) >= wanted), len(points))


def _straightened(joint: Joint, points: np.ndarray, floor: Floor, margin: Margin,
                  options: MakingOptions) -> Optional[WayToFloor]:
    """Returns the cheapest lanes along points (N,2); each lane starts and ends at a place to turn.
    """
    roomy = floor.clearance_at(points) >= margin.turning
    jumping = ~roomy | np.roll(~roomy, 1) | np.roll(~roomy, -1)
    step = max(1, int(round(STEP / floor.resolution)))
    chosen = roomy & (jumping | (np.arange(len(points)) % step == 0))
    chosen[[0, -1]] = True
    places = points[chosen]
    costs, clearances = straights(floor, places, len(places), margin, options)
    totals, before = dijkstra(costs, directed=False, indices=0, return_predecessors=True)
    if len(places) < 2 or not np.isfinite(totals[-1]):
        return None
    way = [len(places) - 1]
    while way[-1]:
        way.append(int(before[way[-1]]))
    way.reverse()
    return WayToFloor(joint, places[way], [float(clearances[a, b]) for a, b in zip(way, way[1:])])


def _draw(net: LaneNet, way: WayToFloor, options: MakingOptions) -> None:
    here = net.joint(*way.joint)
    for start, end, clearance in zip(way.places, way.places[1:], way.clearances):
        there = net.add_node(end)
        net.add_lane(here, there, min(options.wide, clearance), np.array((start, end)))
        here = there
