"""Editing operations have their effect, change nothing else, and can all be undone."""
from __future__ import annotations

import math

import numpy as np
import pytest
from graph_edits import EDIT_LISTS, edited
from hypothesis import given

from trajectory_graph import editing
from trajectory_graph.edit_history import History
from trajectory_graph.editing import Draft, EditError
from trajectory_graph.graph import CurveType, Edge, Graph, Vertex


def square() -> Draft:
    """Returns a ring of four vertices in a square of 4 m; the edge from 2 to 3 is a spline."""
    places = {1: (0.0, 0.0), 2: (4.0, 0.0), 3: (4.0, 4.0), 4: (0.0, 4.0)}
    vertices = [Vertex(id, x, y, (id - 1) * math.pi / 2.0, label='pass', frame_id='map/test')
                for id, (x, y) in places.items()]
    edges = [Edge(id, id, id % 4 + 1, velocity_forward=0.8, velocity_backwards=0.3)
             for id in places]
    edges[1] = Edge(2, 2, 3, CurveType.SPLINE, 1.0, 1.0, 0.8, 0.3)
    return Draft.of(Graph(vertices, edges))


def test_a_moved_vertex_takes_its_edges_along_and_nothing_else():
    before = square()
    after = editing.move_vertex(before, 1, 1.0, -1.0)
    assert after.curve(1).point_at(0.0) == (1.0, -1.0)
    assert [id for id in after.vertices if after.vertices[id] is not before.vertices[id]] == [1]
    assert after.edges == before.edges


def test_a_deleted_vertex_takes_its_edges_along():
    after = editing.delete_vertex(square(), 1)
    assert sorted(after.vertices) == [2, 3, 4]
    assert sorted(after.edges) == [2, 3]


def test_the_last_vertex_stays():
    with pytest.raises(EditError, match='last vertex'):
        editing.delete_vertex(Draft.of(Graph([Vertex(1, 0.0, 0.0, 0.0)], [])), 1)


def test_a_new_edge_is_as_fast_as_those_around():
    after, id = editing.connect(square(), 1, 3)
    assert id == 5
    assert (after.edges[id].velocity_forward, after.edges[id].velocity_backwards) == (0.8, 0.3)


@pytest.mark.parametrize('origin, destination, words', [
    (1, 2, 'joins vertices 1 and 2 already'), (2, 1, 'already'), (1, 1, 'itself'),
    (1, 9, 'no vertex 9')])
def test_an_edge_that_cannot_be_is_refused(origin, destination, words):
    with pytest.raises(EditError, match=words):
        editing.connect(square(), origin, destination)


@pytest.mark.parametrize('id', [1, 2])
@pytest.mark.parametrize('fraction', [0.2, 0.5, 0.9])
def test_a_cut_edge_stays_where_it_was(id, fraction):
    before = square()
    after, middle = editing.cut_edge(before, id, fraction)
    old = before.curve(id)
    assert math.dist(after.vertices[middle].position, old.point_at(fraction * old.length)) < 1e-3
    for half in (id, 5):
        for x, y in after.curve(half).sample(0.1):
            assert old.project(x, y).distance < 1e-3
    assert after.curve(id).length + after.curve(5).length == pytest.approx(old.length, abs=1e-3)


def test_an_edge_turned_round_keeps_its_shape():
    for id in (1, 2):
        before = square()
        after = editing.turn_edge_round(before, id)
        assert (after.edges[id].origin, after.edges[id].destination) == (
            before.edges[id].destination, before.edges[id].origin)
        assert np.allclose(after.curve(id).sample(0.1), before.curve(id).reversed().sample(0.1),
                           atol=1e-4)


def test_a_spline_is_not_turned_round_where_it_would_bend_another():
    draft = editing.make_spline(square(), 3)
    with pytest.raises(EditError, match='edge 3 is a spline'):
        editing.turn_edge_round(draft, 2)


@pytest.mark.parametrize('at_origin', [True, False])
def test_a_handle_is_where_it_was_dragged(at_origin):
    after = editing.move_handle(square(), 2, at_origin, 5.5, 1.5)
    control = after.edge_alone(2).control_points(2)
    assert np.allclose(control[1 if at_origin else 2], (5.5, 1.5), atol=1e-3)


def test_a_line_has_no_handles():
    with pytest.raises(EditError, match='is a line'):
        editing.move_handle(square(), 1, True, 0.0, 0.0)


def test_a_line_that_becomes_a_spline_and_a_line_again_is_where_it_was():
    after = editing.make_line(editing.make_spline(square(), 1), 1)
    assert np.allclose(after.curve(1).points, square().curve(1).points)


def test_parts_that_do_not_hang_together_are_told():
    draft, id = editing.add_vertex(square(), 9.0, 9.0)
    assert draft.parts() == ({1, 2, 3, 4}, {id})


def test_places_are_snapped_to_the_grid():
    assert editing.snapped(1.23, -0.37, 0.25) == (1.25, -0.25)
    assert editing.snapped(1.23456, 0.0, 0.0) == (1.2346, 0.0)


def test_a_drag_is_undone_at_once():
    history = History(square())
    for x in (1.0, 2.0, 3.0):
        history.change('move', editing.move_vertex(history.draft, 1, x, 0.5), gesture='drag 1')
    history.end_gesture()
    history.change('move', editing.move_vertex(history.draft, 1, 3.5, 0.5), gesture='drag 1')
    assert history.undo() == 'move'
    assert history.draft.vertices[1].x == 3.0
    history.undo()
    assert history.draft == square()
    assert history.undo() is None


def test_what_is_done_after_an_undo_ends_what_could_be_redone():
    history = History(square())
    history.change('move', editing.move_vertex(history.draft, 1, 1.0, 0.0))
    history.undo()
    history.change('turn', editing.turn_vertex(history.draft, 1, 1.0))
    assert history.redoable is None


@given(EDIT_LISTS)
def test_undo_of_everything_gives_the_graph_back_and_redo_the_result(edits):
    history = History(square())
    for edit in edits:
        history.change(edit[0], edited(history.draft, edit))
    result = history.draft
    while history.undo():
        pass
    assert history.draft == square()
    while history.redo():
        pass
    assert history.draft == result


@given(EDIT_LISTS)
def test_edges_always_have_vertices_and_a_curve(edits):
    draft = square()
    for edit in edits:
        draft = edited(draft, edit)
        for edge in draft.edges.values():
            assert {edge.origin, edge.destination} <= set(draft.vertices)
