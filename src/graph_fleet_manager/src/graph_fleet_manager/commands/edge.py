"""The command `edge`: closes edges to all robots, and opens them again.

Exit status 0: done; 1: wrong input, or no fleet manager.
"""
from __future__ import annotations

import time
from typing import List, Optional, Sequence, Set

import rospy

from graph_fleet_manager.commands.command_line import OK, CommandError, Parser
from graph_fleet_manager.commands.fleet_client import (
    PATIENCE,
    Listener,
    connect,
    connected_publisher,
    run,
)
from itrci_nav_msgs.msg import ClosedEdges, Graph


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Runs the command; returns its exit status."""
    return run('edge', _edge, arguments)


def _edge(arguments: List[str]) -> int:
    parser = Parser('edge', description='Closes edges of the graph to all robots, or opens them.')
    commands = parser.add_subparsers(dest='command', metavar='COMMAND')
    commands.required = True
    commands.add_parser('list', help='the edges that are closed')
    for name, what in (('close', 'robots already let onto these edges drive them to their end'),
                       ('open', 'lets robots use these edges again')):
        commands.add_parser(name, help=what).add_argument('edges', type=int, nargs='+',
                                                          metavar='ID')
    options = parser.parse_args(arguments)
    connect('edge_command')
    in_force = Listener('/closed_edges_in_force', ClosedEdges)
    closed: Set[int] = set(in_force.last().edges)
    if options.command != 'list':
        graph = Listener('/graph', Graph).last()
        asked = {abs(id) for id in options.edges}
        unknown = sorted(asked - {edge.id for edge in graph.edges})
        if unknown:
            raise CommandError(f'The graph has no edge {unknown[0]}.')
        closed = closed | asked if options.command == 'close' else closed - asked
        _put_in_force(closed, in_force)
    print('Closed edges: ' + (', '.join(map(str, sorted(closed))) or 'none'))
    return OK


def _put_in_force(closed: Set[int], in_force: Listener) -> None:
    message = ClosedEdges(edges=sorted(closed))
    message.header.stamp = rospy.Time.now()
    connected_publisher('/closed_edges', ClosedEdges).publish(message)
    deadline = time.monotonic() + PATIENCE
    while set(in_force.last().edges) != closed:
        if time.monotonic() > deadline:
            raise CommandError('graph_server did not take it up; its log says why.')
        time.sleep(0.02)
