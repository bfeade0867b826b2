"""Differences between two maps are found by name, or by equality if there is no name."""
from __future__ import annotations

from map_builders import map_bytes, room

from omron_map import MapDocument, MapObject, RotatedRectangle
from omron_map.compare import compare


def test_a_map_does_not_differ_from_itself():
    assert not compare(room(), room())


def test_an_object_that_moved_is_one_change_whatever_its_place_in_the_file():
    new = room()
    new.move(new.find('Dock'), 2900, 900, 0)
    difference = compare(room(), new)
    (old_dock, new_dock), = difference.changed
    assert (old_dock.x, new_dock.x) == (-800, 2900)
    assert difference.added == difference.removed == ()


def test_a_renamed_object_is_one_removed_and_one_added():
    new = room()
    new.rename(new.find('Dock'), 'Station')
    difference = compare(room(), new)
    assert [obj.name for obj in difference.removed] == ['Dock']
    assert [obj.name for obj in difference.added] == ['Station']


def test_unnamed_areas_are_paired_only_when_they_are_equal():
    new = room()
    unnamed = new.forbidden_areas[0]
    new.move(unnamed, 0, 0)
    difference = compare(room(), new)
    assert difference.removed == (unnamed,) and len(difference.added) == 1
    twice = room()
    twice.add(MapObject.forbidden_area(RotatedRectangle.from_extent(unnamed.extent,
                                                                    unnamed.theta)))
    assert len(compare(room(), twice).added) == 1, 'a second equal area must count as added'


def test_rows_are_counted_each_way():
    old = MapDocument.from_bytes(map_bytes([(0, 0), (0, 50)], [(0, 0, 1, 1)]))
    new = MapDocument.from_bytes(map_bytes([(0, 50), (50, 50), (100, 50)]))
    difference = compare(old, new)
    assert (difference.points_added, difference.points_removed) == (2, 1)
    assert (difference.lines_added, difference.lines_removed) == (0, 1)
