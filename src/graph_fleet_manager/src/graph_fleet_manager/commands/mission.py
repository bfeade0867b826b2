"""The command `mission`: sends a mission and shows its progress; lists and changes missions; shows
the history.

    mission 18 39 52 6 16 --type omron_ld90 --wait
    mission press shelves
    mission why MISSION
    mission list | cancel MISSION | pause MISSION | resume MISSION | release MISSION
    mission history [--csv]
    mission modify MISSION --priority 3 [VERTEX ... | --stops FILE]
    mission --stops pallet.yaml --wait
    mission run pallet from:=press to:=shelves --before 14:30 --wait
    mission templates
    mission timetables [pause|resume NAME]
    mission answer MISSION retry|skip|fail|done

MISSION is the id of a request, or the short name of a mission, such as M42.

Exit status 0: done; with --wait: the mission succeeded. 1: wrong input, or no fleet manager. 2: the
mission was refused or did not succeed.
"""
from __future__ import annotations

import argparse
import csv
import math
import os
import sys
import textwrap
import time
from datetime import datetime
from typing import Any, Dict, List, Optional, Sequence

import rosgraph
import rospkg
import rospy

from fleet_core.files.errors import FileError
from fleet_core.files.stops_file import StopsFile, load_stops
from fleet_core.supervision.hindrances import Hindrance
from fleet_core.supervision.history import HISTORY_COLUMNS, history, row_of
from fleet_core.supervision.journal_database import JournalError
from fleet_core.supervision.missions import (
    CommandKind,
    DeadlineState,
    MissionState,
    short_name,
)
from fleet_core.supervision.waits import WaitCode
from fleet_core.work.rules import StepDecision
from fleet_core.work.stations import Destination
from fleet_core.work.timetables import minute_of_day, next_time
from fleet_requests import ImpossibleRequest, mission_request, visits
from graph_fleet_manager.commands.command_line import NOT_DONE, OK, CommandProblem, Parser, whole
from graph_fleet_manager.commands.fleet_client import (
    PATIENCE,
    TopicListener,
    ask,
    connect,
    connected_sender,
    first_answer,
    first_message,
    requested_by,
    run,
)
from graph_fleet_manager.commands.mission_names import mission_name, open_mission, request_id
from graph_fleet_manager.commands.mission_watch import MissionWatch, ask_for
from graph_fleet_manager.commands.place_names import PlaceNames
from graph_fleet_manager.commands.progress import ProgressLine, line_of
from graph_fleet_manager.commands.tables import (
    WIDTH,
    as_json,
    for_about,
    offer_json,
    stop_values,
    table,
    table_with_notes,
)
from graph_fleet_manager.commands.timetables import timetables
from graph_fleet_manager.messages.missions import is_about, stop_of
from graph_fleet_manager.messages.stops import stop_messages
from itrci_nav_msgs.msg import (
    FleetState,
    MissionCommand,
    MissionDependency,
    MissionRequest,
    MissionStatus,
    MissionTemplates,
    StepParameter,
)
from itrci_nav_msgs.srv import ExplainMission, ExplainMissionResponse
from node_program.inert_text import cell
from trajectory_graph import Graph

_CHANGES = {command.name.lower(): command for command in CommandKind}
_ANSWERS = {answer.name.lower(): answer for answer in StepDecision if answer}


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Runs the command; returns its exit status."""
    if arguments is None and sys.argv[1:2] == ['run']:  # ROS would remove NAME:=VALUE
        arguments = [word for word in sys.argv[1:] if not is_for_ros(word)]
    return run('mission', _mission, arguments)


def is_for_ros(word: str) -> bool:
    """Returns whether a word of `mission run` is a remapping for ROS.

    Such a word begins with `_`. The name of a template's parameter never begins with `_`.
    """
    return word.startswith('_') and ':=' in word


def _mission(arguments: List[str]) -> int:
    word = arguments[0] if arguments else ''
    if word == 'list':
        options = _options('list', 'lists all open missions', arguments)
        connect('mission_command')
        return _list(options.json)
    if word == 'history':
        return _history(arguments)
    if word == 'why':
        return _why(arguments)
    if word in _CHANGES:
        return _change(word, arguments)
    if word == 'run':
        return _run_template(arguments[1:])
    if word == 'templates':
        return _templates(arguments)
    if word == 'timetables':
        return timetables(arguments[1:])
    return _send(arguments)


def _options(name: str, what: str, arguments: List[str]) -> argparse.Namespace:
    parser = Parser(f'mission {name}', description=what)
    if name in _CHANGES or name == 'why':
        parser.add_argument('id', type=mission_name, metavar='MISSION',
                            help='id of the mission, or its short name, such as M42')
    if name in ('list', 'why'):
        offer_json(parser)
    if name == 'answer':
        parser.add_argument('answer', choices=list(_ANSWERS),
                            help='retry: the step is carried out again; skip: the mission goes on, '
                                 'the step was not done; fail: the mission fails; done: the '
                                 'mission goes on, the step was done')
    if name == 'modify':
        parser.add_argument('destinations', nargs='*', metavar='VERTEX',
                            help='the new destinations, in order, without dwells, named as those '
                                 'of a new mission; none: as before')
        parser.add_argument('--stops', metavar='FILE',
                            help='of a mission with stops: YAML file of the stops after those that '
                                 'have begun')
        parser.add_argument('--priority', type=whole, required=True,
                            help='a mission with a higher priority is served first; give the '
                                 'present priority to keep it')
    return parser.parse_args(arguments[1:])


# -- sending --------------------------------------------------------------------------------------


def _send(arguments: List[str]) -> int:
    parser = Parser('mission', description='Sends a robot to places, in order. Other uses: '
                    'mission run TEMPLATE, mission templates, mission timetables, mission list, '
                    'mission why ID, mission cancel|pause|resume|release|modify|answer ID, '
                    'mission history.')
    parser.add_argument('destinations', nargs='*', metavar='PLACE',
                        help='id of a vertex; name of a station with one place; name of a group, '
                             'of which the fleet manager chooses a place; or a label that only one '
                             'vertex has')
    _offer_conditions(parser)
    parser.add_argument('--dwell', type=float, nargs='+', default=[], metavar='S',
                        help='s to stay at each destination: one for all, or one for each; '
                             'negative: until mission release')
    parser.add_argument('--stops', metavar='FILE',
                        help='YAML file of stops with steps, in place of PLACE and --dwell')
    options = parser.parse_args(arguments)
    if bool(options.destinations) is bool(options.stops) or options.stops and options.dwell:
        parser.error('give places, with or without --dwell, or give --stops')
    connect('mission_command')
    names = PlaceNames()
    work = _stops(options.stops, names) if options.stops else StopsFile(())
    destinations = [names.destination(word) for word in options.destinations]
    dwells = options.dwell * len(destinations) if len(options.dwell) == 1 else options.dwell
    try:
        request = mission_request(
            destinations, dwell=dwells, **({} if options.destinations else {
                'stops': stop_messages(work.stops), 'on_cancel': stop_messages(work.on_cancel)}),
            **_conditions(options))
    except ImpossibleRequest as wrong:
        raise CommandProblem(str(wrong)) from None
    return _send_request(request, options.wait, names.graph if options.wait else None)


def _offer_conditions(parser: Parser) -> None:
    """Adds the options that all missions have, with or without a template."""
    parser.add_argument('--type', default='', help='robot type that must do it')
    parser.add_argument('--robot', default='', help='the robot that must do it')
    parser.add_argument('--priority', type=whole, default=0,
                        help='a mission with a higher priority is served first (0)')
    parser.add_argument('--after', type=mission_name, nargs='+', default=[], metavar='MISSION',
                        help='missions that must succeed first: id of the request, or the '
                             'short name of an open mission (M42)')
    parser.add_argument('--after-end', type=mission_name, nargs='+', default=[], metavar='MISSION',
                        help='missions that must end first, in any way')
    parser.add_argument('--not-before', type=_time_of_day, metavar='HH:MM',
                        help='it does not begin before the next time at which clocks show this')
    parser.add_argument('--before', type=_time_of_day, metavar='HH:MM',
                        help='it is to be done by the next time at which clocks show this')
    parser.add_argument('--id', type=whole, help='request id; random if not given')
    parser.add_argument('--wait', action='store_true', help='show the progress until the end')


def _time_of_day(text: str) -> rospy.Time:
    try:
        minute = minute_of_day(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
    return rospy.Time.from_sec(next_time(minute, datetime.now()).timestamp())


def _conditions(options: argparse.Namespace) -> Dict[str, Any]:
    """Returns the fields of a request that are set by the options of all missions."""
    return {'robot_type': options.type, 'robot': options.robot, 'priority': options.priority,
            'after': [MissionDependency(request_id(name), until) for names, until in (
                (options.after, MissionDependency.DONE),
                (options.after_end, MissionDependency.ENDED)) for name in names],
            'requested_by': requested_by('mission'),
            **({} if options.id is None else {'request_id': options.id}),
            **({} if options.not_before is None else {'earliest': options.not_before}),
            **({} if options.before is None else {'deadline': options.before})}


def _run_template(arguments: List[str]) -> int:
    parser = Parser('mission run', description='Sends the mission that a template of the work '
                    'file describes; see mission templates.')
    parser.add_argument('template', help='name of the template')
    parser.add_argument('arguments', nargs='*', type=_argument, metavar='NAME:=VALUE',
                        help='one for each parameter of the template')
    _offer_conditions(parser)
    options = parser.parse_args(arguments)
    connect('mission_command', [sys.argv[0], *filter(is_for_ros, sys.argv[1:])])
    return _send_request(mission_request(
        (), template=options.template, arguments=options.arguments, **_conditions(options)),
        options.wait, PlaceNames().graph if options.wait else None)


def _argument(text: str) -> StepParameter:
    name, assigned, value = text.partition(':=')
    if not assigned or not name:
        raise argparse.ArgumentTypeError(f'{text!r} is not of the form NAME:=VALUE')
    return StepParameter(name, value)


def _templates(arguments: List[str]) -> int:
    parser = Parser('mission templates', description='Lists the templates of the work file.')
    offer_json(parser)
    options = parser.parse_args(arguments[1:])
    connect('mission_command')
    known = TopicListener('/mission_templates', MissionTemplates).last().templates
    if options.json:
        print(as_json({'templates': [{'template': one.name, 'parameters': list(one.parameters)}
                                     for one in known]}))
    elif known:
        print(table([('template', 'parameters'),
                     *((one.name, ' '.join(one.parameters) or '-') for one in known)]))
    else:
        print('There are no templates: the work file of the fleet manager has none, or it has no '
              'work file.')
    return OK


def _send_request(request: MissionRequest, waits: bool, graph: Optional[Graph]) -> int:
    """Sends a request. If `waits` and a graph is given, follows the mission to its end."""
    listener = TopicListener('/mission_status', MissionStatus)
    status = _acknowledged(request, listener)
    if status.state == MissionStatus.REFUSED:
        raise CommandProblem(f'The mission was refused: {status.reason}.', NOT_DONE)
    print(f'Mission {request.request_id} is accepted.', flush=True)
    return _follow(request, status, listener, graph) if waits and graph is not None else OK


def _stops(path: str, names: PlaceNames) -> StopsFile:
    try:
        return load_stops(path, names.place)
    except FileError as error:
        raise CommandProblem(str(error)) from None


def _acknowledged(request: MissionRequest, listener: TopicListener) -> MissionStatus:
    """Sends the request until the fleet manager acknowledges or refuses it. Returns the status."""
    status = first_answer(request, listener, lambda told: is_about(told, request))
    if status is None:
        raise CommandProblem('The fleet manager does not answer; it may have no graph, or hang.')
    return status


def _follow(request: MissionRequest, status: MissionStatus, listener: TopicListener,
            graph: Graph) -> int:
    """Shows the progress of a mission until it ends. Returns the exit status."""
    states = TopicListener('/fleet_state', FleetState)
    state: Optional[FleetState] = None
    line = ProgressLine()
    id = status.request_id
    watch = MissionWatch(request, status, listener, ask_for(request))
    try:
        while MissionState(status.state).is_open:
            state = (states.unread() or [state])[-1]
            about = (status.state, status.robot, status.destinations_reached, status.reason)
            line.show(line_of(status, _destinations(request, status), state, graph), about)
            status = watch.wait(0.5)
    except KeyboardInterrupt:
        line.end()
        print(f'The mission goes on. To end it: mission cancel {id}', file=sys.stderr)
        return 130
    line.end()
    if status.state != MissionStatus.SUCCEEDED:
        raise CommandProblem(f'Mission {id}: {MissionState(status.state).name}: {status.reason}.',
                             NOT_DONE)
    places = ', '.join(map(str, _destinations(request, status))) or (
        f'all {status.destinations_reached} stops')
    print(f'Mission {id} has succeeded: {status.robot} was at {places}.')
    return OK


def _destinations(request: MissionRequest, status: MissionStatus) -> List[int]:
    """Returns the destinations in the request or, if it names no vertices, those in the status.

    The fleet manager chooses the vertex of a group.
    """
    return list(request.destination_vertices_id) or list(status.destinations)


# -- listing and changing -------------------------------------------------------------------------


def _list(is_json: bool) -> int:
    listener = TopicListener('/mission_status', MissionStatus)
    deadline = time.monotonic() + PATIENCE
    # The fleet manager runs, so it sends the open missions to this new subscriber.
    stop = stop_of(TopicListener('/fleet_state', FleetState).last().stop)
    quiet = time.monotonic() + 1.0
    while time.monotonic() < min(quiet, deadline):
        listener.wait(quiet - time.monotonic())
        time.sleep(0.02)
    latest = {status.request_id: status for status in listener.unread()}
    missions = [s for s in latest.values() if MissionState(s.state).is_open]
    if is_json:
        print(as_json({'stop': stop_values(stop), 'missions': list(map(_values, missions))}))
        return OK
    if stop.is_in_force:
        print(stop.words(time.time()))
    print(_listed(missions) if missions else 'There are no open missions.')
    return OK


def _listed(missions: Sequence[MissionStatus]) -> str:
    rows = [(short_name(s.serial), str(s.request_id), MissionState(s.state).name, s.robot or '-',
             str(s.destinations_reached), _clock(s.request_stamp.to_sec()), _deadline(s))
            for s in missions]
    head = ('mission', 'id', 'state', 'robot', 'reached', 'requested', 'deadline')
    return table_with_notes(head, rows, ['; '.join(filter(None, (_origin(s), s.reason)))
                                   for s in missions])


def _origin(status: MissionStatus) -> str:
    """Returns a mission's template and arguments; while it is PLANNED, also its earliest time."""
    words = [status.template, *(f'{one.name}:={one.value}' for one in status.arguments)]
    if status.state == MissionState.PLANNED:
        words.append(f'not before {_clock(status.earliest.to_sec())}')
    return ' '.join(filter(None, words))


def _deadline(status: MissionStatus) -> str:
    """Returns the deadline of a mission, with `AT RISK` or `MISSED` if so; '-' if it has none."""
    alarm = {DeadlineState.AT_RISK: ' AT RISK', DeadlineState.MISSED: ' MISSED'}
    return _clock(status.deadline.to_sec()) + alarm.get(status.deadline_code, '')


def _values(status: MissionStatus) -> Dict[str, Any]:
    return {'mission': status.request_id, 'serial': status.serial or None,
            'state': MissionState(status.state).name, 'robot': status.robot or None,
            'destinations_reached': status.destinations_reached,
            'reason': status.reason, 'requested': status.request_stamp.to_sec() or None,
            'template': status.template or None,
            'arguments': {one.name: one.value for one in status.arguments},
            'earliest': status.earliest.to_sec() or None,
            'deadline': status.deadline.to_sec() or None,
            'deadline_state': DeadlineState(status.deadline_code).name}


def _clock(seconds: float) -> str:
    """Returns a time of day, with the date if it is not today.

    Returns '-' for the time 0, which means that no time was given.
    """
    if not seconds:
        return '-'
    moment = datetime.fromtimestamp(seconds)
    form = '%H:%M:%S' if moment.date() == datetime.now().date() else '%Y-%m-%d %H:%M:%S'
    return moment.strftime(form)


def _why(arguments: List[str]) -> int:
    """Prints what a mission waits for, and for each robot why it does not serve the mission."""
    options = _options('why', 'says what an open mission waits for, and until when; while no robot '
                       'serves it, also why each robot does not', arguments)
    connect('mission_why')
    id = request_id(options.id)
    told = ask('/explain_mission', ExplainMission, id)
    if not told.found:
        raise CommandProblem(f'There is no open mission {options.id}; see mission list and '
                             'mission history.', NOT_DONE)
    print(as_json(_why_values(id, told)) if options.json else _why_words(id, told))
    return OK


def _why_words(id: int, told: ExplainMissionResponse) -> str:
    robot = f', served by {told.robot}' if told.robot else ''
    reason = told.waits_for or 'its robot drives, or sets out'
    first = (f'Mission {id} is {MissionState(told.state).name}{robot}. Reason: {reason}'
             f'{for_about(told.until)}.')
    rows = [(one.robot, f'{one.reason}{for_about(one.until)}') for one in told.robots]
    return '\n'.join((*textwrap.wrap(first, WIDTH), *(
        [table((('robot', 'why it does not serve the mission'), *rows), WIDTH)] if rows else [])))


def _why_values(id: int, told: ExplainMissionResponse) -> Dict[str, Any]:
    def known(seconds: float) -> Optional[float]:
        return seconds if math.isfinite(seconds) else None
    return {'mission': id, 'state': MissionState(told.state).name, 'robot': told.robot or None,
            'code': WaitCode(told.waits_for_code).name, 'waits_for': told.waits_for,
            'until': known(told.until), 'robots': [
                {'robot': one.robot, 'hindrance': Hindrance(one.hindrance).name,
                 'reason': one.reason, 'until': known(one.until),
                 'mission': one.request_id if one.has_mission else None}
                for one in told.robots]}


def _change(word: str, arguments: List[str]) -> int:
    options = _options(word, f'tells the fleet manager to {word} a mission', arguments)
    connect('mission_command')
    listener = TopicListener('/mission_status', MissionStatus)
    commands = connected_sender(MissionCommand)
    message = MissionCommand(command=int(_CHANGES[word]), requested_by=requested_by('mission'))
    if word == 'answer':
        message.answer = int(_ANSWERS[options.answer])
    if word == 'modify':
        message.priority = options.priority
        names = PlaceNames()
        _change_destinations(message, [names.destination(one) for one in options.destinations])
        if options.stops:
            found = _stops(options.stops, names)
            if found.on_cancel or options.destinations:
                raise CommandProblem('Give either places, or a file of stops without on_cancel.')
            message.stops = stop_messages(found.stops)
    known = open_mission(options.id, listener)
    message.request_id = known.request_id
    message.step_key = known.asks if word == 'answer' else 0
    commands.send(message)
    if _is_so(known, _CHANGES[word]):
        print(f'Mission {options.id} is {MissionState(known.state).name} already: nothing to '
              f'{word}.')
        return OK
    status = first_message(
        listener, lambda s: (s.request_id == known.request_id
                             and s.request_stamp == known.request_stamp
                             and _shows(s, _CHANGES[word])), PATIENCE)
    if status is None:
        raise CommandProblem(f'Nothing changed about mission {options.id}; see mission list.',
                             NOT_DONE)
    reason = f': {status.reason}' if status.reason else ''
    if status.command_code == MissionStatus.COMMAND_NOT_DONE:
        raise CommandProblem(f'Mission {options.id}{reason}.', NOT_DONE)
    print(f'Mission {options.id}: {MissionState(status.state).name}{reason}')
    return OK


def _change_destinations(message: MissionCommand, destinations: List[Destination]) -> None:
    """Fills in the new destinations. If one is a group, all are sent as stops, because only a stop
    can name a group.
    """
    if any(isinstance(one, str) for one in destinations):
        message.stops = visits(destinations)
    else:
        message.destination_vertices_id = destinations


def _is_so(status: MissionStatus, command: CommandKind) -> bool:
    """Returns whether a command to pause or resume would change nothing.

    The fleet manager publishes no status for a command that changes nothing.
    """
    return command in (CommandKind.PAUSE, CommandKind.RESUME) and (
        (status.state == MissionState.PAUSED) is (command is CommandKind.PAUSE))


def _shows(status: MissionStatus, command: CommandKind) -> bool:
    """Returns whether the status of a mission shows the result of a command."""
    state = MissionState(status.state)
    is_answer = status.command_code != MissionStatus.COMMAND_NONE and status.command == command
    if not state.is_open or is_answer:
        return True
    if command in (CommandKind.RELEASE, CommandKind.MODIFY, CommandKind.ANSWER):
        return True
    if command is CommandKind.CANCEL:
        return state in (MissionState.CANCELLING, MissionState.NEEDS_PERSON)
    return _is_so(status, command)


def _history(arguments: List[str]) -> int:
    parser = Parser('mission history', description='All missions, with their times.')
    parser.add_argument('--csv', action='store_true', help='as CSV with all columns')
    parser.add_argument('--journal', default='', help='journal of path_supervisor; default: '
                        'that of the running path_supervisor; if none runs, that in ROS_HOME on '
                        'this computer')
    options = parser.parse_args(arguments[1:])
    path = options.journal or os.path.join(
        rospkg.get_ros_home(), _journal_in_use() or 'graph_fleet_manager/fleet.sqlite')
    rows = (row_of(line, _moment) for line in history(path))
    try:
        if options.csv:
            writer = csv.writer(sys.stdout, lineterminator='\n')
            writer.writerow(HISTORY_COLUMNS)
            writer.writerows(map(cell, row) for row in rows)
        else:
            shown = (14, 0, 1, 4, 5, 7, 11, 12, 13)
            print(table([[HISTORY_COLUMNS[k] for k in shown],
                         *([row[k] for k in shown] for row in rows)]))
    except JournalError as error:
        raise CommandProblem(str(error)) from None
    return OK


def _journal_in_use() -> str:
    """Returns the ~journal of the fleet manager of this ROS master. Empty if no fleet manager
    runs, or if the parameter is not set.

    A relative path is relative to ROS_HOME, because roslaunch starts nodes there.
    """
    if not rosgraph.is_master_online():
        return ''
    try:
        rosgraph.Master('mission_history').lookupNode('/path_supervisor')
    except rosgraph.MasterError:
        return ''
    return str(rospy.get_param('/path_supervisor/journal', ''))


def _moment(seconds: float) -> str:
    return datetime.fromtimestamp(seconds).astimezone().isoformat(timespec='milliseconds')
