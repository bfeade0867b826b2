"""Makes a node for each goal and dock: on a lane that passes the place, or at the end of a new
lane.
"""
from __future__ import annotations

import math
from types import MappingProxyType
from typing import Dict, Iterable, List, Mapping, NamedTuple, Optional, Set, Tuple

import numpy as np
from skimage.graph import MCP_Geometric

from graph_editor.floor import Floor
from graph_editor.making.lanes import Lane, LaneNet, LaneOrNode
from graph_editor.making.options import MakingOptions
from graph_editor.making.sight import TOLERANCE, in_sight, straight
from graph_editor.making.straightening import straight_pieces
from graph_editor.site import NamedPlace, PlaceKind

ON_LANE = 0.6  # m; a goal within this distance of a lane becomes a node of this lane
NEAR_NODE = 0.7  # m; a lane to a place starts at a node if a node is within this distance
STRAIGHT_IN = 1.0  # m; length of the straight path of a robot into a dock
FARTHEST = 8.0  # m; largest distance at which a place is joined to a lane by a straight lane
UNEVEN = 0.5  # m; additional cost of a lane that does not meet its target at a right angle


class Attached(NamedTuple):
    """The nodes of the places, and notes for people about places without a node."""

    nodes: Dict[int, NamedPlace]
    notes: List[str]


def attach_places(net: LaneNet, places: Iterable[NamedPlace], options: MakingOptions,
                  there: Mapping[int, NamedPlace] = MappingProxyType({})) -> Attached:
    """Makes a node for each goal and dock; homes get no node.

    there -- places that already have nodes
    """
    attached = Attached(dict(there), [])
    for place in places:
        if place.kind is PlaceKind.HOME:
            continue
        node = _attach(net, place, attached, options)
        if node is None:
            continue
        attached.nodes[node] = place
    return attached


def _attach(net: LaneNet, place: NamedPlace, attached: Attached,
            options: MakingOptions) -> Optional[int]:
    position = np.array(place.position)
    room = net.floor.clearance_of(position)
    if room < options.robot_width / 2.0 - TOLERANCE:
        attached.notes.append(f'{place.name} is {room:.2f} m from an obstacle, too near for a '
                              f'robot {options.robot_width:g} m wide: it gets no vertex.')
        return None
    for node, other in attached.nodes.items():
        if np.hypot(*(net.positions[node] - position)) < 0.05:
            attached.notes.append(f'{place.name} is at the position of {other.name}: they are one '
                                  'vertex.')
            return None
    if place.kind is not PlaceKind.DOCK:
        on_lane = _on_lane(net, position, attached.nodes)
        if on_lane is not None:
            return on_lane
    return _with_lane_of_its_own(net, place, attached, options)


def _on_lane(net: LaneNet, position: np.ndarray, taken: Dict[int, NamedPlace]) -> Optional[int]:
    """Moves a nearby node to the position, or bends a nearby lane so that it passes there. Returns
    the node; None: no suitable node or lane is near.
    """
    near = [(float(np.hypot(*(net.positions[node] - position))), node) for node in net.nodes
            if node not in taken]
    near = [(distance, node) for distance, node in near if distance < ON_LANE]
    for _, node in sorted(near):
        if all(in_sight(net.floor, net.positions[other], position,
                        net.lane(node, other).need) for other in net.neighbours(node)):
            net.positions[node] = position
            return node
    passing = [(_distance(net, lane, position), lane.nodes) for lane in net.lanes]
    for distance, key in sorted(passing):
        if distance >= ON_LANE:
            break
        lane = net.lane(*key)
        ends = net.ends(lane)
        if min(np.hypot(*(end - position)) for end in ends) > ON_LANE and all(
                in_sight(net.floor, end, position, lane.need) for end in ends):
            return net.split(lane, position)
    return None


def _distance(net: LaneNet, lane: Lane, position: np.ndarray) -> float:
    return float(np.hypot(*(_foot(net, lane, position) - position)))


def _foot(net: LaneNet, lane: Lane, position: np.ndarray) -> np.ndarray:
    a, b = net.ends(lane)
    along = b - a
    fraction = float((position - a) @ along / max(float(along @ along), 1e-12))
    return a + min(max(fraction, 0.0), 1.0) * along


def _with_lane_of_its_own(net: LaneNet, place: NamedPlace, attached: Attached,
                          options: MakingOptions) -> Optional[int]:
    position = np.array(place.position)
    if place.kind is PlaceKind.DOCK and place.heading is not None:
        node = _straight_behind(net, position, place.heading, attached.nodes, options)
        if node is not None:
            return _draw(net, [position, net.positions[node]], node, options)
    start, need = _start_of_lane(net.floor, place, options)
    found = _straight_to_lane(net, start, need, options, set(attached.nodes))
    if found is None and not np.array_equal(start, position):
        start, need = position, _need_at(net.floor, position, options)
        found = _straight_to_lane(net, start, need, options, set(attached.nodes))
    way = [position] if np.array_equal(start, position) else [position, start]
    if found is not None:
        end, lane_or_node = found
        node = net.joint(lane_or_node, end)
        way.append(end)
    else:
        path = _path_to_lane(net, position, options)
        if path is None:
            attached.notes.append(f'{place.name} cannot be reached from the lanes: it gets no '
                                  'vertex.')
            return None
        way, node = path
    return _draw(net, way, node, options)


def _straight_behind(net: LaneNet, position: np.ndarray, heading: float,
                     taken: Dict[int, NamedPlace], options: MakingOptions) -> Optional[int]:
    """Returns a node straight behind a dock, at least 0.4 m away: an existing node, or a new node
    on a lane.
    """
    behind = -np.array((math.cos(heading), math.sin(heading)))
    across = np.array((-behind[1], behind[0]))
    found: List[Tuple[float, int, LaneOrNode]] = []
    for node in net.nodes:
        offset = net.positions[node] - position
        if abs(offset @ across) < 0.1 * abs(offset @ behind) + 0.05:
            found.append((float(offset @ behind), len(found), node))
    for lane in net.lanes:
        a, b = (end - position for end in net.ends(lane))
        sides = float(a @ across), float(b @ across)
        if sides[0] * sides[1] < 0.0:
            share = sides[0] / (sides[0] - sides[1])
            place = a + share * (b - a)
            if min(share, 1.0 - share) * net.length(lane) > NEAR_NODE / 2.0:
                found.append((float(place @ behind), len(found), lane))
    for distance, _, target in sorted(found, key=lambda entry: entry[:2]):
        if not 0.4 < distance < FARTHEST / 2.0:
            continue
        end = net.positions[target] if isinstance(target, int) else position + distance * behind
        if in_sight(net.floor, position, end, options.tight):
            return net.joint(target, end)
    return None


def _draw(net: LaneNet, way: List[np.ndarray], node: int, options: MakingOptions) -> int:
    """Adds lanes along `way`, from a new node to `node`; returns the new node."""
    first = last = net.add_node(way[0])
    for here in [*way[1:-1], None]:
        onward = node if here is None else net.add_node(here)
        a, b = net.positions[last], net.positions[onward]
        clearance = float(net.floor.clearance_at(straight(net.floor, a, b)).min())
        net.add_lane(last, onward, min(options.wide, clearance), np.array((a, b)))
        last = onward
    return first


def _start_of_lane(floor: Floor, place: NamedPlace,
                   options: MakingOptions) -> Tuple[np.ndarray, float]:
    """Returns the start of a place's own lane, and the clearance that the lane needs there.

    For a dock with enough space, the lane starts where the straight path into the dock starts.
    """
    position = np.array(place.position)
    if place.kind is PlaceKind.DOCK and place.heading is not None:
        behind = position - STRAIGHT_IN * np.array((math.cos(place.heading),
                                                    math.sin(place.heading)))
        if in_sight(floor, position, behind, options.tight):
            return behind, _need_at(floor, behind, options)
    return position, _need_at(floor, position, options)


def _need_at(floor: Floor, position: np.ndarray, options: MakingOptions) -> float:
    """Returns the clearance that a lane needs: the clearance at the position, but at most that of a
    whole corridor, and at least that of the robot.
    """
    room = floor.clearance_of(position)
    return max(min(options.wide, room), options.robot_width / 2.0)


def _straight_to_lane(net: LaneNet, start: np.ndarray, need: float, options: MakingOptions,
                      taken: Set[int]) -> Optional[Tuple[np.ndarray, LaneOrNode]]:
    """Finds the cheapest straight path from `start` to a lane or node. Returns the end of the path,
    and this lane or node.
    """
    ways: List[Tuple[float, int, np.ndarray, LaneOrNode]] = []
    for lane in net.lanes:
        foot = _foot(net, lane, start)
        ends = [(float(np.hypot(*(net.positions[node] - foot))), node) for node in lane.nodes]
        distance, node = min(ends)
        target: LaneOrNode = lane
        if distance < NEAR_NODE:
            foot, target = net.positions[node], node
        length = float(np.hypot(*(foot - start)))
        right_angle = distance >= NEAR_NODE
        cost = length + (0.0 if right_angle else UNEVEN) + (5.0 if target in taken else 0.0)
        if 0.05 < length < FARTHEST:
            ways.append((cost, len(ways), foot, target))
    for _, _, foot, target in sorted(ways, key=lambda way: way[:2]):
        if in_sight(net.floor, start, foot, need):
            return foot, target
    return None


def _path_to_lane(net: LaneNet, start: np.ndarray,
                  options: MakingOptions) -> Optional[Tuple[List[np.ndarray], int]]:
    """Returns a winding path to the nearest node. If possible, the path keeps away from walls."""
    floor = net.floor
    costs = np.where(floor.clearance >= options.robot_width / 2.0,
                     1.0 + 4.0 * np.exp(-4.0 * floor.clearance), -1.0)
    nodes = net.nodes
    rows, columns = floor.cells_of(np.array([net.positions[node] for node in nodes]))
    (row,), (column,) = floor.cells_of(start[None, :])
    ways = MCP_Geometric(costs)
    totals, _ = ways.find_costs([(row, column)])
    best = int(np.argmin(totals[rows, columns]))
    if not np.isfinite(totals[rows[best], columns[best]]):
        return None
    cells = np.array(ways.traceback((rows[best], columns[best])))
    path = floor.centres(cells[:, 0], cells[:, 1])
    path[0], path[-1] = start, net.positions[nodes[best]]
    corners = straight_pieces(floor, path, options.wide)
    return [path[index] for index in corners], nodes[best]
