"""The controller's password, its comparison of goals, and the poses that it takes."""
from __future__ import annotations

import math
import time
from pathlib import Path

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper
from geometry_msgs.msg import PoseStamped

from omron_ld90.nodes.controller import PASSWORD_VARIABLE, read_password
from omron_ld90.nodes.controller_actions import Refused, robot_pose
from omron_ld90.nodes.controller_goals import GoalComparison
from omron_ld90.nodes.support.startup import ConfigurationError
from omron_map import MapDocument, MapError

LAB = Path(__file__).resolve().parents[4] / 'maps' / 'lab.map'


# --- password -------------------------------------------------------------------------------------

@pytest.mark.parametrize('content', [b'secret', b'secret\n', b' secret\r\n'])
def test_the_password_is_what_the_file_holds(tmp_path, content):
    path = tmp_path / 'password'
    path.write_bytes(content)
    assert read_password(str(path)) == b'secret'


def test_without_a_file_the_environment_has_the_password(monkeypatch):
    monkeypatch.setenv(PASSWORD_VARIABLE, 'secret')
    assert read_password('') == b'secret'


@pytest.mark.parametrize('content', [b'', b'\n', b'sec\nret', b'sec\x00ret', b's\xe9cret'])
def test_an_unusable_password_is_refused_and_not_shown(tmp_path, content):
    path = tmp_path / 'file'
    path.write_bytes(content)
    with pytest.raises(ConfigurationError) as refused:
        read_password(str(path))
    assert str(path) in str(refused.value)
    assert 'ret' not in str(refused.value)


def test_a_missing_password_file_is_named(tmp_path):
    with pytest.raises(ConfigurationError, match='No such file'):
        read_password(str(tmp_path / 'none'))


def test_without_any_password_both_ways_are_named(monkeypatch):
    monkeypatch.delenv(PASSWORD_VARIABLE, raising=False)
    with pytest.raises(ConfigurationError, match=f'~password_file.*{PASSWORD_VARIABLE}'):
        read_password('')


# --- goals ----------------------------------------------------------------------------------------

def compared(goals: GoalComparison) -> DiagnosticStatusWrapper:
    """What /diagnostics says once the comparison is done."""
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


# --- poses ----------------------------------------------------------------------------------------

def pose(x: float = 1.0, y: float = 2.0, yaw: float = 0.0, frame: str = 'map') -> PoseStamped:
    stamped = PoseStamped()
    stamped.header.frame_id = frame
    stamped.pose.position.x, stamped.pose.position.y = x, y
    stamped.pose.orientation.z, stamped.pose.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
    return stamped


def test_a_pose_becomes_whole_millimetres_and_degrees():
    assert robot_pose(pose(1.2345, -2.0, math.radians(-90)), 'map') == (1234, -2000, -90)


@pytest.mark.parametrize(('bad', 'reason'), [
    (pose(frame='odom'), '"odom"'), (pose(frame=''), '""'), (pose(x=math.nan), 'finite'),
    (pose(y=math.inf), 'finite'), (pose(x=1e9), 'away'), (PoseStamped(), 'frame'),
])
def test_a_pose_that_is_none_is_refused(bad, reason):
    with pytest.raises(Refused, match=reason):
        robot_pose(bad, 'map')


def test_an_orientation_that_is_none_is_refused():
    bad = pose()
    bad.pose.orientation.w = 0.0
    with pytest.raises(Refused, match='unit quaternion'):
        robot_pose(bad, 'map')
