"""Forbidden areas rotate about the map's origin; the numbers are those of worked examples."""
from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omron_map import Extent, RotatedRectangle
from omron_map.geometry import normalise_degrees


def test_the_stored_corners_turn_about_the_origin_of_the_map():
    rectangle = RotatedRectangle.from_extent(Extent(2000, 1000, 5000, 2000), 30.0)
    expected = [(1232.1, 1866.0), (3830.1, 3366.0), (3330.1, 4232.1), (732.1, 2732.1)]
    assert rectangle.corners == pytest.approx(np.array(expected), abs=0.06)
    assert (rectangle.centre_x, rectangle.centre_y) == pytest.approx((2281.1, 3049.0), abs=0.06)
    assert (rectangle.width, rectangle.height, rectangle.yaw) == (3000.0, 1000.0, 30.0)


def test_a_quarter_turn_by_head():
    rectangle = RotatedRectangle.from_extent(Extent(1000, -3000, 4000, -1000), 90.0)
    assert rectangle.corners.tolist() == [[3000, 1000], [3000, 4000], [1000, 4000], [1000, 1000]]
    assert (rectangle.centre_x, rectangle.centre_y) == (2000.0, 2500.0)


def test_a_rectangle_is_stored_as_the_corners_before_the_turn():
    assert RotatedRectangle(3000, 3000, 2000, 1000, 30).to_extent() == Extent(3098, 598, 5098, 1598)


def test_swapped_corners_are_the_same_rectangle():
    swapped = RotatedRectangle.from_extent(Extent(40, 20, 0, 0), 90.0)
    assert swapped == RotatedRectangle.from_extent(Extent(0, 0, 40, 20), 90.0)


def test_edges_and_corners_are_inside():
    rectangle = RotatedRectangle(100.0, 50.0, 40.0, 20.0, 30.0)
    middles = (rectangle.corners + np.roll(rectangle.corners, 1, axis=0)) / 2
    assert rectangle.contains(rectangle.corners).all()
    assert rectangle.contains(middles).all()
    outside = rectangle.corners + (rectangle.corners - (100.0, 50.0)) * 0.01
    assert not rectangle.contains(outside).any()


@pytest.mark.parametrize('angle, expected', [
    (0, 0), (180, 180), (-180, 180), (270, -90), (540, 180), (-190, 170), (-0.0, 0.0)])
def test_angles_are_brought_into_half_a_turn_each_way(angle, expected):
    result = normalise_degrees(angle)
    assert result == expected and math.copysign(1.0, result) == math.copysign(1.0, expected)


MILLIMETRES = st.integers(-100_000, 100_000)
SIZES = st.integers(0, 20_000)
ANGLES = st.floats(-180.0, 180.0, exclude_min=True)


@given(MILLIMETRES, MILLIMETRES, SIZES, SIZES, ANGLES)
def test_an_extent_comes_back_from_its_rectangle(x, y, width, height, theta):
    extent = Extent(x, y, x + width, y + height)
    assert RotatedRectangle.from_extent(extent, theta).to_extent() == extent


@given(MILLIMETRES, MILLIMETRES, SIZES, SIZES, ANGLES)
def test_corners_are_the_stored_ones_turned_one_by_one(x, y, width, height, theta):
    c, s = math.cos(math.radians(theta)), math.sin(math.radians(theta))
    stored = [(x, y), (x + width, y), (x + width, y + height), (x, y + height)]
    turned = [(px * c - py * s, px * s + py * c) for px, py in stored]
    corners = RotatedRectangle.from_extent(Extent(x, y, x + width, y + height), theta).corners
    assert corners == pytest.approx(np.array(turned), abs=1e-6)
