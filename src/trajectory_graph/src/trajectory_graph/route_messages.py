"""Converts routes to and from messages of `itrci_nav_msgs`.

The module does not import ROS; it only uses the names of the fields. The original definitions of
INESC TEC (itrci_nav_msgs) are not public. To support other definitions, change this file, and
`trajectory_graph.messages` for the graph.
"""
from __future__ import annotations

import math
from typing import Any, Optional

from trajectory_graph.route_protocol import (
    Location,
    Reason,
    RouteOrder,
    RouteRefusal,
    RouteReport,
)

_UNKNOWN = Location(math.nan, math.nan, math.nan)


def order_of(message: Any, received: int) -> RouteOrder:
    """Returns the order in an `itrci_nav_msgs/TargetRoute` that came at `received` (ns)."""
    return RouteOrder(message.route_id, tuple(message.edges), message.header.stamp.to_nsec(),
                      received, message.known_epoch)


def fill_refusal(message: Any, refusal: RouteRefusal, now: int) -> Any:
    """Fills an empty `itrci_nav_msgs/RouteRefused`, sent at `now` (ns), and returns it."""
    _set_stamp(message, now)
    message.route_id, message.edges = refusal.route_id, list(refusal.edges)
    _set_reason(message, refusal.reason)
    return message


def fill_report(message: Any, report: RouteReport, state_type: Any) -> Any:
    """Fills an empty `itrci_nav_msgs/ExecutionRouteStates` and returns it.

    state_type -- the message type of its states
    """
    _set_stamp(message, report.stamp)
    message.header.frame_id = 'map'
    message.route_id = report.route_id
    message.edge_states = [state_type(edge, int(state))
                           for edge, state in zip(report.edges, report.states)]
    message.symbolic_pose.edge_id = report.pose.edge
    message.symbolic_pose.percentage = report.pose.percentage
    _set_reason(message, report.reason)
    location = report.location or _UNKNOWN
    message.x, message.y, message.theta = location.x, location.y, location.theta
    message.epoch = report.epoch
    return message


def location_of(message: Any) -> Optional[Location]:
    """Returns the robot's pose in an `itrci_nav_msgs/ExecutionRouteStates`; None if unknown."""
    if not (math.isfinite(message.x) and math.isfinite(message.y)):
        return None
    return Location(message.x, message.y,
                    message.theta if math.isfinite(message.theta) else math.nan)


def _set_reason(message: Any, reason: Reason) -> None:
    message.reason, message.reason_code = reason.text, int(reason.code)


def _set_stamp(message: Any, nanoseconds: int) -> None:
    message.header.stamp.secs, message.header.stamp.nsecs = divmod(nanoseconds, 1_000_000_000)
