"""Handles in RViz: a left click drives to a goal or dock, the right button opens a menu.

A left click on the handle of the robot stops it. The handles only report the requested action;
their owner decides whether it is carried out.
"""
from __future__ import annotations

import enum
import math
from typing import Callable, Dict, Iterable, Optional

from interactive_markers.menu_handler import MenuHandler
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import (
    InteractiveMarker,
    InteractiveMarkerControl,
    InteractiveMarkerFeedback,
    Marker,
)

from node_lifecycle.marker_server import OrderedMarkerServer
from omron_ld90.operator.goal_clicks import Target, TargetKind
from rviz_drawing import drawing

ROBOT_HANDLE = 'robot'
HANDLE_COLOURS = {
    TargetKind.GOAL: drawing.colour(0.2, 0.85, 0.3, 0.3),
    TargetKind.DOCK: drawing.colour(0.2, 0.75, 0.85, 0.4),
}
HANDLE_Z = 0.1  # m: above the square and the ring, so that the mouse finds the handle
STOP_SIZE, STOP_Z = 1.1, 0.6  # m; the handle is wide, because the robot moves
STOP_COLOUR = drawing.colour(1.0, 0.15, 0.1, 0.14)


class HandleAction(enum.Enum):
    """An action that a handle can request; the value is the text in the menu."""

    GO = 'Go here'
    DOCK = 'Dock'
    UNDOCK = 'Undock'
    STOP = 'Stop'
    LOCALIZE = 'The robot is here (localize)'


LEFT_CLICK = {TargetKind.GOAL: HandleAction.GO, TargetKind.DOCK: HandleAction.DOCK}
MENUS = {
    TargetKind.GOAL: (HandleAction.GO, HandleAction.STOP, HandleAction.LOCALIZE),
    TargetKind.DOCK: (HandleAction.DOCK, HandleAction.UNDOCK, HandleAction.STOP,
                      HandleAction.LOCALIZE),
}
"""Localizing comes last, away from driving: if chosen by mistake, it gives a wrong pose."""
ROBOT_MENU = (HandleAction.STOP, HandleAction.DOCK, HandleAction.UNDOCK)


class InteractiveGoals:
    """The handles of one robot, on `interactive_goals/update` and `/feedback`.

    `act(action, target)` is called once for each click or menu choice; `target` is None for the
    handle of the robot itself. Handles of different robots have different `size` (diameter, m): on
    each goal, the smaller handles lie on the larger ones.
    """

    def __init__(self, map_frame: str, base_frame: str, size: float,
                 act: Callable[[HandleAction, Optional[Target]], None]) -> None:
        self._map_frame, self._base_frame, self._size = map_frame, base_frame, size
        self._robot = base_frame.split('/')[0]
        self._act = act
        self._server = OrderedMarkerServer('interactive_goals')
        self._menus: Dict[str, MenuHandler] = {}

    def show(self, targets: Iterable[Target]) -> None:
        """Replaces all handles except the robot's with handles for `targets`."""
        for name in [name for name in self._menus if name != ROBOT_HANDLE]:
            self._remove(name)
        height = HANDLE_Z * (1.0 + math.exp(-self._size))
        for index, target in enumerate(targets):
            marker = InteractiveMarker(name=f'{target.kind.value} {index}', scale=self._size)
            marker.header.frame_id = self._map_frame
            marker.pose.position.x, marker.pose.position.y = target.x, target.y
            marker.pose.orientation.w = 1.0
            disc = _flat(Marker.CYLINDER, self._size, height, HANDLE_COLOURS[target.kind])
            self._insert(marker, [disc], LEFT_CLICK[target.kind], MENUS[target.kind], target)
        self._server.applyChanges()

    def show_robot(self, visible: bool) -> None:
        """Puts the stop handle on the robot, or removes it."""
        if visible == (ROBOT_HANDLE in self._menus):
            return
        if visible:
            marker = InteractiveMarker(name=ROBOT_HANDLE, scale=1.0)
            marker.header.frame_id = self._base_frame  # stamp 0: follows the robot
            marker.pose.orientation.w = 1.0
            sign = _flat(Marker.CYLINDER, STOP_SIZE, STOP_Z, STOP_COLOUR)
            self._insert(marker, [sign], HandleAction.STOP, ROBOT_MENU, None)
        else:
            self._remove(ROBOT_HANDLE)
        self._server.applyChanges()

    def _insert(self, marker: InteractiveMarker, shapes: list, left_click: HandleAction,
                menu: tuple, target: Optional[Target]) -> None:
        control = InteractiveMarkerControl(
            name='button', interaction_mode=InteractiveMarkerControl.BUTTON, always_visible=True,
            markers=shapes, description=f'{self._robot}: {left_click.value} {target or ""}')
        marker.controls.append(control)

        def on_feedback(feedback: InteractiveMarkerFeedback) -> None:
            # A click also sends MOUSE_DOWN, MOUSE_UP and other events: only BUTTON_CLICK counts.
            if feedback.event_type == InteractiveMarkerFeedback.BUTTON_CLICK:
                self._act(left_click, target)

        self._server.insert(marker, on_feedback)
        handler = MenuHandler()
        for action in menu:
            handler.insert(
                action.value, callback=lambda _feedback, chosen=action: self._act(chosen, target))
        handler.apply(self._server, marker.name)
        self._menus[marker.name] = handler

    def _remove(self, name: str) -> None:
        self._server.erase(name)
        del self._menus[name]


def _flat(kind: int, size: float, z: float, paint: ColorRGBA) -> Marker:
    marker = Marker(type=kind, color=paint, pose=drawing.pose_at((0.0, 0.0), z=z))
    marker.scale.x, marker.scale.y, marker.scale.z = size, size, 0.01
    return marker
