"""The command `edge`: closes edges and areas to all robots, and opens them again.

A person names an area on the fleet page. The page publishes all areas while it runs.

Exit status 0: done; 1: wrong input, or no fleet manager.
"""
from __future__ import annotations

from typing import Any, Dict, Iterable, List, Mapping, Optional, Sequence, Tuple

import rosgraph
import rospy

from graph_fleet_manager.commands.command_line import OK, CommandProblem, Parser
from graph_fleet_manager.commands.fleet_client import (
    TopicListener,
    connect,
    first_answer,
    requested_by,
    run,
)
from graph_fleet_manager.commands.tables import WIDTH, as_json, offer_json, table
from itrci_nav_msgs.msg import ClosedEdges, EdgeAreas, EdgeCommand
from itrci_nav_msgs.msg import Graph as GraphMessage
from trajectory_graph import Graph
from trajectory_graph.drawn_names import drawn_ids
from trajectory_graph.messages import graph_from_message

_AREAS = '/edge_areas'
_CODES = {'close': EdgeCommand.CLOSE, 'open': EdgeCommand.OPEN}


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Runs the command; returns its exit status."""
    return run('edge', _edge, arguments)


def _edge(arguments: List[str]) -> int:
    parser = Parser('edge', description='Closes edges of the graph to all robots, or opens them.')
    commands = parser.add_subparsers(dest='command', metavar='COMMAND')
    commands.required = True
    offer_json(commands.add_parser('list', help='the edges that are closed, and the areas'))
    for name, what in (('close', 'closes these edges; a robot to which one was granted drives to '
                                 'its end'),
                       ('open', 'lets robots use these edges again')):
        commands.add_parser(name, help=what).add_argument(
            'edges', nargs='+', metavar='ID|AREA',
            help='id of an edge, or the name of an area that was kept on the fleet page')
    options = parser.parse_args(arguments)
    connect('edge_command')
    in_force = TopicListener('/closed_edges_in_force', ClosedEdges)
    graph = graph_from_message(TopicListener('/graph', GraphMessage).last())
    told: ClosedEdges = in_force.last()
    areas = _known_areas() if options.command == 'list' or not all(
        map(_is_id, options.edges)) else {}
    if options.command != 'list':
        command = EdgeCommand(edges=asked_edges(graph, ids_of(options.edges, areas)),
                              requested_by=requested_by('edge'), command=_CODES[options.command])
        told = _carried_out(command, in_force)
    is_json = options.command == 'list' and options.json
    closed = _closed(graph, told.edges)
    shown = _area_values(graph, areas, told.edges)
    print(as_json({'closed': closed, 'areas': shown}) if is_json else _listed(closed, shown))
    return OK


def _known_areas() -> Dict[str, Tuple[int, ...]]:
    """Returns the edges of each area; none if the fleet page does not run."""
    topics = rosgraph.Master(rospy.get_name()).getSystemState()[0]
    if not any(name == _AREAS for name, _ in topics):
        return {}
    listener = TopicListener(_AREAS, EdgeAreas)
    return {area.name: tuple(area.edges) for area in listener.last().areas}


def _is_id(word: str) -> bool:
    return word.isascii() and word.isdigit()


def ids_of(words: Iterable[str], areas: Mapping[str, Sequence[int]]) -> List[int]:
    """Returns the edges that ids of edges and names of areas stand for. Raises CommandProblem."""
    found: List[int] = []
    for word in words:
        if _is_id(word):
            found.append(int(word))
        elif word in areas:
            found += areas[word]
        else:
            raise CommandProblem(f'{word!r} is neither an id nor an area; ' + (
                f'there are: {", ".join(sorted(areas))}.' if areas else
                'the fleet page, on which areas are named, does not run or has none.'))
    return found


def _area_values(graph: Graph, areas: Mapping[str, Sequence[int]],
                 closed: Iterable[int]) -> List[Dict[str, Any]]:
    """Returns the areas: name, edges, and the number of these edges that are closed."""
    shut = drawn_ids(graph, closed)
    return [{'area': name, 'edges': list(edges), 'closed': len(set(edges) & set(shut))}
            for name, edges in sorted(areas.items())]


def _closed(graph: Graph, edges: Iterable[int]) -> List[Dict[str, Any]]:
    """Returns the closed edges as the user has drawn them: id, first and last vertex, and length
    in m.
    """
    found = []
    for id in sorted(drawn_ids(graph, edges)):
        sections = [section for section in graph.sections[id] if section in graph.edges]
        found.append({'edge': id, 'from': graph.start_vertex(sections[0]).id,
                      'to': graph.end_vertex(sections[-1]).id,
                      'length': sum(graph.curve(section).length for section in sections)})
    return found


def _listed(closed: List[Dict[str, Any]], areas: List[Dict[str, Any]]) -> str:
    edges = _listed_edges(closed)
    if not areas:
        return edges
    return edges + '\n\n' + table([('area', 'edges', 'state'), *(
        (one['area'], ' '.join(map(str, one['edges'])), _state(one['closed'], len(one['edges'])))
        for one in areas)], WIDTH)


def _state(closed: int, whole: int) -> str:
    return 'open' if not closed else 'closed' if closed == whole else (
        f'{closed} of {whole} closed')


def _listed_edges(closed: List[Dict[str, Any]]) -> str:
    rows = [('closed edge', 'from', 'to', 'length'), *(
        (str(one['edge']), str(one['from']), str(one['to']), f'{one["length"]:.1f} m')
        for one in closed)]
    return table(rows, WIDTH) if closed else 'No edge is closed.'


def asked_edges(graph: Graph, ids: Iterable[int]) -> List[int]:
    """Returns the named edges of the graph in force. For a section, returns all sections of its
    drawn edge.
    """
    edges = sorted(graph.whole_edges(ids))
    unknown = [id for id in edges if id not in graph.edges]
    if unknown:
        raise CommandProblem(f'The graph has no edge {unknown[0]}.')
    return edges


def _carried_out(command: EdgeCommand, in_force: TopicListener) -> ClosedEdges:
    """Sends a command and waits for the list of closed edges that shows its effect.

    Returns this list.
    """
    in_force.unread()  # drops earlier messages: they do not answer the command
    wanted = set(command.edges) if command.command == EdgeCommand.CLOSE else set()
    told = first_answer(command, in_force, lambda message: (
        set(command.edges) & set(message.edges) == wanted))
    if told is None:
        raise CommandProblem('graph_server did not carry out the command; its log says why.')
    return told
