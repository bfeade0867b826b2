"""The goals that the robot lists are compared with those of the map file."""
from __future__ import annotations

import time
from pathlib import Path

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from omron_ld90.nodes.controller_goals import GoalComparison
from omron_map import MapDocument, MapError

LAB = Path(__file__).resolve().parents[4] / 'maps' / 'lab.map'


def compared(goals: GoalComparison) -> DiagnosticStatusWrapper:
    """Returns the entry in /diagnostics after the comparison."""
    deadline = time.monotonic() + 10.0
    while time.monotonic() < deadline:
        status = goals.diagnose(DiagnosticStatusWrapper())
        if 'not listed' not in status.message:
            return status
        time.sleep(0.01)
    raise AssertionError('the goals were not compared')


@pytest.fixture
def lab_goals() -> frozenset:
    return frozenset(goal.name for goal in MapDocument.load(str(LAB)).goals)


def test_equal_goals_are_well_whatever_their_case(lab_goals):
    goals = GoalComparison(str(LAB))
    goals.robot_goals(frozenset(name.upper() for name in lab_goals))
    assert compared(goals).level == DiagnosticStatus.OK
    goals.close()


def test_goals_that_only_one_side_has_are_named(lab_goals):
    goals = GoalComparison(str(LAB))
    goals.robot_goals(lab_goals - {'8'} | {'kitchen'})
    status = compared(goals)
    assert status.level == DiagnosticStatus.WARN
    values = {value.key: value.value for value in status.values}
    assert values['only in the robot'] == 'kitchen'
    assert values['only in the map file'] == '8'
    goals.close()


def test_a_map_file_that_is_missing_is_a_warning(tmp_path):
    goals = GoalComparison(str(tmp_path / 'none.map'))
    goals.robot_goals(frozenset({'8'}))
    status = compared(goals)
    assert status.level == DiagnosticStatus.WARN
    assert 'none.map' in status.message
    goals.close()


def test_a_map_that_is_being_made_is_waited_for(lab_goals):
    waited = []

    def wait(path, made_from, **_):
        waited.append((path, made_from))
        if len(waited) == 1:
            raise MapError(path, 'not there yet')
    goals = GoalComparison(str(LAB), ('base.map', 'graph.yaml'), wait)
    goals.robot_goals(lab_goals)
    assert 'not there yet' in compared(goals).message
    assert waited == [(str(LAB), ('base.map', 'graph.yaml'))]
    goals.close()


@pytest.mark.parametrize('written', ['K\xfcche'.encode(), b'K\xfcche'])
def test_a_name_that_is_not_ascii_is_the_same_in_either_encoding(tmp_path, written):
    path = tmp_path / 'site.map'
    path.write_bytes(b'2D-Map\nCairn: Goal 0 0 0.000000 "" ICON "' + written + b'"\nDATA\n')
    goals = GoalComparison(str(path))
    goals.robot_goals(frozenset({'K\xfcche'}))
    assert compared(goals).level == DiagnosticStatus.OK
    goals.close()


def test_what_only_one_side_has_can_be_shown(tmp_path):
    path = tmp_path / 'site.map'
    path.write_bytes(b'2D-Map\nCairn: Goal 0 0 0.000000 "" ICON "K\xfcche"\nDATA\n')
    goals = GoalComparison(str(path))
    goals.robot_goals(frozenset({'a\x1b[2J'}))
    values = {value.key: value.value for value in compared(goals).values}
    assert values['only in the robot'] == r'a\x1b[2J'
    assert values['only in the map file'] == 'K\xfcche'
    goals.close()
