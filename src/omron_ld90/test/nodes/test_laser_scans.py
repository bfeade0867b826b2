"""A cloud becomes a scan with the location that is nearest to it in time."""
from __future__ import annotations

import math

import numpy as np
import pytest
import rospy
from geometry_msgs.msg import Pose

from omron_ld90.nodes.laser_scans import StampedPose, nearest_in_time, scan_of


def at(seconds: float) -> StampedPose:
    return StampedPose(rospy.Time.from_sec(seconds), Pose())


@pytest.mark.parametrize('cloud, nearest', [(10.1, 10.0), (10.4, 10.5), (10.5, 10.5)])
def test_of_two_locations_the_nearer_counts(cloud, nearest):
    found = nearest_in_time(rospy.Time.from_sec(cloud), at(10.0), at(10.5))
    assert found.stamp == rospy.Time.from_sec(nearest)


def test_a_cloud_without_a_location_near_it_becomes_no_scan():
    assert nearest_in_time(rospy.Time(11), None, None) is None
    assert nearest_in_time(rospy.Time(11), at(10.0), at(12.0)) is None
    assert nearest_in_time(rospy.Time(11), None, at(11.2)) is not None


def test_a_scan_says_how_its_ranges_are_to_be_read():
    scan = scan_of(np.array([1.0] + [math.inf] * 240), rospy.Time(3), 'ld/laser_link')
    assert (scan.header.frame_id, scan.header.stamp) == ('ld/laser_link', rospy.Time(3))
    assert math.degrees(scan.angle_min) == pytest.approx(-120.0)
    assert math.degrees(scan.angle_max) == pytest.approx(120.0)
    assert scan.angle_min + 240 * scan.angle_increment == pytest.approx(scan.angle_max)
    assert 0.0 < scan.range_min < 1.0 < scan.range_max == 15.0
