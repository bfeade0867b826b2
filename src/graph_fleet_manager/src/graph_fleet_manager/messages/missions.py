"""Messages about missions, routes and the state of the fleet."""
from __future__ import annotations

import math
from typing import Any, Callable, Dict, Iterable, List, Mapping, Optional, Tuple

import genpy

from fleet_core.interlocking.reports import Report
from fleet_core.interlocking.route_master import ME
from fleet_core.supervision.fleet_stop import FleetStop, StopCause
from fleet_core.supervision.fleet_view import DriveView, RobotView
from fleet_core.supervision.machine_view import MachineView
from fleet_core.supervision.missions import (
    MissionState,
    Request,
    RequestRefused,
    Status,
)
from fleet_core.supervision.outages import Outage
from fleet_core.supervision.resource_view import ResourceView
from fleet_core.supervision.timetable_runs import TimetableView
from fleet_core.supervision.why import MissionReason
from fleet_core.work.site_work import SiteWork
from fleet_core.work.stops import dwells_of
from fleet_core.work.tables import LoadState
from graph_fleet_manager.messages.resources import machine_messages, resource_messages
from graph_fleet_manager.messages.stops import WrongStopMessage, dependencies_of, stops_of
from itrci_nav_msgs import msg, srv
from route_protocol import messages as route_messages
from route_protocol.master import Order

Moment = Callable[[float], genpy.Time]
"""Converts a time of the supervisor's clock (s) into ROS time."""

_OUTAGES: Dict[Optional[Outage], int] = {
    None: msg.FleetRobot.OUTAGE_NONE,
    **{outage: getattr(msg.FleetRobot, f'OUTAGE_{outage.name}') for outage in Outage}}
OUTAGE_OF_CODE: Dict[int, Optional[Outage]] = {code: outage for outage, code in _OUTAGES.items()}
"""The outage of each `FleetRobot.outage_code`; None: the robot works."""
_LOADS: Dict[LoadState, int] = {
    state: getattr(msg.FleetRobot, f'LOAD_{state.name}') for state in LoadState}
LOAD_OF_CODE: Dict[int, LoadState] = {code: state for state, code in _LOADS.items()}
"""The state of a load for each `FleetRobot.load`."""
_SAME = 1e-6           # s by which stamps of one request may differ, because floats round them
_END_OF_TIME = genpy.Time(2 ** 32 - 1, 10 ** 9 - 1)  # the latest time that a message can carry
_LONGEST_NAME = 256
_LONGEST_REASON = 500  # characters of a robot's reason that are kept


def request_of(message: msg.MissionRequest) -> Request:
    """Returns the request in a message.

    Raises RequestRefused for values that a status could not repeat.
    """
    _check_times(message)
    _check_texts(message)
    try:
        stops, on_cancel = stops_of(message.stops), stops_of(message.on_cancel)
        after = dependencies_of(message.after)
    except WrongStopMessage as wrong:
        raise RequestRefused(str(wrong)) from None
    destinations, dwells = tuple(message.destination_vertices_id), tuple(message.dwell)
    if stops:
        if destinations or dwells:
            raise RequestRefused('it has stops and also destinations or dwells: give one of them')
        destinations, dwells = tuple(stop.place for stop in stops), dwells_of(stops)
    if message.template and (destinations or dwells or stops or on_cancel):
        raise RequestRefused('it has a template and also destinations or stops: give one of them')
    if message.arguments and not message.template:
        raise RequestRefused('it has arguments, but no template')
    return Request(message.request_id, destinations, message.robot_type, message.robot,
                   message.priority, dwells, message.header.stamp.to_sec(),
                   person_of(message.requested_by), stops, on_cancel, after, message.template,
                   tuple((one.name, one.value) for one in message.arguments),
                   message.earliest.to_sec(), message.deadline.to_sec())


def _check_times(message: msg.MissionRequest) -> None:
    """Raises RequestRefused for a time that a status cannot carry."""
    for name, time, what in (
            ('header.stamp', message.header.stamp, 'the time at which it was sent'),
            ('earliest', message.earliest, 'a time'), ('deadline', message.deadline, 'a time')):
        if time.to_sec() >= _END_OF_TIME.to_sec():
            raise RequestRefused(f'its {name} is later than any time that a message can carry: '
                                 f'give {what}, or 0')


def _check_texts(message: msg.MissionRequest) -> None:
    """Raises RequestRefused for a text that a status could not show to people."""
    for name, value in (
            ('robot_type', message.robot_type), ('robot', message.robot),
            ('template', message.template),
            *(('arguments', text) for one in message.arguments for text in (one.name, one.value))):
        if value and not value.isprintable():
            raise RequestRefused(f'its {name} has characters that cannot be printed')
        if len(value) > _LONGEST_NAME:
            raise RequestRefused(f'its {name} has more than {_LONGEST_NAME} letters')


def person_of(text: str) -> str:
    """Returns a person's name from a request, shortened, with printable characters only."""
    return _words(text[:_LONGEST_NAME])


def caller_of(request: Any) -> str:
    """Returns the caller of a service whose request has no field for the caller.

    The connection's header has the person (`requested_by`), or at least the name of the node.
    """
    header: Dict[str, str] = getattr(request, '_connection_header', None) or {}
    return person_of(header.get('requested_by') or header.get('callerid', ''))


def refusal_status(message: msg.MissionRequest, reason: str) -> Status:
    """Returns the status REFUSED for a message that is no valid request."""
    return Status(message.request_id, MissionState.REFUSED, reason=reason,
                  stamp=message.header.stamp.to_sec())


def is_about(status: msg.MissionStatus, request: msg.MissionRequest) -> bool:
    """Returns whether a status is about this request; another request may have had the same id."""
    apart = status.request_stamp.to_sec() - request.header.stamp.to_sec()
    return bool(status.request_id == request.request_id and abs(apart) < _SAME)


def status_message(status: Status, now: genpy.Time) -> msg.MissionStatus:
    """Returns a status as a message; `now` is its stamp."""
    message = msg.MissionStatus(
        request_id=status.request_id, state=int(status.state), robot=status.robot,
        destinations_reached=status.reached, reason=status.reason,
        command=int(status.command or 0), command_code=int(status.command_code),
        asks=status.asks, template=status.template,
        arguments=[msg.StepParameter(*one) for one in status.arguments],
        earliest=genpy.Time.from_sec(status.earliest),
        deadline=genpy.Time.from_sec(status.deadline),
        deadline_code=int(status.deadline_state), serial=status.serial,
        priority=status.priority, destinations=list(status.destinations),
        request_stamp=min(genpy.Time.from_sec(status.stamp), _END_OF_TIME))
    message.header.stamp = now
    return message


def templates_message(work: SiteWork, now: genpy.Time) -> msg.MissionTemplates:
    """Returns the templates of a work file; `now` is the stamp."""
    message = msg.MissionTemplates(templates=[
        msg.MissionTemplate(one.name, list(one.parameters)) for one in work.templates.values()])
    message.header.stamp = now
    return message


def timetables_message(views: Iterable[TimetableView], now: genpy.Time) -> msg.Timetables:
    """Returns the timetables of a work file, with their next runs; `now` is the stamp."""
    message = msg.Timetables(timetables=[msg.Timetable(
        one.name, one.template, [msg.StepParameter(*pair) for pair in one.arguments],
        one.priority, one.every, one.begin, one.end, sorted(one.days), view.next is None,
        genpy.Time.from_sec(view.next or 0.0)) for view in views for one in (view.timetable,)])
    message.header.stamp = now
    return message


def explanation_message(status: Status, reason: MissionReason) -> srv.ExplainMissionResponse:
    """Returns what an open mission waits for, as a message."""
    return srv.ExplainMissionResponse(
        found=True, state=int(status.state), robot=status.robot,
        waits_for_code=int(reason.wait.code), waits_for=reason.wait.text, until=reason.wait.until,
        robots=[msg.RobotHindrance(
            robot=one.robot, hindrance=int(one.hindrance), has_mission=one.mission is not None,
            request_id=one.mission or 0, until=one.until, reason=one.text)
            for one in reason.robots])


def report_of(message: msg.ExecutionRouteStates, now: genpy.Time) -> Report:
    """Returns the report in a message of a robot.

    Raises WrongReport for a state that does not exist.
    """
    stamp = message.header.stamp
    return Report(route_messages.report_of(message), (now - stamp).to_sec() if stamp else 0.0)


def moment_of(seconds: float, now: genpy.Time) -> genpy.Time:
    """Returns the ROS time that is `seconds` after `now` (negative: before it), limited to times
    that a message can carry.
    """
    last = int(_END_OF_TIME.to_nsec())
    nanoseconds = min(max(int(now.to_nsec()) + round(1e9 * seconds), 0), last)
    time = genpy.Time.__new__(genpy.Time)  # skips its checks, which take ten times as long
    time.secs, time.nsecs = divmod(nanoseconds, 10 ** 9)
    return time


def _words(text: str) -> str:
    return ''.join(letter if letter.isprintable() else '?' for letter in text[:_LONGEST_REASON])


def route_message(order: Order, stamp: genpy.Time, speed: float = 0.0) -> msg.TargetRoute:
    """Returns an order to a robot.

    speed -- m/s that the robot must not exceed because of its load; 0: no such limit
    """
    return route_messages.fill_order(
        msg.TargetRoute(), order.sent_by(ME if order.number else '', stamp.to_nsec(), speed))


def stop_message(stop: FleetStop) -> msg.FleetStop:
    """Returns whether the fleet is stopped, as a message."""
    return msg.FleetStop(int(stop.cause), stop.by, genpy.Time.from_sec(stop.since), stop.why)


def stop_of(message: msg.FleetStop) -> FleetStop:
    """Returns whether the fleet is stopped. A cause that this version does not know is UNKNOWN."""
    cause = next((cause for cause in StopCause if cause == message.cause), StopCause.UNKNOWN)
    return FleetStop(cause, message.by, message.since.to_sec(), message.why)


def state_message(robots: Iterable[RobotView], resources: Iterable[ResourceView],
                  machines: Iterable[MachineView], stop: FleetStop, moment: Moment,
                  now: genpy.Time, software: Mapping[str, str],
                  rate: float = 1.0) -> msg.FleetState:
    """Returns the state of the fleet, its robots, resources and machines as a message; `now`: its
    stamp.

    software -- name and version of each robot's software, by robot, if the robot reports them
    rate     -- factor by which simulated robots are faster than the clock
    """
    message = msg.FleetState(stop=stop_message(stop), resources=resource_messages(resources),
                             machines=machine_messages(machines), robots=[
        msg.FleetRobot(
            name=robot.name, type=robot.type, state=int(robot.state),
            outage_code=_OUTAGES[robot.outage],
            pose=msg.SymbolicPose(robot.pose.edge, 100.0 * robot.pose.fraction),
            seen=moment(robot.seen) if math.isfinite(robot.seen) else genpy.Time(0),
            battery=robot.battery, has_mission=robot.mission is not None,
            request_id=robot.mission or 0, destination=robot.destination or 0,
            to_destination=robot.to_go.destination / rate, to_end=robot.to_go.end / rate,
            waits_for_code=int(robot.waits_for.code), waits_for=robot.waits_for.text,
            until=robot.waits_for.until, load=_LOADS[robot.load.state],
            load_serial=robot.load.serial, load_types=sorted(robot.load.may_be),
            software=software.get(robot.name, ''))
        for robot in robots])
    message.header.stamp = now
    return message


def plan_message(plans: Iterable[Tuple[str, List[DriveView]]], behind: Callable[[float], float],
                 now: genpy.Time) -> msg.FleetPlan:
    """Returns the plans of all robots as a message; `now` is its stamp.

    behind -- converts a time in the plans to seconds of ROS time after the stamp
    """
    message = msg.FleetPlan(plans=[
        msg.RobotPlan(name, msg.PlannedDrives(
            [drive.edge for drive in drives], [behind(drive.start) for drive in drives],
            [behind(drive.end) for drive in drives]), sum(drive.released for drive in drives))
        for name, drives in plans])
    message.header.stamp = now
    return message
