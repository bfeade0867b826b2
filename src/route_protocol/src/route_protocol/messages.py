"""Converts orders, reports and refusals to and from messages of `itrci_nav_msgs`.

Only this module uses the fields of these messages. It does not import ROS. The original definitions
of INESC TEC (itrci_nav_msgs) are not public. To support other definitions, change this file, and
`trajectory_graph.messages` for the graph.
"""
from __future__ import annotations

import math
from enum import IntEnum
from typing import Any, Optional, Type, TypeVar

from route_protocol.order_rules import MAXIMUM_EDGES
from route_protocol.values import (
    EdgeState,
    EpochCause,
    Motion,
    ReasonCode,
    RouteOrder,
    RouteRefusal,
    RouteReport,
    SymbolicPose,
    VehicleLocation,
    reason_of,
)

Kind = TypeVar('Kind', bound=IntEnum)

_LONGEST_REASON = 500  # maximum number of characters kept of a robot's reason
_LONGEST_NAME = 256
_LONGEST_SOFTWARE = 80

_LAST_NUMBER = 2 ** 63  # a report with a number that is not below this is refused

_UNKNOWN = VehicleLocation(math.nan, math.nan, math.nan)


class WrongReport(ValueError):
    """A report that cannot be true. The text of the error is a clause that says why."""


def order_of(message: Any, received: int) -> RouteOrder:
    """Returns the order in an `itrci_nav_msgs/TargetRoute` that came at `received` (ns).

    A speed that is not a number above 0 sets no limit.
    """
    speed = message.speed if math.isfinite(message.speed) and message.speed > 0.0 else 0.0
    return RouteOrder(message.route_id, tuple(message.edges), message.header.stamp.to_nsec(),
                      received, message.known_epoch, order=message.order, first=message.first,
                      master=_name(message.master), speed=speed)


def fill_order(message: Any, order: RouteOrder) -> Any:
    """Fills an empty `itrci_nav_msgs/TargetRoute` and returns it."""
    _set_stamp(message, order.stamp)
    message.route_id, message.edges = order.route_id, list(order.edges)
    message.known_epoch, message.order = order.known_epoch, order.order
    message.first, message.master = order.first, order.master
    message.speed = order.speed
    return message


def fill_refusal(message: Any, refusal: RouteRefusal, now: int) -> Any:
    """Fills an empty `itrci_nav_msgs/RouteRefused`, sent at `now` (ns), and returns it."""
    _set_stamp(message, now)
    message.route_id, message.edges = refusal.route_id, list(refusal.edges)
    message.order = refusal.order
    message.reason, message.reason_code = refusal.reason.text, int(refusal.reason.code)
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
    message.reason, message.reason_code = report.reason.text, int(report.reason.code)
    location = report.location or _UNKNOWN
    message.x, message.y, message.theta = location.x, location.y, location.theta
    message.epoch, message.epoch_cause = report.epoch, int(report.cause)
    message.master, message.order, message.refused = report.master, report.order, report.refused
    message.refusal, message.refusal_code = report.refusal.text, int(report.refusal.code)
    message.first, message.motion, message.report = report.first, int(report.motion), report.number
    message.unready = int(report.unready)
    return message


def report_of(message: Any) -> RouteReport:
    """Returns the report in an `itrci_nav_msgs/ExecutionRouteStates`.

    Raises WrongReport for a state that does not exist. An unknown motion becomes UNKNOWN, and an
    unknown cause becomes NONE, so that later versions of the message can add motions and causes.
    """
    try:
        states = tuple(EdgeState(edge.state) for edge in message.edge_states)
    except ValueError:
        raise WrongReport('it has a state that does not exist') from None
    return RouteReport(
        message.header.stamp.to_nsec(), message.route_id,
        tuple(edge.edge_id for edge in message.edge_states), states,
        SymbolicPose(message.symbolic_pose.edge_id, message.symbolic_pose.percentage),
        reason_of(message.reason_code, _words(message.reason)), location_of(message),
        message.epoch, _member(EpochCause, message.epoch_cause, EpochCause.NONE),
        _name(message.master), message.order, message.refused,
        reason_of(message.refusal_code, _words(message.refusal)), message.first,
        _member(Motion, message.motion, Motion.UNKNOWN), message.report,
        _member(ReasonCode, message.unready, ReasonCode.OTHER))


def check_report(said: RouteReport) -> None:
    """Raises WrongReport for a report that no master can use."""
    if not said.number:
        raise WrongReport('it has no number (field `report`): the program of the robot is older '
                          'than the one that reads it, so update it')
    if len(said.edges) != len(said.states):
        raise WrongReport('it does not have one state for each edge')
    if len(said.edges) > MAXIMUM_EDGES:
        raise WrongReport(f'its route has more than {MAXIMUM_EDGES} edges')
    if max(said.number, said.order, said.refused) >= _LAST_NUMBER:
        raise WrongReport('it has a number at the end of 64 bits: none could follow')


def location_of(message: Any) -> Optional[VehicleLocation]:
    """Returns the robot's pose in an `itrci_nav_msgs/ExecutionRouteStates`; None if unknown."""
    if not (math.isfinite(message.x) and math.isfinite(message.y)):
        return None
    return VehicleLocation(message.x, message.y,
                           message.theta if math.isfinite(message.theta) else math.nan)


def software_of(message: Any) -> str:
    """Returns the robot's software from an `itrci_nav_msgs/ExecutionRouteStates`; empty: none.

    Only people use this text, so a `RouteReport` does not have it.
    """
    return _printable(message.software, _LONGEST_SOFTWARE)


def _words(text: str) -> str:
    return _printable(text, _LONGEST_REASON)


def _name(text: str) -> str:
    return _printable(text, _LONGEST_NAME)


def _printable(text: str, longest: int) -> str:
    """Returns a text from the network, shortened and with printable characters only."""
    return ''.join(letter if letter.isprintable() else '?' for letter in text[:longest])


def _member(kind: Type[Kind], number: int, otherwise: Kind) -> Kind:
    try:
        return kind(number)
    except ValueError:
        return otherwise


def _set_stamp(message: Any, nanoseconds: int) -> None:
    message.header.stamp.secs, message.header.stamp.nsecs = divmod(nanoseconds, 1_000_000_000)
