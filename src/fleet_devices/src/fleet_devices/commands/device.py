"""The command `device`: lists devices and machines, opens devices, and gives them back.

    device list [--json]
    device open gate_north
    device release gate_north [--of REQUESTER]

A person is a requester like any other: a device that a person has opened stays open until this
person gives it back, even if robots have passed through it in the meantime.

Exit status 0: done; 1: wrong input, or fleet_devices does not run; 2: the request was not taken.
"""
from __future__ import annotations

import time
from typing import Any, Dict, List, Optional, Sequence

from fleet_devices.commands.ages import age
from fleet_devices.commands.machines import (
    listed_machines,
    machine_of_topic,
    machine_table,
    machine_topics,
    machine_values,
)
from graph_fleet_manager.commands.command_line import NOT_DONE, OK, CommandProblem, Parser
from graph_fleet_manager.commands.fleet_client import (
    PATIENCE,
    TopicListener,
    connect,
    first_answer,
    first_message,
    requested_by,
    run,
)
from graph_fleet_manager.commands.tables import as_json, offer_json, table_with_notes
from itrci_nav_msgs.msg import DeviceRequest, DeviceState, FleetState, StepStates
from route_protocol.device_messages import (
    LONGEST_NAME,
    WrongDeviceMessage,
    device_report_of,
    fill_device_request,
)
from route_protocol.devices import UNKNOWN_REQUESTER, DeviceMode, DeviceReport, DeviceUse
from route_protocol.devices import DeviceRequest as Request
from route_protocol.vehicle import milliseconds

ALL_REPORTS = 1.5  # s within which each device is reported
_MODES = {'open': DeviceMode.OPEN, 'release': DeviceMode.CLOSED}


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Runs the command; returns its exit status."""
    return run('device', _device, arguments)


def _device(arguments: List[str]) -> int:
    parser = Parser('device', description='Lists the doors, lights and other devices of a site, '
                    'and its machines; opens devices, and gives them back.')
    commands = parser.add_subparsers(dest='command', metavar='COMMAND')
    commands.required = True
    offer_json(commands.add_parser(
        'list', help='what each device shows, and its holders; what each machine does, and for '
                     'which robot'))
    asks = commands.add_parser('open', help='holds a device open until you give it back')
    gives = commands.add_parser('release', help='gives a device back; it closes when it has no '
                                                'other holder')
    for one in (asks, gives):
        one.add_argument('name', help='name of the device')
    gives.add_argument('--of', metavar='REQUESTER', help='gives it back for a requester that '
                       f'cannot; "{UNKNOWN_REQUESTER}" if the memory was lost. Look first: no '
                       'robot and no person may be in it')
    options = parser.parse_args(arguments)
    connect('device_command')
    states = TopicListener('/device_states', DeviceState)
    if options.command == 'list':
        return _list(states, options.json)
    requester = getattr(options, 'of', None) or requested_by('device')[:LONGEST_NAME]
    return _ask(states, options.name, requester, _MODES[options.command])


# -- asking ---------------------------------------------------------------------------------------


def _ask(states: TopicListener, name: str, requester: str, mode: DeviceMode) -> int:
    known = first_message(states, lambda message: message.device_name == name, PATIENCE)
    if known is None:
        raise CommandProblem(f'No device {name} is reported: see device list. Is fleet_devices '
                             'running?')
    report = _report(known)
    use = report.use_of(requester)
    if mode is DeviceMode.CLOSED and (use is None or not use.holds):
        raise CommandProblem(not_held(report, requester), NOT_DONE)
    request = Request(requester, name, mode, number_after(use))
    shown: List[DeviceReport] = []

    def is_answer(message: DeviceState) -> bool:
        if message.device_name == name:
            shown.append(_report(message))
        return bool(shown) and is_taken(shown[-1], request)
    if first_answer(fill_device_request(DeviceRequest(), request), states, is_answer) is None:
        raise CommandProblem(f'fleet_devices did not take the request; its log says why. Device '
                             f'{name} is {known_mode(shown, known)}.', NOT_DONE)
    print(answer(shown[-1], request))
    return OK


def not_held(report: DeviceReport, requester: str) -> str:
    """Returns sentences that say that the requester does not hold the device, and list its holders.
    """
    holders = [use.requester for use in report.obeyed if use.holds]
    return (f'{requester} does not hold device {report.device}, so nothing is given back. '
            + (f'It is held for {", ".join(holders)}: name one with --of.' if holders
               else 'It has no holder.'))


def number_after(use: Optional[DeviceUse]) -> int:
    """Returns the number of the next request of a requester. It is larger than the number of its
    last request, even if another computer's clock gave that number.
    """
    return max(milliseconds(), use.number + 1 if use is not None else 0)


def is_taken(report: DeviceReport, request: Request) -> bool:
    """Returns whether a report shows that a request was taken.

    A request of `unknown` was taken if the report does not have the requester `unknown` any more.
    """
    if request.requester == UNKNOWN_REQUESTER:
        return report.use_of(UNKNOWN_REQUESTER) is None
    return report.shows(request)


def answer(report: DeviceReport, request: Request) -> str:
    """Returns the result of a request, as a sentence."""
    holders = [use.requester for use in report.obeyed if use.holds]
    if request.mode is DeviceMode.OPEN:
        return (f'Device {report.device} is held open for {request.requester}; it is '
                f'{report.mode.name}.')
    if holders:
        return (f'Device {report.device} is given back. It stays open for {", ".join(holders)}.')
    return f'Device {report.device} is given back, and closes. It is {report.mode.name}.'


def known_mode(shown: List[DeviceReport], known: DeviceState) -> str:
    """Returns the last mode that was reported."""
    return (shown[-1] if shown else _report(known)).mode.name


def _report(message: DeviceState) -> DeviceReport:
    try:
        return device_report_of(message)
    except WrongDeviceMessage as wrong:
        raise CommandProblem(f'fleet_devices reports what this version does not know: {wrong}.'
                             ) from None


# -- listing --------------------------------------------------------------------------------------


def _list(states: TopicListener, is_json: bool) -> int:
    fleet = TopicListener('/fleet_state', FleetState)
    steps = {topic: TopicListener(topic, StepStates) for topic in machine_topics()}
    latest = _newest_reports(states, ALL_REPORTS if steps else PATIENCE)
    machines = listed_machines(
        {machine_of_topic(topic): heard.messages[-1] for topic, heard in steps.items()
         if heard.messages}, fleet.messages[-1] if fleet.messages else None)
    if not latest and not machines:
        raise CommandProblem('No device is reported: is fleet_devices running, and does its work '
                             'file have devices?')
    reports, now = [latest[name] for name in sorted(latest)], time.time()
    if is_json:
        print(as_json({'devices': [values(report) for report in reports],
                       'machines': [machine_values(one, now) for one in machines]}))
    else:
        tables = [listed(reports, now)] if reports else []
        print('\n\n'.join([*tables, machine_table(machines, now)] if machines else tables))
    return OK


def _newest_reports(states: TopicListener, patience: float) -> Dict[str, DeviceReport]:
    """Returns the newest report of each device, by its name.

    patience -- s to wait for the first report; the others follow within ALL_REPORTS
    """
    until = time.monotonic() + patience
    latest: Dict[str, DeviceReport] = {}
    while time.monotonic() < until:
        states.wait(until - time.monotonic())
        for message in states.unread():
            if not latest:
                until = min(until, time.monotonic() + ALL_REPORTS)
            report = _report(message)
            if report.is_newer_than(latest.get(report.device)):
                latest[report.device] = report
    return latest


def listed(reports: Sequence[DeviceReport], now: float) -> str:
    """Returns the devices as a table, with the fault of each device below it."""
    rows = [(report.device, report.mode.name, age(report.since, now),
             'never' if report.read_at is None else age(report.read_at, now),
             ', '.join(f'{use.requester} ({age(use.since, now)})' if use.since
                       else use.requester for use in report.obeyed if use.holds) or '-')
            for report in reports]
    return table_with_notes(('device', 'shows', 'for', 'read', 'held by (for)'), rows,
                            [report.reason for report in reports])


def values(report: DeviceReport) -> Dict[str, Any]:
    """Returns a report as values for JSON."""
    return {'device': report.device, 'shows': report.mode.name, 'since': report.since,
            'read': report.read_at, 'fault': report.fault.name, 'reason': report.reason or None,
            'obeyed': [{'requester': use.requester, 'mode': use.mode.name, 'number': use.number,
                      'since': use.since or None} for use in report.obeyed]}
