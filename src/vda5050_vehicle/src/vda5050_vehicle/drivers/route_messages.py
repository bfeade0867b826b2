"""What the route driver says and hears: the route protocol's messages as values."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Tuple

from trajectory_graph.route_protocol import NO_REASON, Reason


@dataclass(frozen=True)
class RouteCommand:
    """To be published: drive these edges, or stop where there are none.

    known_epoch -- the robot's, when the route was first sent; 0: not known
    """

    route_id: int
    edges: Tuple[int, ...]
    known_epoch: int = 0


@dataclass(frozen=True)
class RouteReport:
    """What the robot's side tells of a route.

    states           -- of its edges: `trajectory_graph.route_protocol.EdgeState`
    edge, percentage -- where on the graph the robot is; edge 0: nowhere
    """

    route_id: int
    states: Tuple[int, ...]
    edge: int
    percentage: float
    reason: Reason = NO_REASON


@dataclass(frozen=True)
class SentRoute:
    """A route that was sent; its first edge is leg number `first`, or leads to the next leg.

    epoch    -- the robot's, when it was first sent as it is
    taken    -- how many of its edges a report has acknowledged
    complete -- all were driven
    lost     -- it failed, or is not known to be driven
    unwanted -- it may be driven though its extension was refused
    """

    id: int
    edges: Tuple[int, ...]
    first: int
    epoch: int = 0
    taken: int = 0
    complete: bool = False
    lost: bool = False
    unwanted: bool = False
