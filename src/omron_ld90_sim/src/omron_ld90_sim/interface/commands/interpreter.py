"""Executes a command line: expands variables, calls the handler, answers errors."""
from __future__ import annotations

import re
from typing import Dict

from omron_ld90_sim.interface.commands.table import TABLE, CommandCall, CommandFailed, NotReady
from omron_ld90_sim.interface.server import ArclServer
from omron_ld90_sim.interface.session import SimSession

_VARIABLE = re.compile(r'\$([gymdHMSTXYhstx])')


def execute(server: ArclServer, session: SimSession, line: str) -> None:
    """Carries out one command line for `session`."""
    variables = _variables(server)
    line = _VARIABLE.sub(lambda match: variables[match.group(1)], line)
    name, rest = [*line.split(None, 1), '', ''][:2]
    row = TABLE.get(name.lower())
    if row is None or row.name.lower() in server.dialect.missing:
        session.send(f'Unknown command {name}' if server.dialect.names_unknown
                     else 'Unknown command')
        return
    call = CommandCall(server, session, line, rest)
    if len(call.arguments) < row.required:
        session.send(f'usage: {row.usage}')
        return
    try:
        row.handler(call)
    except CommandFailed as failure:
        session.send(f'CommandError: {line}')
        session.send(f'CommandErrorDescription: {failure}')
    except NotReady as failure:
        session.send(f'SetUpError: {failure}')


def _variables(server: ArclServer) -> Dict[str, str]:
    """Returns the values of `$g`, `$y` and so on in a command line (ARCL manual I617-E-01 p. 51).

    I617-E-02 p. 45 has them in lower case, so lower case is accepted, too. Two letters differ by
    case: `$m` is the month and `$M` the minute, `$y` is the year and `$Y` the position.
    """
    robot, now = server.robot, server.wall_time()
    x, y, theta = (int(round(value)) for value in (robot.pose.x, robot.pose.y, robot.pose.theta))
    values = {'g': robot.tasks.last_goal, 'y': f'{now.tm_year}', 'm': f'{now.tm_mon:02d}',
              'd': f'{now.tm_mday:02d}', 'H': f'{now.tm_hour:02d}', 'M': f'{now.tm_min:02d}',
              'S': f'{now.tm_sec:02d}', 'T': f'{theta}', 'X': f'{x}', 'Y': f'{y}'}
    return {**{name.lower(): value for name, value in values.items()}, **values}
