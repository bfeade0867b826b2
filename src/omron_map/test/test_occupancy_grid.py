"""The grid of a map, cell by cell, and its conversion to image files and back."""
from __future__ import annotations

import os

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from map_builders import TWO_SCANS, cell, map_bytes, room
from map_fixtures import ODD
from map_server_reader import read_served_map

from omron_map import (
    FREE,
    OCCUPIED,
    UNKNOWN,
    MapDocument,
    MapError,
    OccupancyGrid,
    fitting_resolution,
)
from omron_map.grid_files import export_grid


def document(points=(), lines=(), objects='', resolution=100) -> MapDocument:
    return MapDocument.from_bytes(map_bytes(points, lines, objects, resolution=resolution))


def occupied(grid: OccupancyGrid) -> list:
    """Returns the (column, row) of each occupied cell."""
    return sorted((int(column), int(row)) for row, column in np.argwhere(grid.cells == OCCUPIED))


class TestPoints:
    def test_bounds_are_inclusive_and_the_origin_is_the_smallest_coordinate(self):
        grid = OccupancyGrid.from_map(room())
        assert (grid.width, grid.height) == (81, 41)
        assert (grid.resolution, grid.origin) == (50, (-1000, -1000))
        assert (grid.cells == OCCUPIED).sum() == 81 * 2 + 39 * 2

    @pytest.mark.parametrize('corner, index', [
        ((-300, -200), (0, 0)), ((500, -200), (8, 0)), ((-300, 400), (0, 6)), ((500, 400), (8, 6))])
    def test_each_corner_has_its_own_cell(self, corner, index):
        corners = [(-300, -200), (500, -200), (-300, 400), (500, 400)]
        grid = OccupancyGrid.from_map(document(corners))
        assert grid.cells[index[1], index[0]] == OCCUPIED
        alone = [point for point in corners if point != corner] + [(0, 0)]
        assert OccupancyGrid.from_map(document(alone)).cells[index[1], index[0]] == UNKNOWN

    def test_row_0_is_the_lowest_y(self):
        assert occupied(OccupancyGrid.from_map(document([(0, 0), (0, 100), (200, 100)]))) == [
            (0, 0), (0, 1), (2, 1)]

    def test_the_rest_is_unknown_or_free_as_asked(self):
        assert set(np.unique(OccupancyGrid.from_map(room()).cells)) == {UNKNOWN, OCCUPIED}
        free = OccupancyGrid.from_map(room(), background=FREE)
        assert set(np.unique(free.cells)) == {FREE, OCCUPIED}

    def test_points_off_the_pitch_go_to_the_cell_that_holds_them(self):
        grid = OccupancyGrid.from_map(document([(-7, 0), (92, 99), (93, 100)]))
        assert occupied(grid) == [(0, 0), (1, 1)]

    def test_bounds_come_from_the_rows_not_from_the_header(self):
        wrong = MapDocument.from_bytes(ODD['wrong bounds'].data)
        assert OccupancyGrid.from_map(wrong).origin == (-20, 0)

    def test_another_pitch_can_be_asked_for(self):
        grid = OccupancyGrid.from_map(cell(), resolution=40)
        assert (grid.width, grid.height) == (3, 2)
        assert occupied(grid) == [(0, 0), (1, 0), (2, 1)]


class TestLines:
    LINES = [(0, 0, 300, 0), (300, 0, 300, 200)]

    def test_a_map_without_points_is_made_of_its_lines(self):
        grid = OccupancyGrid.from_map(document(lines=self.LINES), resolution=100)
        assert occupied(grid) == [(0, 0), (1, 0), (2, 0), (3, 0), (3, 1), (3, 2)]

    def test_points_alone_lines_alone_and_both(self):
        mixed = document([(0, 200)], self.LINES)
        counts = {use: len(occupied(OccupancyGrid.from_map(mixed, use=use)))
                  for use in ('auto', 'points', 'lines', 'both')}
        assert counts == {'auto': 1, 'points': 1, 'lines': 6, 'both': 7}

    def test_lines_that_overhang_the_points_widen_the_grid(self):
        grid = OccupancyGrid.from_map(document([(0, 0), (100, 0)], [(-8, 0, 104, 0)]), use='both')
        assert (grid.origin, grid.width) == ((-8, 0), 2)

    @given(st.tuples(*[st.integers(-1500, 1500)] * 4))
    def test_a_line_is_drawn_without_gaps_and_never_astray(self, line):
        grid = OccupancyGrid.from_map(document(lines=[line]), resolution=100)
        cells = occupied(grid)
        start, end = np.array(line[:2]), np.array(line[2:])
        for point in (start, end):
            assert tuple(((point - grid.origin) // 100).tolist()) in cells
        for x, y in cells:
            middle = np.array(grid.origin) + (np.array((x, y)) + 0.5) * 100
            assert _distance(middle, start, end) <= 71.0
        reached, todo = set(), [cells[0]]
        while todo:
            x, y = todo.pop()
            reached.add((x, y))
            todo += [(x + i, y + j) for i in (-1, 0, 1) for j in (-1, 0, 1)
                     if (x + i, y + j) in set(cells) - reached]
        assert reached == set(cells)


def _distance(point: np.ndarray, start: np.ndarray, end: np.ndarray) -> float:
    along = end - start
    share = 0.0 if not along.any() else np.clip((point - start) @ along / (along @ along), 0, 1)
    return float(np.linalg.norm(point - (start + share * along)))


class TestAreas:
    ENDS = {(0, 0), (10, 5)}  # the cells of the two points that determine the size of the grid

    def grid(self, line: str) -> OccupancyGrid:
        spanned = document([(0, 0), (1000, 500)], objects=line + '\n')
        return OccupancyGrid.from_map(spanned, areas=True)

    def test_a_cell_is_forbidden_when_its_centre_is_inside_edges_included(self):
        grid = self.grid('Cairn: ForbiddenArea 0 0 0 "" ICON "" 250 150 450 250')
        assert set(occupied(grid)) - self.ENDS == {(x, y) for x in (2, 3, 4) for y in (1, 2)}

    def test_an_area_is_turned_about_the_origin_of_the_map(self):
        grid = self.grid('Cairn: ForbiddenArea 0 0 90.000000 "" ICON "" 100 -400 300 -100')
        assert set(occupied(grid)) - self.ENDS == {(x, y) for x in (1, 2, 3) for y in (1, 2)}

    def test_what_lies_outside_is_clipped(self):
        grid = self.grid('Cairn: ForbiddenArea 0 0 0 "" ICON "" -90000 -90000 150 90000')
        assert set(occupied(grid)) == {(x, y) for x in (0, 1) for y in range(6)} | {(10, 5)}
        beyond = self.grid('Cairn: ForbiddenArea 0 0 0 "" ICON "" 5000 5000 9000 9000')
        assert occupied(beyond) == [(0, 0), (10, 5)]

    def test_a_forbidden_line_is_a_line_of_cells(self):
        grid = self.grid('Cairn: ForbiddenLine 0 200 0 "" ICON "" -500 200 250 200')
        assert set(occupied(grid)) == {(0, 0), (10, 5), (0, 2), (1, 2), (2, 2)}

    def test_areas_are_left_out_unless_asked_for(self):
        assert (OccupancyGrid.from_map(room(), areas=True).cells == OCCUPIED).sum() > 240
        assert (OccupancyGrid.from_map(room()).cells == OCCUPIED).sum() == 240


class TestRefusals:
    @pytest.mark.parametrize('arguments, data, words', [
        ({}, map_bytes([(0, 0)], resolution=0), 'gives no pitch'),
        ({}, TWO_SCANS, 'gives no pitch'),
        ({}, map_bytes([]), 'no pitch'),
        ({'resolution': 10}, map_bytes([]), 'no points and no lines'),
        ({'resolution': 1}, map_bytes([(0, 0), (100_000, 100_000)]), 'too large'),
    ])
    def test_a_grid_that_cannot_be_is_refused(self, arguments, data, words):
        with pytest.raises(MapError, match=words):
            OccupancyGrid.from_map(MapDocument.from_bytes(data), **arguments)

    def test_a_map_too_large_for_its_own_pitch_fits_with_a_multiple_of_it(self):
        vast = document([(0, 0), (1_999_999, 1_999_999)], resolution=20)
        assert fitting_resolution(vast, 20) == 200, '10,000 x 10,000 cells'
        assert fitting_resolution(room(), 50) == 50

    def test_a_wrong_use_is_the_callers_fault(self):
        with pytest.raises(ValueError, match='must be one of'):
            OccupancyGrid.from_map(room(), use='walls')

    def test_two_scans_make_one_grid_on_a_pitch_that_the_caller_names(self):
        grid = OccupancyGrid.from_map(MapDocument.from_bytes(TWO_SCANS), resolution=50)
        assert occupied(grid) == [(0, 0), (1, 1), (1, 3), (2, 2), (4, 0)]


class TestFiles:
    @pytest.mark.parametrize('name', ['room.png', 'room.pgm', 'room.yaml'])
    @pytest.mark.parametrize('background', [UNKNOWN, FREE])
    def test_what_map_server_reads_is_the_grid_cell_by_cell(self, tmp_path, name, background):
        grid = OccupancyGrid.from_map(room(), background=background)
        image, description = export_grid(grid, str(tmp_path / name))
        assert os.path.basename(image) == name.replace('.yaml', '.pgm')
        served = read_served_map(description)
        assert np.array_equal(served.cells, grid.cells)
        assert (served.resolution, served.origin) == (0.05, (-1.0, -1.0, 0.0))

    @settings(max_examples=30)
    @given(st.data())
    def test_any_grid_comes_back(self, tmp_path_factory, data):
        height, width = data.draw(st.integers(1, 12)), data.draw(st.integers(1, 12))
        values = data.draw(st.lists(st.sampled_from([UNKNOWN, FREE, OCCUPIED]),
                                    min_size=height * width, max_size=height * width))
        grid = OccupancyGrid(np.array(values, np.int8).reshape(height, width), 20, (-40, 60))
        folder = tmp_path_factory.mktemp('grid')
        for suffix in ('png', 'pgm'):
            _, description = export_grid(grid, str(folder / f'a.{suffix}'))
            assert np.array_equal(read_served_map(description).cells, grid.cells)

    def test_the_pair_can_be_carried_to_another_folder(self, tmp_path):
        _, description = export_grid(OccupancyGrid.from_map(room()), str(tmp_path / 'a' / '..' /
                                                                         'grid.png'))
        moved = tmp_path / 'moved'
        moved.mkdir()
        for name in ('grid.png', 'grid.yaml'):
            os.replace(str(tmp_path / name), str(moved / name))
        assert read_served_map(str(moved / 'grid.yaml')).cells.shape == (41, 81)

    def test_another_kind_of_image_is_refused(self, tmp_path):
        with pytest.raises(MapError, match=r"type '\.jpg' cannot be written; expected \.png"):
            export_grid(OccupancyGrid.from_map(room()), str(tmp_path / 'a.jpg'))
