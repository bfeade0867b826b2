"""The robot's activity, read from a status text."""
from __future__ import annotations

import pytest

from omron_arcl import ActivityKind, read_activity
from omron_arcl.activity import MOVING, STANDING

K = ActivityKind


@pytest.mark.parametrize(('text', 'kind', 'goal'), [
    ('Stopped', K.STOPPED, ''), ('Stopping', K.STOPPING, ''), ('stopped', K.STOPPED, ''),
    ('Going to 12', K.GOING_TO_GOAL, '12'), ('Arrived at 12', K.ARRIVED_AT_GOAL, '12'),
    ('Going to "goal space"', K.GOING_TO_GOAL, 'goal space'),
    ('Going to K\xfcche', K.GOING_TO_GOAL, 'K\xfcche'),
    ('Going to point', K.GOING_TO_POINT, ''), ('Arrived at point', K.ARRIVED_AT_POINT, ''),
    ('Going to -597 -5765', K.GOING_TO_POINT, ''), ('Arrived at 1 2 90', K.ARRIVED_AT_POINT, ''),
    ('Failed going to 12', K.FAILED, '12'), ('Error: Cannot find path', K.FAILED, ''),
    ('Cannot find path', K.FAILED, ''),
    ('Interrupted: Going to 12', K.INTERRUPTED, '12'),
    ('Interrupted: Going to -597 -5765', K.INTERRUPTED, ''),
    ('Interrupted: Interrupted: Interrupted: x', K.INTERRUPTED, ''),
    ('DockingState: Docked ForcedState: Unforced ChargeState: Bulk', K.DOCKED, ''),
    ('DockingState: Undocking ForcedState: Unforced ChargeState: Not', K.UNDOCKING, ''),
    ('Docked', K.DOCKED, ''), ('Docking', K.DOCKING, ''), ('Driving into dock', K.DOCKING, ''),
    ('Going to dock at Dock1', K.DOCKING, 'Dock1'),
    ('Patrolling route r', K.PATROLLING, 'r'), ('Patrolling route r once', K.PATROLLING, 'r'),
    ('Finished patrolling route r', K.STOPPED, 'r'),
    ('Doing task wait 10', K.DOING_TASK, 'wait 10'), ('Executing macro m', K.DOING_TASK, 'm'),
    ('Completed doing task wait 10', K.STOPPED, 'wait 10'), ('Completed macro m', K.STOPPED, 'm'),
    ('Parking', K.PARKING, ''), ('Parked', K.PARKED, ''),
    ('Teleop driving', K.TELEOPERATED, ''), ('Teleop driving unsafely', K.TELEOPERATED, ''),
    ('EStop pressed', K.EMERGENCY_STOP, ''),
    ('EStop relieved but motors still disabled', K.EMERGENCY_STOP, ''),
    ('E-Stop pressed', K.EMERGENCY_STOP, ''), ('Emergency stop pressed', K.EMERGENCY_STOP, ''),
    ('Motors disabled', K.MOTORS_DISABLED, ''), ('Robot lost', K.LOST, ''),
    ('', K.UNKNOWN, ''), ('Waiting for a friend', K.UNKNOWN, ''), ('Driving', K.UNKNOWN, ''),
    ('Motors enabled', K.UNKNOWN, ''), ('Location: 1 2 3', K.UNKNOWN, ''),
])
def test_a_status_text_is_read(text, kind, goal):
    activity = read_activity(text)
    assert (activity.kind, activity.goal) == (kind, goal)


def test_the_robot_moves_or_stands_or_neither_is_known():
    assert not MOVING & STANDING
    assert set(ActivityKind) - MOVING - STANDING == {K.STOPPING, K.UNKNOWN}
