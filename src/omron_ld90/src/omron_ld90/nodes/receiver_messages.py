"""Makes the receiver's messages from replies, in SI units and according to REP 103."""
from __future__ import annotations

import math
from typing import Optional

import numpy as np
import rospy
from sensor_msgs.msg import BatteryState, PointCloud2, PointField

from omron_arcl import Activity, ActivityKind, printable
from omron_arcl.replies import DockingStatus, OneLineStatus, RangeReading
from omron_ld90.nodes.support.poses import pose_from_robot
from omron_ld90.units import MM_PER_M
from omron_ld90_msgs.msg import RobotStatus

ACTIVITIES = {kind: getattr(RobotStatus, kind.name) for kind in ActivityKind}
_LONGEST_TEXT = 1000  # characters
_FIELDS = [PointField(name, offset, PointField.FLOAT32, 1)
           for name, offset in (('x', 0), ('y', 4), ('z', 8))]
_CHARGING = {
    'bulk': BatteryState.POWER_SUPPLY_STATUS_CHARGING,
    'overcharge': BatteryState.POWER_SUPPLY_STATUS_CHARGING,
    'float': BatteryState.POWER_SUPPLY_STATUS_FULL,
    'not': BatteryState.POWER_SUPPLY_STATUS_DISCHARGING,
}


def robot_status(status: OneLineStatus, activity: Activity, docking: Optional[DockingStatus],
                 stamp: rospy.Time, frame: str) -> RobotStatus:
    """Returns the typed status.

    activity -- read from the text of the status
    docking -- the last docking state
    stamp -- the time when the location came
    """
    message = RobotStatus(
        status=_text(status.status), activity=ACTIVITIES[activity.kind],
        goal=_text(activity.goal), extended_status=_text(status.extended_status or ''),
        emergency_stop=activity.kind is ActivityKind.EMERGENCY_STOP)
    message.header.stamp = stamp
    message.header.frame_id = frame
    if docking:
        message.docking_state = docking.docking.value
        message.charge_state = _text(docking.charge)
    message.has_pose = status.location is not None
    if status.location:
        message.pose = pose_from_robot(status.location.x, status.location.y,
                                       status.location.heading)
    else:
        message.pose.orientation.w = 1.0
    message.state_of_charge = _share(status)
    message.battery_voltage = _voltage(status)
    message.localization_score = (status.localization_score.score if status.localization_score
                                  else math.nan)
    temperature = status.temperature.celsius if status.temperature else None
    message.temperature = math.nan if temperature is None else temperature
    return message


def battery_state(status: OneLineStatus, docking: Optional[DockingStatus],
                  stamp: rospy.Time) -> BatteryState:
    """Returns the battery state; values that the robot does not measure are NaN."""
    message = BatteryState(
        percentage=_share(status), voltage=_voltage(status), current=math.nan, charge=math.nan,
        capacity=math.nan, design_capacity=math.nan, present=True,
        power_supply_technology=BatteryState.POWER_SUPPLY_TECHNOLOGY_UNKNOWN,
        power_supply_status=_CHARGING.get(docking.charge.lower() if docking else '',
                                          BatteryState.POWER_SUPPLY_STATUS_UNKNOWN))
    message.header.stamp = stamp
    return message


def point_cloud(reading: RangeReading, stamp: rospy.Time, frame: str,
                height: float) -> PointCloud2:
    """Returns the points of a scan in the map frame. The laser is `height` m above the floor."""
    points = np.empty((len(reading.points), 3), '<f4')
    points[:, :2] = reading.points / MM_PER_M
    points[:, 2] = height
    message = PointCloud2(height=1, width=len(points), fields=_FIELDS, is_bigendian=False,
                          point_step=12, row_step=12 * len(points), data=points.tobytes(),
                          is_dense=True)
    message.header.stamp = stamp
    message.header.frame_id = frame
    return message


def _text(text: str) -> str:
    """Returns a text of the robot without the characters that control a terminal."""
    return printable(text, _LONGEST_TEXT)


def _share(status: OneLineStatus) -> float:
    charge = status.state_of_charge
    return charge.percent / 100.0 if charge else math.nan


def _voltage(status: OneLineStatus) -> float:
    return status.battery_voltage.volts if status.battery_voltage else math.nan
