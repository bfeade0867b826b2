"""The displayed destination of a robot depends on its typed activity, not on its status text."""
from __future__ import annotations

import pytest

from omron_ld90.nodes.route_visualisation import destination
from omron_ld90.operator.goal_clicks import Target, TargetKind
from omron_ld90_msgs.msg import RobotStatus

TARGETS = [Target(TargetKind.GOAL, '12', 1.0, 2.0), Target(TargetKind.GOAL, 'Küche', 3.0, 4.0),
           Target(TargetKind.DOCK, '16', 5.0, 6.0, 0.0)]
POINT = (7.0, 8.0)


@pytest.mark.parametrize('activity, goal, place', [
    (RobotStatus.GOING_TO_GOAL, '12', (1.0, 2.0)),
    (RobotStatus.GOING_TO_GOAL, 'küche', (3.0, 4.0)),
    (RobotStatus.GOING_TO_GOAL, 'elsewhere', None),
    (RobotStatus.GOING_TO_POINT, '', POINT),
    (RobotStatus.DOCKING, '', (5.0, 6.0)),
    (RobotStatus.ARRIVED_AT_GOAL, '12', None),
    (RobotStatus.STOPPED, '', None),
    (RobotStatus.UNKNOWN, '12', None),
])
def test_a_robot_goes_to_what_its_activity_names(activity, goal, place):
    status = RobotStatus(activity=activity, goal=goal, status='Going to 12')
    assert destination(status, TARGETS, POINT) == place
