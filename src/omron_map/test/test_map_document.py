"""A map is read strictly, interpreted, and written back byte for byte."""
from __future__ import annotations

import hashlib
import os
import stat

import numpy as np
import pytest
from map_builders import CELL, TWO_SCANS, cell, room, room_bytes
from map_fixtures import BAD, ODD

from omron_map import Extent, MapDocument, MapError


@pytest.mark.parametrize('name', BAD)
def test_a_bad_file_is_refused_with_line_field_and_reason(name):
    bad = BAD[name]
    with pytest.raises(MapError) as caught:
        MapDocument.from_bytes(bad.data, 'bad.map')
    error = caught.value
    assert (error.file, error.line, error.field) == ('bad.map', bad.line, bad.field), str(error)
    assert bad.words in str(error)
    assert str(error).startswith('bad.map') and '\n' not in str(error)


@pytest.mark.parametrize('name', ODD)
def test_an_odd_file_loads_saves_back_unchanged_and_warns_where_it_must(name):
    odd = ODD[name]
    document = MapDocument.from_bytes(odd.data, 'odd.map')
    assert document.to_bytes() == odd.data
    warnings = [str(warning) for warning in document.warnings]
    if odd.warning is None:
        assert warnings == []
    else:
        assert len(warnings) == 1 and odd.warning in warnings[0], warnings


def test_rows_become_arrays_of_whole_millimetres():
    document = cell()
    assert document.points.dtype == document.lines.dtype == np.int32
    assert document.points.tolist() == [[-20, 0], [0, 0], [40, 20], [60, 40]]
    assert document.lines.tolist() == [[-23, 0, 60, 0], [60, 0, 60, 41]]
    assert document.resolution == 20


@pytest.mark.parametrize('name', ['CRLF', 'blank lines', 'tabs', 'no final newline',
                                  'DATA before LINES', 'a section that goes on'])
def test_oddly_written_rows_are_the_same_numbers(name):
    document = MapDocument.from_bytes(ODD[name].data)
    assert document.points.tolist() == cell().points.tolist()
    assert document.lines.tolist() == cell().lines.tolist()


def test_objects_are_found_in_file_order_and_by_what_they_are():
    document = room()
    assert [obj.kind for obj in document.objects] == [
        'ForbiddenArea', 'MovementParametersSector', 'DockLynx', 'FeedbackHandler', 'Goal',
        'ForbiddenLine', 'RobotHome', 'StandbyGoalWithHeading', 'ForbiddenArea', 'GoalWithHeading']
    assert [goal.name for goal in document.goals] == ['Shelf A', 'Rest 1', 'Türe 門']
    assert [dock.name for dock in document.docks] == ['Dock']
    assert [area.name for area in document.forbidden_areas] == ['', 'Keep out']
    assert [line.extent for line in document.forbidden_lines] == [Extent(500, -900, 500, 400)]
    assert [sector.name for sector in document.sectors] == ['Crawl']
    assert [home.extent for home in document.homes] == [Extent(900, 100, 1300, 500)]
    assert document.category == '2D-Map-Ex4'


def test_inactive_and_child_objects_are_no_objects():
    assert room().find('Switched off') is None
    assert room().find('Inner dock') is None


def test_names_are_looked_up_without_regard_to_case_and_the_first_wins():
    assert room().find('SHELF a').x == 0
    twice = MapDocument.from_bytes(ODD['a name twice'].data)
    assert twice.find('north').x == 20


def test_the_fields_of_an_object_are_read_by_the_quoting_rule():
    goal = room().find('Shelf A')
    assert (goal.description, goal.icon) == ('with, a comma', 'ICON')
    assert room().find('Rest 1').icon == 'ID=3'
    assert MapDocument.from_bytes(ODD['a quote inside a name'].data).goals[0].name == '6"x9 pipe'
    assert MapDocument.from_bytes(ODD['tabs'].data).goals[0].name == 'a\tb'


def test_a_name_that_is_not_utf8_is_kept_and_can_be_shown():
    goal = MapDocument.from_bytes(ODD['a name in Latin-1'].data).goals[0]
    assert goal.name.encode('utf-8', 'surrogateescape') == b'K\xfcche'
    assert goal.label == 'Küche'


def test_each_scan_has_its_own_rows_and_pitch():
    document = MapDocument.from_bytes(TWO_SCANS)
    high, low = document.scans
    assert (high.name, high.resolution, high.points.tolist()) == (
        'High', 100, [[0, 0], [100, 100], [200, 0]])
    assert (low.name, low.resolution, low.points.tolist()) == ('Low', 50, [[50, 50], [50, 150]])
    assert len(document.points) == 5 and len(document.lines) == 1
    assert document.resolution is None, 'the scans differ'


def test_the_first_scan_may_go_without_its_name():
    high, low = MapDocument.from_bytes(ODD['first scan without its name'].data).scans
    assert (high.name, high.resolution, len(high.points)) == ('SickLaser', 100, 3)
    assert (low.name, low.resolution, len(low.points)) == ('Low', 50, 2)


def test_no_pitch_is_none():
    assert MapDocument.from_bytes(ODD['lines and no DATA'].data).resolution is None
    assert MapDocument.from_bytes(CELL.replace(b'Resolution: 20', b'Resolution: -1')
                                  ).resolution is None


def test_a_turned_polygon_is_drawn_as_its_rectangle():
    straight = MapDocument.from_bytes(ODD['a polygon and unknown lines'].data).sectors[0]
    assert straight.outline.tolist() == [[0, 0], [60, 0], [60, 40], [30, 60], [0, 40]]
    turned = MapDocument.from_bytes(ODD['a turned polygon'].data).sectors[0]
    assert len(turned.outline) == 4


def test_a_missing_file_is_told_by_name(tmp_path):
    with pytest.raises(MapError, match=r'gone\.map: it cannot be read \(No such file'):
        MapDocument.load(str(tmp_path / 'gone.map'))


def test_nothing_of_the_configuration_gets_into_errors_and_warnings():
    secret = b'CustomInfo: ConfigParam "Name=Password" "Value=hush-hush\n'
    document = MapDocument.from_bytes(CELL.replace(b'LINES\n', secret + b'LINES\n', 1))
    assert not any('hush' in str(warning) for warning in document.warnings)
    with pytest.raises(MapError) as caught:
        MapDocument.from_bytes(CELL + secret)
    assert 'hush' not in str(caught.value)


class TestSaving:
    def test_the_file_holds_the_same_bytes(self, tmp_path):
        path = tmp_path / 'room.map'
        room().save(str(path))
        assert hashlib.md5(path.read_bytes()).digest() == hashlib.md5(room_bytes()).digest()

    def test_nothing_else_is_left_in_the_folder(self, tmp_path):
        room().save(str(tmp_path / 'room.map'))
        assert os.listdir(str(tmp_path)) == ['room.map']

    def test_the_old_file_is_kept_on_request(self, tmp_path):
        path = tmp_path / 'room.map'
        path.write_bytes(b'old')
        room().save(str(path), backup=True)
        assert (tmp_path / 'room.map.bak').read_bytes() == b'old'
        assert path.read_bytes() == room_bytes()

    def test_mode_and_link_are_kept(self, tmp_path):
        target, link = tmp_path / 'target.map', tmp_path / 'link.map'
        target.write_bytes(b'old')
        target.chmod(0o640)
        link.symlink_to(target)
        room().save(str(link))
        assert link.is_symlink() and target.read_bytes() == room_bytes()
        assert stat.S_IMODE(target.stat().st_mode) == 0o640

    def test_a_write_that_fails_leaves_the_old_file_and_says_why(self, tmp_path, monkeypatch):
        path = tmp_path / 'room.map'
        path.write_bytes(b'old')

        def full(handle):
            raise OSError(28, 'No space left on device')
        monkeypatch.setattr(os, 'fsync', full)
        with pytest.raises(MapError, match=r'room\.map: it cannot be written \(No space left'):
            room().save(str(path))
        assert path.read_bytes() == b'old'
        assert os.listdir(str(tmp_path)) == ['room.map']

    def test_a_folder_that_is_not_there_is_told(self, tmp_path):
        with pytest.raises(MapError, match='cannot be written'):
            room().save(str(tmp_path / 'no' / 'room.map'))
