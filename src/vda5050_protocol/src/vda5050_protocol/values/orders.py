"""The values that come from the master: orders and actions."""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Mapping, Optional, Tuple, Union

from vda5050_protocol.values.enums import BlockingType


@dataclass(frozen=True)
class ActionParameter:
    """A parameter of an action; `value` is any JSON value."""

    key: str
    value: Any


@dataclass(frozen=True)
class VdaAction:
    """An action to execute on a node, on an edge or at once."""

    action_type: str
    action_id: str
    blocking_type: BlockingType
    parameters: Tuple[ActionParameter, ...] = ()
    description: Optional[str] = None
    retriable: bool = False  # 3.0: after a failure the master decides whether to retry the action

    @property
    def arguments(self) -> Mapping[str, Any]:
        """The parameters by key."""
        return {parameter.key: parameter.value for parameter in self.parameters}


@dataclass(frozen=True)
class Deviation:
    """An ellipse around a node: half-axes `a` and `b` (m), and the heading of `a` (rad).

    In 2.x the ellipse is a circle.
    """

    a: float
    b: float
    theta: float = 0.0

    @property
    def radius(self) -> float:
        """The radius of the largest circle inside the ellipse, in m."""
        return min(self.a, self.b)

    def contains(self, dx: float, dy: float) -> bool:
        """Returns whether the point at the offset dx, dy (m) from the node is inside."""
        along = dx * math.cos(self.theta) + dy * math.sin(self.theta)
        across = dy * math.cos(self.theta) - dx * math.sin(self.theta)
        return math.hypot(along / max(self.a, 1e-6), across / max(self.b, 1e-6)) <= 1.0


@dataclass(frozen=True)
class NodePosition:
    """The position of a node on the map `map_id`, in m and rad."""

    x: float
    y: float
    map_id: str
    theta: Optional[float] = None
    allowed_deviation_xy: Optional[Deviation] = None
    allowed_deviation_theta: Optional[float] = None
    map_description: Optional[str] = None


@dataclass(frozen=True)
class OrderNode:
    """A point that the vehicle drives over."""

    node_id: str
    sequence_id: int
    released: bool
    actions: Tuple[VdaAction, ...] = ()
    position: Optional[NodePosition] = None
    description: Optional[str] = None


@dataclass(frozen=True)
class Corridor:
    """The distances (m) by which the vehicle may leave an edge to the left and to the right.

    release_required -- 3.0: the vehicle must request a release before it leaves the edge
    """

    left_width: float
    right_width: float
    reference_point: Optional[str] = None
    release_required: bool = False


@dataclass(frozen=True)
class OrderEdge:
    """A connection from the node with `sequence_id` - 1 to the node with `sequence_id` + 1.

    start_node_id, end_node_id -- the ids of these nodes; None if the message does not have them, as
                                  in 3.0

    The attributes are the fields of the standard.
    """

    edge_id: str
    sequence_id: int
    released: bool
    start_node_id: Optional[str] = None
    end_node_id: Optional[str] = None
    actions: Tuple[VdaAction, ...] = ()
    description: Optional[str] = None
    max_speed: Optional[float] = None
    max_height: Optional[float] = None
    min_height: Optional[float] = None
    orientation: Optional[float] = None
    orientation_type: Optional[str] = None
    direction: Optional[str] = None
    rotation_allowed: Optional[bool] = None
    max_rotation_speed: Optional[float] = None
    length: Optional[float] = None
    trajectory: Optional[Mapping[str, Any]] = None
    corridor: Optional[Corridor] = None


Element = Union[OrderNode, OrderEdge]


@dataclass(frozen=True)
class OrderMessage:
    """A new order or an order update; nodes and edges alternate."""

    order_id: str
    order_update_id: int
    nodes: Tuple[OrderNode, ...]
    edges: Tuple[OrderEdge, ...] = ()
    zone_set_id: Optional[str] = None


@dataclass(frozen=True)
class InstantActions:
    """Actions to execute at once."""

    actions: Tuple[VdaAction, ...]
