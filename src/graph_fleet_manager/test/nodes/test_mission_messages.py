"""Reports of robots, and the fleet's state, keep their meaning in messages."""
from __future__ import annotations

import io
import math

import genpy
import pytest

from fleet_core.interlocking.reports import Pose
from fleet_core.interlocking.resources import Resource, ResourceKind
from fleet_core.supervision.fleet_stop import NOT_STOPPED
from fleet_core.supervision.fleet_view import RobotState, RobotView
from fleet_core.supervision.machine_view import MachineState, MachineView
from fleet_core.supervision.missions import (
    CommandCode,
    CommandKind,
    DeadlineState,
    Mission,
    MissionState,
    RequestRefused,
    Status,
)
from fleet_core.supervision.outages import Outage
from fleet_core.supervision.resource_view import ResourceView
from fleet_core.supervision.station_desk import QueuePlace
from fleet_core.work.site_work import SiteWork
from fleet_core.work.tables import LoadState
from fleet_core.work.templates import Template
from fleet_core.work.work import RobotLoad
from graph_fleet_manager.messages.missions import (
    LOAD_OF_CODE,
    moment_of,
    refusal_status,
    report_of,
    request_of,
    state_message,
    status_message,
    templates_message,
)
from graph_fleet_manager.messages.resources import machine_of
from itrci_nav_msgs import msg
from route_protocol.values import Reason, ReasonCode, VehicleLocation

NOW = genpy.Time(100)


def fleet_robot(outage):
    view = RobotView('a', 'agv', RobotState.IDLE, outage, Pose(), 0.0, 1.0, None, None)
    return state_message([view], (), (), NOT_STOPPED, genpy.Time.from_sec, NOW, {}).robots[0]


def test_a_robot_has_the_software_that_it_tells_and_none_if_it_tells_none():
    views = [RobotView(name, 'agv', RobotState.IDLE, None, Pose(), 0.0, 1.0, None, None)
             for name in ('a', 'b')]
    told = state_message(views, (), (), NOT_STOPPED, genpy.Time.from_sec, NOW, {'a': 'own 2.1'})
    assert [robot.software for robot in told.robots] == ['own 2.1', '']


def constants(kind, prefix):
    return {name[len(prefix):]: value for name, value in vars(kind).items()
            if name.startswith(prefix) and isinstance(value, int)}


@pytest.mark.parametrize('outage', Outage)
def test_every_outage_has_a_code_of_its_own(outage):
    code = fleet_robot(outage).outage_code
    assert code == constants(msg.FleetRobot, 'OUTAGE_')[outage.name] != msg.FleetRobot.OUTAGE_NONE


def test_a_robot_that_works_has_no_outage():
    assert fleet_robot(None).outage_code == msg.FleetRobot.OUTAGE_NONE


@pytest.mark.parametrize('state', LoadState)
def test_a_robots_load_is_told_with_its_mission(state):
    view = RobotView('a', 'agv', RobotState.IDLE, None, Pose(), 0.0, 1.0, None, None,
                     load=RobotLoad(state, 42))
    told = state_message([view], (), (), NOT_STOPPED, genpy.Time.from_sec, NOW, {}).robots[0]
    assert (LOAD_OF_CODE[told.load], told.load_serial) == (state, 42)


def test_a_machine_and_a_queue_can_be_read_back_from_their_messages():
    machine = MachineView('press_1', MachineState.WORKING, (18,), 2 ** 53 - 1, 'a', 42)
    press = ResourceView(Resource('press', ResourceKind.STATION, vertices=frozenset({18})), None,
                         (), True, (QueuePlace(22, 'b', True), QueuePlace(8)))
    told = state_message((), [press], [machine], NOT_STOPPED, genpy.Time.from_sec, NOW, {})
    assert machine_of(told.machines[0]) == machine
    assert told.resources[0].is_group
    assert [(one.vertex, one.robot, one.is_there) for one in told.resources[0].queue] == [
        (22, 'b', True), (8, '', False)]
    told.serialize(io.BytesIO())


def test_every_state_of_a_machine_has_the_number_of_the_message():
    assert {state.name: getattr(msg.FleetMachine, state.name) for state in MachineState} == {
        state.name: int(state) for state in MachineState}


def test_every_state_of_a_robot_has_the_number_of_the_message():
    assert {state.name: getattr(msg.FleetRobot, state.name) for state in RobotState} == {
        state.name: int(state) for state in RobotState}


@pytest.mark.parametrize('values, location', [
    ((1.5, -2.0, 0.7), VehicleLocation(1.5, -2.0, 0.7)), ((math.nan,) * 3, None),
    ((math.inf, 0.0, 0.0), None)])
def test_a_report_has_the_place_in_metres_or_none(values, location):
    x, y, theta = values
    message = msg.ExecutionRouteStates(x=x, y=y, theta=theta)
    assert report_of(message, NOW).said.location == location


def test_a_report_and_a_refusal_have_the_reason_with_its_code():
    reason = Reason(ReasonCode.LOST_LINK, 'gone?')
    report = msg.ExecutionRouteStates(reason='gone\n', reason_code=msg.ReasonCode.LOST_LINK)
    report.refusal, report.refusal_code = report.reason, report.reason_code
    said = report_of(report, NOW).said
    assert said.reason == said.refusal == reason


def test_a_request_keeps_its_template_and_its_times_and_its_status_tells_them():
    message = msg.MissionRequest(
        request_id=7, template='pallet', arguments=[msg.StepParameter('to', '39')],
        earliest=genpy.Time(1700000000, 500), deadline=genpy.Time(1700003600))
    request = request_of(message)
    assert (request.destinations, request.template, request.arguments) == (
        (), 'pallet', (('to', '39'),))
    told = status_message(Mission(1, request, deadline_state=DeadlineState.AT_RISK).status, NOW)
    assert (told.template, told.arguments, told.deadline) == (
        message.template, message.arguments, message.deadline)
    assert abs(told.earliest.to_sec() - message.earliest.to_sec()) < 1e-6
    assert told.deadline_code == msg.MissionStatus.DEADLINE_AT_RISK


@pytest.mark.parametrize('kind, prefix', [(MissionState, ''), (DeadlineState, 'DEADLINE_')])
def test_every_state_of_a_mission_has_the_number_of_the_message(kind, prefix):
    assert {one.name: getattr(msg.MissionStatus, prefix + one.name) for one in kind} == {
        one.name: int(one) for one in kind}


@pytest.mark.parametrize('fields, told', [
    ({'template': 'pallet', 'destination_vertices_id': [1]}, 'a template and also destinations'),
    ({'template': 'pallet', 'on_cancel': [msg.MissionStop(vertex=1)]}, 'a template and also'),
    ({'arguments': [msg.StepParameter('to', '39')]}, 'arguments, but no template'),
    ({'template': 'a\n'}, 'its template has characters'),
    ({'template': 'a', 'arguments': [msg.StepParameter('to', 'x' * 300)]}, 'its arguments has'),
    ({'deadline': genpy.Time(2 ** 32 - 1, 10 ** 9 - 1)}, 'its deadline is later than any time')])
def test_a_request_whose_template_or_times_make_no_sense_is_refused(fields, told):
    with pytest.raises(RequestRefused, match=told):
        request_of(msg.MissionRequest(request_id=7, **fields))


def test_the_templates_are_told_with_their_parameters():
    work = SiteWork(templates={'pallet': Template('pallet', ('from', 'to'), ())})
    one, = templates_message(work, NOW).templates
    assert (one.name, one.parameters) == ('pallet', ['from', 'to'])


def test_a_status_tells_which_command_it_answers():
    status = Status(7, MissionState.ACTIVE, command=CommandKind.PAUSE,
                    command_code=CommandCode.NOT_DONE)
    message = status_message(status, NOW)
    assert (message.command, message.command_code) == (
        msg.MissionCommand.PAUSE, msg.MissionStatus.COMMAND_NOT_DONE)
    assert status_message(Status(7, MissionState.ACTIVE), NOW).command_code == (
        msg.MissionStatus.COMMAND_NONE)
    assert constants(msg.MissionStatus, 'COMMAND_') == {
        code.name: int(code) for code in CommandCode}


def test_a_status_tells_the_priority_and_the_destinations_in_force():
    message = status_message(Status(7, MissionState.ACTIVE, priority=-4, destinations=(3, 8)), NOW)
    assert (message.priority, message.destinations) == (-4, [3, 8])


LATEST = (genpy.Time(2 ** 32 - 1, 10 ** 9 - 1), genpy.Time(2 ** 32 - 1, 2 ** 32 - 1))
"""Times that a message can have, and that the fleet manager keeps as a number of seconds."""


@pytest.mark.parametrize('stamp', LATEST)
def test_a_request_with_a_time_that_no_status_could_tell_is_refused_in_a_status(stamp):
    message = msg.MissionRequest(request_id=3, destination_vertices_id=[1])
    message.header.stamp = stamp
    with pytest.raises(RequestRefused, match='give the time at which it was sent') as refused:
        request_of(message)
    status = status_message(refusal_status(message, str(refused.value)), NOW)
    status.serialize(io.BytesIO())
    assert status.state == msg.MissionStatus.REFUSED


@pytest.mark.parametrize('stamp', [stamp.to_sec() for stamp in LATEST])
def test_a_mission_with_such_a_time_that_was_accepted_before_can_be_told(stamp):
    """Journals of earlier releases can have a time that no message can carry."""
    status_message(Status(3, MissionState.PENDING, stamp=stamp), NOW).serialize(io.BytesIO())


@pytest.mark.parametrize('seconds', [-1e12, 1e12])
def test_a_moment_that_no_message_can_carry_is_the_nearest_one_that_it_can(seconds):
    view = RobotView('a', 'agv', RobotState.IDLE, None, Pose(), seconds, 1.0, None, None)
    state_message([view], (), (), NOT_STOPPED, lambda moment: moment_of(moment, NOW),
                  NOW, {}).serialize(io.BytesIO())


def test_who_requests_a_mission_is_kept_short_and_printable():
    message = msg.MissionRequest(request_id=1, destination_vertices_id=[2],
                                 requested_by='anna\n' + 'x' * 1000)
    by = request_of(message).requested_by
    assert by.startswith('anna?x') and len(by) == 256
