"""New points and lines change their rows and the header's values about them, nothing else."""
from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from map_builders import CELL, TWO_SCANS, cell, changed_lines, map_bytes, room_bytes
from map_fixtures import ODD

from omron_map import MapDocument, MapError


def test_points_are_written_sorted_and_once_with_count_and_bounds():
    document = cell()
    document.replace_points([[60, 40], [-40, 20], [60, 40], [0, 0]])
    assert document.points.tolist() == [[-40, 20], [0, 0], [60, 40]]
    assert changed_lines(CELL, document.to_bytes()) == (
        [b'MinPos: -20 0', b'NumPoints: 4', b'-20 0', b'40 20'],
        [b'MinPos: -40 0', b'NumPoints: 3', b'-40 20'])
    assert document.warnings == ()


def test_lines_are_written_sorted_and_points_stay():
    document = cell()
    document.replace_lines([[60, 0, 60, 41], [-23, 0, 60, 0], [-23, 0, 10, 0]])
    assert document.lines.tolist() == [[-23, 0, 10, 0], [-23, 0, 60, 0], [60, 0, 60, 41]]
    assert changed_lines(CELL, document.to_bytes()) == (
        [b'NumLines: 2'], [b'NumLines: 3', b'-23 0 10 0'])


def test_the_same_rows_are_no_change():
    document = cell()
    document.replace_points(document.points[::-1])
    document.replace_lines(document.lines)
    assert document.to_bytes() == CELL


@pytest.mark.parametrize('order', [1, -1])
def test_the_same_rows_are_no_change_in_a_map_whose_rows_are_in_no_order(order):
    unsorted = (b'2D-Map\nLinesAreSorted: false\nLINES\n5 0 1 1\n1 1 2 2\n'
                b'DATA\n5 5\n1 1\n5 5\n')
    document = MapDocument.from_bytes(unsorted)
    document.replace_lines(document.lines[::order])
    document.replace_points(document.points[::order])
    assert document.to_bytes() == unsorted


def test_without_rows_their_keys_go_and_the_lines_section_too():
    document = cell()
    document.replace_lines(np.empty((0, 4)))
    document.replace_points([])
    assert document.to_bytes() == (
        b'2D-Map\nResolution: 20\nCairn: Goal 20 20 0.000000 "" ICON "North"\nDATA\n')
    assert document.points.shape == (0, 2) and document.lines.shape == (0, 4)


def test_a_map_without_header_gets_one_in_the_vendors_order():
    document = MapDocument.from_bytes(b'2D-Map\nDATA\n')
    document.replace_lines([[0, 0, 40, 20]])
    document.replace_points([[0, 0], [20, 0]])
    assert document.to_bytes() == map_bytes([(0, 0), (20, 0)], [(0, 0, 40, 20)]).replace(
        b'Resolution: 50\n', b'')


def test_several_sections_become_one():
    document = MapDocument.from_bytes(ODD['a section that goes on'].data)
    document.replace_points([[0, 0]])
    assert document.to_bytes().count(b'DATA\n') == 1


def test_the_files_own_line_end_is_used():
    document = MapDocument.from_bytes(ODD['CRLF'].data)
    document.replace_points([[5, 6]])
    assert document.to_bytes().endswith(b'DATA\r\n5 6\r\n')


@pytest.mark.parametrize('rows', [[[0.5, 0]], [[0, 0, 0]], [1, 2], [[0, 2**31]],
                                  [[0, 0], [2_000_001, 0]], [[float('nan'), 0]]])
def test_rows_that_cannot_be_change_nothing(rows):
    document = cell()
    with pytest.raises(MapError):
        document.replace_points(rows)
    assert document.to_bytes() == CELL


def test_a_map_of_several_scans_is_refused():
    with pytest.raises(MapError, match='one scan'):
        MapDocument.from_bytes(TWO_SCANS).replace_points([[0, 0]])


POINTS = st.lists(st.tuples(*[st.integers(-900_000, 900_000)] * 2), max_size=20)
LINES = st.lists(st.tuples(*[st.integers(-900_000, 900_000)] * 4), max_size=10)


@given(POINTS, LINES)
def test_any_rows_read_back_and_all_metadata_but_the_header_stays(points, lines):
    document = MapDocument.from_bytes(room_bytes())
    document.replace_points(points)
    document.replace_lines(lines)
    again = MapDocument.from_bytes(document.to_bytes())
    assert again.points.tolist() == [list(point) for point in sorted(set(points))]
    assert again.lines.tolist() == [list(line) for line in sorted(lines)]
    assert again.warnings == ()
    assert again.resolution == 50

    def metadata(data: bytes) -> list:
        return [line for line in data.splitlines() if line.split()[0].endswith(b'nfo:')
                or b'airn:' in line]
    assert metadata(document.to_bytes()) == metadata(room_bytes())
