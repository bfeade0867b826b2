"""Each location is published once, while it is recent, and never from the future."""
from __future__ import annotations

import rospy

from omron_ld90.nodes.robot_state_publisher import LocationFilter

MAX_AGE = rospy.Duration(1.0)


def at(seconds: float) -> rospy.Time:
    return rospy.Time.from_sec(seconds)


def test_a_fresh_location_keeps_the_stamp_of_its_arrival():
    assert LocationFilter(MAX_AGE).stamp_for(at(100.0), at(100.2)) == at(100.0)


def test_the_same_location_goes_out_once():
    locations = LocationFilter(MAX_AGE)
    locations.stamp_for(at(100.0), at(100.0))
    assert locations.stamp_for(at(100.0), at(100.1)) is None


def test_a_location_that_arrives_after_a_newer_one_is_dropped():
    locations = LocationFilter(MAX_AGE)
    locations.stamp_for(at(100.5), at(100.5))
    assert locations.stamp_for(at(100.0), at(100.6)) is None


def test_an_old_location_is_not_published():
    locations = LocationFilter(MAX_AGE)
    assert locations.stamp_for(at(100.0), at(101.001)) is None
    assert locations.stamp_for(at(100.0), at(101.0)) == at(100.0)


def test_a_stamp_from_the_future_is_set_back_to_now():
    assert LocationFilter(MAX_AGE).stamp_for(at(105.0), at(100.0)) == at(100.0)


def test_a_future_location_does_not_block_those_that_follow():
    locations = LocationFilter(MAX_AGE)
    locations.stamp_for(at(500.0), at(100.0))
    assert locations.stamp_for(at(100.5), at(100.5)) == at(100.5)


def test_after_the_clock_was_set_back_locations_go_out_again():
    locations = LocationFilter(MAX_AGE)
    locations.stamp_for(at(100.0), at(100.0))
    assert locations.stamp_for(at(40.0), at(40.0)) == at(40.0)
