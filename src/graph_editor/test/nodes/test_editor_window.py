"""The window beside RViz shows the selection, and passes texts and numbers to the session."""
from __future__ import annotations

import math
import threading

import pytest

from graph_editor.checking.findings import Finding, Severity
from graph_editor.editor.session import EditingSession, Selected
from trajectory_graph import CurveType
from trajectory_graph.yaml_editing import GraphFile

QtWidgets = pytest.importorskip('PyQt5.QtWidgets')
HALL = """\
Edges:
- {CurveType: line, Destination_ID: 2, Id: 1, Origin_ID: 1, ParamB: 0.25, ParamF: 0.25, VelocityBackwards: 0.3, VelocityForward: 1.0}
Vertices:
- {FrameId: m, Id: 1, Label: pass, Theta: 0.0, ThetaHolomonic: 0.0, X: 0.0, Y: 0.0}
- {FrameId: m, Id: 2, Label: pass, Theta: 0.0, ThetaHolomonic: 0.0, X: 8.1234, Y: 0.0}
"""  # noqa: E501


class Node:
    """The functions of the editor's node that the window needs."""

    def __init__(self, path) -> None:
        path.write_text(HALL)
        self.session = EditingSession(GraphFile.load(path), str(path))
        self.lock = threading.RLock()
        self.findings = [Finding(Severity.ERROR, 'it is in a wall', 'edge', 1, (1.0, 2.0))]

    def show(self) -> None:
        """Does nothing, because there is no RViz."""


@pytest.fixture
def node(tmp_path):
    return Node(tmp_path / 'hall.yaml')


@pytest.fixture
def window(node, monkeypatch):
    monkeypatch.setenv('QT_QPA_PLATFORM', 'offscreen')
    application = QtWidgets.QApplication.instance() or QtWidgets.QApplication(['test'])
    from graph_editor.nodes.window import EditorWindow
    monkeypatch.setattr('rospy.is_shutdown', lambda: False)
    window = EditorWindow(node)
    window._follow()
    yield window
    window._timer.stop()
    application.processEvents()


def select(window, kind: str, id: int):
    window._edit(lambda session: session.click_vertex(id) if kind == 'vertex'
                 else session.click_edge(id))
    return window._form.currentWidget()


def test_fields_of_a_vertex_are_given_to_the_session(window, node):
    form = select(window, 'vertex', 2)
    form._label.setText('press 4')
    form._label.editingFinished.emit()
    form._theta.setValue(90.0)
    form._y.setValue(1.5)
    form._dock.click()
    form._parking.setCurrentIndex(2)
    form._parking.activated.emit(2)
    vertex = node.session.draft.vertices[2]
    assert (vertex.label, vertex.y, vertex.dock, vertex.parking) == ('press 4', 1.5, True, False)
    assert vertex.theta == pytest.approx(math.pi / 2.0, abs=1e-6)
    assert vertex.x == 8.1234, 'a value that was not typed must not be rounded'


def test_fields_of_an_edge_are_given_to_the_session(window, node):
    form = select(window, 'edge', 1)
    form._boxes['velocity_backwards'].setValue(0.0)
    form._boxes['param_f'].setValue(1.25)
    form._curve.setCurrentIndex(1)
    form._curve.activated.emit(1)
    edge = node.session.draft.edges[1]
    assert (edge.velocity_backwards, edge.param_f, edge.curve_type) == (
        0.0, 1.25, CurveType.SPLINE)


def test_looking_at_elements_changes_nothing(window, node):
    for kind, id in (('vertex', 1), ('vertex', 2), ('edge', 1), ('vertex', 2)):
        select(window, kind, id)
    assert node.session.history.undoable is None


def test_a_finding_that_is_clicked_is_selected(window, node):
    item = window._findings.item(0)
    assert item.text() == 'error: edge 1: it is in a wall (at 1.00 2.00)'
    window._findings.itemClicked.emit(item)
    assert node.session.selected == Selected('edge', 1)


def test_buttons_undo_redo_and_save(window, node):
    form = select(window, 'vertex', 1)
    form._y.setValue(2.0)
    assert window.windowTitle() == '* hall.yaml: graph editor'
    window._undo.click()
    assert node.session.draft.vertices[1].y == 0.0 and not window._undo.isEnabled()
    window._redo.click()
    window._save.click()
    assert window.windowTitle() == 'hall.yaml: graph editor'
    assert GraphFile.load(node.session.path).draft.vertices[1].y == 2.0


@pytest.mark.parametrize('answer, closes, saved', [
    ('Save', True, True), ('Discard', True, False), ('Cancel', False, False)])
def test_closing_asks_before_edits_are_lost(window, node, monkeypatch, answer, closes, saved):
    select(window, 'vertex', 1)._y.setValue(2.0)
    monkeypatch.setattr(QtWidgets.QMessageBox, 'question', staticmethod(
        lambda *_: getattr(QtWidgets.QMessageBox, answer)))
    assert window.close() is closes
    assert node.session.is_saved is saved


def test_closing_does_not_ask_when_all_is_saved(window, monkeypatch):
    monkeypatch.setattr(QtWidgets.QMessageBox, 'question', staticmethod(
        lambda *_: pytest.fail('the window asked')))
    assert window.close()
