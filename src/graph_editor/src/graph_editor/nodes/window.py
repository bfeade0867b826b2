"""The window beside RViz: texts and numbers of the selected element, findings, undo and saving.

The window is needed because RViz markers do not accept typed texts and numbers. It is updated ten
times a second.
"""
from __future__ import annotations

import math
from typing import Any, Callable, Dict, List, Optional, Tuple

import rospy
from PyQt5 import QtCore, QtGui, QtWidgets

from graph_editor.checking.findings import Finding, Severity
from graph_editor.editor.session import EditingSession, Selected
from trajectory_graph import CurveType, Edge, Vertex

PERIOD = 100  # ms
WIDTH, HEIGHT = 360, 720  # px
ERROR, WARNING = QtGui.QColor(200, 20, 20), QtGui.QColor(190, 110, 0)
UNDO_KEY, REDO_KEY, SAVE_KEY, TAKE_OVER_KEY = 'Ctrl+Z', 'Ctrl+Shift+Z', 'Ctrl+S', 'Ctrl+T'
Fields = Dict[str, Any]


class EditorWindow(QtWidgets.QMainWindow):
    """Form, findings and buttons of one editor node."""

    def __init__(self, node: Any) -> None:
        """`node` has `session`, `lock`, `findings` and `show()`, like EditorNode."""
        super().__init__()
        self._node = node
        self._shown: Optional[Tuple] = None
        self._form = _Form(self._edit)
        self._texts: List[str] = []
        self._findings = QtWidgets.QListWidget()
        self._findings.setWordWrap(True)
        self._findings.itemClicked.connect(self._select_finding)
        self._words = QtWidgets.QLabel()
        self._words.setWordWrap(True)
        buttons = QtWidgets.QHBoxLayout()
        self._undo = self._button(buttons, 'Undo', UNDO_KEY, lambda session: session.undo())
        self._redo = self._button(buttons, 'Redo', REDO_KEY, lambda session: session.redo())
        self._save = self._button(buttons, 'Save', SAVE_KEY, lambda session: session.save())
        self._button(buttons, 'Take over', TAKE_OVER_KEY, lambda session: session.take_over())
        layout = QtWidgets.QVBoxLayout()
        layout.addWidget(self._form)
        layout.addLayout(buttons)
        layout.addWidget(QtWidgets.QLabel('Findings'))
        layout.addWidget(self._findings, 1)
        layout.addWidget(self._words)
        centre = QtWidgets.QWidget()
        centre.setLayout(layout)
        self.setCentralWidget(centre)
        self.setWindowTitle('Graph editor')
        self._put_beside_rviz()
        self._timer = QtCore.QTimer(self)
        self._timer.timeout.connect(self._follow)
        self._timer.start(PERIOD)

    def _put_beside_rviz(self) -> None:
        """Moves the window to the right edge of the screen, and makes it high enough for some
        findings.
        """
        screen = QtWidgets.QApplication.primaryScreen()
        if screen is None:
            return
        space = screen.availableGeometry()
        self.resize(WIDTH, min(HEIGHT, space.height()))
        self.move(space.right() - WIDTH, space.top())

    def closeEvent(self, event: Optional[QtGui.QCloseEvent]) -> None:  # noqa: N802, Qt's name
        """Asks the person before unsaved edits are lost."""
        assert event is not None, 'Qt gives an event'
        with self._node.lock:
            lost = not self._node.session.is_saved
        box = QtWidgets.QMessageBox
        answer = box.Discard if not lost else box.question(
            self, 'Graph editor', 'The graph is not saved. Save it?',
            box.Save | box.Discard | box.Cancel, box.Save)
        if answer == box.Save:
            with self._node.lock:
                saved = self._node.session.save()
                self._node.show()
            event.setAccepted(saved)
        else:
            event.setAccepted(answer == box.Discard)

    def _button(self, layout: QtWidgets.QHBoxLayout, words: str, keys: str,
                act: Callable[[EditingSession], object]) -> QtWidgets.QPushButton:
        button = QtWidgets.QPushButton(words)
        button.setShortcut(keys)
        button.setToolTip(f'{words} ({keys})')
        button.clicked.connect(lambda: self._edit(act))
        layout.addWidget(button)
        return button

    def _edit(self, act: Callable[[EditingSession], object]) -> None:
        with self._node.lock:
            act(self._node.session)
            self._node.show()
        self._follow()

    def _follow(self) -> None:
        """Updates the window after a change."""
        if rospy.is_shutdown():
            QtWidgets.QApplication.quit()
            return
        with self._node.lock:
            session = self._node.session
            findings = list(self._node.findings)
            state = (session.version, session.history.version, tuple(findings))
            if state == self._shown:
                return
            self._shown = state
            draft, selected = session.draft, session.selected
            said, saved = session.said, session.is_saved
            undoable, redoable = session.history.undoable, session.history.redoable
            path = session.path
        self._form.show_element(selected, draft)
        self._words.setText(said)
        for button, name in ((self._undo, undoable), (self._redo, redoable)):
            button.setEnabled(name is not None)
            button.setToolTip(f'{button.text()}: {name}' if name else '')
        self.setWindowTitle(f'{"" if saved else "* "}{path.rsplit("/", 1)[-1]}: graph editor')
        self._list(findings)

    def _list(self, findings: List[Finding]) -> None:
        texts = [str(finding) for finding in findings] or ['Nothing']
        if texts == self._texts:
            return
        self._texts = texts
        self._findings.clear()
        items = [QtWidgets.QListWidgetItem(text, self._findings) for text in texts]
        for item, finding in zip(items, findings):
            item.setForeground(ERROR if finding.severity is Severity.ERROR else WARNING)
            if finding.id is not None:
                item.setData(QtCore.Qt.ItemDataRole.UserRole, (finding.kind, finding.id))

    def _select_finding(self, item: QtWidgets.QListWidgetItem) -> None:
        about = item.data(QtCore.Qt.ItemDataRole.UserRole)
        if about is not None:
            kind, id = about
            self._edit(lambda session: session.click_edge(id) if kind == 'edge'
                       else session.click_vertex(id))


class _Form(QtWidgets.QStackedWidget):
    """The fields of the selected vertex or edge."""

    def __init__(self, edit: Callable[[Callable[[EditingSession], object]], None]) -> None:
        super().__init__()
        self._edit = edit
        self._element: Optional[Any] = None
        hint = QtWidgets.QLabel(
            'Click a vertex or an edge in RViz.\n\nPublish Point (key c) and a click: a new '
            'vertex, or an edge cut in two.\nDrag: move.\nRight click: everything else.')
        hint.setWordWrap(True)
        hint.setAlignment(QtCore.Qt.AlignmentFlag.AlignTop)
        self._vertex, self._edge = _VertexFields(self._change), _EdgeFields(self._change)
        for page in (hint, self._vertex, self._edge):
            self.addWidget(page)

    def show_element(self, selected: Optional[Selected], draft: Any) -> None:
        """Shows the fields of the selected element. Does not change a field while a person types in
        it.
        """
        if selected is None:
            self._element = None
            self.setCurrentIndex(0)
            return
        page = self._vertex if selected.kind == 'vertex' else self._edge
        element = (draft.vertices if selected.kind == 'vertex' else draft.edges)[selected.id]
        if element is not self._element:
            self._element = element
            page.show_element(element)
        self.setCurrentWidget(page)

    def _change(self, kind: str, **fields: Any) -> None:
        element = self._element
        if element is not None and any(getattr(element, name) != value
                                       for name, value in fields.items()):
            self._edit(lambda session: session.set_fields(kind, element.id, **fields))


class _Fields(QtWidgets.QGroupBox):
    """A group of widgets for the fields of an element."""

    def __init__(self, kind: str, change: Callable[..., None]) -> None:
        super().__init__()
        self._kind, self._change = kind, change
        self._rows = QtWidgets.QFormLayout(self)

    def _number(self, words: str, unit: str, low: float, high: float, digits: int,
                changed: Callable[[float], None]) -> QtWidgets.QDoubleSpinBox:
        box = QtWidgets.QDoubleSpinBox()
        box.setRange(low, high)
        box.setDecimals(digits)
        box.setSingleStep(0.1 if digits > 1 else 5.0)
        box.setSuffix(f' {unit}')
        box.setKeyboardTracking(False)
        box.valueChanged.connect(changed)
        self._rows.addRow(words, box)
        return box

    def _choice(self, words: str, choices: List[str],
                changed: Callable[[int], None]) -> QtWidgets.QComboBox:
        box = QtWidgets.QComboBox()
        box.addItems(choices)
        box.activated.connect(changed)
        self._rows.addRow(words, box)
        return box

    def _set(self, **fields: Any) -> None:
        self._change(self._kind, **fields)


class _VertexFields(_Fields):

    PARKING = (None, True, False)

    def __init__(self, change: Callable[..., None]) -> None:
        super().__init__('vertex', change)
        self._label = QtWidgets.QLineEdit()
        self._label.editingFinished.connect(lambda: self._set(label=self._label.text()))
        self._rows.addRow('Label', self._label)
        self._x = self._number('X', 'm', -1e5, 1e5, 3, lambda value: self._place('x', value))
        self._y = self._number('Y', 'm', -1e5, 1e5, 3, lambda value: self._place('y', value))
        self._theta = self._number('Heading', 'deg', -360.0, 360.0, 2, self._turn)
        self._dock = QtWidgets.QCheckBox('robots charge here')
        self._dock.clicked.connect(lambda checked: self._set(dock=checked))
        self._rows.addRow('Dock', self._dock)
        self._parking = self._choice('Parking', ['not said', 'yes', 'no'], lambda index: self._set(
            parking=self.PARKING[index]))
        self._element: Optional[Vertex] = None

    def show_element(self, vertex: Vertex) -> None:
        """Shows the values of a vertex."""
        self._element = None  # setting the widgets must not count as an edit
        self.setTitle(f'Vertex {vertex.id}')
        self._label.setText(vertex.label)
        self._x.setValue(vertex.x)
        self._y.setValue(vertex.y)
        self._theta.setValue(math.degrees(vertex.theta))
        self._dock.setChecked(vertex.dock)
        self._parking.setCurrentIndex(self.PARKING.index(vertex.parking))
        self._element = vertex

    def _place(self, name: str, value: float) -> None:
        if self._element is not None and abs(value - getattr(self._element, name)) > 5e-4:
            self._set(**{name: value})

    def _turn(self, degrees: float) -> None:
        if self._element is not None and abs(degrees - math.degrees(self._element.theta)) > 5e-3:
            theta = round(math.remainder(math.radians(degrees), 2.0 * math.pi), 6)
            self._set(theta=theta, theta_holonomic=theta)


class _EdgeFields(_Fields):

    CURVES = (CurveType.LINE, CurveType.SPLINE)

    def __init__(self, change: Callable[..., None]) -> None:
        super().__init__('edge', change)
        self._ends = QtWidgets.QLabel()
        self._rows.addRow('From, to', self._ends)
        self._curve = self._choice('Curve', ['line', 'spline'], lambda index: self._set(
            curve_type=self.CURVES[index]))
        self._boxes = {name: self._number(words, unit, 0.0, high, 3, self._setter(name))
                       for name, words, unit, high in (
                           ('param_f', 'ParamF', 'm', 1e3), ('param_b', 'ParamB', 'm', 1e3),
                           ('velocity_forward', 'Forward', 'm/s', 10.0),
                           ('velocity_backwards', 'Backwards (0: one-way)', 'm/s', 10.0))}
        self._element: Optional[Edge] = None

    def _setter(self, name: str) -> Callable[[float], None]:
        def changed(value: float) -> None:
            if self._element is not None and abs(value - getattr(self._element, name)) > 5e-4:
                self._set(**{name: value})
        return changed

    def show_element(self, edge: Edge) -> None:
        """Shows the values of an edge."""
        self._element = None
        self.setTitle(f'Edge {edge.id}')
        self._ends.setText(f'{edge.origin} to {edge.destination}')
        self._curve.setCurrentIndex(self.CURVES.index(edge.curve_type))
        for name, box in self._boxes.items():
            box.setValue(getattr(edge, name))
        self._element = edge


def run_window(node: Any) -> None:
    """Shows the window until it is closed or ROS ends."""
    application = QtWidgets.QApplication(['graph_editor'])
    window = EditorWindow(node)
    window.show()
    application.exec_()
