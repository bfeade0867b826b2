"""The effects of clicks, drags, menus and fields on a graph file; each effect can be undone."""
from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graph_editor.editor.actions import EDGE_MENU, VERTEX_MENU, Action
from graph_editor.editor.session import EditingSession, Selected
from trajectory_graph import CurveType, load_graph
from trajectory_graph.yaml_editing import GraphFile

HALL = """\
# Graph of the hall: keep this
Edges:
- {CurveType: line, Destination_ID: 2, Id: 1, Origin_ID: 1, ParamB: 0.25, ParamF: 0.25, VelocityBackwards: 0.3, VelocityForward: 1.0}  # main lane
- {CurveType: spline, Destination_ID: 3, Id: 2, Origin_ID: 2, ParamB: 1.50, ParamF: 1.5, VelocityBackwards: 0.0, VelocityForward: 0.5, Zone: A}
Vertices:
- {FrameId: m, Id: 1, Label: 'pass', Theta: 0, ThetaHolomonic: 0, X: 0.00, Y: 0.0}   # start
- {FrameId: m, Id: 2, Label: pass, Theta: 0.0, ThetaHolomonic: 0.0, X: 8.0, Y: 0.0, Colour: red}
- {FrameId: m, Id: 3, Label: dock, Theta: 1.5708, ThetaHolomonic: 0, X: 10.0, Y: 3.0}
"""  # noqa: E501


@pytest.fixture
def path(tmp_path):
    path = tmp_path / 'hall.yaml'
    path.write_text(HALL)
    return path


def session_of(path) -> EditingSession:
    return EditingSession(GraphFile.load(path), str(path))


def hall() -> EditingSession:
    """Returns a session whose file is never written."""
    return EditingSession(GraphFile(HALL, 'hall.yaml'), '/nowhere/hall.yaml')


# Clicks


def test_a_click_on_the_floor_adds_a_vertex_and_selects_it():
    session = hall()
    session.click_floor(4.0, 5.0)
    assert session.draft.vertices[4].position == (4.0, 5.0)
    assert session.draft.vertices[4].frame_id == 'm'
    assert session.selected == Selected('vertex', 4)
    assert session.said == 'Add vertex 4'


def test_a_click_on_an_edge_cuts_it_there():
    session = hall()
    session.click_floor(3.0, 0.1)
    assert session.draft.vertices[4].position == pytest.approx((3.0, 0.0), abs=1e-3)
    assert {1, 3} <= set(session.draft.edges_at(4))


def test_a_click_on_a_vertex_selects_it():
    session = hall()
    session.click_floor(8.1, 0.1)
    assert session.selected == Selected('vertex', 2)
    assert session.history.undoable is None


def test_a_vertex_is_connected_to_the_next_that_is_clicked():
    session = hall()
    session.do(Action.CONNECT, 'vertex', 1)
    session.click_vertex(3)
    edge = session.draft.edges[3]
    assert (edge.origin, edge.destination, edge.velocity_forward) == (1, 3, 1.0)
    assert session.connecting_from is None


def test_clicks_on_the_floor_go_on_with_a_chain_of_connected_vertices():
    session = hall()
    session.do(Action.CONNECT, 'vertex', 1)
    session.click_floor(0.0, 4.0)
    session.click_floor(2.0, 4.0)
    assert [(edge.origin, edge.destination) for edge in session.draft.edges.values()][2:] == [
        (1, 4), (4, 5)]
    assert session.draft.vertices[4].theta == pytest.approx(math.pi / 2.0)
    assert session.connecting_from == 5


def test_connect_to_here_ends_what_connect_from_here_began():
    session = hall()
    session.do(Action.CONNECT_HERE, 'vertex', 3)
    assert 'First choose' in session.said
    session.do(Action.CONNECT, 'vertex', 1)
    session.do(Action.CONNECT_HERE, 'vertex', 3)
    assert 3 in session.draft.edges


def test_two_vertices_that_are_joined_already_are_not_joined_again():
    session = hall()
    session.do(Action.CONNECT, 'vertex', 1)
    session.click_vertex(2)
    assert session.said.startswith('Not done: Edge 1 joins vertices 1 and 2 already')
    assert len(session.draft.edges) == 2


@pytest.mark.parametrize('place', [(math.nan, 0.0), (math.inf, 1.0), (1e9, 0.0)])
@pytest.mark.parametrize('grid', [0.0, 0.5])
def test_a_place_that_is_none_adds_nothing(place, grid):
    session = hall()
    session.set_grid(grid)
    session.click_floor(*place)
    assert session.said.startswith('Not done')
    assert session.is_saved


# Drags


def test_a_drag_is_one_step_and_snaps_to_the_grid():
    session = hall()
    session.set_grid(0.25)
    for x in (0.1, 0.3, 0.6):
        session.drag_vertex(1, x, 0.9)
    session.end_drag()
    assert session.draft.vertices[1].position == (0.5, 1.0)
    session.undo()
    assert session.is_saved
    session.redo()
    assert session.draft.vertices[1].position == (0.5, 1.0)


def test_a_second_drag_is_a_second_step():
    session = hall()
    for y in (1.0, 2.0):
        session.drag_vertex(1, 0.0, y)
        session.end_drag()
    session.undo()
    assert session.draft.vertices[1].position == (0.0, 1.0)


def test_the_ball_ahead_of_a_vertex_turns_it():
    session = hall()
    session.drag_heading(2, 8.0, 3.0)
    assert session.draft.vertices[2].theta == pytest.approx(math.pi / 2.0)
    session.drag_heading(2, 8.0, 0.0)
    assert session.draft.vertices[2].theta == pytest.approx(math.pi / 2.0), (
        'the robot is on the vertex, so there is no direction')


def test_the_balls_of_a_spline_bend_it():
    session = hall()
    session.drag_handle(2, True, 8.0, 2.0)
    assert session.draft.edges[2].param_f == pytest.approx(2.0)
    assert session.draft.vertices[2].theta == pytest.approx(math.pi / 2.0)
    session.drag_handle(1, True, 0.0, 2.0)
    assert session.said == 'Not done: Edge 1 is a line and has no handles.'


# Menus


@pytest.mark.parametrize('action, kind, id, field, value', [
    (Action.TURN_ROUND, 'vertex', 1, 'theta', math.pi),
    (Action.QUARTER_LEFT, 'vertex', 1, 'theta', math.pi / 2.0),
    (Action.HEAD_ALONG, 'vertex', 2, 'theta', 0.0),
    (Action.DOCK, 'vertex', 1, 'dock', True), (Action.DOCK, 'vertex', 3, 'dock', False),
    (Action.PARKING, 'vertex', 1, 'parking', True),
    (Action.SPLINE, 'edge', 1, 'curve_type', CurveType.SPLINE),
    (Action.LINE, 'edge', 2, 'curve_type', CurveType.LINE),
    (Action.TURN_EDGE, 'edge', 1, 'origin', 2),
    (Action.TWO_WAY, 'edge', 2, 'velocity_backwards', 0.5),
    (Action.ONE_WAY, 'edge', 1, 'velocity_backwards', 0.0)])
def test_menus_of_vertices_and_edges_do_what_they_say(action, kind, id, field, value):
    session = hall()
    session.do(action, kind, id)
    element = (session.draft.vertices if kind == 'vertex' else session.draft.edges)[id]
    assert getattr(element, field) == (pytest.approx(value, abs=1e-6)
                                       if isinstance(value, float) else value)


def test_parking_is_taken_back_to_not_said():
    session = hall()
    for expected in (True, None):
        session.do(Action.PARKING, 'vertex', 1)
        assert session.draft.vertices[1].parking is expected


def test_a_speed_is_for_the_directions_that_may_be_driven():
    session = hall()
    session.do(Action.SPEED, 'edge', 2, 0.8)
    assert (session.draft.edges[2].velocity_forward,
            session.draft.edges[2].velocity_backwards) == (0.8, 0.0)


def test_what_is_deleted_is_not_selected_or_waited_for_any_more():
    session = hall()
    session.do(Action.CONNECT, 'vertex', 2)
    session.do(Action.DELETE_VERTEX, 'vertex', 2)
    assert session.selected is None and session.connecting_from is None
    assert not session.draft.edges
    session.do(Action.DELETE_EDGE, 'edge', 1)
    assert session.said == 'Not done: There is no edge 1 any more.'


def test_an_edge_without_length_hinders_nobody():
    session = hall()
    session.drag_vertex(1, 8.0, 0.0)
    session.do(Action.HEAD_ALONG, 'vertex', 1)
    assert session.said.startswith('Not done')
    session.do(Action.CUT, 'edge', 1)
    assert session.said.startswith('Not done')
    session.click_floor(2.0, 5.0)
    assert 4 in session.draft.vertices


def test_every_action_of_every_menu_is_understood():
    def actions(entries):
        for entry in entries:
            yield from actions(entry.entries)
            if entry.action is not None:
                yield entry.action, entry.argument
    for kind, menu in (('vertex', VERTEX_MENU), ('edge', EDGE_MENU)):
        for action, argument in actions(menu):
            session = hall()
            before = session.version
            session.do(action, kind, 1, argument)
            assert session.version > before, action


# Files


def test_saving_writes_only_what_was_edited(path):
    session = session_of(path)
    session.drag_vertex(2, 8.5, 0.0)
    assert not session.is_saved
    assert session.save()
    assert path.read_text() == HALL.replace('X: 8.0', 'X: 8.5')
    assert session.is_saved
    assert [entry.name for entry in path.parent.iterdir()] == ['hall.yaml']


def test_a_graph_that_the_loader_refuses_is_not_saved(path):
    session = session_of(path)
    session.click_floor(4.0, 5.0)
    assert not session.save()
    assert session.said.startswith('NOT SAVED') and 'vertex 4' in session.said
    assert path.read_text() == HALL


def test_what_another_program_wrote_meanwhile_is_not_overwritten(path):
    session = session_of(path)
    session.drag_vertex(2, 8.5, 0.0)
    path.write_text(HALL + '# by another hand\n')
    assert not session.save()
    assert 'another program' in session.said
    session.load_again()
    assert session.draft.vertices[2].x == 8.0
    session.undo()
    assert session.draft.vertices[2].x == 8.5
    assert session.save()
    assert path.read_text() == HALL.replace('X: 8.0', 'X: 8.5') + '# by another hand\n'


def test_a_folder_that_cannot_be_written_to_is_told(path):
    session = session_of(path)
    session.drag_vertex(2, 8.5, 0.0)
    path.unlink()
    path.parent.rmdir()
    assert not session.save()
    assert 'cannot be written' in session.said


def test_a_file_that_is_spoilt_is_not_loaded(path):
    session = session_of(path)
    path.write_text('Edges: [')
    session.load_again()
    assert session.said.startswith('Not loaded') and str(path) in session.said
    assert len(session.draft.vertices) == 3


def test_a_new_graph_is_saved_where_no_file_is_and_never_over_one(path):
    new = path.parent / 'new.yaml'
    session = EditingSession(GraphFile(HALL, str(new)), str(new), is_new=True)
    assert not session.is_saved
    assert session.save() and load_graph(new)
    other = EditingSession(GraphFile(HALL, str(path)), str(path), is_new=True)
    assert not other.save()


# Random actions

PLACES = st.tuples(st.floats(-5.0, 15.0), st.floats(-5.0, 15.0))
IDS = st.integers(1, 6)
VERTEX_ACTIONS = st.sampled_from([
    Action.CONNECT, Action.CONNECT_HERE, Action.HEAD_ALONG, Action.TURN_ROUND, Action.QUARTER_LEFT,
    Action.DOCK, Action.PARKING, Action.DELETE_VERTEX])
EDGE_ACTIONS = st.sampled_from([
    Action.LINE, Action.SPLINE, Action.CUT, Action.TURN_EDGE, Action.TWO_WAY, Action.ONE_WAY,
    Action.SPEED, Action.DELETE_EDGE])
STEPS = st.lists(st.one_of(
    st.builds(lambda place: lambda s: s.click_floor(*place), PLACES),
    st.builds(lambda id, place: lambda s: s.drag_vertex(id, *place), IDS, PLACES),
    st.builds(lambda id, place: lambda s: s.drag_heading(id, *place), IDS, PLACES),
    st.builds(lambda id, end, place: lambda s: s.drag_handle(id, end, *place), IDS, st.booleans(),
              PLACES),
    st.builds(lambda id: lambda s: s.click_vertex(id), IDS),
    st.builds(lambda id: lambda s: s.click_edge(id), IDS),
    st.builds(lambda action, id: lambda s: s.do(action, 'vertex', id), VERTEX_ACTIONS, IDS),
    st.builds(lambda action, id: lambda s: s.do(action, 'edge', id, 0.5), EDGE_ACTIONS, IDS),
    st.just(lambda s: s.end_drag()), st.just(lambda s: s.redo())), max_size=15)


@given(STEPS)
def test_undo_of_everything_gives_the_graph_and_the_files_bytes_back(steps):
    session = hall()
    for step in steps:
        step(session)
    result = session.draft
    while session.history.undoable:
        session.undo()
    assert session.is_saved
    assert GraphFile(HALL, 'hall.yaml').edited(session.draft).text == HALL
    while session.history.redoable:
        session.redo()
    assert session.draft == result
    if session.selected is not None:
        there = {'vertex': result.vertices, 'edge': result.edges}[session.selected.kind]
        assert session.selected.id in there
    assert session.connecting_from in (None, *result.vertices)
