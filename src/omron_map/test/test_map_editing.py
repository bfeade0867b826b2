"""Edits change only the necessary lines; objects are placed where the vendor's tools place them."""
from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from map_builders import CELL, GROUPS, OBJECTS, cell, changed_lines, map_bytes, room, room_bytes
from map_fixtures import GOAL, ODD

from omron_map import (
    DuplicateName,
    Extent,
    MapDocument,
    MapError,
    MapObject,
    RotatedRectangle,
)


def line_of(document: MapDocument, name: str) -> int:
    """Returns the line number of the object called `name`."""
    return next(number for number, record in enumerate(document.records, 1)
                if record.object is not None and record.object.name == name)


JUMBLED = ''.join(reversed(OBJECTS.splitlines(keepends=True)))
PLACES = st.sampled_from([-4900, -800, 0, 1, 500, 2500])
NEW_OBJECTS = st.lists(st.one_of(
    st.builds(MapObject.goal, st.sampled_from('ABCDEFGH'), PLACES, PLACES),
    st.builds(MapObject.forbidden_line, PLACES, PLACES, PLACES, PLACES, st.sampled_from('IJKLMN'))),
    unique_by=lambda obj: obj.name)


class TestAdding:
    def test_one_line_is_new_and_the_rest_is_the_same(self):
        document = room()
        document.add(MapObject.goal('New', 200, 100))
        assert changed_lines(room_bytes(), document.to_bytes()) == (
            [], [b'Cairn: Goal 200 100 0.000000 "" ICON "New"'])

    def test_it_goes_where_its_stored_position_belongs(self):
        document = room()
        document.add(MapObject.goal('New', 200, 100))
        assert line_of(document, 'Shelf A') + 1 == line_of(document, 'New')
        document.add(MapObject.forbidden_area(RotatedRectangle(0, 0, 200, 100, 180), 'Fence'))
        names = [obj.name for obj in document.objects]
        assert names.index('Fence') == names.index('Replies') - 1, names

    def test_on_a_tie_the_point_goes_before_the_line(self):
        document = room()
        document.add(MapObject.goal('Tie', 500, -900))
        assert line_of(document, 'Tie') == line_of(document, 'Line') - 1

    def test_it_goes_last_where_the_objects_are_in_no_order(self):
        jumbled = GOAL + b'Cairn: Goal -5 0 0.000000 "" ICON "West"\n'
        document = MapDocument.from_bytes(CELL.replace(GOAL, jumbled))
        document.add(MapObject.goal('First', -900, 0))
        assert [obj.name for obj in document.objects] == ['North', 'West', 'First']

    @pytest.mark.parametrize('groups, before', [
        (GROUPS + '_MapInfo: SectorType Name=A\nChildCairn: Goal 0 0 0 "" ICON "c"\n', '_MapInfo:'),
        (GROUPS, 'LINES'), ('', 'LINES'), ('Unknown: line\n', 'Unknown:')])
    def test_the_first_object_goes_behind_the_info_lines(self, groups, before):
        document = MapDocument.from_bytes(map_bytes([(0, 0)], [(0, 0, 1, 0)], groups=groups))
        document.add(MapObject.goal('Only', 0, 0))
        lines = document.to_bytes().decode().splitlines()
        place = next(i for i, line in enumerate(lines) if line.startswith('Cairn:'))
        assert lines[place + 1].startswith(before)

    def test_a_name_that_is_there_is_refused_in_any_case(self):
        document = room()
        with pytest.raises(DuplicateName, match="Goal 'Shelf A' already"):
            document.add(MapObject.goal('shelf a', 5, 5))
        assert document.to_bytes() == room_bytes()

    def test_unnamed_areas_may_be_many(self):
        document = room()
        for x in (100, 200):
            document.add(MapObject.forbidden_area(RotatedRectangle(x, 0, 10, 10, 0)))
        assert len(document.forbidden_areas) == 4

    def test_what_cannot_be_written_changes_nothing_and_names_the_file(self):
        document = room()
        with pytest.raises(MapError, match=r'room\.map, name: .*double quote'):
            document.add(MapObject.goal('6"', 0, 0))
        assert document.to_bytes() == room_bytes()

    @given(NEW_OBJECTS, st.sampled_from([OBJECTS, JUMBLED, '']))
    def test_many_at_once_give_the_same_file_as_one_by_one(self, objects, present):
        at_once, one_by_one = (MapDocument.from_bytes(room_bytes(present)) for _ in range(2))
        at_once.add_all(objects)
        for obj in objects:
            one_by_one.add(obj)
        assert at_once.to_bytes() == one_by_one.to_bytes()

    @pytest.mark.parametrize('bad', [MapObject.goal('shelf a', 5, 5), MapObject.goal('new', 1, 1),
                                     MapObject.goal('6"', 0, 0)])
    def test_of_many_none_is_added_where_one_cannot_be(self, bad):
        document = room()
        with pytest.raises(MapError):
            document.add_all([MapObject.goal('New', 0, 0), bad])
        assert document.to_bytes() == room_bytes()

    def test_the_files_own_line_end_is_used(self):
        document = MapDocument.from_bytes(ODD['CRLF'].data)
        document.add(MapObject.goal('New', 0, 0))
        data = document.to_bytes()
        assert data.count(b'\r\n') == data.count(b'\n')

    def test_a_last_row_without_line_end_gets_one(self):
        document = MapDocument.from_bytes(ODD['no final newline'].data)
        document.add(MapObject.goal('New', 900, 0))
        assert document.to_bytes() == CELL.replace(
            GOAL, GOAL + b'Cairn: Goal 900 0 0.000000 "" ICON "New"\n')

    def test_a_dock_of_a_kind_that_the_map_does_not_declare_is_warned_of(self):
        document = room()
        document.add(MapObject.dock('Dock 2', 0, 0, 0, kind='DockHD'))
        assert [str(w) for w in document.warnings] == [
            f"line {line_of(document, 'Dock 2')}: DockHD 'Dock 2': the map declares other types, "
            'but not this one (MapInfo: DockType Name=DockHD)']


class TestMoving:
    def test_a_point_changes_its_own_line_only(self):
        document = room()
        document.move(document.find('Dock'), -700.4, -600, 270)
        assert changed_lines(room_bytes(), document.to_bytes()) == (
            [b'Cairn: DockLynx -800 -700 90.000000 "" ICON "Dock"'],
            [b'Cairn: DockLynx -700 -600 -90.000000 "" ICON "Dock"'])

    def test_it_goes_where_the_order_puts_it(self):
        document = room()
        document.move(document.find('Dock'), 9000, 0)
        assert document.objects[-1].name == 'Dock'
        assert document.find('Dock').theta == 90.0, 'the heading must be kept'

    def test_a_goal_without_heading_has_none_afterwards_either(self):
        document = room()
        document.move(document.find('Shelf A'), 10, 10, 45)
        assert document.find('Shelf A').theta == 0.0

    def test_of_an_area_the_centre_moves(self):
        document = room()
        document.move(document.find('Keep out'), 3000, 3000, 30)
        rectangle = document.find('Keep out').rectangle
        assert (rectangle.width, rectangle.height) == (3000, 1000)
        assert (rectangle.centre_x, rectangle.centre_y) == pytest.approx((3000, 3000), abs=1)

    def test_of_a_line_the_from_point_moves_and_the_rest_follows(self):
        document = room()
        document.move(document.find('Line'), 0, 0, 90)
        line = document.find('Line')
        assert (line.x, line.y, line.theta) == (0, 0, 0)
        assert line.extent == Extent(0, 0, 0, 1300)

    def test_an_object_with_a_polygon_is_not_moved(self):
        document = MapDocument.from_bytes(ODD['a polygon and unknown lines'].data)
        with pytest.raises(MapError, match='cannot be moved'):
            document.move(document.find('Poly'), 0, 0)

    @pytest.mark.parametrize('target', [(math.nan, 0, 0), (0, math.inf, 0), (0, 0, math.nan)])
    @pytest.mark.parametrize('name', ['Shelf A', 'Keep out', 'Line'])
    def test_a_place_that_is_no_place_is_refused(self, name, target):
        document = room()
        with pytest.raises(MapError, match='finite'):
            document.move(document.find(name), *target)
        assert document.to_bytes() == room_bytes()

    def test_an_object_of_another_map_is_refused(self):
        with pytest.raises(MapError, match='is not in the map'):
            room().move(MapObject.goal('Elsewhere', 0, 0), 1, 1)


class TestRenaming:
    def test_routes_and_parameters_follow(self):
        document = room()
        document.rename(document.find('Crawl'), 'Slow zone')
        assert changed_lines(room_bytes(), document.to_bytes()) == (
            [b'CairnInfo: Params "Crawl" "Slow" 250 0',
             b'Cairn: MovementParametersSector 0 0 -90.000000 "" ICON "Crawl" -900 300 -100 1100'],
            [b'CairnInfo: Params "Slow zone" "Slow" 250 0',
             b'Cairn: MovementParametersSector 0 0 -90.000000 "" ICON "Slow zone" '
             b'-900 300 -100 1100'])
        assert document.warnings == ()

    def test_lines_that_may_mean_the_object_are_left_and_told(self):
        document = room()
        document.rename(document.find('Shelf A'), 'Shelf B')
        data = document.to_bytes()
        assert b'RouteInfo: GoalAfter "Shelf B"\n' in data
        assert b'CairnInfo: Params "Rest 1" "Shelf A" false\n' in data
        told = [str(warning) for warning in document.warnings]
        assert len(told) == 2, told
        assert told[0].endswith("CairnInfo: still names 'Shelf A', now 'Shelf B'")
        assert told[1].endswith("TaskInfo: still names 'Shelf A', now 'Shelf B'")

    def test_upper_and_lower_case_may_change(self):
        document = room()
        document.rename(document.find('Shelf A'), 'SHELF A')
        assert document.find('shelf a').name == 'SHELF A'

    def test_the_name_of_another_object_is_refused(self):
        document = room()
        with pytest.raises(DuplicateName):
            document.rename(document.find('Shelf A'), 'dock')
        assert document.to_bytes() == room_bytes()

    def test_what_names_two_objects_stays_with_the_other(self):
        twice = OBJECTS + 'Cairn: Goal 2900 0 0.000000 "" ICON "Shelf A"\n'
        document = MapDocument.from_bytes(room_bytes(twice))
        document.rename(document.goals[0], 'Shelf B')
        assert b'RouteInfo: GoalAfter "Shelf A"\n' in document.to_bytes()

    @pytest.mark.parametrize('name', ['', 'a"b', 'a\nb'])
    def test_a_name_that_cannot_be_is_refused(self, name):
        document = room()
        with pytest.raises(MapError):
            document.rename(document.find('Shelf A'), name)
        assert document.to_bytes() == room_bytes()


class TestRemoving:
    def test_its_parameters_go_with_it(self):
        document = room()
        document.remove(document.find('Crawl'))
        removed, new = changed_lines(room_bytes(), document.to_bytes())
        assert new == [] and [line.split()[0] for line in removed] == [b'CairnInfo:', b'Cairn:']

    def test_what_still_names_it_is_told(self):
        document = room()
        document.remove(document.find('Shelf A'))
        told = [str(warning) for warning in document.warnings]
        assert any("RouteInfo: names 'Shelf A', which is not in the map" in text for text in told)
        assert any("TaskInfo: still names 'Shelf A', which was removed" in text for text in told)

    def test_adding_and_removing_gives_the_same_bytes(self):
        document = room()
        document.add(MapObject.goal('Guest', 123, 456, heading=7))
        document.remove(document.find('guest'))
        assert document.to_bytes() == room_bytes()

    def test_the_last_object_can_go(self):
        document = cell()
        document.remove(document.goals[0])
        assert document.objects == () and document.to_bytes() == CELL.replace(GOAL, b'')

    @given(st.permutations(range(10)), st.integers(0, 10))
    def test_many_at_once_give_the_same_file_as_one_by_one(self, order, count):
        at_once, one_by_one = room(), room()
        chosen = [at_once.objects[index] for index in order[:count]]
        at_once.remove_all(chosen)
        for obj in chosen:
            one_by_one.remove(obj)
        assert at_once.to_bytes() == one_by_one.to_bytes()
        assert at_once.warnings == one_by_one.warnings

    def test_of_many_none_is_removed_where_one_is_not_there(self):
        document = room()
        with pytest.raises(MapError, match='is not in the map'):
            document.remove_all([document.objects[0]] * 2)
        assert document.to_bytes() == room_bytes()

    def test_an_object_that_is_not_there_is_refused(self):
        with pytest.raises(MapError, match='is not in the map'):
            cell().remove(MapObject.goal('None', 0, 0))
