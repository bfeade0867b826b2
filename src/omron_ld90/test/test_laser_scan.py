"""Ranges by angle, computed from hits in the map."""
from __future__ import annotations

import math

import numpy as np
import pytest

from omron_ld90 import robot_model
from omron_ld90.laser_scan import BEAMS, FIRST_ANGLE, INCREMENT, LaserPlace, ranges_of

HERE = LaserPlace(2.0, 1.0, math.radians(90.0))


def beam(degrees: float) -> int:
    """Returns the beam at an angle (degrees) from straight ahead, counter-clockwise."""
    return round((math.radians(degrees) - FIRST_ANGLE) / INCREMENT)


def hit(degrees: float, distance: float) -> tuple:
    """Returns a hit at the given distance (m) and angle (degrees) from straight ahead."""
    angle = HERE.yaw + math.radians(degrees)
    return HERE.x + distance * math.cos(angle), HERE.y + distance * math.sin(angle)


def test_a_scan_covers_240_degrees():
    assert math.degrees(FIRST_ANGLE) == pytest.approx(-120.0)
    assert math.degrees(FIRST_ANGLE + (BEAMS - 1) * INCREMENT) == pytest.approx(120.0)


@pytest.mark.parametrize('degrees', [-120.0, -45.0, 0.0, 30.0, 120.0])
def test_a_hit_is_seen_at_its_angle_and_distance(degrees):
    ranges = ranges_of(np.array([hit(degrees, 3.5)]), HERE)
    assert ranges[beam(degrees)] == pytest.approx(3.5)
    assert np.isinf(ranges).sum() == BEAMS - 1


def test_of_two_hits_in_one_direction_the_nearer_is_seen():
    assert ranges_of(np.array([hit(10, 4.0), hit(10, 2.0)]), HERE)[beam(10)] == pytest.approx(2.0)


@pytest.mark.parametrize('degrees, distance', [
    (130.0, 1.0), (180.0, 1.0), (-125.0, 1.0), (0.0, robot_model.LASER_RANGE + 0.1), (0.0, 0.0)])
def test_what_no_laser_can_see_is_left_out(degrees, distance):
    assert np.isinf(ranges_of(np.array([hit(degrees, distance)]), HERE)).all()


def test_without_hits_every_beam_sees_nothing():
    assert np.isinf(ranges_of(np.empty((0, 2)), HERE)).all()
