"""The robot's state for RViz: body, arrow, destination, and a banner above the map.

All markers have the lifetime `LIFETIME`, and are sent again before it ends. So nothing remains on
display when the robot, its link or this program has gone. Metres, in the map frame.
"""
from __future__ import annotations

import copy
import math
from typing import List, NamedTuple, Optional, Sequence, Tuple

import numpy as np
import rospy
from geometry_msgs.msg import Pose
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from omron_ld90 import robot_model
from omron_ld90.nodes.support.link_reports import words_of
from omron_ld90.nodes.support.robot_health import LOW_CHARGE
from omron_ld90_msgs.msg import LinkState, RobotStatus
from omron_map_converter import footprint
from rviz_drawing import drawing
from rviz_drawing.fast_messages import FastMarkerArray

LIFETIME = 2.5  # s
ARROW = drawing.colour(0.15, 0.4, 1.0)
DESTINATION = drawing.colour(1.0, 0.85, 0.15)
GHOST = drawing.colour(0.6, 0.6, 0.65, 0.6)
WELL = drawing.colour(0.92, 0.94, 0.97)
CARE = drawing.colour(1.0, 0.80, 0.25)
WRONG = drawing.colour(1.0, 0.38, 0.30)
GHOST_SIZE = (footprint.LENGTH, footprint.WIDTH, robot_model.HEIGHT)
ARROW_Z = robot_model.HEIGHT + 0.07  # m, on top of the body
TEXT_Z = 1.5    # m
AT_THE_DOCK = (RobotStatus.DOCKING, RobotStatus.DOCKED, RobotStatus.UNDOCKING,
               RobotStatus.UNDOCKED)


class Banner(NamedTuple):
    """A line of text and its colour."""

    text: str
    paint: ColorRGBA


def banner(robot: str, status: Optional[RobotStatus], silent_for: float,
           links: Sequence[LinkState], silence_limit: float) -> Banner:
    """Returns the name, battery, state and link of a robot in one line. If a link is down, a second
    line has the reason.

    silent_for -- seconds since the last status
    """
    if status is None:
        parts, paint = ['no status yet'], CARE
    elif silent_for > silence_limit:
        parts, paint = [f'silent for {silent_for:.0f} s'], WRONG
    else:
        parts, paint = _told(status)
    broken = [link for link in links if link.state != LinkState.CONNECTED]
    if broken:
        paint = WRONG
        parts += [f'{link.link} link {words_of(link.state)}' for link in broken]
    elif links:
        parts.append('link ok')
    reasons = [f'\n{link.reason}' for link in broken if link.reason]
    return Banner(' | '.join([robot, *parts]) + ''.join(reasons[:1]), paint)


def _told(status: RobotStatus) -> Tuple[List[str], ColorRGBA]:
    """Returns the battery and state of a robot that is heard, and their colour."""
    parts, paint = [], WELL
    if math.isfinite(status.state_of_charge):
        parts.append(f'battery {100 * status.state_of_charge:.0f} %')
        if 100 * status.state_of_charge < LOW_CHARGE:
            paint = CARE
    doing = _doing(status)
    if doing:
        parts.append(doing)
    if status.emergency_stop:
        parts.append('EMERGENCY STOP')
        paint = WRONG
    return parts, paint


def _doing(status: RobotStatus) -> str:
    """Returns the robot's status text.

    At the dock the text has four fields, so a short form is returned.
    """
    if status.activity in AT_THE_DOCK and status.docking_state:
        return f'{status.docking_state}, charger {status.charge_state}'
    return status.status


def status_markers(frame: str, words: Banner, banner_at: drawing.XY, pose: Optional[Pose],
                   alive: bool, destination: Optional[Tuple[float, float]],
                   body: Sequence[Marker] = ()) -> MarkerArray:
    """Returns the banner `words` at `banner_at`, and the robot at `pose`.

    A robot that is `alive` is shown as its body with an arrow; any other robot is shown as a grey
    box "last seen here".
    """
    markers = [drawing.text('status', 0, words.text, banner_at, 0.42, words.paint, TEXT_Z, frame)]
    if pose is not None and alive:
        arrow = drawing.shape(Marker.ARROW, 'robot', 0, ARROW, (0.9, 0.18, 0.1), frame=frame)
        arrow.pose = copy.deepcopy(pose)
        arrow.pose.position.z = ARROW_Z
        markers += [arrow, *body]
        if destination is not None:
            markers += _destination(frame, destination)
    elif pose is not None:
        ghost = drawing.shape(Marker.CUBE, 'last_seen', 0, GHOST, GHOST_SIZE, frame=frame)
        ghost.pose = copy.deepcopy(pose)
        ghost.pose.position.z = GHOST_SIZE[2] / 2
        place = (pose.position.x, pose.position.y - 0.75)
        markers += [ghost, drawing.text('last_seen_words', 0, 'last seen here', place, 0.34,
                                        WRONG, TEXT_Z, frame)]
    for marker in markers:
        marker.lifetime = rospy.Duration(LIFETIME)
    return FastMarkerArray(markers=markers)


def _destination(frame: str, place: Tuple[float, float]) -> List[Marker]:
    rings = [drawing.segments(drawing.ring(place, radius), 0.05) for radius in (0.48, 0.62)]
    return [drawing.many(Marker.LINE_LIST, 'destination', 0, DESTINATION, (0.06, 0.0, 0.0),
                         np.concatenate(rings), frame)]
