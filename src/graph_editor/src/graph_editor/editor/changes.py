"""The changes that the menus of vertices and edges make in a draft: one function for each action.
"""
from __future__ import annotations

import math
from typing import Callable, Dict

from graph_editor.editor.actions import Action
from trajectory_graph import editing
from trajectory_graph.editing import Draft, EditError

DEFAULT_SPEED_BACK = 0.3  # m/s, for an edge without speeds that becomes two-way

Change = Callable[[Draft, int, float], Draft]
"""Changes a draft. Arguments: the draft, the id of the menu's vertex or edge, the action's
argument.
"""


def facing_away(draft: Draft, id: int) -> Draft:
    """Turns a new vertex so that it faces along the edge that leads to it."""
    edge = draft.edges[draft.edges_at(id)[-1]]
    origin, destination = draft.vertices[edge.origin], draft.vertices[edge.destination]
    return editing.turn_vertex(draft, id, math.atan2(destination.y - origin.y,
                                                     destination.x - origin.x))


def _head_along(draft: Draft, id: int, _: float) -> Draft:
    edges = draft.edges_at(id)
    if not edges:
        raise EditError(f'No edge leads to vertex {id} yet.')
    edge, curve = draft.edges[edges[0]], draft.curve(edges[0])
    theta = curve.heading_at(0.0 if edge.origin == id else curve.length)
    return editing.turn_vertex(draft, id, theta)


def _turn(draft: Draft, id: int, by: float) -> Draft:
    return editing.turn_vertex(draft, id, draft.vertex(id).theta + by)


def _two_way(draft: Draft, id: int, _: float) -> Draft:
    edge = draft.edge(id)
    speed = max(edge.velocity_forward, edge.velocity_backwards) or DEFAULT_SPEED_BACK
    return editing.change_edge(draft, id, velocity_forward=edge.velocity_forward or speed,
                               velocity_backwards=edge.velocity_backwards or speed)


def _one_way(draft: Draft, id: int, _: float) -> Draft:
    edge = draft.edge(id)
    return editing.change_edge(draft, id, velocity_backwards=0.0,
                               velocity_forward=edge.velocity_forward or edge.velocity_backwards)


def _with_speed(draft: Draft, id: int, speed: float) -> Draft:
    """Sets the speed of each direction that may be driven."""
    edge = draft.edge(id)
    return editing.change_edge(
        draft, id, velocity_forward=speed if edge.velocity_forward else 0.0,
        velocity_backwards=speed if edge.velocity_backwards else 0.0)


CHANGES: Dict[Action, Change] = {
    Action.HEAD_ALONG: _head_along,
    Action.TURN_ROUND: lambda draft, id, _: _turn(draft, id, math.pi),
    Action.QUARTER_LEFT: lambda draft, id, _: _turn(draft, id, math.pi / 2.0),
    Action.DOCK: lambda draft, id, _: editing.change_vertex(
        draft, id, dock=not draft.vertex(id).dock),
    Action.PARKING: lambda draft, id, _: editing.change_vertex(
        draft, id, parking=None if draft.vertex(id).parking else True),
    Action.DELETE_VERTEX: lambda draft, id, _: editing.delete_vertex(draft, id),
    Action.LINE: lambda draft, id, _: editing.make_line(draft, id),
    Action.SPLINE: lambda draft, id, _: editing.make_spline(draft, id),
    Action.CUT: lambda draft, id, _: editing.cut_edge(draft, id, 0.5)[0],
    Action.TURN_EDGE: lambda draft, id, _: editing.turn_edge_round(draft, id),
    Action.TWO_WAY: _two_way,
    Action.ONE_WAY: _one_way,
    Action.SPEED: _with_speed,
    Action.DELETE_EDGE: lambda draft, id, _: editing.delete_edge(draft, id),
}
