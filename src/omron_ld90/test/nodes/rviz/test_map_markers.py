"""The look and the place of each marker of the map."""
from __future__ import annotations

import math
from itertools import combinations

import numpy as np
import pytest
from genpy import Time
from marker_reader import drawn, received
from std_msgs.msg import Header
from visualization_msgs.msg import Marker

from omron_ld90.nodes.rviz import map_markers
from omron_map import MapDocument, MapObject, RotatedRectangle
from rviz_drawing.text_places import text_size
from trajectory_graph.placing import box_around, shared

HEADER = Header(stamp=Time(1), frame_id='map')
SECTORS = b"""2D-Map
Cairn: MotionLimitsSector 0 0 0.000000 "" ICON "Poly" 0 0 60 40 5 0 0 60 0 60 40 30 60 0 40
Cairn: OneWaySector 0 0 90.000000 "" ICON "" 1000 -3000 4000 -1000
Cairn: FeedbackHandler 0 0 0.000000 "" ICON "Replies" 0 0 0 0
DATA
0 0
"""


def document(*objects: MapObject, data: bytes = b'2D-Map\nDATA\n0 0\n40 20\n') -> MapDocument:
    result = MapDocument.from_bytes(data)
    for obj in objects:
        result.add(obj)
    return result


def colour(marker: Marker) -> tuple:
    return marker.color.r, marker.color.g, marker.color.b


def test_walls_are_neutral_because_red_is_only_for_trouble():
    shown = document(data=b'2D-Map\nLINES\n0 0 100 0\nDATA\n0 0\n')
    for walls in (map_markers.points(shown, 'map'), map_markers.lines(shown, 'map')):
        assert max(colour(walls)) - min(colour(walls)) < 0.1


@pytest.mark.parametrize('build', [map_markers.lines, map_markers.goals, map_markers.docks])
def test_a_marker_of_nothing_takes_the_older_one_away(build):
    marker = build(document(), 'map')
    assert marker.action == Marker.DELETE and len(marker.array) == 0


def test_points_and_lines_are_in_metres():
    shown = document(data=b'2D-Map\nResolution: 40\nLINES\n0 0 60 -41\nDATA\n-20 0\n')
    points, lines = map_markers.points(shown, 'map'), map_markers.lines(shown, 'map')
    assert points.array[:, :2].tolist() == [[-0.02, 0.0]]
    assert points.scale.x == 0.04, 'a point must be as large as its cell'
    assert lines.array[:, :2].tolist() == [[0.0, 0.0], [0.06, -0.041]]


@pytest.mark.parametrize('heading', [None, 0, 90, 180, -120])
@pytest.mark.parametrize('name', ['A', 'A rather long name'])
def test_a_name_is_at_a_corner_clear_of_its_handle_and_of_the_sides(name, heading):
    text, = drawn(map_markers.goal_names(document(MapObject.goal(name, 1000, 500, heading)), 'map'))
    width, height = text_size(name, text.scale.z)
    left, top = text.pose.position.x - width / 2, text.pose.position.y + height / 2
    assert left >= 1.0 + map_markers.HANDLE / 2 and top <= 0.5 - map_markers.HANDLE / 2
    assert colour(text) == (1.0, 1.0, 1.0)


def test_names_of_goals_beside_each_other_cover_no_goal_and_no_other_name():
    goals = [MapObject.goal(f'Goal {n}', 900 * n, 0) for n in range(3)]
    texts = drawn(map_markers.goal_names(document(*goals), 'map'))
    boxes = [box_around((text.pose.position.x, text.pose.position.y),
                        text_size(text.text, text.scale.z)) for text in texts]
    handles = [box_around((0.9 * n, 0.0), (map_markers.HANDLE,) * 2) for n in range(3)]
    assert not any(shared(*pair) for pair in combinations(boxes, 2))
    assert not any(shared(box, handle) for box in boxes for handle in handles)


def test_only_what_has_a_heading_gets_an_arrow():
    shown = document(MapObject.goal('A', 0, 0), MapObject.goal('B', 100, 0, heading=-90),
                     MapObject.dock('D', 200, 0, 180))
    arrows = drawn(map_markers.goal_headings(shown, 'map'))
    yaws = [2 * math.atan2(a.pose.orientation.z, a.pose.orientation.w) for a in arrows]
    assert yaws == pytest.approx([-math.pi / 2, math.pi])
    assert [arrow.id for arrow in arrows] == [0, 1] and colour(arrows[0]) == (0.0, 0.0, 0.0)


def test_an_area_is_a_box_turned_like_the_stored_corners():
    rectangle = RotatedRectangle(3000, 3000, 2000, 1000, 30)
    box, = drawn(map_markers.forbidden_areas(document(MapObject.forbidden_area(rectangle)), 'map'))
    yaw = 2 * math.atan2(box.pose.orientation.z, box.pose.orientation.w)
    corner = np.array((box.pose.position.x, box.pose.position.y)) + (
        math.cos(yaw) * box.scale.x / 2 - math.sin(yaw) * box.scale.y / 2,
        math.sin(yaw) * box.scale.x / 2 + math.cos(yaw) * box.scale.y / 2)
    assert corner * 1000 == pytest.approx(rectangle.corners[2], abs=1.5)
    assert box.color.r > box.color.g > box.color.b == 0.0, 'orange'


def test_sectors_are_outlined_and_configuration_is_not_drawn():
    polygon, name, rectangle = drawn(map_markers.sectors(document(data=SECTORS), 'map'))
    assert len(polygon.points) == 6 and polygon.points[0] == polygon.points[-1]
    assert name.text == 'Poly'
    assert [(round(p.x, 9), round(p.y, 9)) for p in rectangle.points] == [
        (3.0, 1.0), (3.0, 4.0), (1.0, 4.0), (1.0, 1.0), (3.0, 1.0)]


def test_a_name_is_shown_right_in_whichever_encoding_the_file_is():
    for encoding in ('utf-8', 'latin-1'):
        data = '2D-Map\nCairn: Goal 0 0 0 "" ICON "Küche"\nDATA\n'.encode(encoding)
        text, = drawn(map_markers.goal_names(document(data=data), 'map'))
        assert text.text == 'Küche', encoding


def test_a_laser_reading_lives_for_its_limit_and_an_empty_one_clears_the_last():
    marker = received(map_markers.laser(np.array([[1.5, -0.25]]), HEADER, 0.5))
    assert [(point.x, point.y) for point in marker.points] == [(1.5, -0.25)]
    assert (marker.header, marker.lifetime.to_sec()) == (HEADER, 0.5)
    empty = map_markers.laser(np.empty((0, 2)), HEADER, 0.5)
    assert empty.action == Marker.DELETE
