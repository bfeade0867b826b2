"""The robots of a fleet in RViz: body, name, state, mission, and the reason why they wait."""
from __future__ import annotations

import math
import textwrap
from dataclasses import dataclass
from typing import Dict, List, Optional, Tuple

import rospy
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker

from fleet_core.supervision.fleet_view import (
    ASKS,
    LOAD_MOVES,
    LOAD_WORDS,
    WORKING,
    RobotState,
)
from fleet_core.supervision.looks import ResourceLook
from fleet_core.supervision.missions import short_name
from fleet_core.supervision.waits import WaitCode
from fleet_core.work.tables import LoadState
from graph_fleet_manager.messages.missions import LOAD_OF_CODE
from graph_fleet_manager.nodes.rviz.paints import LOAD, PAINTS
from itrci_nav_msgs.msg import FleetRobot
from rviz_drawing import drawing
from rviz_drawing.label_places import Label
from trajectory_graph import Graph

GREY, RED = drawing.colour(0.62, 0.62, 0.62), drawing.colour(1.0, 0.25, 0.2)
DARK, WHITE = drawing.colour(0.1, 0.1, 0.12), drawing.colour(1.0, 1.0, 1.0)
LIFETIME = 3.0  # s after which RViz removes the markers, so that none remain when the node ends
TEXT_HEIGHT = 0.42
LONGEST_TEXT = 120  # characters
MOVED_ALPHA = 0.5  # alpha of a load's paint while a step takes or gives the load
WORDS_SATURATION = 0.4  # lighter than the body, to be readable on a dark map
_STATES: Dict[int, RobotState] = {int(state): state for state in RobotState}
_TROUBLE = frozenset((FleetRobot.STOPPED, FleetRobot.TAKEN_OVER, FleetRobot.FAILED,
                      FleetRobot.OFF_GRAPH))
#: States whose word needs no reason beside it.
_SAID = frozenset((FleetRobot.OFFLINE, FleetRobot.OUT_OF_SERVICE))
WAIT_WIDTH, WAIT_LINES = 24, 2  # size of the reason to wait: characters per line, lines
ASK_LINES = 6  # lines of that reason if the robot waits for a person


@dataclass(frozen=True)
class DrawnPose:
    """Where a robot is: x, y (m) and heading (rad)."""

    x: float
    y: float
    heading: float


def place_on_graph(robot: FleetRobot, graph: Graph) -> Optional[DrawnPose]:
    """Returns the robot's pose from its edge and percentage; None if it is off the graph."""
    edge = robot.pose.edge_id
    if abs(edge) not in graph.edges or not math.isfinite(robot.pose.percentage):
        return None
    curve = graph.curve(edge)
    s = curve.length * min(max(robot.pose.percentage, 0.0), 100.0) / 100.0
    return DrawnPose(*curve.point_at(s), curve.heading_at(s))


def label_of(robot: FleetRobot, place: DrawnPose, radius: float, now: float) -> Label:
    """Returns the label of a robot with a body of this radius (m); `now` in s of the ROS clock."""
    return Label(place.x, place.y, radius, words_of(robot, now), TEXT_HEIGHT)


def robot_markers(robot: FleetRobot, number: int, place: DrawnPose, label: Label, side: int,
                  chosen: bool) -> List[Marker]:
    """Returns the markers of one robot.

    `number` selects its colour, `side` is an index in ABOVE_FIRST.
    """
    radius = label.radius
    gone = robot.state in (FleetRobot.OFFLINE, FleetRobot.OUT_OF_SERVICE)
    paint = GREY if gone else drawing.own_colour(number)
    here = place.x, place.y
    length, width = 1.55 * radius, 1.15 * radius
    body = drawing.shape(Marker.CUBE, 'bodies', number, paint, (length, width, 0.3),
                         drawing.pose_at(here, place.heading, 0.2))
    nose = drawing.shape(Marker.ARROW, 'noses', number, DARK, (length * 0.8, width * 0.45, 0.05),
                         drawing.pose_at(_along(place, -0.4 * length), place.heading, 0.4))
    trouble = robot.state in _TROUBLE or needs_person(robot)
    words = drawing.text('names', number, label.words[:2 * LONGEST_TEXT], label.middle(side),
                         label.height, RED if trouble else GREY if gone else
                         drawing.own_colour(number, WORDS_SATURATION), 1.5)
    markers = [body, nose, words]
    if robot.load != FleetRobot.LOAD_EMPTY:
        size = 0.6 * width
        markers.append(drawing.shape(
            Marker.CUBE, 'loads', number, _paint_of_load(robot), (size, size, 0.2),
            drawing.pose_at(_along(place, -0.25 * length), place.heading, 0.45)))
    outline = drawing.lines('outlines', number, RED if trouble else WHITE, 0.08,
                            [drawing.ring(here, radius + 0.12)] if trouble or chosen else [], 0.3)
    markers.append(outline)
    for marker in markers:
        marker.lifetime = rospy.Duration(LIFETIME)
    return markers


def words_of(robot: FleetRobot, now: float) -> str:
    """Returns the text of a robot's label: name and battery, activity,
    and the reason why it waits.
    """
    charge = '' if math.isnan(robot.battery) else f'  {100.0 * robot.battery:.0f} %'
    state = _STATES.get(robot.state)
    doing = '' if state is None else state.words_with(robot.waits_for_code)
    if robot.state == FleetRobot.BUSY and robot.destination and doing != ASKS:
        doing = f'{WORKING} at' if doing == WORKING else 'to'
        doing += f' {robot.destination}'
    elif robot.state == FleetRobot.OFFLINE and robot.seen.to_sec() > 0.0:
        doing += f' for {_duration(now - robot.seen.to_sec())}'
    lines = [robot.name + charge, doing, *load_words(robot)]
    if (robot.waits_for and robot.state not in _SAID
            and robot.waits_for_code != WaitCode.RESUME_FLEET):  # the frame shows the stop
        lines += textwrap.wrap(f'({robot.waits_for})', WAIT_WIDTH, placeholder=' ...',
                               max_lines=ASK_LINES if needs_person(robot) else WAIT_LINES)
    return '\n'.join(lines)


def needs_person(robot: FleetRobot) -> bool:
    """Returns whether a step waits for an answer, or a person must look at the load."""
    return robot.waits_for_code == WaitCode.PERSON or (
        robot.load == FleetRobot.LOAD_UNKNOWN and not _moves_load(robot))


def _moves_load(robot: FleetRobot) -> bool:
    """Returns whether a step takes or gives the load now, so that no person has to look at it."""
    return bool(robot.load == FleetRobot.LOAD_UNKNOWN and robot.waits_for_code == WaitCode.STEP)


def _paint_of_load(robot: FleetRobot) -> ColorRGBA:
    if _moves_load(robot):
        return ColorRGBA(LOAD.r, LOAD.g, LOAD.b, MOVED_ALPHA)
    return LOAD if robot.load == FleetRobot.LOAD_LOADED else PAINTS[ResourceLook.TROUBLE]


def load_words(robot: FleetRobot) -> List[str]:
    """Returns what a robot carries, as a line of its label; no line if it carries nothing."""
    words = LOAD_MOVES if _moves_load(robot) else LOAD_WORDS.get(
        LOAD_OF_CODE.get(robot.load, LoadState.UNKNOWN))
    if words is None:
        return []
    named = ', '.join(one for one in robot.load_types if one)
    return [words.format(mission=short_name(robot.load_serial)) + (named and f' ({named})')]


def _duration(seconds: float) -> str:
    seconds = max(seconds, 0.0)
    return f'{seconds:.0f} s' if seconds < 120.0 else f'{seconds / 60.0:.0f} min'


def _along(place: DrawnPose, distance: float) -> Tuple[float, float]:
    return (place.x + distance * math.cos(place.heading),
            place.y + distance * math.sin(place.heading))
