"""`mission timetables`: lists the timetables of the work file, and pauses or resumes one of them.
"""
from __future__ import annotations

from datetime import datetime
from typing import Any, Dict, List, Sequence

from fleet_core.work.timetables import DAY, DAYS, WEEK
from fleet_requests import call
from graph_fleet_manager.commands.command_line import OK, Parser
from graph_fleet_manager.commands.fleet_client import TopicListener, connect, requested_by
from graph_fleet_manager.commands.tables import WIDTH, as_json, offer_json, table
from itrci_nav_msgs.msg import Timetable, Timetables
from itrci_nav_msgs.srv import PauseTimetable

_HEAD = ('timetable', 'template', 'arguments', 'runs', 'next')


def timetables(arguments: Sequence[str]) -> int:
    """Runs the command; returns its exit status."""
    parser = Parser('mission timetables', description='Lists the timetables of the work file.')
    commands = parser.add_subparsers(dest='command', metavar='COMMAND')
    offer_json(parser)
    for name, what in (('pause', 'the timetable makes no runs until it is resumed'),
                       ('resume', 'it goes on; runs of the time in which it was paused are not '
                                  'made')):
        commands.add_parser(name, help=what).add_argument('timetable')
    options = parser.parse_args(arguments)
    connect('mission_command')
    if options.command:
        print(call('/pause_timetable', PauseTimetable, options.timetable,
                   options.command == 'pause', requested_by('mission')))
        return OK
    known = TopicListener('/timetables', Timetables).last().timetables
    print(as_json({'timetables': [_values(one) for one in known]}) if options.json
          else _listed(known))
    return OK


def _listed(known: List[Timetable]) -> str:
    if not known:
        return ('There are no timetables: the work file of the fleet manager has none, or it has '
                'no work file.')
    return table([_HEAD, *((one.name, one.template, ' '.join(
        f'{argument.name}:={argument.value}' for argument in one.arguments) or '-',
        runs_of(one), 'paused' if one.is_paused else f'{_next(one):%a %H:%M}')
        for one in known)], WIDTH)


def runs_of(one: Timetable) -> str:
    """Returns when a timetable runs, as in the work file."""
    every = f'{one.every // 60} h' if one.every % 60 == 0 else f'{one.every} min'
    days = frozenset(one.days)
    return f'every {every}, {_clock(one.begin)} to {_clock(one.end)}' + (
        '' if days == WEEK else ', ' + ' '.join(DAYS[day] for day in sorted(days)))


def _clock(minute: int) -> str:
    return f'{minute % DAY // 60:02}:{minute % 60:02}'


def _next(one: Timetable) -> datetime:
    return datetime.fromtimestamp(one.next.to_sec())


def _values(one: Timetable) -> Dict[str, Any]:
    return {'timetable': one.name, 'template': one.template,
            'arguments': {argument.name: argument.value for argument in one.arguments},
            'priority': one.priority, 'every': one.every, 'from': _clock(one.begin),
            'to': _clock(one.end), 'days': [DAYS[day] for day in one.days],
            'paused': one.is_paused, 'next': one.next.to_sec() or None}
