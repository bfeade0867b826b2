"""Replies become messages: SI units, NaN if unmeasured, the robot's activity as a number."""
from __future__ import annotations

import math
from io import BytesIO
from typing import Optional

import numpy as np
import pytest
import rospy
from sensor_msgs.msg import BatteryState, PointCloud2
from sensor_msgs.point_cloud2 import read_points

from omron_arcl import ActivityKind, parse_line, read_activity
from omron_arcl.replies import DockingState, DockingStatus, OneLineStatus, RangeReading
from omron_ld90.nodes.receiver_messages import (
    ACTIVITIES,
    battery_state,
    point_cloud,
    robot_status,
)
from omron_ld90_msgs.msg import RobotStatus

STAMP = rospy.Time(12, 34)


def status_of(line: str) -> OneLineStatus:
    return parse_line(line)


def message_of(status: OneLineStatus, docking: Optional[DockingStatus] = None) -> RobotStatus:
    return robot_status(status, read_activity(status.status), docking, STAMP, 'map')


def test_a_whole_status_is_in_si_units():
    status = status_of('Status: Going to 12 StateOfCharge: 50 Location: 1500 -2500 90 '
                       'LocalizationScore: 0.5 Temperature: 30')
    message = message_of(status, DockingStatus(DockingState.UNDOCKED, False, 'Not'))
    assert (message.header.stamp, message.header.frame_id) == (STAMP, 'map')
    assert (message.pose.position.x, message.pose.position.y) == (1.5, -2.5)
    assert message.pose.orientation.z == pytest.approx(math.sqrt(0.5))
    assert message.state_of_charge == 0.5
    assert message.temperature == 30.0
    assert (message.docking_state, message.charge_state) == ('Undocked', 'Not')
    assert message.has_pose
    assert not message.emergency_stop


def test_what_was_not_sent_is_nan_and_no_pose_is_no_pose():
    message = message_of(status_of('Status: Stopped Temperature: -127'))
    assert not message.has_pose
    assert all(math.isnan(value) for value in (
        message.state_of_charge, message.battery_voltage, message.localization_score,
        message.temperature))
    assert message.docking_state == ''


def test_volts_are_no_percentage():
    message = message_of(status_of('Status: Stopped BatteryVoltage: 26.1'))
    assert math.isnan(message.state_of_charge)
    assert message.battery_voltage == pytest.approx(26.1)


@pytest.mark.parametrize('text', ['EStop pressed', 'EStop relieved but motors still disabled'])
def test_the_emergency_stop_is_read_from_the_status(text):
    assert message_of(OneLineStatus(text)).emergency_stop


@pytest.mark.parametrize(('text', 'activity', 'goal'), [
    ('Going to 12', RobotStatus.GOING_TO_GOAL, '12'),
    ('Arrived at K\xfcche', RobotStatus.ARRIVED_AT_GOAL, 'K\xfcche'),
    ('Going to point', RobotStatus.GOING_TO_POINT, ''),
    ('DockingState: Docked ForcedState: Unforced ChargeState: Bulk', RobotStatus.DOCKED, ''),
    ('Robot lost', RobotStatus.LOST, ''), ('hello', RobotStatus.UNKNOWN, ''),
])
def test_what_the_robot_does_is_typed(text, activity, goal):
    message = message_of(OneLineStatus(text))
    assert (message.activity, message.goal, message.status) == (activity, goal, text)


def test_every_activity_of_the_message_has_its_kind():
    constants = {name: value for name, value in vars(RobotStatus).items()
                 if name.isupper() and isinstance(value, int)}
    assert {kind.name: ACTIVITIES[kind] for kind in ActivityKind} == constants


def test_what_a_terminal_would_obey_is_escaped():
    message = message_of(OneLineStatus('Going to \x1b[2J', 'a\x07b'))
    assert (message.status, message.goal) == (r'Going to \x1b[2J', r'\x1b[2J')
    assert message.extended_status == r'a\x07b'


@pytest.mark.parametrize('line', [
    'Status: Stopped StateOfCharge: 1e41 Location: 1 2 3 Temperature: 36',
    'Status: Stopped StateOfCharge: nan Location: 1e308 0 0 LocalizationScore: -1',
    'Status: Stopped BatteryVoltage: 1e39 Location: inf 0 0 Temperature: 1e300',
])
def test_numbers_that_cannot_be_are_left_out_and_the_rest_fits_a_message(line):
    message = message_of(status_of(line))
    message.serialize(BytesIO())
    assert math.isnan(message.state_of_charge)
    assert math.isnan(message.battery_voltage)
    assert message.status == 'Stopped'
    battery_state(status_of(line), None, STAMP).serialize(BytesIO())


@pytest.mark.parametrize(('charge', 'expected'), [
    ('Bulk', BatteryState.POWER_SUPPLY_STATUS_CHARGING),
    ('Overcharge', BatteryState.POWER_SUPPLY_STATUS_CHARGING),
    ('Float', BatteryState.POWER_SUPPLY_STATUS_FULL),
    ('Not', BatteryState.POWER_SUPPLY_STATUS_DISCHARGING),
    ('Unknowable', BatteryState.POWER_SUPPLY_STATUS_UNKNOWN),
])
def test_the_charge_state_tells_whether_the_battery_charges(charge, expected):
    docking = DockingStatus(DockingState.DOCKED, False, charge)
    battery = battery_state(status_of('Status: x StateOfCharge: 79.4'), docking, STAMP)
    assert battery.power_supply_status == expected
    assert battery.percentage == pytest.approx(0.794)
    assert math.isnan(battery.current)


@pytest.mark.parametrize('count', [0, 1, 1000])
def test_a_cloud_holds_every_point_in_metres(count):
    points = np.random.default_rng(count).integers(-20_000, 20_000, (count, 2))
    cloud = point_cloud(RangeReading('Laser_1', points), STAMP, 'map', 0.2)
    received = PointCloud2()
    buffer = BytesIO()
    cloud.serialize(buffer)
    received.deserialize(buffer.getvalue())
    found = np.array(list(read_points(received))).reshape(-1, 3)
    assert found[:, :2] == pytest.approx(points / 1000.0, abs=1e-4)
    assert (found[:, 2] == np.float32(0.2)).all()
    assert received.width == count
    assert len(received.data) == received.row_step == 12 * count
