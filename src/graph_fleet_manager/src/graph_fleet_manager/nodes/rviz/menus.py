"""Handles in RViz with menus: vertices, edges, robots, and a button that stops the whole fleet."""
from __future__ import annotations

import enum
from typing import Callable, Dict, Iterable, List, Mapping, NamedTuple, Optional, Tuple

from interactive_markers.menu_handler import MenuHandler
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import (
    InteractiveMarker,
    InteractiveMarkerControl,
    InteractiveMarkerFeedback,
    Marker,
)

from graph_fleet_manager.nodes.rviz.graph_picture import is_place
from graph_fleet_manager.nodes.rviz.robot_picture import DrawnPose
from node_lifecycle.marker_server import OrderedMarkerServer
from rviz_drawing import drawing
from trajectory_graph import Graph

VERTEX_SIZE, EDGE_SIZE, ROBOT_SIZE = 0.6, 0.3, 1.2  # m, diameters
VERTEX_PAINT = drawing.colour(0.6, 0.65, 0.8, 0.12)
EDGE_PAINT = drawing.colour(0.7, 0.7, 0.75, 0.25)
ROBOT_PAINT = drawing.colour(1.0, 1.0, 1.0, 0.05)
STOP_PAINT, RESUME_PAINT = drawing.colour(0.85, 0.1, 0.1), drawing.colour(0.15, 0.55, 0.25)
BUTTON = (2.6, 0.8)  # m
MOVED = 0.02         # m; a handle follows its robot in steps of at least this length
BUTTON_ABOVE = 2.4  # m from the graph to the buttons above it


class MenuAct(enum.Enum):
    """An entry of a menu; the value is its text."""

    SEND_ANY = 'Send a robot here'
    SEND_CHOSEN = 'Send the chosen robot here'
    CLOSE = 'Close'
    OPEN = 'Open'
    OPEN_ALL = 'Open all edges'
    CHOOSE = 'Choose (for "Send the chosen robot here")'
    CANCEL = 'Cancel its mission'
    PAUSE = 'Pause its mission'
    RESUME = 'Go on with its mission'
    RELEASE = 'End its stay'
    OUT = 'Stop it, and take it out of service'
    IN = 'Put it back into service'
    ABSENT = 'It is not on the site (absent)'
    RETRY = 'Do it again'
    SKIP = 'It was not done: go on without it'
    DONE = 'It was done: go on'
    FAIL = 'The mission fails'
    STOP_ALL = 'Stop all robots'
    RESUME_ALL = 'Let all robots go on'


VERTEX_MENU = (MenuAct.SEND_ANY, MenuAct.SEND_CHOSEN, MenuAct.STOP_ALL)
EDGE_MENU = (MenuAct.CLOSE, MenuAct.OPEN, MenuAct.OPEN_ALL)
ROBOT_MENU = (MenuAct.CHOOSE, MenuAct.CANCEL, MenuAct.PAUSE, MenuAct.RESUME, MenuAct.RELEASE,
              MenuAct.OUT, MenuAct.IN, MenuAct.ABSENT, MenuAct.STOP_ALL)


ANSWERS = (MenuAct.RETRY, MenuAct.SKIP, MenuAct.DONE, MenuAct.FAIL)
"""The answers to a step. While a step waits for an answer, its robot's menu offers them."""
ANSWER = 'Answer its step'


class Subject(NamedTuple):
    """The object of a handle: a vertex, a drawn edge or a robot; without these, the whole fleet.

    step -- key of the step that an answer is about
    """

    vertex: int = 0
    edge: int = 0
    robot: str = ''
    step: int = 0


class Ask(NamedTuple):
    """A step that waits for an answer, and the possible answers."""

    step: int
    answers: Tuple[MenuAct, ...]


class _AnswerMenu(NamedTuple):
    """The entries for answers in the menu of a robot.

    entries -- numbers of the entries. Entries for an earlier step stay in the menu, but hidden. So
               a click in a menu that was opened during the earlier step cannot answer a later step
    """

    top: int
    ask: Optional[Ask] = None
    entries: Tuple[int, ...] = ()


class FleetMenus:
    """The handles, on `/fleet_menus/update` and `/fleet_menus/feedback`.

    act -- is called for each choice in a menu
    """

    def __init__(self, act: Callable[[MenuAct, Subject], None]) -> None:
        self._act = act
        self._server = OrderedMarkerServer('/fleet_menus', q_size=10)
        self._menus: Dict[str, MenuHandler] = {}
        self._robots: Dict[str, DrawnPose] = {}
        self._answers: Dict[str, _AnswerMenu] = {}

    def show_graph(self, graph: Graph) -> None:
        """Shows the buttons and the handles of vertices and edges, and removes all earlier buttons
        and handles.
        """
        for name in [name for name in self._menus if not name.startswith('robot ')]:
            self._remove(name)
        for vertex in graph.vertices.values():
            if is_place(graph, vertex.id):
                self._insert(f'vertex {vertex.id}', vertex.position, [
                    _disc(VERTEX_SIZE, 0.06, VERTEX_PAINT)], VERTEX_MENU, Subject(vertex.id))
        for id in graph.edges:
            curve = graph.curve(id)
            self._insert(f'edge {id}', curve.point_at(curve.length / 2.0), [
                _disc(EDGE_SIZE, 0.07, EDGE_PAINT)], EDGE_MENU,
                Subject(edge=graph.edges[id].drawn_id))
        left = min(vertex.x for vertex in graph.vertices.values())
        top = max(vertex.y for vertex in graph.vertices.values()) + BUTTON_ABOVE
        for number, (act, words, paint) in enumerate((
                (MenuAct.STOP_ALL, 'STOP ALL', STOP_PAINT),
                (MenuAct.RESUME_ALL, 'GO ON', RESUME_PAINT))):
            self._insert(f'button {words}', (left + (BUTTON[0] + 0.3) * number, top),
                         _button(words, paint), (act,), Subject(), act)
        self._server.applyChanges()

    def show_robots(self, places: Mapping[str, DrawnPose], asks: Mapping[str, Ask]) -> None:
        """Shows handles at the present poses of these robots, and removes those of other robots.

        asks -- the step that waits for an answer in each robot's mission, by robot
        """
        changed = False
        for name in [name for name in self._robots if name not in places]:
            del self._robots[name], self._answers[name]
            self._remove(f'robot {name}')
            changed = True
        for name, place in places.items():
            before = self._robots.get(name)
            if before is None:
                self._insert(f'robot {name}', (place.x, place.y), [
                    _disc(ROBOT_SIZE, 0.45, ROBOT_PAINT)], ROBOT_MENU, Subject(robot=name),
                    MenuAct.CHOOSE)
                self._answers[name] = self._no_answers(name)
            elif max(abs(before.x - place.x), abs(before.y - place.y)) > MOVED:
                self._server.setPose(f'robot {name}', drawing.pose_at((place.x, place.y)))
            else:
                continue
            self._robots[name] = place
            changed = True
        for name in places:
            changed |= self._offer(name, asks.get(name))
        if changed:
            self._server.applyChanges()

    def _no_answers(self, name: str) -> _AnswerMenu:
        handler = self._menus[f'robot {name}']
        top = handler.insert(ANSWER, callback=lambda _feedback: None)
        handler.setVisible(top, False)
        return _AnswerMenu(top)

    def _offer(self, name: str, ask: Optional[Ask]) -> bool:
        """Offers the answers to a step in the menu of a robot. Returns whether the menu changed."""
        shown, handler = self._answers[name], self._menus[f'robot {name}']
        if shown.ask == ask:
            return False
        for entry in shown.entries:
            handler.setVisible(entry, False)
        handler.setVisible(shown.top, ask is not None)
        entries = () if ask is None else tuple(
            handler.insert(act.value, parent=shown.top,
                           callback=self._chosen(act, Subject(robot=name, step=ask.step)))
            for act in ask.answers)
        self._answers[name] = _AnswerMenu(shown.top, ask, entries)
        handler.reApply(self._server)
        return True

    def _insert(self, name: str, place: Tuple[float, float], shapes: List[Marker],
                menu: Iterable[MenuAct], subject: Subject,
                left_click: Optional[MenuAct] = None) -> None:
        marker = InteractiveMarker(name=name, scale=1.0, pose=drawing.pose_at(place))
        marker.header.frame_id = drawing.FRAME
        for part in shapes:
            part.header.frame_id = ''  # relative to the handle
        marker.controls.append(InteractiveMarkerControl(
            name='menu', always_visible=True, markers=shapes,
            interaction_mode=(InteractiveMarkerControl.BUTTON if left_click
                              else InteractiveMarkerControl.MENU)))

        def on_feedback(feedback: InteractiveMarkerFeedback) -> None:
            if left_click and feedback.event_type == InteractiveMarkerFeedback.BUTTON_CLICK:
                self._act(left_click, subject)

        self._server.insert(marker, on_feedback)
        handler = MenuHandler()
        for act in menu:
            handler.insert(act.value, callback=self._chosen(act, subject))
        handler.apply(self._server, name)
        self._menus[name] = handler

    def _chosen(self, act: MenuAct,
                subject: Subject) -> Callable[[InteractiveMarkerFeedback], None]:
        return lambda _feedback: self._act(act, subject)

    def _remove(self, name: str) -> None:
        self._server.erase(name)
        del self._menus[name]


def _disc(size: float, z: float, paint: ColorRGBA) -> Marker:
    return drawing.shape(Marker.CYLINDER, '', 0, paint, (size, size, 0.02),
                         drawing.pose_at((0.0, 0.0), z=z))


def _button(words: str, paint: ColorRGBA) -> List[Marker]:
    middle = BUTTON[0] / 2.0, 0.0
    return [drawing.shape(Marker.CUBE, '', 0, paint, (*BUTTON, 0.05), drawing.pose_at(middle)),
            drawing.text('', 0, words, middle, 0.45, drawing.colour(1.0, 1.0, 1.0), z=0.2)]
