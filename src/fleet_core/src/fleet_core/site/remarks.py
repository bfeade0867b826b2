"""Sentences about a survey, for people who draw the graph or run the fleet.

If long edges are cut into sections, the sentences name only the drawn edges and vertices.
"""
from __future__ import annotations

from collections import Counter
from typing import FrozenSet, Iterable, List, NamedTuple, Tuple

from fleet_core.fleet import Fleet
from fleet_core.site.survey import Survey
from trajectory_graph import Graph
from trajectory_graph.drawn_names import drawn_ids, edge_name
from trajectory_graph.id_lists import listed

_NAMED = 5  # maximum number of objects in a list; further ones are only counted


class Remark(NamedTuple):
    """One sentence. A warning means that the graph or the fleet file should be corrected."""

    warning: bool
    text: str


def remarks(graph: Graph, fleet: Fleet, found: Survey) -> List[Remark]:
    """Returns the remarks about a survey and the fleet file, the most important first."""
    told = [Remark(True, text) for text in _wrong_in_fleet(graph, fleet)]
    if len(graph.parts) > 1:
        told.append(Remark(True, f'The graph has {len(graph.parts)} parts, which no edges join: '
                           f'{"; ".join(map(_part, graph.parts))}. A mission stays in one part.'))
    told += _on_parking(fleet, found)
    for part in found.stranded:
        for ids, remedy in (
                (part.vertices, 'let edges lead there both ways'),
                (part.behind_docks, 'each way leads through a dock, and no route leads through a '
                 'dock; let edges lead around it')):
            vertices = _drawn(graph, ids)
            if vertices:
                told.append(Remark(True, f'Robots of type {part.type} cannot reach, or cannot '
                                   f'return from, {_named("vertex", "vertices", vertices)}: '
                                   f'{remedy}.'))
    pairs = _near_edges(graph, found)
    for one, other in pairs[:_NAMED]:
        told.append(Remark(False, f'Edges {one} and {other} run so near each other that only one '
                           'robot at a time may be on the two.'))
    if len(pairs) > _NAMED:
        told.append(Remark(False, f'The same is so for {len(pairs) - _NAMED} more pairs of edges.'))
    return [*told, *_on_dead_ends(graph, found), *_on_long_edges(graph, found)]


def _near_edges(graph: Graph, found: Survey) -> List[Tuple[int, ...]]:
    """Returns pairs of drawn edges without a common vertex that have sections near each other."""
    pairs = dict.fromkeys(drawn_ids(graph, pair) for pair in found.near_edges)
    ends = {id: {graph.edges[sections[0]].origin, graph.edges[sections[-1]].destination}
            for id, sections in graph.sections.items()}
    return [pair for pair in pairs if len(pair) == 2 and not ends[pair[0]] & ends[pair[1]]]


def _drawn(graph: Graph, vertices: Iterable[int]) -> List[int]:
    """Returns these vertices, without the vertices that only divide an edge into sections."""
    return [id for id in vertices if not graph.divides_an_edge(id)]


def _wrong_in_fleet(graph: Graph, fleet: Fleet) -> Iterable[str]:
    for robot in fleet.robots:
        if robot.vertex not in graph.vertices:
            yield (f'Robot {robot.name} of the fleet file begins on vertex {robot.vertex}, which '
                   'the graph does not have: correct the fleet file.')
    docks = {vertex.id for vertex in graph.vertices.values() if vertex.dock}
    for kind in fleet.types:
        for dock in sorted((kind.docks or frozenset()) - docks):
            yield (f'Robot type {kind.name} lists dock {dock}, but the graph has no dock there: '
                   'correct the fleet file, or mark the vertex (Dock: true).')
    unused = docks.difference(*(kind.docks or () for kind in fleet.types))
    if unused:
        yield (f'No robot type lists {_named("dock", "docks", sorted(unused))} under docks in the '
               'fleet file: no robot charges there.')


def _on_parking(fleet: Fleet, found: Survey) -> Iterable[Remark]:
    count = Counter(robot.type.name for robot in fleet.robots)
    for one in found.capacities:
        beside = f', and {one.docks} more at docks' if one.docks else ''
        total = one.robots + one.docks
        text = (f'The graph holds {_robots(one.robots)} of type {one.type} without cutting any '
                f'robot off, docks kept free{beside}; the fleet has {count[one.type]}')
        if count[one.type] > total:
            yield Remark(True, f'{text}: they will block each other for good; take some out or '
                         'give the graph more dead-end parking.')
        else:
            yield Remark(False, f'{text}.')
    if len(fleet.types) > 1:
        text = (f'All types together have {len(found.parking)} parking places, for '
                f'{_robots(len(fleet.robots))}')
        if len(fleet.robots) > len(found.parking):
            yield Remark(True, f'{text}: they will block each other for good; take some out or '
                         'give the graph more dead-end parking.')
        else:
            yield Remark(False, f'{text}.')
    yield Remark(False, f'Parking: {_all_of(sorted(found.parking))}.')


def _on_dead_ends(graph: Graph, found: Survey) -> Iterable[Remark]:
    ends = [(end, _drawn(graph, end.vertices)) for end in found.dead_ends]
    ids = sorted(vertices[0] for end, vertices in ends
                 if end.entry is not None and len(vertices) == 1)
    if ids:
        yield Remark(False, f'{_named("Vertex", "Vertices", ids)} '
                     f'{"is" if len(ids) == 1 else "are"} at the end of a single edge: a robot '
                     'drives back the way it came.')
    for end, vertices in ends:
        if end.entry is None:
            where = 'The graph' if len(graph.parts) == 1 else (
                f'The part of the graph with vertex {min(vertices)}')
            yield Remark(True, f'{where} has no loop: robots that meet must drive back; join some '
                         'of its dead ends.')
        elif len(vertices) > 1:
            yield Remark(False, f'Behind vertex {end.entry} lies a dead end of {end.length:.1f} m '
                         f'with {_named("vertex", "vertices", vertices)}: robots that are to '
                         'pass each other there wait outside.')


def _on_long_edges(graph: Graph, found: Survey) -> Iterable[Remark]:
    worst_of = {drawn_ids(graph, (edge.id,)): edge for edge in reversed(found.long_edges)}
    if not worst_of:
        return
    worst = ', '.join(
        f'{edge_name(graph, edge.id)} ({"sections of " if graph.edges[edge.id].section_of else ""}'
        f'{edge.length:.1f} m, on {edge.share:.0%} of all paths)'
        for edge in list(worst_of.values())[::-1][:_NAMED])
    longest = max(round(2.0 * found.following_distance, 1), 0.1)
    yield Remark(False, f'Edges so long that they cost throughput, because a robot blocks its '
                 f'whole edge: {len(worst_of)}, most of all {worst}. To divide them: '
                 f'rosrun trajectory_graph split_edges --longest {longest} GRAPH.yaml OUT.yaml')


def _named(one: str, many: str, ids: Iterable[int]) -> str:
    """Returns `vertex 3`, or `vertices 3, 4`.

    The text has at most `_NAMED` ids, followed by the number of the other ids.
    """
    ids = list(ids)
    if len(ids) == 1:
        return f'{one} {ids[0]}'
    return f'{many} {listed(ids, _NAMED)}'


def _part(vertices: FrozenSet[int]) -> str:
    return _named('vertex', 'vertices', sorted(vertices))


def _robots(count: int) -> str:
    return '1 robot' if count == 1 else f'{count} robots'


def _all_of(ids: List[int]) -> str:
    return f'vertices {listed(ids)}' if ids else 'none'
