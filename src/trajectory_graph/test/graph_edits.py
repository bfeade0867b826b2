"""Random edits of a draft, for tests. An edit is the name of an operation, and numbers that choose
its arguments.
"""
from __future__ import annotations

from hypothesis import strategies as st

from trajectory_graph import editing
from trajectory_graph.editing import Draft, EditError

COORDINATES = st.floats(-50.0, 50.0).map(lambda value: round(value, 3))


def _pick(ids, choice: int) -> int:
    ids = list(ids)
    return ids[choice % len(ids)] if ids else 1


def _label(draft: Draft, vertex: int, x: float) -> Draft:
    labels = ('pass', 'dock', "it's", '# 5', 'ü: x', '', 'true')
    return editing.change_vertex(draft, vertex, label=labels[int(abs(x)) % len(labels)])


EDITS = {
    'add vertex': lambda d, v, e, w, x, y: editing.add_vertex(d, x, y, label='new')[0],
    'move vertex': lambda d, v, e, w, x, y: editing.move_vertex(d, v, x, y),
    'turn vertex': lambda d, v, e, w, x, y: editing.turn_vertex(d, v, x),
    'delete vertex': lambda d, v, e, w, x, y: editing.delete_vertex(d, v),
    'connect': lambda d, v, e, w, x, y: editing.connect(d, v, w)[0],
    'turn edge round': lambda d, v, e, w, x, y: editing.turn_edge_round(d, e),
    'delete edge': lambda d, v, e, w, x, y: editing.delete_edge(d, e),
    'line': lambda d, v, e, w, x, y: editing.make_line(d, e),
    'spline': lambda d, v, e, w, x, y: editing.make_spline(d, e),
    'handle': lambda d, v, e, w, x, y: editing.move_handle(d, e, x > 0, x, y),
    'cut': lambda d, v, e, w, x, y: editing.cut_edge(d, e, abs(x) / 51.0)[0],
    'label': lambda d, v, e, w, x, y: _label(d, v, x),
    'dock': lambda d, v, e, w, x, y: editing.change_vertex(d, v, dock=x > 0),
    'parking': lambda d, v, e, w, x, y: editing.change_vertex(
        d, v, parking=None if x > 9 else x > 0),
    'speed': lambda d, v, e, w, x, y: editing.change_edge(d, e, velocity_forward=abs(x)),
}
EDIT_LISTS = st.lists(st.tuples(st.sampled_from(sorted(EDITS)), st.integers(0, 99),
                                st.integers(0, 99), COORDINATES, COORDINATES), max_size=12)


def edited(draft: Draft, edit: tuple) -> Draft:
    """Returns the draft after one random edit; the same draft if the edit is refused."""
    name, first, second, x, y = edit
    vertex, other = _pick(draft.vertices, first), _pick(draft.vertices, second)
    try:
        return EDITS[name](draft, vertex, _pick(draft.edges, first), other, x, y)
    except EditError:
        return draft
