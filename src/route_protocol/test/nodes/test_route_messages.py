"""Messages of the fleet manager are converted to values and back without loss."""
from __future__ import annotations

import math

import genpy
import pytest

from itrci_nav_msgs.msg import EdgeState as EdgeStateMessage
from itrci_nav_msgs.msg import ExecutionRouteStates, RouteRefused, TargetRoute
from itrci_nav_msgs.msg import ReasonCode as ReasonCodeMessage
from route_protocol.messages import (
    fill_order,
    fill_refusal,
    fill_report,
    location_of,
    order_of,
    software_of,
)
from route_protocol.values import (
    EMERGENCY_STOP,
    NO_REASON,
    EdgeState,
    Reason,
    ReasonCode,
    RouteOrder,
    RouteRefusal,
    RouteReport,
    SymbolicPose,
    VehicleLocation,
    reason_of,
)

WHY = Reason(ReasonCode.NO_PROGRESS, 'why')


def test_a_target_route_is_an_order():
    message = TargetRoute(route_id=7, edges=[3, -4])
    message.header.stamp = genpy.Time(12, 5)
    order = order_of(message, 13_000_000_000)
    assert order == RouteOrder(7, (3, -4), 12_000_000_005)
    assert order.received == 13_000_000_000


@pytest.mark.parametrize('told, read', [
    (0.6, 0.6), (0.0, 0.0), (-1.0, 0.0), (float('nan'), 0.0), (float('inf'), 0.0)])
def test_a_speed_limit_is_a_number_above_0(told, read):
    order = order_of(TargetRoute(speed=told), 0)
    assert order.speed == read
    assert fill_order(TargetRoute(), order).speed == read


def test_a_refusal_names_the_order_and_the_reason():
    refusal = RouteRefusal(7, (3, -4), Reason(ReasonCode.WRONG_ROUTE, 'no edge 3'))
    message = fill_refusal(RouteRefused(), refusal, 13_000_000_000)
    assert (message.route_id, message.edges, message.reason) == (7, [3, -4], 'no edge 3')
    assert message.reason_code == ReasonCodeMessage.WRONG_ROUTE
    assert message.header.stamp == genpy.Time(13, 0)


def test_a_report_keeps_the_stamp_to_the_nanosecond():
    report = RouteReport(1_795_263_724_236_859_123, 7, (3, -4),
                         (EdgeState.COMPLETE, EdgeState.FAILED), SymbolicPose(-4, 12.5), WHY)
    message = fill_report(ExecutionRouteStates(), report, EdgeStateMessage)
    assert message.header.stamp.to_nsec() == report.stamp
    assert [(edge.edge_id, edge.state) for edge in message.edge_states] == [(3, 2), (-4, 3)]
    assert (message.route_id, message.reason, message.reason_code) == (7, 'why', 6)
    assert (message.symbolic_pose.edge_id, message.symbolic_pose.percentage) == (-4, 12.5)


def test_what_a_robot_tells_of_its_software_is_kept_short_and_printable():
    assert software_of(ExecutionRouteStates(software='own\n2.1')) == 'own?2.1'
    assert len(software_of(ExecutionRouteStates(software='x' * 1000))) == 80
    assert software_of(ExecutionRouteStates()) == ''


def test_the_message_has_every_code_of_a_reason():
    assert {name: getattr(ReasonCodeMessage, name) for name in vars(ReasonCodeMessage)
            if name.isupper()} == {code.name: int(code) for code in ReasonCode}


@pytest.mark.parametrize('code, text, reason', [
    (0, '', NO_REASON), (3, 'emergency stop', EMERGENCY_STOP),
    (0, 'emergency stop', Reason(ReasonCode.OTHER, 'emergency stop')),
    (250, 'of a later release', Reason(ReasonCode.OTHER, 'of a later release'))])
def test_a_reason_is_what_its_code_says_whatever_the_words(code, text, reason):
    assert reason_of(code, text) == reason and bool(reason) is (code > 0 or bool(text))


@pytest.mark.parametrize('location', [VehicleLocation(1.5, -2.0, 0.7), None])
def test_a_report_tells_where_the_robot_is_in_metres(location):
    report = RouteReport(0, 7, (), (), SymbolicPose(), location=location)
    message = fill_report(ExecutionRouteStates(), report, EdgeStateMessage)
    assert location_of(message) == location
    assert location is not None or all(map(math.isnan, (message.x, message.y, message.theta)))


def test_a_robot_may_tell_its_place_without_its_heading():
    found = location_of(ExecutionRouteStates(x=1.0, y=2.0, theta=math.inf))
    assert found is not None and (found.x, found.y) == (1.0, 2.0) and math.isnan(found.theta)
