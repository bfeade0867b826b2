"""What robots report, and what is told of the fleet, means the same in messages."""
from __future__ import annotations

import math

import genpy
import pytest

from graph_fleet_manager.interlocking.reports import Pose
from graph_fleet_manager.messages.missions import (
    refusal_of,
    report_of,
    state_message,
    status_message,
)
from graph_fleet_manager.supervision.fleet_view import RobotState, RobotView
from graph_fleet_manager.supervision.missions import Command, CommandCode, MissionState, Status
from graph_fleet_manager.supervision.outages import Outage
from itrci_nav_msgs import msg
from trajectory_graph.route_protocol import Location, Reason, ReasonCode

NOW = genpy.Time(100)


def fleet_robot(outage):
    view = RobotView('a', 'agv', RobotState.IDLE, outage, Pose(), 0.0, 1.0, None, None, '')
    return state_message([view], genpy.Time.from_sec, NOW).robots[0]


def constants(kind, prefix):
    return {name[len(prefix):]: value for name, value in vars(kind).items()
            if name.startswith(prefix) and isinstance(value, int)}


@pytest.mark.parametrize('outage', Outage)
def test_every_outage_has_a_code_of_its_own(outage):
    code = fleet_robot(outage).outage_code
    assert code == constants(msg.FleetRobot, 'OUTAGE_')[outage.name] != msg.FleetRobot.OUTAGE_NONE


def test_a_robot_that_works_has_no_outage():
    assert fleet_robot(None).outage_code == msg.FleetRobot.OUTAGE_NONE


def test_every_state_of_a_robot_has_the_number_of_the_message():
    assert {state.name: getattr(msg.FleetRobot, state.name) for state in RobotState} == {
        state.name: int(state) for state in RobotState}


@pytest.mark.parametrize('values, location', [
    ((1.5, -2.0, 0.7), Location(1.5, -2.0, 0.7)), ((math.nan,) * 3, None),
    ((math.inf, 0.0, 0.0), None)])
def test_a_report_has_the_place_in_metres_or_none(values, location):
    x, y, theta = values
    message = msg.ExecutionRouteStates(x=x, y=y, theta=theta)
    assert report_of(message, NOW).location == location


def test_a_report_and_a_refusal_have_the_reason_with_its_code():
    reason = Reason(ReasonCode.LOST_LINK, 'gone?')
    report = msg.ExecutionRouteStates(reason='gone\n', reason_code=msg.ReasonCode.LOST_LINK)
    refusal = msg.RouteRefused(reason='gone\n', reason_code=msg.ReasonCode.LOST_LINK)
    assert report_of(report, NOW).reason == refusal_of(refusal).reason == reason


def test_a_status_tells_which_command_it_answers():
    status = Status(7, MissionState.ACTIVE, command=Command.PAUSE,
                    command_code=CommandCode.NOT_DONE)
    message = status_message(status, NOW)
    assert (message.command, message.command_code) == (
        msg.MissionCommand.PAUSE, msg.MissionStatus.COMMAND_NOT_DONE)
    assert status_message(Status(7, MissionState.ACTIVE), NOW).command_code == (
        msg.MissionStatus.COMMAND_NONE)
    assert constants(msg.MissionStatus, 'COMMAND_') == {
        code.name: int(code) for code in CommandCode}
