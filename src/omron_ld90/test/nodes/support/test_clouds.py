"""The points of clouds from the receiver and from other nodes, and of invalid messages."""
from __future__ import annotations

import numpy as np
import pytest
import rospy
from sensor_msgs.msg import PointCloud2, PointField

from node_lifecycle import clouds
from node_lifecycle.clouds import places_in
from omron_arcl.replies import RangeReading
from omron_ld90.nodes.receiver_messages import point_cloud


def test_the_receivers_cloud_gives_back_its_points():
    reading = RangeReading('Laser_1', np.array([[1500, -250], [0, 2000]]))
    cloud = point_cloud(reading, rospy.Time(1), 'map', 0.203)
    assert places_in(cloud).tolist() == [[1.5, -0.25], [0.0, 2.0]]


def cloud(**fields) -> PointCloud2:
    """Returns two big-endian points with the fields y, x, intensity; the second is not finite."""
    data = np.array([[2.0, 1.0, 9.0], [0.0, np.nan, 9.0]], '>f4').tobytes()
    layout = [PointField(name, offset, PointField.FLOAT32, 1)
              for name, offset in (('y', 0), ('x', 4), ('intensity', 8))]
    plain = {'height': 1, 'width': 2, 'fields': layout, 'is_bigendian': True, 'point_step': 12,
             'row_step': 24, 'data': data}
    return PointCloud2(**{**plain, **fields})


def test_another_layout_is_read_and_a_point_without_a_place_is_left_out():
    assert places_in(cloud()).tolist() == [[1.0, 2.0]]


@pytest.mark.parametrize('wrong, reason', [
    ({'width': 3}, 'the layout'), ({'point_step': 7}, 'the layout'), ({'data': b''}, 'the layout'),
    ({'fields': []}, 'no x and y'), ({'width': 2**31}, 'at most'),
    ({'fields': [PointField('x', 2**31, 7, 1), PointField('y', 4, 7, 1)]}, 'the layout'),
    ({'fields': [PointField('x', 0, PointField.INT8, 1), PointField('y', 4, 7, 1)]}, 'no x and y'),
    ({'height': 2, 'width': 1, 'row_step': 100}, 'the layout')])
def test_what_is_no_cloud_is_refused_in_words(wrong, reason):
    with pytest.raises(ValueError, match=reason):
        places_in(cloud(**wrong))


def test_no_points_are_no_places():
    assert places_in(cloud(width=0, data=b'')).shape == (0, 2)


def test_the_bound_is_on_points():
    with pytest.raises(ValueError, match=str(clouds.MAX_POINTS + 1)):
        places_in(cloud(width=clouds.MAX_POINTS + 1))
