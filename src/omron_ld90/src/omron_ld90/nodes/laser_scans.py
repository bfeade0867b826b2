"""Makes sensor_msgs/LaserScan from the receiver's laser cloud; a part of robot_state_publisher.

Subscribes
    laser_cloud (sensor_msgs/PointCloud2), in the map's frame
Publishes
    scan (sensor_msgs/LaserScan)
"""
from __future__ import annotations

import math
import threading
from typing import NamedTuple, Optional

import numpy as np
import rospy
import tf2_ros
from geometry_msgs.msg import Pose
from sensor_msgs.msg import LaserScan, PointCloud2

from node_lifecycle.clouds import places_in
from node_lifecycle.headings import yaw_from_quaternion
from omron_ld90 import laser_scan, robot_model

MAX_SKEW = rospy.Duration(0.5)  # maximum time between a cloud and the location used for it
REFUSALS_TOLD = 60.0  # s between two log lines about refused clouds


class StampedPose(NamedTuple):
    """The pose of the robot's base in the map, and its time."""

    stamp: rospy.Time
    pose: Pose


class LaserScans:
    """Publishes a scan for each cloud that has a location near enough in time.

    A cloud waits for the first location that is not older than the cloud. This location or the
    previous one is used, whichever is nearer in time to the cloud. The scan gets the stamp of that
    location. So the transform at this stamp puts every point where the robot reported it.
    """

    def __init__(self, map_frame: str, base_frame: str, laser_frame: str,
                 transforms: tf2_ros.Buffer) -> None:
        self._map_frame, self._base_frame, self._laser_frame = map_frame, base_frame, laser_frame
        self._transforms = transforms
        self._lock = threading.Lock()
        self._waiting: Optional[PointCloud2] = None
        self._last: Optional[StampedPose] = None
        self._published = rospy.Time(0)
        self._scans = rospy.Publisher('scan', LaserScan, queue_size=5, tcp_nodelay=True)
        rospy.Subscriber('laser_cloud', PointCloud2, self._on_cloud, queue_size=2,
                         tcp_nodelay=True)

    def _on_cloud(self, cloud: PointCloud2) -> None:
        if cloud.header.frame_id == self._map_frame:
            with self._lock:
                self._waiting = cloud

    def on_location(self, stamp: rospy.Time, pose: Pose) -> None:
        """Takes the `pose` of the robot's base in the map at the time `stamp`."""
        with self._lock:
            before, self._last = self._last, StampedPose(stamp, pose)
            if before is not None and stamp < before.stamp:  # the clock was set back
                before, self._waiting, self._published = None, None, rospy.Time()
            cloud = self._waiting
            if cloud is None or cloud.header.stamp > stamp:
                return
            self._waiting = None
            nearest = nearest_in_time(cloud.header.stamp, before, self._last)
            if nearest is None or nearest.stamp <= self._published:
                return
            scan = self._scan(cloud, nearest)
            if scan is not None:
                self._published = nearest.stamp
                self._scans.publish(scan)

    def _scan(self, cloud: PointCloud2, base: StampedPose) -> Optional[LaserScan]:
        try:
            laser = self._transforms.lookup_transform(
                self._base_frame, self._laser_frame, rospy.Time(0)).transform
            hits = places_in(cloud)
        except (tf2_ros.TransformException, ValueError) as error:
            rospy.logwarn_throttle(REFUSALS_TOLD, 'No scan is made of a laser_cloud: %s', error)
            return None
        yaw = yaw_from_quaternion(base.pose.orientation)
        ahead, left = laser.translation.x, laser.translation.y
        place = laser_scan.LaserPlace(
            base.pose.position.x + ahead * math.cos(yaw) - left * math.sin(yaw),
            base.pose.position.y + ahead * math.sin(yaw) + left * math.cos(yaw),
            yaw + yaw_from_quaternion(laser.rotation))
        return scan_of(laser_scan.ranges_of(hits, place), base.stamp, self._laser_frame)


def nearest_in_time(stamp: rospy.Time, *candidates: Optional[StampedPose]
                    ) -> Optional[StampedPose]:
    """Returns the candidate nearest in time to `stamp`; None if none is within MAX_SKEW."""
    known = [candidate for candidate in candidates if candidate is not None]
    nearest = min(known, key=lambda pose: abs(pose.stamp - stamp), default=None)
    return nearest if nearest is not None and abs(nearest.stamp - stamp) <= MAX_SKEW else None


def scan_of(ranges: np.ndarray, stamp: rospy.Time, frame: str) -> LaserScan:
    """Returns the message for ranges from right to left. No hit means infinite (REP 117)."""
    message = LaserScan(
        angle_min=laser_scan.FIRST_ANGLE, angle_increment=laser_scan.INCREMENT,
        angle_max=laser_scan.FIRST_ANGLE + (len(ranges) - 1) * laser_scan.INCREMENT,
        range_min=laser_scan.NEAREST, range_max=robot_model.LASER_RANGE,
        ranges=ranges.tolist())
    message.header.stamp = stamp
    message.header.frame_id = frame
    return message
