"""The editor's board in RViz: keeps the handles there true to the session, changing few at a time.

What is being dragged is never replaced under the mouse: only its pose is corrected.
"""
from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, Callable, ContextManager, Dict, Iterable, List, Mapping, Optional, Tuple

from visualization_msgs.msg import InteractiveMarker, InteractiveMarkerFeedback

from graph_editor.checking.findings import Finding, Severity
from graph_editor.editor.session import Session
from graph_editor.nodes import drawing, handles
from graph_editor.nodes.handles import Look, ShownEdge
from graph_editor.nodes.marker_server import OrderedMarkerServer
from trajectory_graph import CurveType, Vertex

NAMESPACE = 'graph_editor'
MOVED = 0.02  # m that the mouse must move a vertex by, for a drag and no click
Key = Tuple[str, int]
Shown = Any
"""What a handle shows; it is drawn anew when that is another."""


class Board:
    """The handles of one session; whoever calls it holds the session's lock."""

    def __init__(self, session: Session, lock: ContextManager, changed: Callable[[], None]) -> None:
        """`changed` is called after what a person did in RViz, with the lock held."""
        self._session = session
        self._lock = lock
        self._changed = changed
        self._server = OrderedMarkerServer(NAMESPACE)
        self._shown: Dict[str, Shown] = {}
        self._severities: Dict[Key, Severity] = {}
        self._grabbed: Optional[str] = None
        self._grabbed_at = (0.0, 0.0)
        self._dragged = False

    @property
    def is_dragging(self) -> bool:
        """Is a handle being dragged now?"""
        return self._dragged

    def mark(self, findings: Iterable[Finding]) -> None:
        """From now on these are wrong."""
        self._severities = {}
        for finding in findings:
            if finding.id is not None:
                key = finding.kind, finding.id
                if self._severities.get(key) is not Severity.ERROR:
                    self._severities[key] = finding.severity

    def show(self, own_severities: Mapping[Key, Optional[Severity]]) -> None:
        """Brings RViz up to date; the severities are those of elements that changed just now."""
        draft = self._session.draft
        wanted: Dict[str, Shown] = {}
        for vertex in draft.vertices.values():
            name = handles.vertex_name(vertex.id)
            look = self._look('vertex', vertex.id, own_severities)
            wanted[name] = vertex, look
            shown = self._shown.get(name)
            if shown == wanted[name]:
                continue
            if name == self._grabbed or (shown is not None and shown[1] == look and _same_but_place(
                    shown[0], vertex)):
                self._server.setPose(name, drawing.pose_at(*vertex.position))
                if name == self._grabbed:
                    wanted[name] = shown  # what else changed is drawn when it is let go
                    continue
            else:
                self._insert(handles.vertex_handle(vertex, look))
        groups: Dict[int, List[ShownEdge]] = {}
        for edge in draft.edges.values():
            look = self._look('edge', edge.id, own_severities)
            groups.setdefault(handles.edge_group(edge.id), []).append(ShownEdge(
                edge, draft.vertices[edge.origin], draft.vertices[edge.destination], look))
        for group, edges in groups.items():
            name = f'{handles.EDGES} {group}'
            wanted[name] = edges
            if self._shown.get(name) != edges:
                self._insert(handles.edges_handle(group, edges))
        self._show_handles_of_selected(wanted)
        for name in self._shown.keys() - wanted.keys():
            self._server.erase(name)
        self._shown = wanted
        self._server.applyChanges()

    def _show_handles_of_selected(self, wanted: Dict[str, Shown]) -> None:
        selected, draft = self._session.selected, self._session.draft
        markers: List[InteractiveMarker] = []
        if selected is not None and selected.kind == 'vertex':
            markers = [handles.turner(draft.vertices[selected.id])]
        elif selected is not None:
            edge = draft.edges[selected.id]
            if edge.curve_type is CurveType.SPLINE:
                markers = handles.benders(draft, edge)
        for marker in markers:
            wanted[marker.name] = selected
            if self._shown.get(marker.name) == selected:
                self._server.setPose(marker.name, marker.pose)
            else:
                self._insert(marker)

    def _look(self, kind: str, id: int, own: Mapping[Key, Optional[Severity]]) -> Look:
        selected = self._session.selected
        return Look(own.get((kind, id), self._severities.get((kind, id))),
                    selected is not None and (selected.kind, selected.id) == (kind, id),
                    kind == 'vertex' and self._session.connecting_from == id)

    def _insert(self, marker: InteractiveMarker) -> None:
        self._server.insert(marker, self._on_feedback)

    def _on_feedback(self, feedback: InteractiveMarkerFeedback) -> None:
        with self._lock:
            self._take(feedback)

    def _take(self, feedback: InteractiveMarkerFeedback) -> None:
        kind = feedback.event_type
        place = feedback.pose.position.x, feedback.pose.position.y
        if kind == InteractiveMarkerFeedback.MOUSE_DOWN:
            self._grabbed, self._grabbed_at, self._dragged = feedback.marker_name, place, False
            return
        if kind == InteractiveMarkerFeedback.POSE_UPDATE:
            if not self._dragged and math.dist(place, self._grabbed_at) < MOVED:
                return
            self._grabbed, self._dragged = feedback.marker_name, True
            self._drag(feedback.marker_name, *place)
        elif kind == InteractiveMarkerFeedback.MOUSE_UP:
            clicked = not self._dragged
            self._grabbed, self._dragged = None, False
            self._session.end_drag()
            if clicked:
                self._click(*self._meant(feedback))
        elif kind == InteractiveMarkerFeedback.MENU_SELECT:
            self._choose(*self._meant(feedback), feedback.menu_entry_id)
        else:
            return
        self._changed()

    def _drag(self, name: str, x: float, y: float) -> None:
        what, _, id = name.rpartition(' ')
        selected = self._session.selected
        if what == 'vertex':
            self._session.drag_vertex(int(id), x, y)
        elif selected is not None and name == handles.TURNER:
            self._session.drag_heading(selected.id, x, y)
        elif selected is not None and name in handles.BENDERS:
            self._session.drag_handle(selected.id, name == handles.BENDERS[0], x, y)

    def _meant(self, feedback: InteractiveMarkerFeedback) -> Tuple[str, int]:
        """Kind and id of what was clicked; of edges the one that is nearest to the mouse."""
        what, _, id = feedback.marker_name.rpartition(' ')
        if what != handles.EDGES:
            return what, int(id) if id.isdigit() else 0
        edges = self._shown.get(feedback.marker_name, ())
        place = feedback.mouse_point.x, feedback.mouse_point.y
        return 'edge', self._session.nearest_edge(place, [shown.edge.id for shown in edges]) or 0

    def _click(self, what: str, id: int) -> None:
        if what == 'vertex':
            self._session.click_vertex(id)
        elif what == 'edge':
            self._session.click_edge(id)

    def _choose(self, what: str, id: int, entry_id: int) -> None:
        actions = handles.VERTEX_ACTIONS if what == 'vertex' else handles.EDGE_ACTIONS
        entry = actions.get(entry_id)
        if entry is not None and entry.action is not None:
            self._session.do(entry.action, what, id, entry.argument)


def _same_but_place(one: Vertex, other: Vertex) -> bool:
    """Do two vertices differ in their place only?"""
    return replace(one, x=other.x, y=other.y) == other
