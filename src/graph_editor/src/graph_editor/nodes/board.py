"""Keeps the handles in RViz consistent with the session, and changes as few handles as possible.

While a vertex is dragged, the handle of its group contains no other vertices, because RViz moves
the whole handle with the mouse.
"""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import (
    Any,
    Callable,
    ContextManager,
    Dict,
    List,
    Mapping,
    Optional,
    Sequence,
    Tuple,
)

from geometry_msgs.msg import Point
from visualization_msgs.msg import InteractiveMarker, InteractiveMarkerFeedback

from graph_editor.checking.findings import Finding, Severity
from graph_editor.editor.session import EditingSession
from graph_editor.nodes import handles
from graph_editor.nodes.finding_words import finding_text
from graph_editor.nodes.handles import PLAIN, Look, ShownEdge, ShownVertex
from node_lifecycle.marker_server import OrderedMarkerServer
from rviz_drawing.text_places import TextPlaces, VertexText
from trajectory_graph import CurveType

NAMESPACE = 'graph_editor'
MOVED = 0.02  # m; a shorter movement of the mouse is a click and not a drag
Key = Tuple[str, int]
Shown = Any
"""The contents of a handle. When they change, the handle is drawn anew."""


@dataclass
class Grabbed:
    """The handle that the mouse holds."""

    handle: str
    vertex: Optional[int] = None
    start: Tuple[float, float] = (0.0, 0.0)
    """The position of the vertex before the drag, m."""
    handle_start: Tuple[float, float] = (0.0, 0.0)
    moved: Tuple[float, float] = (0.0, 0.0)
    """The distance (x, y) by which the mouse has moved so far, m."""
    dragged: bool = False


class Board:
    """The handles of one session; the caller holds the session's lock."""

    def __init__(self, session: EditingSession, lock: ContextManager,
                 changed: Callable[[], None]) -> None:
        """`changed` is called after each action of a person in RViz, with the lock held."""
        self._session = session
        self._lock = lock
        self._changed = changed
        self._server = OrderedMarkerServer(NAMESPACE)
        self._shown: Dict[str, Shown] = {}
        self._texts = TextPlaces()
        self._finding_texts: List[Optional[VertexText]] = []
        self._severities: Dict[Key, Optional[Severity]] = {}
        self._grabbed: Optional[Grabbed] = None

    @property
    def is_dragging(self) -> bool:
        """Whether a handle is being dragged now."""
        return self._grabbed is not None and self._grabbed.dragged

    @property
    def finding_places(self) -> List[Optional[Tuple[float, float]]]:
        """The middle of each finding's text (m), as `show` placed it; None: the text is not shown.
        """
        return [None if text is None else self._texts.middle(('finding', number))
                for number, text in enumerate(self._finding_texts)]

    def mark(self, findings: Sequence[Finding]) -> None:
        """Sets the findings that are marked from now on."""
        self._severities = {}
        self._finding_texts = [finding_text(finding) for finding in findings]
        for finding in findings:
            if finding.id is not None:
                key = finding.kind, finding.id
                if self._severities.get(key) is not Severity.ERROR:
                    self._severities[key] = finding.severity

    def show(self, own_severities: Mapping[Key, Optional[Severity]]) -> None:
        """Updates RViz.

        own_severities -- the severities of elements that have just changed
        """
        draft = self._session.draft
        wanted: Dict[str, Shown] = {}
        looks = self._looks({**self._severities, **own_severities})
        self._show_vertices(wanted, looks['vertex'])
        groups: Dict[int, List[ShownEdge]] = {}
        for edge in draft.edges.values():
            groups.setdefault(handles.edge_group(edge.id), []).append(ShownEdge(
                edge, draft.vertices[edge.origin], draft.vertices[edge.destination],
                looks['edge'].get(edge.id, PLAIN)))
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

    def _show_vertices(self, wanted: Dict[str, Shown], looks: Mapping[int, Look]) -> None:
        groups: Dict[int, List[ShownVertex]] = {}
        vertices = self._session.draft.vertices
        ids = {('id', id): handles.id_text(vertex) for id, vertex in vertices.items()}
        labels = {('label', id): text for id, vertex in vertices.items()
                  for text in (handles.label_text(vertex),) if text is not None}
        self._texts.show({**ids, **labels, **{
            ('finding', number): text for number, text in enumerate(self._finding_texts)
            if text is not None}})
        for vertex in vertices.values():
            label = ('label', vertex.id)
            groups.setdefault(handles.vertex_group(vertex.id), []).append(ShownVertex(
                vertex, looks.get(vertex.id, PLAIN), self._texts.middle(('id', vertex.id)),
                self._texts.middle(label) if label in labels else None))
        for group, ones in groups.items():
            drawn, name = f'{handles.DRAWN} {group}', f'{handles.VERTICES} {group}'
            wanted[drawn] = ones
            if self._shown.get(drawn) != ones:
                self._insert(handles.drawn_vertices(group, ones))
            grabbed = self._grabbed
            if grabbed is not None and grabbed.handle == name:
                places, moved = [grabbed.start], grabbed.moved
            else:
                places, moved = [one.vertex.position for one in ones], (0.0, 0.0)
            wanted[name] = places
            if self._shown.get(name) != places:
                self._insert(handles.vertices_handle(group, places, moved))

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

    def _looks(self, severities: Mapping[Key, Optional[Severity]]) -> Dict[str, Dict[int, Look]]:
        """Returns the looks that are not plain, by kind and id of their elements."""
        looks: Dict[str, Dict[int, Look]] = {'vertex': {}, 'edge': {}}
        for (kind, id), severity in severities.items():
            if severity is not None:
                looks[kind][id] = Look(severity)
        selected, waiting = self._session.selected, self._session.connecting_from
        if selected is not None:
            of_kind = looks[selected.kind]
            of_kind[selected.id] = of_kind.get(selected.id, PLAIN)._replace(selected=True)
        if waiting is not None:
            look = looks['vertex'].get(waiting, PLAIN)
            looks['vertex'][waiting] = look._replace(waiting=True)
        return looks

    def _insert(self, marker: InteractiveMarker) -> None:
        self._server.insert(marker, self._on_feedback)

    def _on_feedback(self, feedback: InteractiveMarkerFeedback) -> None:
        with self._lock:
            self._handle(feedback)

    def _handle(self, feedback: InteractiveMarkerFeedback) -> None:
        kind = feedback.event_type
        if kind == InteractiveMarkerFeedback.MOUSE_DOWN:
            self._grab(feedback)
            return
        if kind == InteractiveMarkerFeedback.POSE_UPDATE:
            if not self._drag(feedback):
                return
        elif kind == InteractiveMarkerFeedback.MOUSE_UP:
            clicked = not self.is_dragging
            if not clicked and self._grabbed is not None and self._grabbed.vertex is not None:
                self._shown.pop(feedback.marker_name, None)  # RViz has moved the handle
            self._grabbed = None
            self._session.end_drag()
            if clicked:
                self._click(*self._meant(feedback))
        elif kind == InteractiveMarkerFeedback.MENU_SELECT:
            self._choose(*self._meant(feedback), feedback.menu_entry_id)
        else:
            return
        self._changed()

    def _grab(self, feedback: InteractiveMarkerFeedback) -> None:
        self._grabbed = Grabbed(feedback.marker_name,
                                handle_start=_place_of(feedback.pose.position))
        what, id = self._meant(feedback)
        if what == 'vertex' and id in self._session.draft.vertices:
            self._grabbed.vertex = id
            self._grabbed.start = self._session.draft.vertices[id].position

    def _drag(self, feedback: InteractiveMarkerFeedback) -> bool:
        """Moves the held element with the mouse. Returns False as long as the movement is too short
        for a drag.
        """
        grabbed, selected = self._grabbed, self._session.selected
        if grabbed is None or grabbed.handle != feedback.marker_name:
            return False
        place = x, y = _place_of(feedback.pose.position)
        moved = x - grabbed.handle_start[0], y - grabbed.handle_start[1]
        if not grabbed.dragged and math.hypot(*moved) < MOVED:
            return False
        grabbed.moved, grabbed.dragged = moved, True
        if grabbed.vertex is not None:
            self._session.drag_vertex(grabbed.vertex, grabbed.start[0] + moved[0],
                                      grabbed.start[1] + moved[1])
        elif selected is not None and grabbed.handle == handles.TURNER:
            self._session.drag_heading(selected.id, *place)
        elif selected is not None and grabbed.handle in handles.BENDERS:
            self._session.drag_handle(selected.id, grabbed.handle == handles.BENDERS[0], *place)
        return True

    def _meant(self, feedback: InteractiveMarkerFeedback) -> Tuple[str, int]:
        """Returns kind and id of the element under the mouse.

        If the handle stands for several elements, this is the one nearest to the mouse.
        """
        what, _, group = feedback.marker_name.rpartition(' ')
        place = _place_of(feedback.mouse_point)
        if what == handles.EDGES:
            edges = self._shown.get(feedback.marker_name, ())
            return 'edge', self._session.nearest_edge(place, [one.edge.id for one in edges]) or 0
        if what == handles.VERTICES:
            vertices = [one.vertex for one in self._shown.get(f'{handles.DRAWN} {group}', ())]
            return 'vertex', min(((math.dist(vertex.position, place), vertex.id)
                                  for vertex in vertices), default=(0.0, 0))[1]
        return what, 0

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


def _place_of(point: Point) -> Tuple[float, float]:
    return point.x, point.y
