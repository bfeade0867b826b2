"""The data store: values that follow the robot."""
from __future__ import annotations

from typing import Dict, List

import pytest
from sim_builders import Rig


def values(lines: List[str]) -> Dict[str, float]:
    """Returns the numbers in the lines `...: <field> <value>`, by field."""
    rows = (line.split(' ') for line in lines if ': ' in line)
    return {row[1]: float(row[2]) for row in rows}


def test_the_data_store_follows_the_robot_on_its_way() -> None:
    rig = Rig()
    client = rig.client()
    client.send('goto 12')
    rig.clock.advance(4.0)
    client.lines()
    driving = values(client.ask('dsfv TransVel', 'dsfv Distance_to_goal', 'dsfv RobotX'))
    assert driving['TransVel'] > 500.0 and driving['Distance_to_goal'] > 5000.0, driving
    assert driving['RobotX'] == pytest.approx(rig.robot.pose.x, abs=0.5)
    client.until('Arrived')
    assert values(client.ask('dsgv Path_Planning', 'dsgv Velocities')) == {
        'Distance_to_goal': 0.0, 'TransVel': 0.0}


def test_the_wheels_count_from_where_the_robot_was_switched_on() -> None:
    rig = Rig(start=(-2500.0, 1000.0, 90.0))
    client = rig.client()
    for task in ('move 500', 'deltaHeading 90'):
        client.send(f'doTask {task}')
        client.until(f'Completed doing task {task}')
    assert values(client.ask('dsgv EncoderPose')) == {
        'EncoderX': 500.0, 'EncoderY': 0.0, 'EncoderTh': 90.0}


def test_the_data_store_counts_the_hours_of_each_state_and_the_trip_anew() -> None:
    rig = Rig(start=None)  # the robot starts in its dock
    client = rig.client()
    rig.clock.advance(3600.0)
    rig.robot.permission.press_estop()
    rig.clock.advance(3600.0 * 3)
    docked = values(client.ask('dsgv StateInformation'))
    assert (docked['DockedTime'], docked['InEstopTime']) == (1.0, 2.0)
    client.ask('tripReset')
    rig.robot.permission.release_estop()
    client.send('enableMotors')
    rig.clock.advance(3600.0 * 5)
    trip = values(client.ask('dsgv TripStateInformation'))
    assert (trip['TripDockedTime'], trip['TripInEstopTime']) == (2.0, 0.0), trip
    whole = values(client.ask('dsgv StateInformation'))
    assert (whole['DockedTime'], whole['InEstopTime']) == (3.0, 2.0), whole
    assert values(client.ask('dsfv SecsSinceLastTripReset')) == {'SecsSinceLastTripReset': 7200.0}


def test_the_way_to_the_dock_and_a_driving_fault_are_counted() -> None:
    rig = Rig()
    client = rig.client()
    client.send('dock')
    client.until('DockingState: Docked')
    state = values(client.ask('dsgv StateInformation'))
    assert 0.0 < state['DockingTime'] < 0.1
    assert state['DockingDistance'] == pytest.approx(rig.robot.base.driven / 1000.0, abs=0.5)
    client.ask('afs jam "Jam" "Too sweet" 1 0')
    rig.clock.advance(rig.clock.now + 1800.0)
    assert values(client.ask('dsfv InFaultTime'))['InFaultTime'] == 0.5
