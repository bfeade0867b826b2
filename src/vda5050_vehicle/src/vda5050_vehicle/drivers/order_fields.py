"""The optional fields of an order that a driver honours; orders with other fields are rejected.

VDA 5050 2.1.0, 6.1.1: a vehicle must not ignore a field. A field is honoured if the vehicle
satisfies it anyway. The error of a rejected order names the field.
"""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable, Dict, FrozenSet, Optional, Sequence, Tuple

from vda5050_protocol import problems as e
from vda5050_protocol.values import NodePosition, OrderEdge, OrderMessage, OrderNode
from vda5050_vehicle.drivers.driver import NotDrivable
from vda5050_vehicle.drivers.robot_view import RobotPose

HEADING_TOLERANCE = 0.1  # rad; the tolerance of a heading for which the node sets no deviation


@dataclass(frozen=True)
class Abilities:
    """The abilities of the robot, in m/s, rad/s and m.

    corridor -- half the width that the robot may need on an edge
    passing  -- distance within which the robot passes a vertex of a route
    map_id   -- the only map that the robot knows; '': any name that the master uses
    ignored  -- keys of the fields that the site has chosen to ignore
    """

    top_speed: float = 1.35
    top_rotation: float = math.pi
    height: float = 0.4
    corridor: float = 0.45
    passing: float = 0.3
    map_id: str = ''
    ignored: FrozenSet[str] = frozenset()


def _drives_forwards(edge: OrderEdge) -> bool:
    return edge.orientation == 0.0 and edge.orientation_type in (None, 'TANGENTIAL')


_Rule = Callable[[OrderEdge, Abilities], bool]

# For each field of an edge: a function that returns whether the vehicle satisfies the field anyway.
EDGE_RULES: Dict[str, _Rule] = {
    'trajectory': lambda edge, _: edge.trajectory is None,
    'maxSpeed': lambda edge, can: edge.max_speed is None or edge.max_speed >= can.top_speed,
    'maxRotationSpeed': lambda edge, can: (edge.max_rotation_speed is None
                                           or edge.max_rotation_speed >= can.top_rotation),
    'maxHeight': lambda edge, can: edge.max_height is None or edge.max_height >= can.height,
    'minHeight': lambda edge, can: edge.min_height is None or edge.min_height <= 0.0,
    'orientation': lambda edge, _: edge.orientation is None or _drives_forwards(edge),
    'direction': lambda edge, _: edge.direction is None,
    'rotationAllowed': lambda edge, _: edge.rotation_allowed is not False,
    'corridor': lambda edge, can: edge.corridor is None or not edge.corridor.release_required
    and min(edge.corridor.left_width, edge.corridor.right_width) >= can.corridor,
}
FIELDS = frozenset(EDGE_RULES) | {'zoneSetId', 'theta', 'mapId', 'allowedDeviationXY'}


def check_fields(order: OrderMessage, can: Abilities) -> None:
    """Raises NotDrivable if the order has a field that the robot does not honour.

    `check_headings` and `check_deviations` check headings and deviations.
    """
    if order.zone_set_id is not None and 'zoneSetId' not in can.ignored:
        raise _unsupported('zoneSetId', 'the vehicle does not support zones')
    for index, edge in enumerate(order.edges):
        for key, is_honoured in EDGE_RULES.items():
            if key not in can.ignored and not is_honoured(edge, can):
                raise _unsupported(f'edges[{index}].{key}', f'edge {edge.edge_id!r}: the vehicle '
                                                            f'cannot satisfy the {key} field')
    for index, node in enumerate(order.nodes):
        if node.position is not None and not _knows_map(node.position, can):
            raise NotDrivable(e.UNKNOWN_MAP,
                              f'node {node.node_id!r} is on map {node.position.map_id!r}, but '
                              f'the vehicle has map {can.map_id!r} only',
                              f'nodes[{index}].nodePosition.mapId')


def check_headings(nodes: Sequence[OrderNode], can: Abilities,
                   can_turn: Callable[[int, OrderNode], bool], first: int = 1) -> None:
    """Raises NotDrivable if a node has a heading for which `can_turn` returns False. Nodes before
    index `first` are not checked.
    """
    if 'theta' in can.ignored:
        return
    for index, node in enumerate(nodes):
        if index >= first and heading_of(node, can) is not None and not can_turn(index, node):
            raise _unsupported(f'nodes[{index}].nodePosition.theta',
                               f'node {node.node_id!r}: the vehicle cannot take a heading there')


def check_start_heading(node: OrderNode, pose: RobotPose, can: Abilities) -> None:
    """Raises NotDrivable if an order begins with a heading that the robot does not have."""
    wanted = heading_of(node, can)
    if wanted is not None and not has_heading(node, wanted, pose.theta):
        raise _unsupported('nodes[0].nodePosition.theta',
                           f'node {node.node_id!r}: the vehicle does not turn before it drives, '
                           f'and has heading {pose.theta:.2f}')


def check_deviations(nodes: Sequence[OrderNode], place: Callable[[OrderNode], Tuple[float, float]],
                     can: Abilities) -> None:
    """Raises NotDrivable if a node has a deviation that the robot cannot keep.

    The first node of the order is not checked. A deviation of 0 means the vehicle's own deviation.
    place -- returns the position at which the robot passes a node
    """
    if 'allowedDeviationXY' in can.ignored:
        return
    for index, node in enumerate(nodes):
        deviation = node.position.allowed_deviation_xy if node.position else None
        if index == 0 or node.position is None or deviation is None or deviation.radius <= 0.0:
            continue
        needed = can.passing + math.dist(place(node), (node.position.x, node.position.y))
        if deviation.radius < needed - 1e-6:
            raise _unsupported(f'nodes[{index}].nodePosition.allowedDeviationXY',
                               f'node {node.node_id!r}: the vehicle passes it within '
                               f'{needed:.2f} m')


def has_heading(node: OrderNode, wanted: float, heading: float) -> bool:
    """Returns whether `heading` equals the wanted heading, within the deviation of the node."""
    deviation = node.position.allowed_deviation_theta if node.position else None
    return abs(math.remainder(heading - wanted, 2.0 * math.pi)) <= max(
        deviation or 0.0, HEADING_TOLERANCE)


def heading_of(node: OrderNode, can: Abilities) -> Optional[float]:
    """Returns the heading that a node requires; None if any heading is allowed."""
    position = node.position
    if position is None or position.theta is None or 'theta' in can.ignored:
        return None
    free = (position.allowed_deviation_theta or 0.0) >= math.pi - 1e-6
    return None if free else position.theta


def is_within(node: OrderNode, place: Tuple[float, float], pose: RobotPose, near: float) -> bool:
    """Returns whether the robot is within `near` (m) of a node, or within the node's deviation."""
    dx, dy = pose.x - place[0], pose.y - place[1]
    deviation = node.position.allowed_deviation_xy if node.position else None
    return math.hypot(dx, dy) <= near or deviation is not None and deviation.contains(dx, dy)


def _knows_map(position: NodePosition, can: Abilities) -> bool:
    return not can.map_id or 'mapId' in can.ignored or position.map_id == can.map_id


def _unsupported(field: str, why: str) -> NotDrivable:
    return NotDrivable(e.UNSUPPORTED, why, field)
