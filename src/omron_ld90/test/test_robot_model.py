"""The constants of the LD-90, its URDF and the simulated robot have the same dimensions."""
from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

from omron_ld90 import robot_model
from omron_ld90_sim.devices import laser
from omron_ld90_sim.motion.kinematics import LD90_BODY, LD90_LIMITS
from omron_map_converter import footprint

URDF = ElementTree.parse(Path(__file__).resolve().parents[1] / 'urdf' / 'ld90.urdf').getroot()
MM = 1000.0


def numbers(text: str) -> list:
    return [float(word) for word in text.split()]


def boxes(kind: str):
    """Returns the centre and size (m) of each axis-aligned box of the body."""
    for link in URDF.iter('link'):
        for shape in link.iter(kind):
            box = shape.find('geometry/box')
            if box is not None:
                yield numbers(shape.find('origin').get('xyz')), numbers(box.get('size'))


@pytest.mark.parametrize('kind', ['visual', 'collision'])
def test_the_urdf_has_the_robots_size(kind):
    low = [min(centre[i] - size[i] / 2 for centre, size in boxes(kind)) for i in range(3)]
    high = [max(centre[i] + size[i] / 2 for centre, size in boxes(kind)) for i in range(3)]
    assert high[0] - low[0] == pytest.approx(footprint.LENGTH)
    assert high[1] - low[1] == pytest.approx(footprint.WIDTH)
    assert high[2] == pytest.approx(robot_model.HEIGHT)


def test_the_urdf_has_the_laser_where_it_is():
    joint = next(joint for joint in URDF.iter('joint') if joint.get('name') == 'laser_joint')
    assert numbers(joint.find('origin').get('xyz')) == [
        robot_model.LASER_AHEAD, 0.0, robot_model.LASER_HEIGHT]


def test_the_half_diagonal_is_that_of_the_size_rounded_up():
    exact = math.hypot(footprint.LENGTH, footprint.WIDTH) / 2
    assert exact <= footprint.HALF_DIAGONAL < exact + 0.001


def test_the_simulated_robot_is_the_same_robot():
    assert (LD90_BODY.length, LD90_BODY.width) == (
        footprint.LENGTH * MM, footprint.WIDTH * MM)
    assert (LD90_LIMITS.speed, LD90_LIMITS.acceleration, LD90_LIMITS.goal_deceleration) == (
        robot_model.TOP_SPEED * MM, robot_model.ACCELERATION * MM,
        robot_model.BRAKING_TO_GOAL * MM)
    assert math.radians(laser.FIELD_OF_VIEW) == pytest.approx(robot_model.LASER_FIELD_OF_VIEW)
    assert robot_model.LASER_RANGE * MM == laser.RANGE
