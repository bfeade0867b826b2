"""The messages of the route protocol as values, for the route driver."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Tuple

from route_protocol.values import NO_REASON, Reason


@dataclass(frozen=True)
class RouteCommand:
    """A command to publish: drive these edges; without edges: stop.

    known_epoch -- the robot's epoch when the route was first sent; 0: unknown
    """

    route_id: int
    edges: Tuple[int, ...]
    known_epoch: int = 0


@dataclass(frozen=True)
class RouteReport:
    """A report of the robot's side on a route.

    states           -- the states of its edges: `route_protocol.values.EdgeState`
    edge, percentage -- the robot's position on the graph; edge 0: not on the graph
    epoch            -- what a route must name as known_epoch; 0: unknown
    """

    route_id: int
    states: Tuple[int, ...]
    edge: int
    percentage: float
    reason: Reason = NO_REASON
    epoch: int = 0


@dataclass(frozen=True)
class SentRoute:
    """A route that was sent.

    first    -- number of the leg that is its first edge; a first edge that approaches the order
                counts as a leg before number 0
    epoch    -- the robot's epoch when the route was first sent in this form
    taken    -- number of its edges that a report has acknowledged
    complete -- whether all edges were driven
    lost     -- whether it failed, or is not known to be driven
    unwanted -- whether it may still be driven although its extension was refused
    """

    id: int
    edges: Tuple[int, ...]
    first: int
    epoch: int = 0
    taken: int = 0
    complete: bool = False
    lost: bool = False
    unwanted: bool = False
