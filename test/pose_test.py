#!/usr/bin/env python3
"""TF and pose have each new location of the robot once, with its time of arrival."""
from __future__ import annotations

import math
import unittest
from typing import Optional

import rospy
import tf2_ros
from geometry_msgs.msg import PoseStamped, TransformStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan, PointCloud2
from sensor_msgs.point_cloud2 import create_cloud_xyz32
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

from omron_ld90_msgs.msg import RobotStatus
from system_support import Recorder, connected_publisher, run_cases, wait_until


def status(x: float, y: float, yaw: float, age: float = 0.0, has_pose: bool = True) -> RobotStatus:
    message = RobotStatus(has_pose=has_pose)
    message.header.stamp = rospy.Time.now() - rospy.Duration(age)
    message.pose.position.x, message.pose.position.y = x, y
    message.pose.orientation.z, message.pose.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
    return message


class PoseTest(unittest.TestCase):
    """Publishes robot_status, and records pose and /tf."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.poses = Recorder('/omron_ld90/pose', PoseStamped)
        cls.transforms = Recorder('/tf', TFMessage)
        cls.status = connected_publisher('/omron_ld90/robot_status', RobotStatus, subscribers=2)
        cls.odometry = tf2_ros.TransformBroadcaster()
        wait_until(cls.everything_listens, 20.0, 'the recorders receive pose and /tf')

    @classmethod
    def everything_listens(cls) -> bool:
        cls.status.publish(status(0.0, 0.0, 0.0))
        return bool(cls.poses.messages and cls.transforms.messages)

    def pose_at(self, x: float) -> PoseStamped:
        return self.poses.wait_for(lambda pose: pose.pose.position.x == x, 10.0, f'pose at x = {x}')

    def sent(self, child: str) -> list:
        return [transform for message in list(self.transforms.messages)
                for transform in message.transforms if transform.child_frame_id == child]

    def test_a_location_becomes_one_pose_and_one_transform_with_its_stamp(self):
        message = status(3.12, -0.54, math.radians(-87))
        self.status.publish(message)
        self.status.publish(message)  # comes twice, as it may if a new subscriber joins
        self.status.publish(status(4.0, 0.0, 0.0))
        pose = self.pose_at(3.12)
        self.assertEqual('map', pose.header.frame_id)
        self.assertEqual(message.header.stamp, pose.header.stamp)
        self.transforms.wait_for(
            lambda tf: tf.transforms[0].transform.translation.x == 4.0, 10.0, 'transform at 4 m')
        same = [tf for tf in self.sent('omron_ld90/base_link')
                if tf.header.stamp == message.header.stamp]
        self.assertEqual(1, len(same), 'one transform for one location')
        self.assertEqual('map', same[0].header.frame_id)
        self.assertAlmostEqual(math.sin(math.radians(-87) / 2), same[0].transform.rotation.z)

    def test_an_old_location_and_a_status_without_one_are_not_published(self):
        self.status.publish(status(11.0, 0.0, 0.0, age=1.5))
        self.status.publish(status(12.0, 0.0, 0.0, has_pose=False))
        self.status.publish(status(13.0, 0.0, 0.0))
        self.pose_at(13.0)
        published = {pose.pose.position.x for pose in self.poses.messages}
        self.assertFalse(published & {11.0, 12.0}, f'published: {sorted(published)}')

    def test_a_pose_never_comes_from_the_future(self):
        self.status.publish(status(21.0, 0.0, 0.0, age=-30.0))
        pose = self.pose_at(21.0)
        self.assertLessEqual(pose.header.stamp, rospy.Time.now())

    def test_a_location_that_no_robot_can_have_is_not_published(self):
        for x in (math.nan, math.inf, 1e305):
            self.status.publish(status(x, 41.0, 0.0))
        self.status.publish(status(41.5, 0.0, math.nan))
        self.status.publish(status(42.0, 0.0, 0.0))
        self.pose_at(42.0)
        published = [pose.pose.position for pose in self.poses.messages]
        self.assertFalse([p for p in published if p.y == 41.0 or p.x == 41.5])

    def test_two_locations_make_an_odometry(self):
        odometry = Recorder('/omron_ld90/odom', Odometry)
        wait_until(odometry.is_connected, 15.0, 'connection to odom')
        begin = rospy.Time.now()

        def drive() -> Optional[Odometry]:  # at half a metre a second along y
            message = status(51.0, 0.0, math.pi / 2)
            message.pose.position.y = 0.5 * (message.header.stamp - begin).to_sec()
            self.status.publish(message)
            return next((m for m in odometry.messages if m.pose.pose.position.x == 51.0), None)

        moved = wait_until(drive, 15.0, 'odometry of the drive')
        self.assertEqual(('map', 'omron_ld90/base_link'),
                         (moved.header.frame_id, moved.child_frame_id))
        self.assertAlmostEqual(0.5, moved.twist.twist.linear.x, 6)
        self.assertGreater(moved.twist.covariance[0], 0.0)

    def test_a_cloud_becomes_a_scan_in_the_lasers_frame(self):
        scans = Recorder('/omron_ld90/scan', LaserScan)
        wait_until(scans.is_connected, 15.0, 'connection to scan')
        clouds = connected_publisher('/omron_ld90/laser_cloud', PointCloud2)
        laser = tf2_ros.StaticTransformBroadcaster()
        place = TransformStamped(child_frame_id='omron_ld90/laser_link')
        place.header.frame_id = 'omron_ld90/base_link'
        place.transform.translation.x, place.transform.rotation.w = 0.28, 1.0
        laser.sendTransform(place)

        def scan() -> Optional[LaserScan]:
            header = Header(stamp=rospy.Time.now(), frame_id='map')
            clouds.publish(create_cloud_xyz32(header, [(61.0, 5.28, 0.2)]))
            self.status.publish(status(61.0, 2.0, math.pi / 2))
            return scans.messages[-1] if scans.messages else None

        made = wait_until(scan, 15.0, 'a scan')
        self.assertEqual('omron_ld90/laser_link', made.header.frame_id)
        self.assertAlmostEqual(3.0, made.ranges[len(made.ranges) // 2], 3)
        self.assertEqual(1, sum(math.isfinite(r) for r in made.ranges))

    def test_with_an_odometry_the_map_carries_the_odometry_and_the_robot_is_where_it_says(self):
        message = status(32.0, 2.0, math.pi / 2)
        odometry = TransformStamped(child_frame_id='other/base_link')
        odometry.header.frame_id = 'other/odom'
        odometry.transform.translation.x = 1.0
        odometry.transform.rotation.w = 1.0
        listener_buffer = tf2_ros.Buffer()
        listener = tf2_ros.TransformListener(listener_buffer)
        self.addCleanup(listener.unregister)

        def robot_is_there() -> bool:
            message.header.stamp = odometry.header.stamp = rospy.Time.now()
            self.odometry.sendTransform(odometry)
            self.status.publish(message)
            if not listener_buffer.can_transform('map', 'other/base_link', rospy.Time(0)):
                return False
            robot = listener_buffer.lookup_transform('map', 'other/base_link', rospy.Time(0))
            # the newest message may still come from another test
            place = robot.transform.translation
            return math.dist((place.x, place.y), (32.0, 2.0)) < 1e-6

        wait_until(robot_is_there, 20.0, 'map -> other/odom -> other/base_link, at 32, 2')
        self.assertEqual([], [tf for tf in self.sent('other/base_link')
                              if tf.header.frame_id == 'map'])


if __name__ == '__main__':
    rospy.init_node('pose_test')
    run_cases(__file__)
