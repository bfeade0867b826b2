"""A reported place is valid for a short time, even if the clock jumps."""
from __future__ import annotations

import time

import pytest
import rospy
from geometry_msgs.msg import PoseStamped

from graph_fleet_manager.nodes.rviz.true_places import FRESH, TruePlaces

HOUR = 3600.0


@pytest.mark.parametrize('jump', [-HOUR, 0.0, HOUR])
@pytest.mark.parametrize('age, is_fresh', [(0.5 * FRESH, True), (2.0 * FRESH, False)])
def test_a_clock_that_jumps_makes_no_place_fresher_or_older(monkeypatch, jump, age, is_fresh):
    wall = 1.7e9
    monkeypatch.setattr(rospy.Time, 'now', lambda: rospy.Time.from_sec(wall))
    monkeypatch.setattr(time, 'monotonic', lambda: 100.0)
    places = TruePlaces()
    message = PoseStamped()
    message.pose.orientation.w = 1.0
    places._on_pose(message, 'a')
    wall += jump + age
    monkeypatch.setattr(time, 'monotonic', lambda: 100.0 + age)
    assert (places.of('a') is not None) is is_fresh
    assert places.last('a') is not None
