"""A sentence in RViz that says what has just happened, above the graph, beside the two buttons."""
from __future__ import annotations

import textwrap

import rospy
from visualization_msgs.msg import Marker

from graph_fleet_manager.nodes.rviz.menus import BUTTON, BUTTON_ABOVE
from rviz_drawing import drawing
from trajectory_graph import Graph

SHOWN_FOR = 8.0      # s
TEXT_HEIGHT = 0.4
LETTER = 0.5         # mean width of a letter, as a share of its height
LINES = 3            # the most lines; more would cover the graph or the words of a stop
LEAST_WIDTH = 12.0   # m, above a narrow graph
GAP = 0.7            # m to the buttons
YELLOW = drawing.colour(1.0, 0.9, 0.4)


def sentence_marker(graph: Graph, sentence: str) -> Marker:
    """Returns the marker of a sentence, in lines that do not cover the buttons."""
    xs = [vertex.x for vertex in graph.vertices.values()]
    left = min(xs) + 2.0 * BUTTON[0] + 0.3 + GAP
    width = max(max(xs) - left, LEAST_WIDTH)
    words = textwrap.fill(sentence, int(width / (LETTER * TEXT_HEIGHT)), max_lines=LINES,
                          placeholder=' ...')
    top = max(vertex.y for vertex in graph.vertices.values()) + BUTTON_ABOVE
    marker = drawing.text('feedback', 0, words, (left + width / 2.0, top), TEXT_HEIGHT, YELLOW,
                          z=2.0)
    marker.lifetime = rospy.Duration(SHOWN_FOR)
    return marker
