"""An editing session: the draft, the selection, the file, and the effects of clicks and menus.

The module does not depend on ROS, RViz or windows. `said` is the message to the person: the last
action, or the reason why an action was not done.
"""
from __future__ import annotations

import math
import os
from dataclasses import dataclass
from typing import Any, Callable, Dict, Iterable, Optional, Tuple

from graph_editor.editor.actions import Action
from graph_editor.editor.changes import CHANGES, facing_away
from trajectory_graph import GraphError, editing
from trajectory_graph.edit_history import History
from trajectory_graph.editing import Draft, EditError
from trajectory_graph.yaml_editing import GraphFile

ON_EDGE = 0.25  # m; a click within this distance of an edge cuts the edge
ON_VERTEX = 0.25  # m; a click within this distance of a vertex selects the vertex


@dataclass(frozen=True)
class Selected:
    """The vertex or edge that was clicked last."""

    kind: str  # 'vertex' or 'edge'
    id: int


class EditingSession:
    """The editing of one graph file.

    version -- a number that changes whenever the draft, the selection or the message changes

    There is one method for each act of the person who edits.
    """

    def __init__(self, file: GraphFile, path: str, is_new: bool = False) -> None:
        """`is_new`: the file does not exist yet; the first save creates it."""
        self._file = file
        self._path = path
        self._is_new = is_new
        self.history = History(file.draft)
        self.selected: Optional[Selected] = None
        self.connecting_from: Optional[int] = None
        self.grid = 0.0
        self.said = ''
        self.version = 0
        self.on_take_over: Callable[[Draft], None] = lambda draft: None

    @property
    def draft(self) -> Draft:
        """The present graph; it may be invalid, so that it cannot be saved yet."""
        return self.history.draft

    @property
    def path(self) -> str:
        """The path of the graph file."""
        return self._path

    @property
    def is_saved(self) -> bool:
        """Whether the file has the same graph as the draft."""
        return not self._is_new and self.draft == self._file.draft

    # Clicks and drags

    def click_floor(self, x: float, y: float) -> None:
        """Adds a vertex at x, y (m), or cuts the edge that is there.

        If another vertex waits for a connection, connects the new vertex to this vertex.
        """
        self._tried(lambda: self._click_floor(x, y))

    def _click_floor(self, x: float, y: float) -> None:
        draft, near = self.draft, self._vertex_near(x, y)
        if near is not None:
            self.click_vertex(near)
            return
        edge = self.nearest_edge((x, y), draft.edges, ON_EDGE)
        if edge is not None:
            fraction = draft.curve(edge).project(x, y).fraction
            draft, vertex = editing.cut_edge(draft, edge, fraction)
            name = f'cut edge {edge}'
        else:
            draft, vertex = editing.add_vertex(draft, *editing.snapped(x, y, self.grid),
                                               label='pass')
            name = f'add vertex {vertex}'
        if self.connecting_from is not None:
            draft, _ = editing.connect(draft, self.connecting_from, vertex)
            draft = facing_away(draft, vertex)
            name += f', connected to {self.connecting_from}'
        self._change(name, draft)
        self._select('vertex', vertex)
        self.connecting_from = vertex if self.connecting_from is not None else None

    def click_vertex(self, id: int) -> None:
        """Selects the vertex, or connects it to the vertex that waits for a connection."""
        if self.connecting_from in (None, id):
            self._tried(lambda: self._choose('vertex', id, f'Vertex {id}'))
        else:
            self._tried(lambda: self._connect_to(id))

    def _connect_to(self, id: int) -> None:
        assert self.connecting_from is not None
        draft, edge = editing.connect(self.draft, self.connecting_from, id)
        self.connecting_from = None
        self._change(f'connect, edge {edge}', draft)
        self._select('edge', edge)

    def click_edge(self, id: int) -> None:
        """Selects the edge."""
        self._tried(lambda: self._choose('edge', id, f'Edge {id}'))

    def drag_vertex(self, id: int, x: float, y: float) -> None:
        """Moves a vertex with the mouse. One undo takes back all moves until `end_drag`."""
        self._tried(lambda: self._drag_vertex(id, *editing.snapped(x, y, self.grid)))

    def _drag_vertex(self, id: int, x: float, y: float) -> None:
        self._change(f'move vertex {id}', editing.move_vertex(self.draft, id, x, y), ('move', id))
        self._select('vertex', id)

    def drag_heading(self, id: int, x: float, y: float) -> None:
        """Turns a vertex so that it faces x, y."""
        vertex = self.draft.vertices.get(id)
        if vertex is not None and math.dist(vertex.position, (x, y)) > 1e-3:
            theta = math.atan2(y - vertex.y, x - vertex.x)
            self._tried(lambda: self._change(
                f'turn vertex {id}', editing.turn_vertex(self.draft, id, theta), ('turn', id)))

    def drag_handle(self, id: int, at_origin: bool, x: float, y: float) -> None:
        """Moves a control point of a spline."""
        self._tried(lambda: self._change(
            f'bend edge {id}', editing.move_handle(self.draft, id, at_origin, x, y),
            ('bend', id, at_origin)))

    def end_drag(self) -> None:
        """Ends a drag, because the mouse button was released."""
        self.history.end_gesture()

    # Menus and fields

    def do(self, action: Action, kind: str, id: int, argument: float = 0.0) -> None:
        """Does an action of the menu of a vertex or edge."""
        if action in _ANYWHERE:
            _ANYWHERE[action](self, argument)
        elif action in CHANGES:
            self._tried(lambda: self._change(
                f'{action.value.split(":")[0].lower()}, {kind} {id}',
                CHANGES[action](self.draft, id, argument)))
        elif action is Action.CONNECT:
            self._tried(lambda: self._connect_from(id))
        elif action is Action.CONNECT_HERE:
            if self.connecting_from is None:
                self.say('First choose "Connect from here" at another vertex')
            else:
                self.click_vertex(id)

    def _connect_from(self, id: int) -> None:
        self._choose('vertex', id, f'Click the vertex to connect {id} to, or the floor (tool '
                     'Publish Point)')
        self.connecting_from = id

    def set_fields(self, kind: str, id: int, **fields: Any) -> None:
        """Changes fields of a vertex or edge, as typed in the window."""
        change = editing.change_vertex if kind == 'vertex' else editing.change_edge
        names = ', '.join(sorted(fields))
        self._tried(lambda: self._change(f'{names} of {kind} {id}',
                                         change(self.draft, id, **fields)))

    def set_grid(self, grid: float) -> None:
        """Makes vertices snap to a grid with this pitch (m); 0: no grid."""
        self.grid = grid
        self.say(f'Vertices snap to {grid:g} m' if grid else 'Vertices snap to no grid')

    def undo(self) -> None:
        """Undoes the last change."""
        name = self.history.undo()
        self._after_step(f'Undone: {name}' if name else 'There is nothing to undo')

    def redo(self) -> None:
        """Redoes the change that was undone last."""
        name = self.history.redo()
        self._after_step(f'Redone: {name}' if name else 'There is nothing to redo')

    def save(self) -> bool:
        """Writes the file. Returns whether it was written; if not, `said` has the reason."""
        try:
            edited = self._file.edited(self.draft)
            if not self._is_unchanged_on_disk():
                self.say(f'NOT SAVED: {self._path} was changed by another program meanwhile. '
                          f'"{Action.LOAD.value}" shows that file; undo restores your changes')
                return False
            edited.save(self._path)
        except GraphError as error:
            self.say(f'NOT SAVED: {error}')
            return False
        except OSError as error:
            self.say(f'NOT SAVED: {self._path} cannot be written ({error.strerror})')
            return False
        self._file, self._is_new = edited, False
        self.say(f'Saved {self._path}')
        return True

    def take_over(self) -> None:
        """Saves the graph and puts it in force, so that robots drive on it from now on."""
        if self.is_saved or self.save():
            self.say(f'Taking over {self._path}')
            self.on_take_over(self.draft)

    def load_again(self) -> None:
        """Loads the file again. Undo restores the previous draft."""
        try:
            self._file = GraphFile.load(self._path)
        except GraphError as error:
            self.say(f'Not loaded: {error}')
            return
        self._is_new = False
        self.history.change('load again', self._file.draft)
        self._after_step(f'Loaded {self._path}')

    # Internals

    def _is_unchanged_on_disk(self) -> bool:
        if self._is_new:
            return not os.path.exists(self._path)
        try:
            with open(self._path, encoding='utf-8', newline='') as stream:
                return stream.read() == self._file.text
        except (OSError, UnicodeDecodeError):
            return not os.path.exists(self._path)

    def _vertex_near(self, x: float, y: float) -> Optional[int]:
        near = [(math.dist(vertex.position, (x, y)), id)
                for id, vertex in self.draft.vertices.items()]
        distance, id = min(near)
        return id if distance <= ON_VERTEX else None

    def nearest_edge(self, place: Tuple[float, float], ids: Iterable[int],
                     reach: float = math.inf) -> Optional[int]:
        """Returns the id, out of `ids`, of the edge nearest to a place; None: none is within
        `reach` m.

        For an edge without length, the distance to its origin counts.
        """
        best: Tuple[float, Optional[int]] = (reach, None)
        for id in ids:
            edge = self.draft.edge(id)
            try:
                distance = self.draft.curve(id).project(*place).distance
            except GraphError:
                distance = math.dist(self.draft.vertices[edge.origin].position, place)
                if reach < math.inf:
                    continue  # an edge without length cannot be cut
            if distance <= best[0]:
                best = distance, id
        return best[1]

    def _choose(self, kind: str, id: int, words: str) -> None:
        """Selects the clicked element; raises EditError if it no longer exists."""
        if kind == 'vertex':
            self.draft.vertex(id)
        else:
            self.draft.edge(id)
        self._select(kind, id)
        self.say(words)

    def _select(self, kind: str, id: int) -> None:
        self.selected = Selected(kind, id)
        self.version += 1

    def say(self, words: str) -> None:
        """Sets the message for the person at the screen."""
        self.said = words
        self.version += 1

    def _tried(self, edit: Callable[[], None]) -> None:
        try:
            edit()
        except (EditError, GraphError) as error:
            self.say(f'Not done: {error}')

    def _change(self, name: str, draft: Draft, gesture: object = None) -> None:
        if self.history.change(name, draft, gesture):
            self._after_step(name[0].upper() + name[1:])
        elif gesture is None:
            self.say(f'Nothing has changed: {name}')

    def _after_step(self, words: str) -> None:
        """Clears references to elements that no longer exist, and sets the message."""
        draft = self.draft
        if self.connecting_from not in draft.vertices:
            self.connecting_from = None
        if self.selected is not None:
            there = draft.vertices if self.selected.kind == 'vertex' else draft.edges
            if self.selected.id not in there:
                self.selected = None
        self.say(words)


_ANYWHERE: Dict[Action, Callable[[EditingSession, float], object]] = {
    Action.UNDO: lambda session, _: session.undo(),
    Action.REDO: lambda session, _: session.redo(),
    Action.SAVE: lambda session, _: session.save(),
    Action.TAKE_OVER: lambda session, _: session.take_over(),
    Action.LOAD: lambda session, _: session.load_again(),
    Action.GRID: EditingSession.set_grid,
}
