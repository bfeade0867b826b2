"""A stopped fleet in RViz: a red frame around the graph, and the person who stopped the fleet."""
from __future__ import annotations

import textwrap
from typing import List

import numpy as np
import rospy
from visualization_msgs.msg import Marker

from fleet_core.supervision.fleet_stop import FleetStop
from graph_fleet_manager.nodes.rviz.robot_picture import LIFETIME, RED
from rviz_drawing import drawing
from trajectory_graph import Graph

MARGIN, WIDTH = 1.6, 0.16  # m, of the frame
WORDS_ABOVE = 1.5          # m from the frame to the words; the buttons are below the words
TEXT_HEIGHT = 0.6
LINES = 4                  # the most lines of words
LETTER = 0.6               # mean width of a letter, as a share of its height


def stop_markers(graph: Graph, stop: FleetStop, now: float) -> List[Marker]:
    """Returns the markers of a stop; none if the fleet is not stopped. `now` in s since 1970."""
    if not stop.is_in_force:
        return []
    xs = [vertex.x for vertex in graph.vertices.values()]
    ys = [vertex.y for vertex in graph.vertices.values()]
    left, right, low, high = (min(xs) - MARGIN, max(xs) + MARGIN, min(ys) - MARGIN,
                              max(ys) + MARGIN)
    letters = max(int((right - left) / (LETTER * TEXT_HEIGHT)), 24)
    words = textwrap.fill(stop.words(now), letters, max_lines=LINES, placeholder=' ...')
    height = TEXT_HEIGHT * len(words.splitlines())
    markers = [
        drawing.lines('stop', 0, RED, WIDTH, [np.array([
            (left, low), (right, low), (right, high), (left, high), (left, low)])], 0.3),
        drawing.text('stop', 1, words, ((left + right) / 2.0, high + WORDS_ABOVE + height / 2.0),
                     TEXT_HEIGHT, RED, z=2.0)]
    for marker in markers:
        marker.lifetime = rospy.Duration(LIFETIME)
    return markers
