"""A RobotHome from which no goal can be reached is reported; others are not."""
from __future__ import annotations

import pytest
from map_builders import map_bytes

from omron_map import MapDocument, MapObject, RotatedRectangle
from omron_map.cli import main
from omron_map.reach import cut_off_homes


def hall(*objects: MapObject, gap: int = 0,
         home: str = '2000 0 0.000000 "" ICON ""') -> MapDocument:
    """Returns a hall of 10 x 4 m. The wall at x = 5 m has a door of `gap` mm."""
    outer = [(0, -2000, 10000, -2000), (0, -2000, 0, 2000), (0, 2000, 10000, 2000),
             (10000, -2000, 10000, 2000)]
    wall = [(5000, -2000, 5000, -gap // 2), (5000, gap - gap // 2, 5000, 2000)]
    document = MapDocument.from_bytes(map_bytes(
        lines=outer + wall, objects=f'Cairn: RobotHome {home}\n'), 'hall.map')
    for obj in objects:
        document.add(obj)
    return document


FAR = MapObject.goal('Far', 8000, 0)


@pytest.mark.parametrize('gap, cut_off', [(0, True), (450, True), (600, False), (2000, False)])
def test_a_robot_gets_through_a_door_that_is_wider_than_itself(gap, cut_off):
    assert bool(cut_off_homes(hall(FAR, gap=gap))) is cut_off


def test_the_warning_names_the_line():
    warning, = cut_off_homes(hall(FAR))
    assert str(warning) == ('line 6: RobotHome is cut off: a robot that starts there reaches no '
                            'goal and no dock')


def test_one_goal_or_dock_on_its_side_is_enough():
    assert cut_off_homes(hall(FAR, MapObject.goal('Near', 3000, 1000))) == []
    assert cut_off_homes(hall(FAR, MapObject.dock('Dock', 3000, 1000, 0.0))) == []


@pytest.mark.parametrize('fence', [
    MapObject.forbidden_area(RotatedRectangle(5000, 0, 300, 3000, 0)),
    MapObject.forbidden_line(5000, -1000, 5000, 1000)])
def test_what_is_forbidden_is_in_the_way_too(fence):
    assert cut_off_homes(hall(FAR, gap=1000)) == []
    assert cut_off_homes(hall(FAR, fence, gap=1000))


def test_of_a_home_with_an_area_one_free_spot_is_enough():
    across = '0 0 0.000000 "" ICON "" 4000 -500 6000 500'
    assert cut_off_homes(hall(FAR, home=across)) == []
    assert cut_off_homes(hall(FAR, home='0 0 0.000000 "" ICON "" 3000 -500 4500 500'))


def test_nothing_is_said_where_there_is_nowhere_to_go():
    assert cut_off_homes(hall()) == []


def test_nothing_is_said_of_a_map_that_is_too_large_to_be_searched():
    assert cut_off_homes(hall(FAR, MapObject.goal('Beyond', 900_000, 900_000))) == []


def test_ld_map_check_tells_it(tmp_path, capsys):
    path = str(tmp_path / 'hall.map')
    hall(FAR).save(path)
    assert main(['check', path]) == 0
    assert f"{path}: warning: line 6: RobotHome is cut off" in capsys.readouterr().out
