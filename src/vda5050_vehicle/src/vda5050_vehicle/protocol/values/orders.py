"""What comes from the master: orders and actions."""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Mapping, Optional, Tuple, Union

from vda5050_vehicle.protocol.values.enums import BlockingType


@dataclass(frozen=True)
class ActionParameter:
    """A parameter of an action; `value` is any JSON value."""

    key: str
    value: Any


@dataclass(frozen=True)
class Action:
    """Something to do, on a node, on an edge or at once."""

    action_type: str
    action_id: str
    blocking_type: BlockingType
    parameters: Tuple[ActionParameter, ...] = ()
    description: Optional[str] = None
    retriable: bool = False  # once it fails, the master is asked; 3.0

    @property
    def arguments(self) -> Mapping[str, Any]:
        """The parameters by key."""
        return {parameter.key: parameter.value for parameter in self.parameters}


@dataclass(frozen=True)
class Deviation:
    """An ellipse about a node: half-axes `a` and `b` (m), and the heading of `a` (rad).

    In 2.x it is a circle.
    """

    a: float
    b: float
    theta: float = 0.0

    @property
    def radius(self) -> float:
        """Of the largest circle within."""
        return min(self.a, self.b)

    def contains(self, dx: float, dy: float) -> bool:
        """Whether a point so far from the node lies within."""
        along = dx * math.cos(self.theta) + dy * math.sin(self.theta)
        across = dy * math.cos(self.theta) - dx * math.sin(self.theta)
        return math.hypot(along / max(self.a, 1e-6), across / max(self.b, 1e-6)) <= 1.0


@dataclass(frozen=True)
class NodePosition:
    """Where a node is: m and rad on the map `map_id`."""

    x: float
    y: float
    map_id: str
    theta: Optional[float] = None
    allowed_deviation_xy: Optional[Deviation] = None
    allowed_deviation_theta: Optional[float] = None
    map_description: Optional[str] = None


@dataclass(frozen=True)
class Node:
    """A place to drive over."""

    node_id: str
    sequence_id: int
    released: bool
    actions: Tuple[Action, ...] = ()
    position: Optional[NodePosition] = None
    description: Optional[str] = None


@dataclass(frozen=True)
class Corridor:
    """How far (m) the vehicle may leave an edge to either side; 3.0 may want to be asked first."""

    left_width: float
    right_width: float
    reference_point: Optional[str] = None
    release_required: bool = False


@dataclass(frozen=True)
class Edge:
    """A connection from one node to the next."""

    edge_id: str
    sequence_id: int
    released: bool
    start_node_id: str
    end_node_id: str
    actions: Tuple[Action, ...] = ()
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


Element = Union[Node, Edge]


@dataclass(frozen=True)
class Order:
    """A new order, or an update of one: nodes and edges by turns."""

    order_id: str
    order_update_id: int
    nodes: Tuple[Node, ...]
    edges: Tuple[Edge, ...] = ()
    zone_set_id: Optional[str] = None


@dataclass(frozen=True)
class InstantActions:
    """Actions to do at once."""

    actions: Tuple[Action, ...]
