"""The maps of two real robots, if they are present: nothing is lost, and everything is found.

The maps belong to other people and contain a robot's configuration. So they are not in the
repository.
"""
from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from omron_map import OCCUPIED, MapDocument, MapObject, OccupancyGrid, RotatedRectangle

FOLDER = os.environ.get('LD90_REAL_MAPS', '')


def load(name: str) -> MapDocument:
    path = Path(FOLDER) / name
    if not FOLDER or not path.exists():
        pytest.skip(f'there is no real map {name} in LD90_REAL_MAPS="{FOLDER}"')
    return MapDocument.load(str(path))


@pytest.fixture
def site_a() -> MapDocument:
    return load('omron-ld-site-a.map')


@pytest.fixture
def site_b() -> MapDocument:
    return load('omron-ld-site-b.map')


def test_they_are_written_back_byte_for_byte_and_nothing_in_them_is_odd(site_a, site_b):
    for document in (site_a, site_b):
        assert document.to_bytes() == Path(document.name).read_bytes()
        assert document.warnings == ()


def test_site_a_is_counted(site_a):
    assert (len(site_a.points), len(site_a.lines), site_a.resolution) == (44440, 299, 20)
    assert sorted(area.name for area in site_a.forbidden_areas) == [f'FA{n}' for n in range(6)]
    goal, = site_a.goals
    assert (goal.name, goal.x, goal.y, goal.theta, goal.has_heading) == (
        'Goal1', 1240, 8152, 90, True)
    assert site_a.docks == site_a.sectors == ()


def test_site_b_is_counted(site_b):
    assert (len(site_b.points), len(site_b.lines)) == (3737, 19)
    assert [dock.name for dock in site_b.docks] == ['LD/Lynx Dock3']
    assert [goal.name for goal in site_b.goals] == ['Goal1', 'Goal2']
    assert len(site_b.forbidden_areas) == 4


def test_every_point_has_a_cell_of_its_own(site_a, site_b):
    for document, count in ((site_a, 44440), (site_b, 3737)):
        grid = OccupancyGrid.from_map(document)
        assert np.count_nonzero(grid.cells == OCCUPIED) == count
    assert (grid.width, grid.height) == (845, 772)


def test_no_goal_or_dock_stands_in_a_forbidden_area(site_a, site_b):
    for document in (site_a, site_b):
        places = np.array([(obj.x, obj.y) for obj in document.goals + document.docks])
        for area in document.forbidden_areas:
            assert not area.rectangle.contains(places).any()


def test_an_edit_there_and_back_gives_the_same_bytes(site_a, site_b):
    for document in (site_a, site_b):
        before = document.to_bytes()
        document.add(MapObject.goal('Visitor', 1000, 1000, heading=45))
        document.add(MapObject.forbidden_area(RotatedRectangle(0, 0, 500, 300, 15), 'Cordon'))
        assert len(document.to_bytes()) > len(before)
        document.remove(document.find('Visitor'))
        document.remove(document.find('Cordon'))
        assert document.to_bytes() == before
