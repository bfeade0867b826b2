"""Curves: length, points, headings, projection."""
from __future__ import annotations

import math

import numpy as np
import pytest
from graph_builders import spline_graph
from hypothesis import given
from hypothesis import strategies as st

from trajectory_graph.curves import (
    bezier_arc_lengths,
    bezier_points,
    bezier_section,
    cubic_bezier,
    line,
    spline,
    spline_control,
)

coordinate = st.floats(-50.0, 50.0)
angle = st.floats(-math.pi, math.pi)
reach = st.floats(0.0, 5.0)
splines = st.builds(
    spline, st.tuples(coordinate, coordinate), angle, reach,
    st.tuples(st.floats(60.0, 80.0), coordinate), angle, reach)


def test_a_line_is_as_long_as_its_ends_are_apart():
    assert line((1.0, 1.0), (4.0, 5.0)).length == pytest.approx(5.0)


def test_a_spline_leaves_along_the_origins_theta_and_enters_along_the_destinations():
    curve = spline_graph().curve(1)
    assert curve.heading_at(0.0) == pytest.approx(0.0, abs=0.05)
    assert curve.heading_at(curve.length) == pytest.approx(math.pi / 2, abs=0.05)


def test_a_quarter_circle_of_bezier_curve_has_its_length():
    k = 4.0 / 3.0 * (math.sqrt(2.0) - 1.0)
    curve = spline((1.0, 0.0), math.pi / 2, k, (0.0, 1.0), math.pi, k)
    assert curve.length == pytest.approx(math.pi / 2, rel=3e-4)
    assert np.hypot(*curve.sample(0.01).T) == pytest.approx(1.0, abs=1e-3)


def test_the_length_of_a_spline_is_that_of_the_curve_not_of_its_polyline():
    curve = spline((0.0, 0.0), 0.0, 2.0, (4.0, 2.0), 1.0, 2.0)
    t = np.linspace(0.0, 1.0, 200001)
    points = bezier_points(spline_control((0.0, 0.0), 0.0, 2.0, (4.0, 2.0), 1.0, 2.0), t)
    assert curve.length == pytest.approx(np.hypot(*np.diff(points, axis=0).T).sum(), rel=1e-9)


def test_a_section_of_a_spline_is_that_part_of_it():
    control = spline_control((0.0, 0.0), 0.0, 2.0, (4.0, 2.0), 1.0, 2.0)
    t = np.linspace(0.0, 1.0, 9)
    part = bezier_points(bezier_section(control, 0.25, 0.75), t)
    assert part == pytest.approx(bezier_points(control, 0.25 + t / 2.0), abs=1e-12)


@pytest.mark.parametrize('ahead', [1e-8, 0.3, 0.5, 1.0, 2.0])
def test_the_length_of_a_curve_that_turns_on_the_spot_is_there_and_back(ahead):
    """The curve lies on the x axis, and reverses at points that are roots of the derivative."""
    end = 2.558151373641067
    curve = spline((0.0, 0.0), math.pi, ahead, (end, 0.0), math.pi, 0.0)
    x = np.polynomial.Polynomial([0.0, -3.0 * ahead, 3.0 * (end + 2.0 * ahead),
                                  -2.0 * end - 3.0 * ahead])
    stops = [0.0, *sorted(t.real for t in x.deriv().roots() if 0.0 < t.real < 1.0), 1.0]
    assert curve.length == pytest.approx(np.abs(np.diff(x(np.array(stops)))).sum(), rel=1e-9)


def test_the_length_of_a_curve_that_nearly_turns_on_the_spot_is_exact():
    curve = spline((0.0, 0.0), 2e-4, 1.0, (0.0, 1e-5), -2e-4, -1.0)
    control = spline_control((0.0, 0.0), 2e-4, 1.0, (0.0, 1e-5), -2e-4, -1.0)
    finely = bezier_arc_lengths(control, np.linspace(0.0, 1.0, 200001))[-1]
    assert curve.length == pytest.approx(finely, rel=1e-9)


def test_a_spline_without_control_lengths_is_the_straight_line():
    curve = spline((0.0, 0.0), 1.0, 0.0, (3.0, 4.0), 2.0, 0.0)
    assert curve.length == pytest.approx(5.0)
    assert curve.heading_at(2.5) == pytest.approx(math.atan2(4, 3))


def test_turns_to_the_left_and_to_the_right_add_up():
    k = 4.0 / 3.0 * (math.sqrt(2.0) - 1.0)
    quarter = spline((1.0, 0.0), math.pi / 2, k, (0.0, 1.0), math.pi, k)
    along = np.array((-1.0, 0.0, math.pi / 4, math.pi / 2, 9.0))
    assert quarter.turned(along) == pytest.approx(along.clip(0.0, math.pi / 2), abs=0.05)
    bends_twice = spline((0.0, 0.0), 0.0, 2.0, (4.0, 2.0), 0.0, 2.0)
    middle, end = bends_twice.turned(np.array((0.5, 1.0)) * bends_twice.length)
    assert end == pytest.approx(2.0 * middle)
    assert middle == pytest.approx(bends_twice.heading_at(bends_twice.length / 2), abs=0.05)
    assert line((0.0, 0.0), (3.0, 4.0)).turned(np.array((0.0, 5.0))).tolist() == [0.0, 0.0]


def test_projection_gives_distance_arc_length_and_fraction():
    projection = line((0.0, 0.0), (10.0, 0.0)).project(2.5, 0.3)
    assert projection == pytest.approx((0.3, 2.5, 0.25))


def test_projection_beyond_an_end_is_that_end():
    assert line((0.0, 0.0), (10.0, 0.0)).project(13.0, 4.0) == pytest.approx((5.0, 10.0, 1.0))


def test_projection_within_a_range_does_not_leave_it():
    curve = line((0.0, 0.0), (10.0, 0.0))
    assert curve.project(2.0, 0.0, start=4.0, end=6.0).arc_length == pytest.approx(4.0)
    assert curve.project(9.0, 0.0, start=4.0, end=6.0).arc_length == pytest.approx(6.0)


def test_where_a_curve_crosses_itself_the_range_decides():
    loop = cubic_bezier(np.array(((0.0, 0.0), (6.0, 4.0), (-4.0, 4.0), (2.0, 0.0))))
    crossing = loop.project(1.0, 1.2)
    later = loop.project(1.0, 1.2, start=loop.length / 2)
    assert crossing.arc_length < loop.length / 2 < later.arc_length


@given(splines)
def test_a_curve_reversed_is_as_long_and_swaps_its_ends(curve):
    back = curve.reversed()
    assert back.length == pytest.approx(curve.length)
    assert back.point_at(0.0) == pytest.approx(curve.point_at(curve.length))


@given(splines, st.floats(0.0, 1.0))
def test_a_point_of_the_curve_projects_onto_itself(curve, fraction):
    point = curve.point_at(fraction * curve.length)
    assert curve.project(*point).distance == pytest.approx(0.0, abs=1e-6)


@given(splines, coordinate, coordinate)
def test_no_sampled_point_is_nearer_than_the_projection(curve, x, y):
    sampled = np.hypot(*(curve.sample(0.2) - (x, y)).T).min()
    assert curve.project(x, y).distance <= sampled + 1e-9


@given(splines, st.floats(0.01, 2.0))
def test_samples_include_both_ends_and_keep_the_step(curve, step):
    points = curve.sample(step)
    assert points[0] == pytest.approx(curve.point_at(0.0))
    assert points[-1] == pytest.approx(curve.point_at(curve.length))
    assert np.linalg.norm(np.diff(points, axis=0), axis=1).max() <= step + 1e-9
