"""Messages serialised by numpy have the same bytes as those serialised by rospy."""
from __future__ import annotations

import io

import genpy
import numpy as np
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from hypothesis import given
from hypothesis import strategies as st
from nav_msgs.msg import MapMetaData, OccupancyGrid
from nav_msgs.srv import GetMapResponse, LoadMapResponse
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from rviz_drawing.fast_messages import (
    FastMarkerArray,
    GetGridResponse,
    GridMessage,
    LoadGridResponse,
    PointsMarker,
)

HEADER = Header(seq=7, stamp=genpy.Time(12, 34), frame_id='map')


def written(message) -> bytes:
    buffer = io.BytesIO()
    buffer.write(b'before')  # other messages are in the buffer before this one
    message.serialize(buffer)
    return buffer.getvalue()


def plain_marker(marker: PointsMarker) -> Marker:
    """Returns the same marker with a list of Point objects."""
    fields = {name: getattr(marker, name) for name in Marker.__slots__}
    return Marker(**{**fields, 'points': [Point(*row) for row in marker.array.tolist()]})


@given(st.lists(st.tuples(*[st.floats(allow_nan=False)] * 3), max_size=20))
def test_a_marker_of_many_points(rows):
    marker = PointsMarker(
        np.array(rows), header=HEADER, ns='wörds', id=3, type=Marker.POINTS, action=Marker.ADD,
        pose=Pose(orientation=Quaternion(0, 0, 0, 1)), scale=Vector3(1, 2, 3),
        color=ColorRGBA(0.1, 0.2, 0.3, 1.0), lifetime=genpy.Duration(2), frame_locked=True)
    plain = plain_marker(marker)
    assert written(marker) == written(plain)
    other = Marker(text='plain', ns='beside')
    assert written(FastMarkerArray([other, marker])) == written(MarkerArray([other, plain]))


def grid(cells: np.ndarray, kind=GridMessage):
    info = MapMetaData(map_load_time=genpy.Time(5), resolution=0.5, width=cells.shape[1],
                       height=cells.shape[0], origin=Pose(orientation=Quaternion(0, 0, 0, 1)))
    if kind is GridMessage:
        return GridMessage(cells, header=HEADER, info=info)
    return OccupancyGrid(HEADER, info, cells.ravel().tolist())


CELLS = np.array([[-1, 0, 100], [100, 0, -1]], np.int8)


def test_a_grid_and_the_answers_that_hold_one():
    fast, plain = grid(CELLS), grid(CELLS, OccupancyGrid)
    assert written(fast) == written(plain)
    assert written(GetGridResponse(fast)) == written(GetMapResponse(plain))
    assert written(LoadGridResponse(fast, 0)) == written(LoadMapResponse(plain, 0))


def test_a_view_of_another_array_is_written_in_its_own_order():
    turned = CELLS.T[::-1]
    assert written(grid(turned)) == written(grid(turned.copy(), OccupancyGrid))


def test_subscribers_see_the_plain_types():
    assert PointsMarker(np.empty((0, 3)))._md5sum == Marker._md5sum
    assert FastMarkerArray()._md5sum == MarkerArray._md5sum
    assert GridMessage(CELLS)._md5sum == OccupancyGrid._md5sum
