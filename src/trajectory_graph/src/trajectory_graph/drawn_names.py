"""Names of edges, vertices and places for people, as in the graph that a person has drawn.

`split_edges` cuts long edges into sections. The ids of sections, and of the vertices between them,
are in no file that a person has drawn. Topics use these ids, but texts for people name the drawn
edges. If the graph does not have an edge or vertex, the text names the id as it is.
"""
from __future__ import annotations

from typing import Iterable, Tuple

from trajectory_graph.graph import Graph


def drawn_ids(graph: Graph, ids: Iterable[int]) -> Tuple[int, ...]:
    """Returns the unsigned ids of the drawn edges to which these edges belong, each id once."""
    edges = graph.edges
    return tuple(dict.fromkeys(edges[id].drawn_id if id in edges else id for id in map(abs, ids)))


def edge_name(graph: Graph, signed_id: int) -> str:
    """Returns the name of an edge: `edge 7`, or `edge -7` if it is driven backwards."""
    return f'edge {"-" if signed_id < 0 else ""}{drawn_ids(graph, (signed_id,))[0]}'


def place_name(graph: Graph, signed_id: int, fraction: float) -> str:
    """Returns the name of a place on an edge: `edge 7 at 60 %`, or `edge -7 at 40 %`.

    fraction -- share (0..1) of the edge before the place, in driving direction
    """
    sign = 1 if signed_id > 0 else -1
    edge = graph.edges.get(abs(signed_id))
    if edge is None:
        return f'edge {signed_id} at {100.0 * fraction:.0f} %'
    sections = graph.sections[edge.drawn_id][::sign]
    lengths = [graph.curve(id).length for id in sections]
    number = sections.index(edge.id)
    before = sum(lengths[:number]) + fraction * lengths[number]
    return f'edge {sign * edge.drawn_id} at {100.0 * before / sum(lengths):.0f} %'


def vertex_name(graph: Graph, id: int) -> str:
    """Returns the name of a vertex: `vertex 5`, or between two sections `edge 7 at 50 %`."""
    return _between_sections(graph, id) or f'vertex {id}'


def at_vertex(graph: Graph, id: int) -> str:
    """Returns the place of a robot at a vertex: `at vertex 5`, or `on edge 7 at 50 %`."""
    between = _between_sections(graph, id)
    return f'on {between}' if between else f'at vertex {id}'


def size_of(graph: Graph) -> str:
    """Returns a text: how many vertices and edges were drawn, and how many sections there are."""
    drawn = sum(not graph.divides_an_edge(id) for id in graph.vertices)
    cut = len(graph.edges) > len(graph.sections)
    return (f'{drawn} vertices and {len(graph.sections)} edges'
            + (f', cut into {len(graph.edges)} sections' if cut else ''))


def _between_sections(graph: Graph, id: int) -> str:
    """Returns the place of a vertex that divides a drawn edge; empty: it divides none."""
    if id not in graph.vertices or not graph.divides_an_edge(id):
        return ''
    return place_name(graph, max(graph.edges_from(id)), 0.0)
