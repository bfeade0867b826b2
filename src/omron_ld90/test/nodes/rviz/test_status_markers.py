"""The status line of a robot, and the display of a robot that no longer reports."""
from __future__ import annotations

import math

import pytest
import rospy
from geometry_msgs.msg import Pose
from visualization_msgs.msg import Marker

from omron_ld90.nodes.rviz.status_markers import (
    CARE,
    LIFETIME,
    WELL,
    WRONG,
    banner,
    status_markers,
)
from omron_ld90_msgs.msg import LinkState, RobotStatus

SILENCE = 3.0
UP = [LinkState(link='commands', state=LinkState.CONNECTED),
      LinkState(link='outgoing', state=LinkState.CONNECTED)]


def status(**fields) -> RobotStatus:
    return RobotStatus(**{'status': 'Going to 12', 'state_of_charge': 0.79, **fields})


def words(message, silent_for=0.1, links=UP):
    return banner('ld', message, silent_for, links, SILENCE)


def test_name_battery_state_and_link_stand_in_one_line():
    assert words(status()) == ('ld | battery 79 % | Going to 12 | link ok', WELL)


def test_a_charge_that_the_robot_did_not_send_is_left_out():
    assert words(status(state_of_charge=math.nan)).text == 'ld | Going to 12 | link ok'


def test_a_docked_robot_is_told_in_short():
    docked = status(status='DockingState: Docked ForcedState: Unforced ChargeState: Float',
                    activity=RobotStatus.DOCKED, docking_state='Docked', charge_state='Float')
    assert words(docked).text == 'ld | battery 79 % | Docked, charger Float | link ok'


def test_what_a_robot_does_away_from_the_dock_is_told_in_its_own_words():
    driving = status(activity=RobotStatus.GOING_TO_GOAL, docking_state='Undocked',
                     charge_state='Not')
    assert words(driving).text == 'ld | battery 79 % | Going to 12 | link ok'


@pytest.mark.parametrize('message, text, paint', [
    (status(state_of_charge=0.1), 'battery 10 %', CARE),
    (status(emergency_stop=True), 'EMERGENCY STOP', WRONG),
    (None, 'no status yet', CARE),
])
def test_what_needs_care_stands_out(message, text, paint):
    told = words(message)
    assert text in told.text
    assert told.paint is paint


def test_a_robot_that_fell_silent_shows_no_old_battery():
    told = words(status(), silent_for=12.4)
    assert told == ('ld | silent for 12 s | link ok', WRONG)


def test_a_broken_link_is_told_with_its_reason():
    broken = LinkState(link='commands', state=LinkState.WRONG_PASSWORD,
                       reason='the robot refused the password')
    told = words(status(), links=[broken, UP[1]])
    assert 'commands link wrong password' in told.text
    assert told.text.endswith('\nthe robot refused the password')
    assert told.paint is WRONG


def shown(alive: bool, destination=None, body=()) -> dict:
    pose = Pose()
    pose.position.x, pose.orientation.w = 2.0, 1.0
    array = status_markers('map', words(status()), (0.0, 10.0), pose, alive, destination, body)
    return {marker.ns: marker for marker in array.markers}


def test_a_robot_that_is_there_is_an_arrow_and_a_ring_where_it_goes():
    assert set(shown(alive=True, destination=(3.0, 3.0))) == {'status', 'robot', 'destination'}


def test_a_robot_that_is_gone_is_no_arrow_but_a_note_where_it_was_last_seen():
    markers = shown(alive=False, destination=(3.0, 3.0))
    assert set(markers) == {'status', 'last_seen', 'last_seen_words'}
    assert markers['last_seen'].pose.position.x == 2.0


def test_only_a_robot_that_is_there_has_a_body():
    assert 'body' in shown(alive=True, body=[Marker(ns='body')])
    assert 'body' not in shown(alive=False, body=[Marker(ns='body')])


def test_everything_goes_away_by_itself():
    for alive in (True, False):
        markers = shown(alive, body=[Marker(ns='body')])
        assert {marker.lifetime for marker in markers.values()} == {rospy.Duration(LIFETIME)}
