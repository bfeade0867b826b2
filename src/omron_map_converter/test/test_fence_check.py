"""Tests the fence checker with fences that are known to be bad, and with a flood fill."""
import math

import numpy as np
import pytest
from converter_builders import LAB, graph_of
from fence_builders import NO_WALLS, fenced, grid
from scipy import ndimage
from shapely.geometry import Point

from omron_map import MapDocument, MapObject, RotatedRectangle
from omron_map_converter.fence_check import check_fences, lost_area, shape_of
from omron_map_converter.fences import is_fence
from omron_map_converter.obstacles import obstacle_points
from trajectory_graph import load_graph

AISLE = graph_of([(1, 0.0, 0.0), (2, 6.0, 0.0)], [(1, 2)])


def test_without_fences_everything_leaks():
    corridors, _ = fenced(AISLE)
    assert len(check_fences(AISLE, corridors, [], NO_WALLS).leaks) >= 1


def test_each_missing_fence_is_found_where_it_was():
    graph = grid(3, 2)
    corridors, fences = fenced(graph)
    for missing in fences:
        rest = [fence for fence in fences if fence is not missing]
        leaks = check_fences(graph, corridors, rest, NO_WALLS).leaks
        assert leaks, missing
        near = [shape_of(missing).distance(Point(leak)) < 600 for leak in leaks]
        assert any(near), (missing, leaks)


@pytest.mark.parametrize('gap, leaks', [(480, 0), (520, 1)])
def test_a_gap_counts_from_the_width_of_the_robot(gap, leaks):
    corridors, _ = fenced(AISLE)
    around = [RotatedRectangle(3000, -560, 9000, 200, 0), RotatedRectangle(-700, 0, 200, 1300, 0),
              RotatedRectangle(6700, 0, 200, 1300, 0),
              RotatedRectangle(3000 - gap / 2 - 2000, 560, 4000, 200, 0),
              RotatedRectangle(3000 + gap / 2 + 2000, 560, 4000, 200, 0)]
    check = check_fences(AISLE, corridors, map(MapObject.forbidden_area, around), NO_WALLS)
    assert len(check.leaks) == leaks
    for x, y in check.leaks:
        assert math.dist((x, y), (3000, 500)) < 100


@pytest.mark.parametrize('y, lost', [(560, 0.0), (548, 0.0), (500, 4000 * 47.5)])
def test_floor_that_a_fence_takes_is_measured(y, lost):
    corridors, _ = fenced(AISLE)
    fence = MapObject.forbidden_area(RotatedRectangle(3000, y, 4000, 200, 0))
    assert lost_area(corridors.floor, [shape_of(fence)]) == pytest.approx(lost, rel=0.02)


def test_a_line_through_a_corridor_is_found():
    corridors, fences = fenced(AISLE)
    across = MapObject.forbidden_line(3000, -1000, 3000, 1000)
    assert not check_fences(AISLE, corridors, [*fences, across], NO_WALLS).passed


def test_a_flood_fill_on_the_laboratory_map_stays_in_the_corridors():
    """The same check on a grid: the pixels that the centre of a disc of 250 mm can reach."""
    pitch = 20.0
    graph = load_graph(str(LAB / 'lab_graph.yaml'))
    document = MapDocument.load(str(LAB / 'lab.map'))
    low, high = np.array([-15500.0, -9500.0]), np.array([15500.0, 9500.0])
    x, y = (np.arange(a, b, pitch) for a, b in zip(low, high))
    cells = np.stack(np.meshgrid(x, y, indexing='ij'), axis=-1)

    def mask(points):
        marked = np.zeros(cells.shape[:2], bool)
        index = np.round((points - low) / pitch).astype(int)
        marked[tuple(index.T)] = True
        return marked

    blocked = mask(obstacle_points(document, ignored=lambda obj: True))
    for area in document.forbidden_areas:
        blocked |= area.rectangle.contains(cells)
    free = ndimage.distance_transform_edt(~blocked) * pitch > 250.0
    rooms, _ = ndimage.label(free)
    starts = np.array([vertex.position for vertex in graph.vertices.values()]) * 1000.0
    reached = np.isin(rooms, np.unique(rooms[mask(starts) & free]))
    curves = mask(np.concatenate([graph.curve(id).sample(0.01) * 1000.0 for id in graph.edges]))
    too_far = ndimage.distance_transform_edt(~curves) * pitch > 500.0
    dock = document.docks[0]
    too_far &= ~RotatedRectangle(dock.x - 750, dock.y, 1500, 900, 0).contains(cells)
    assert np.all((mask(starts) & ~reached).sum() == 0), 'a vertex cannot be reached'
    assert not (reached & too_far).any(), cells[reached & too_far][:5]


def test_the_laboratory_map_would_leak_without_its_fences():
    document = MapDocument.load(str(LAB / 'lab.map'))
    assert any(map(is_fence, document.objects))
    corridors, _ = fenced(load_graph(str(LAB / 'lab_graph.yaml')))
    walls = obstacle_points(document, ignored=is_fence)
    assert check_fences(load_graph(str(LAB / 'lab_graph.yaml')), corridors, [], walls).leaks
