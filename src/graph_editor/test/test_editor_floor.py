"""The clearance, the reachable area and the inside of floors."""
from __future__ import annotations

import math

import numpy as np
import pytest

from graph_editor.floor import Floor, inside_outline


def floor_of(*rows: str, resolution: float = 0.5, origin=(0.0, 0.0)) -> Floor:
    """Returns a floor drawn with `#` for occupied cells; the first row is the highest."""
    occupied = np.array([[letter == '#' for letter in row] for row in rows[::-1]])
    return Floor(occupied, np.ones_like(occupied), resolution, origin)


def test_clearance_is_the_distance_to_the_nearest_obstacle():
    floor = floor_of('.......', '.......', '...#...', '.......', '.......')
    assert floor.clearance_at(np.array([(1.75, 1.25)])) == pytest.approx([0.0])
    assert floor.clearance_at(np.array([(1.75, 1.75)])) == pytest.approx([0.5])


def test_clearance_is_exact_where_the_places_of_obstacles_are_known():
    cells = floor_of('.......', '.......', '...#...', '.......', '.......')
    floor = Floor(cells.occupied, cells.inside, cells.resolution, cells.origin,
                  np.array([(1.55, 1.05)]))
    assert floor.clearance_at(np.array([(2.25, 1.75)])) == pytest.approx([math.hypot(0.7, 0.7)])
    assert floor.clearance_at(np.array([(1.75, 0.25)])) == pytest.approx([0.5]), (
        'measured from the end')
    assert cells.clearance_at(np.array([(2.25, 1.75)])) == pytest.approx([math.hypot(0.5, 0.5)])
    assert np.array_equal(floor.of_cells().clearance, cells.clearance)


def test_amid_an_area_there_is_no_clearance():
    cells = floor_of(*['.......', '.#####.', '.#####.', '.#####.', '.......'])
    outline = np.array([(0.5, 0.5), (3.0, 0.5), (3.0, 2.0), (0.5, 2.0)])
    floor = Floor(cells.occupied, cells.inside, cells.resolution, cells.origin, outline)
    assert floor.clearance_at(np.array([(1.75, 1.25)])) == pytest.approx([0.0])


def test_the_end_of_the_grid_is_an_obstacle():
    floor = floor_of('...', '...', '...', origin=(-10.0, 4.0))
    assert floor.clearance_at(np.array([(-9.25, 4.75), (-9.75, 4.75), (-20.0, 0.0)])) \
        == pytest.approx([1.0, 0.5, 0.0])


def test_clearance_between_centres_is_interpolated():
    floor = floor_of(*['........'] * 8)
    low, between, high = floor.clearance_at(np.array([(1.25, 1.75), (1.5, 1.75), (1.75, 1.75)]))
    assert between == pytest.approx((low + high) / 2.0)


def test_cells_and_centres_belong_together():
    floor = floor_of(*['.....'] * 4, origin=(-1.0, 2.0))
    rows, columns = np.array((0, 3)), np.array((4, 1))
    again = floor.cells_of(floor.centres(rows, columns))
    assert np.array_equal(again[0], rows) and np.array_equal(again[1], columns)


def test_what_is_behind_a_narrow_gap_is_not_reached():
    plan = ['.....#.....'] * 2 + ['...........'] + ['.....#.....'] * 2
    floor = floor_of(*plan)
    start = [(1.25, 1.25)]
    assert floor.reachable(0.4, start)[2, 8]
    assert not floor.reachable(0.6, start)[2, 8]
    assert floor.reachable(0.6, start)[2, 2]


def test_a_start_beside_an_obstacle_counts_for_the_floor_within_a_metre():
    floor = floor_of(*['#..........'] * 5)
    assert floor.reachable(0.6, [(0.25, 1.25)]).any()
    assert not floor.reachable(0.6, [(30.0, 90.0)]).any()


def test_inside_is_what_a_disc_of_the_gaps_width_cannot_roll_into():
    occupied = np.zeros((60, 60), bool)
    occupied[10:50, (10, 49)] = occupied[(10, 49), 10:50] = True
    occupied[25:33, 10] = False  # a gap of 0.8 m
    assert inside_outline(occupied, 0.1, 1.0)[30, 30]
    assert not inside_outline(occupied, 0.1, 0.5)[30, 30]
    assert not inside_outline(occupied, 0.1, 1.0)[2, 2]
