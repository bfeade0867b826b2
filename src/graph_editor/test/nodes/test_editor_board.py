"""Mouse actions in RViz become actions of the session."""
from __future__ import annotations

import threading

import pytest
from visualization_msgs.msg import InteractiveMarkerFeedback as Feedback

from graph_editor.editor.actions import Action
from graph_editor.editor.session import EditingSession
from graph_editor.nodes import board, handles
from trajectory_graph import Edge, Graph, Vertex
from trajectory_graph.yaml_editing import GraphFile
from trajectory_graph.yaml_file import dump_graph


class Server:
    """Records the markers that RViz would show."""

    def __init__(self, _: str) -> None:
        self.markers = {}
        self.sent = []

    def insert(self, marker, callback) -> None:
        self.markers[marker.name] = marker
        self.sent.append(marker.name)
        self.callback = callback

    def setPose(self, name, pose) -> None:  # noqa: N802
        self.markers[name].pose = pose

    def erase(self, name) -> None:
        del self.markers[name]

    def applyChanges(self) -> None:  # noqa: N802
        pass


class Editor:
    """A mouse, and a board with two vertices (in one handle) and an edge between them."""

    def __init__(self, monkeypatch) -> None:
        monkeypatch.setattr(board, 'OrderedMarkerServer', Server)
        graph = Graph([Vertex(1, 0.0, 0.0, 0.0), Vertex(2, 4.0, 0.0, 0.0)],
                      [Edge(1, 1, 2, velocity_forward=1.0, velocity_backwards=1.0)])
        self.session = EditingSession(GraphFile(dump_graph(graph), 'graph.yaml'), 'graph.yaml')
        self.board = board.Board(self.session, threading.RLock(), lambda: self.board.show({}))
        self.board.show({})
        self.server = self.board._server

    def tell(self, event: int, name: str, moved=(0.0, 0.0), mouse=(0.0, 0.0), entry=0) -> None:
        feedback = Feedback(event_type=event, marker_name=name, menu_entry_id=entry)
        feedback.pose.position.x, feedback.pose.position.y = moved
        feedback.mouse_point.x, feedback.mouse_point.y = mouse
        self.server.callback(feedback)

    def places(self) -> list:
        return [vertex.position for vertex in self.session.draft.vertices.values()]

    def discs(self) -> int:
        shape = self.server.markers['vertices 0'].controls[0].markers[0]
        return len(shape.points) // (3 * board.handles.flat.DISC_CORNERS)


@pytest.fixture
def editor(monkeypatch) -> Editor:
    return Editor(monkeypatch)


def test_of_vertices_with_one_handle_the_one_under_the_mouse_is_dragged(editor):
    editor.tell(Feedback.MOUSE_DOWN, 'vertices 0', mouse=(3.9, 0.1))
    editor.tell(Feedback.POSE_UPDATE, 'vertices 0', moved=(0.5, 1.0))
    assert editor.places() == [(0.0, 0.0), (4.5, 1.0)]
    assert editor.board.is_dragging


def test_while_it_is_dragged_its_handle_is_sent_once_and_holds_no_other(editor):
    editor.tell(Feedback.MOUSE_DOWN, 'vertices 0', mouse=(4.0, 0.0))
    editor.tell(Feedback.POSE_UPDATE, 'vertices 0', moved=(0.5, 1.0))
    assert editor.discs() == 1
    position = editor.server.markers['vertices 0'].pose.position
    assert (position.x, position.y) == (0.5, 1.0), 'the handle must be where RViz has it'
    editor.server.sent.clear()
    editor.tell(Feedback.POSE_UPDATE, 'vertices 0', moved=(0.6, 1.0))
    assert 'vertices 0' not in editor.server.sent and 'drawn vertices 0' in editor.server.sent


@pytest.mark.parametrize('end', [(0.5, 1.0), (0.0, 0.0)])
def test_let_go_the_handle_holds_all_vertices_in_their_places(editor, end):
    editor.tell(Feedback.MOUSE_DOWN, 'vertices 0', mouse=(4.0, 0.0))
    for moved in ((0.5, 1.0), end):
        editor.tell(Feedback.POSE_UPDATE, 'vertices 0', moved=moved)
    editor.server.sent.clear()
    editor.tell(Feedback.MOUSE_UP, 'vertices 0', moved=end)
    assert 'vertices 0' in editor.server.sent
    assert editor.discs() == 2
    position = editor.server.markers['vertices 0'].pose.position
    assert (position.x, position.y) == (0.0, 0.0)
    assert editor.session.selected.id == 2
    assert not editor.board.is_dragging


def test_a_tremor_is_no_drag_but_a_click(editor):
    editor.tell(Feedback.MOUSE_DOWN, 'vertices 0', mouse=(4.0, 0.0))
    editor.tell(Feedback.POSE_UPDATE, 'vertices 0', moved=(0.01, 0.0))
    editor.tell(Feedback.MOUSE_UP, 'vertices 0', moved=(0.01, 0.0), mouse=(4.0, 0.0))
    assert editor.places() == [(0.0, 0.0), (4.0, 0.0)]
    assert (editor.session.selected.kind, editor.session.selected.id) == ('vertex', 2)


def test_a_click_on_an_edge_selects_it(editor):
    editor.tell(Feedback.MOUSE_DOWN, 'edges 0', mouse=(2.0, 0.0))
    editor.tell(Feedback.MOUSE_UP, 'edges 0', mouse=(2.0, 0.0))
    assert (editor.session.selected.kind, editor.session.selected.id) == ('edge', 1)


def test_a_menu_is_that_of_the_vertex_under_the_mouse(editor):
    entry, = (id for id, entry in handles.VERTEX_ACTIONS.items()
              if entry.action is Action.DELETE_VERTEX)
    editor.tell(Feedback.MENU_SELECT, 'vertices 0', mouse=(0.1, 0.1), entry=entry)
    assert list(editor.session.draft.vertices) == [2]
    assert 'edges 0' not in editor.server.markers


def test_an_open_menu_keeps_its_handle_where_nothing_of_it_changed(editor):
    editor.server.sent.clear()
    editor.board.show({})
    assert editor.server.sent == []


def test_what_is_told_of_a_handle_that_is_gone_does_nothing(editor):
    for event in (Feedback.MOUSE_DOWN, Feedback.POSE_UPDATE, Feedback.MOUSE_UP):
        editor.tell(event, 'vertices 7', moved=(1.0, 1.0))
    assert editor.places() == [(0.0, 0.0), (4.0, 0.0)]
    assert editor.session.said.startswith('Not done')
