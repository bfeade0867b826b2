"""A published occupancy grid becomes a site, like a map file."""
from __future__ import annotations

import math

import numpy as np
import pytest
from nav_msgs.msg import OccupancyGrid

from graph_editor.errors import SiteError
from graph_editor.making.maker import make_graph
from graph_editor.making.options import MakingOptions
from graph_editor.nodes.live_map import load_map, site_of_message
from graph_editor.site import SiteOptions


def grid(rows: int = 60, columns: int = 160) -> OccupancyGrid:
    """Returns a room of 8 x 3 m with walls around it; the lower left corner is at (-1, 2) m."""
    cells = np.zeros((rows, columns), np.int8)
    cells[(0, -1), :] = cells[:, (0, -1)] = 100
    message = OccupancyGrid()
    message.info.height, message.info.width = rows, columns
    message.info.resolution = 0.05
    message.info.origin.position.x, message.info.origin.position.y = -1.0, 2.0
    message.info.origin.orientation.w = 1.0
    message.data = cells.ravel().tolist()
    return message


def test_a_graph_is_made_of_a_published_grid():
    site = site_of_message(grid(), SiteOptions(), 'topic:/map')
    graph = make_graph(site, MakingOptions()).graph
    assert [vertex.y for vertex in graph.vertices.values()] == pytest.approx(
        [3.5] * len(graph.vertices), abs=0.05)
    assert {vertex.frame_id for vertex in graph.vertices.values()} == {'map/map'}


@pytest.mark.parametrize('spoil, words', [
    (lambda message: message.data.pop(), 'has 9599'),
    (lambda message: setattr(message.info, 'width', 0), 'x 0 cells'),
    (lambda message: setattr(message.info, 'resolution', math.nan), 'not numbers'),
    (lambda message: setattr(message.info, 'resolution', 0.0), 'not numbers'),
    (lambda message: setattr(message.info.origin.position, 'x', math.inf), 'not numbers'),
    (lambda message: setattr(message.info.origin.orientation, 'z', 0.7), 'rotated')])
def test_a_grid_that_is_wrong_is_refused_in_one_sentence(spoil, words):
    message = grid()
    spoil(message)
    with pytest.raises(SiteError, match=words):
        site_of_message(message, SiteOptions(), 'topic:/map')


def test_a_topic_without_a_ros_master_is_told(monkeypatch):
    monkeypatch.setenv('ROS_MASTER_URI', 'http://127.0.0.1:9')
    with pytest.raises(SiteError, match='there is no ROS master'):
        load_map('topic:/map', SiteOptions())
