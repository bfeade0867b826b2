"""The command `fleet`: lists all robots; says what a robot waits for; stops and resumes the fleet;
takes a robot out of service and puts it back; asks it to charge; declares it absent; declares what
it carries.

Exit status 0: done; 1: wrong input, or no fleet manager; 2: not done, with the reason.
"""
from __future__ import annotations

import math
import sys
import textwrap
import time
from argparse import ArgumentTypeError, Namespace
from typing import Any, Dict, List, Optional, Sequence, Union

import rospy

from fleet_core.supervision.fleet_view import RobotState
from fleet_core.supervision.waits import WaitCode
from graph_fleet_manager.commands.command_line import OK, CommandProblem, Parser
from graph_fleet_manager.commands.fleet_client import (
    TopicListener,
    call,
    connect,
    requested_by,
    run,
)
from graph_fleet_manager.commands.mission_names import MissionName, mission_name, request_id
from graph_fleet_manager.commands.stop import stop
from graph_fleet_manager.commands.tables import (
    WIDTH,
    as_json,
    for_about,
    offer_json,
    stop_values,
    table_with_notes,
)
from graph_fleet_manager.messages.missions import OUTAGE_OF_CODE, stop_of
from itrci_nav_msgs.msg import FleetRobot, FleetState
from itrci_nav_msgs.msg import Graph as GraphMessage
from itrci_nav_msgs.srv import ChargeRobot, DeclareAbsent, SetLoad
from trajectory_graph import Graph
from trajectory_graph.drawn_names import place_name, vertex_name
from trajectory_graph.messages import graph_from_message

EMPTY = 'empty'       # the load of a robot that carries nothing
GRAPH_PATIENCE = 2.0  # s to wait for the graph; only the drawn names of edges need it
_NAMES = {int(state): state.name for state in RobotState}
_WAITS = {int(code): code.name for code in WaitCode}
_AT_VERTEX = 0.01     # the part of an edge at each end that counts as the vertex, 0..1


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Runs the command; returns its exit status."""
    return run('fleet', _fleet, arguments)


def _options(arguments: List[str]) -> Namespace:
    """Returns the options of the command, checked."""
    parser = Parser('fleet', description='Lists the robots of the fleet, and stops them.')
    commands = parser.add_subparsers(dest='command', metavar='COMMAND')
    commands.required = True
    offer_json(commands.add_parser(
        'list', help='every robot: state, place, battery, mission, reason to wait'))
    why = commands.add_parser('why', help='what a robot waits for, and until when')
    why.add_argument('robot', metavar='ROBOT')
    offer_json(why)
    commands.add_parser('stop', help='stops every robot at once')
    commands.add_parser('resume', help='releases the stop: every robot may drive again')
    for name, what in (('out', 'stops a robot and takes it out of service'),
                       ('in', 'puts a robot back into service, from where it is')):
        commands.add_parser(name, help=what).add_argument('robot', metavar='ROBOT')
    absent = commands.add_parser('absent', help='declares that robots are not at the site, so that '
                                                'they block nothing until they report')
    absent.add_argument('robots', metavar='ROBOT', nargs='*')
    absent.add_argument('--unseen', action='store_true',
                        help='all robots that have never reported')
    load = commands.add_parser('load', help='says what a robot carries, after a person has looked')
    load.add_argument('robot', metavar='ROBOT')
    load.add_argument('load', type=_load, metavar='empty|MISSION',
                      help='nothing, or the load of this mission, which it serves: id of the '
                           'mission, or its short name, such as M42')
    charge = commands.add_parser('charge', help='asks a robot to charge when it has no mission')
    charge.add_argument('robot', metavar='ROBOT')
    charge.add_argument('--until', type=float, default=80.0, metavar='PERCENT',
                        help='the charge until which it gets no missions (80)')
    charge.add_argument('--end', action='store_true', help='it is not asked to any more')
    options = parser.parse_args(arguments)
    if options.command == 'charge' and not 0.0 < options.until <= 100.0:
        charge.error('--until is above 0 and up to 100 %')
    if options.command == 'absent' and bool(options.robots) == options.unseen:
        absent.error('name the robots, or give --unseen')
    return options


def _load(text: str) -> Union[str, MissionName]:
    """Returns the load that a text names: EMPTY, or a mission.

    Raises ArgumentTypeError.
    """
    if text == EMPTY:
        return EMPTY
    try:
        return mission_name(text)
    except ArgumentTypeError as wrong:
        raise ArgumentTypeError(f'say empty, or name a mission: {wrong}') from None


def _fleet(arguments: List[str]) -> int:
    options = _options(arguments)
    if options.command == 'stop':
        print(stop(requested_by('fleet')))
        return OK
    connect('fleet_command')
    if options.command == 'list':
        graphs = TopicListener('/graph', GraphMessage)
        state, graph = TopicListener('/fleet_state', FleetState).last(), _graph(graphs)
        print(as_json(_values(state, graph)) if options.json else _listed(state, graph))
    elif options.command == 'why':
        robot = _robot(options.robot)
        print(as_json(_why_values(robot)) if options.json else _why_words(robot))
    elif options.command == 'resume':
        print(call('/resume_fleet'))
    elif options.command == 'absent':
        return _absent(_unseen() if options.unseen else options.robots)
    elif options.command == 'load':
        _check(options.robot)
        carried = options.load
        print(call(f'/{options.robot}/set_load', SetLoad, carried != EMPTY,
                   0 if carried == EMPTY else request_id(carried), requested_by('fleet')))
    elif options.command == 'charge':
        _check(options.robot)
        print(call(f'/{options.robot}/charge', ChargeRobot,
                   0.0 if options.end else options.until / 100.0, requested_by('fleet')))
    else:
        _check(options.robot)
        print(call(f'/{options.robot}/{"leave" if options.command == "out" else "join"}_fleet'))
    return OK


def _robots() -> List[FleetRobot]:
    return list(TopicListener('/fleet_state', FleetState).last().robots)


def _check(robot: str) -> None:
    _robot(robot)


def _robot(name: str) -> FleetRobot:
    """Returns the state of a robot. Raises CommandProblem."""
    robots = {one.name: one for one in _robots()}
    if name not in robots:
        raise CommandProblem(f'There is no robot {name!r}; there are: {", ".join(robots)}.')
    return robots[name]


def _why_words(robot: FleetRobot) -> str:
    """Returns a sentence about a robot: what it does, what it waits for, and until when."""
    does = [] if robot.has_mission and robot.state == FleetRobot.BUSY else [
        f'is {_state(robot)}']
    does += [f'serves mission {robot.request_id}'] if robot.has_mission else []
    told = f'{robot.name} {" and ".join(does)}. '
    if robot.waits_for:
        told += f'It waits for: {robot.waits_for}{for_about(robot.until)}.'
    elif robot.has_mission or robot.state == FleetRobot.CHARGING:
        told += 'It waits for nothing: it drives, or may set out.'
    else:
        told += 'It waits for nothing: it has nothing to do.'
    return textwrap.fill(told, WIDTH)


def _why_values(robot: FleetRobot) -> Dict[str, Any]:
    return {'robot': robot.name, 'state': _NAMES.get(robot.state, str(robot.state)),
            'mission': robot.request_id if robot.has_mission else None,
            'code': WaitCode(robot.waits_for_code).name, 'waits_for': robot.waits_for,
            'until': robot.until if math.isfinite(robot.until) else None}


def _unseen() -> List[str]:
    names = [one.name for one in _robots() if one.state == FleetRobot.UNKNOWN]
    if not names:
        print('Every robot has reported, or was declared absent.')
    return names


def _absent(robots: Sequence[str]) -> int:
    """Declares each of the robots absent; continues after a failure. Returns the exit status."""
    status = OK
    for robot in robots:
        try:
            _check(robot)
            print(call(f'/{robot}/declare_absent', DeclareAbsent))
        except CommandProblem as error:
            print(f'fleet: {error}', file=sys.stderr)
            status = max(status, error.status)
    return status


def _graph(graphs: TopicListener) -> Optional[Graph]:
    """Returns the graph in force; None if graph_server does not run. The list needs no graph."""
    graphs.wait(GRAPH_PATIENCE)
    return graph_from_message(graphs.messages[-1]) if graphs.messages else None


def _listed(state: FleetState, graph: Optional[Graph]) -> str:
    """Returns the table of all robots. The note below a robot says why it waits, or what ends
    its outage.
    """
    head = ('robot', 'type', 'state', 'place', 'battery', 'mission', 'to')
    rows, notes = [], []
    for robot in state.robots:
        place = _place(robot, graph) if robot.pose.edge_id else 'off the graph'
        name = _state(robot)
        if robot.state == FleetRobot.OFFLINE:
            place = f'last: {place}' if robot.seen else 'never seen'
            if robot.seen:
                name += f', {(rospy.Time.now() - robot.seen).to_sec():.0f} s'
        rows.append((robot.name, robot.type, name, place,
                     '-' if math.isnan(robot.battery) else f'{100.0 * robot.battery:.0f} %',
                     str(robot.request_id) if robot.has_mission else '-',
                     str(robot.destination or '-')))
        notes.append(_note(robot))
    listed = table_with_notes(head, rows, notes)
    told = stop_of(state.stop).words(time.time())
    if not told:
        return listed
    return '\n'.join((*textwrap.wrap(f'{told} `fleet resume` lets it go on.', WIDTH), listed))


def _state(robot: FleetRobot) -> str:
    """Returns the state of a robot as people read it."""
    return (RobotState(robot.state).words_with(robot.waits_for_code)
            if robot.state in _NAMES else str(robot.state))


def _note(robot: FleetRobot) -> str:
    outage = OUTAGE_OF_CODE.get(robot.outage_code)
    if outage is not None:
        why = f'{robot.waits_for}. ' if robot.waits_for else ''
        return f'{why[:1].upper()}{why[1:]}{outage.way_back(robot.name)}'
    return f'waits for: {robot.waits_for}' if robot.waits_for else ''


def _values(state: FleetState, graph: Optional[Graph]) -> Dict[str, Any]:
    """Returns everything that `fleet list` shows, as values for JSON.

    `seen` and `since` are in s since 1970, `to_destination` and `to_end` in s from now.
    """
    def known(number: float) -> Optional[float]:
        return number if math.isfinite(number) else None

    def one(robot: FleetRobot) -> Dict[str, Any]:
        outage = OUTAGE_OF_CODE.get(robot.outage_code)
        edge = robot.pose.edge_id
        return {'robot': robot.name, 'type': robot.type, 'software': robot.software or None,
                'state': _NAMES.get(robot.state, str(robot.state)),
                'outage': outage.name if outage else None,
                'edge': edge or None, 'fraction': robot.pose.percentage / 100.0 if edge else None,
                'place': _place(robot, graph) if edge else None,
                'seen': robot.seen.to_sec() or None, 'battery': known(robot.battery),
                'mission': robot.request_id if robot.has_mission else None,
                'destination': robot.destination or None,
                'to_destination': known(robot.to_destination), 'to_end': known(robot.to_end),
                'waits_for_code': _WAITS.get(robot.waits_for_code, str(robot.waits_for_code)),
                'waits_for': robot.waits_for}
    return {'stop': stop_values(stop_of(state.stop)), 'robots': list(map(one, state.robots))}


def _place(robot: FleetRobot, graph: Optional[Graph]) -> str:
    edge, fraction = robot.pose.edge_id, robot.pose.percentage / 100.0
    if graph is None or abs(edge) not in graph.edges:
        return f'edge {edge} at {100.0 * fraction:.0f} %'
    if fraction <= _AT_VERTEX:
        return vertex_name(graph, graph.start_vertex(edge).id)
    if fraction >= 1.0 - _AT_VERTEX:
        return vertex_name(graph, graph.end_vertex(edge).id)
    return place_name(graph, edge, fraction)
