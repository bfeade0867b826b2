"""Publishes the robot's pose and motion in the form of ROS, once for each received location.

The LD-90 localizes itself on its own map and sends a location two to ten times a second. Between
two locations there is no odometry. So the transform goes from `map` directly to the robot's base.
(REP 105 puts the frame `odom` between them, for continuous odometry, which ARCL does not have.) A
user with another odometry sets `~odom_frame`: then the node publishes `map` -> `~odom_frame` such
that the robot is at its reported location. The name `robot_state_publisher` is a part of this
workspace's interface. The standard node of ROS with the same name runs here as
`body_state_publisher`, and publishes the frames of the robot's body.

Nothing is extrapolated or repeated:
- A location that is older than `~max_age`, or was received before, is not published.
- A stamp from the future is set back to now.
- A position where no robot can be (NaN, or beyond every map) is ignored with a warning.

The topic `odom` is for software that only accepts nav_msgs/Odometry. Its pose is the location, so
its frame is `map` and not the frame `odom` of REP 105: the pose does not drift, and it jumps when
the robot is relocalized. Its twist, in the base frame, is the mean since the previous location.
There is no message if the robot cannot have driven from the previous location, or if the previous
location is more than 2 s older. The covariances grow with the time between locations.

The topic `scan`, off by default, is for software that only accepts sensor_msgs/LaserScan. It is
made from `laser_cloud`, whose points the robot has already put into the map with its own
localization. So it cannot replace a real scan, for example for localization. See
docs/reference/robot_state_publisher.md.

Subscribes
    robot_status (omron_ld90_msgs/RobotStatus)
    laser_cloud (sensor_msgs/PointCloud2), with ~laser_scan
Publishes
    pose (geometry_msgs/PoseStamped), in `~map_frame`
    odom (nav_msgs/Odometry): pose in `~map_frame`, twist in `~base_frame`
    scan (sensor_msgs/LaserScan), in `~laser_frame`, with ~laser_scan
    /tf: `~map_frame` -> `~base_frame`, or `~map_frame` -> `~odom_frame`
    /diagnostics: whether locations arrive
Parameters
    ~map_frame    string  map
    ~base_frame   string  <namespace>/base_link
    ~odom_frame   string  (empty)  frame of an odometry that publishes ~odom_frame -> ~base_frame
    ~max_age      float   1.0 s    a location older than this is not published
    ~laser_scan   bool    false    true: publish `scan`
    ~laser_frame  string  <namespace>/laser_link; its place on the robot comes from TF (the URDF)
"""
from __future__ import annotations

import time
from typing import List, Optional

import rospy
import tf2_ros
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper
from geometry_msgs.msg import Pose, PoseStamped, TransformStamped
from nav_msgs.msg import Odometry

from node_lifecycle import number, parameter, publish_diagnostics, run
from node_lifecycle.headings import yaw_from_quaternion
from omron_ld90.nodes.laser_scans import LaserScans
from omron_ld90.nodes.support import poses, shared_parameters
from omron_ld90.nodes.support.transforms import wait_for_transform
from omron_ld90.odometry import MeanMotion, MotionMeter, TimedPose
from omron_ld90_msgs.msg import RobotStatus

SILENCE = 3.0  # s without a location after which /diagnostics warns; 0.5 s is usual
REFUSALS_TOLD = 10.0  # s between two log lines about ignored locations
ODOMETRY_TIMEOUT = 0.1  # s, maximum wait for the odometry of a location
UNUSED_AXES = 1e-6  # variance of motions that a robot on a floor cannot make


class LocationFilter:
    """Accepts each location once, and gives it the stamp for publishing."""

    def __init__(self, max_age: rospy.Duration) -> None:
        self._max_age = max_age
        self._last = rospy.Time(0)

    def stamp_for(self, received: rospy.Time, now: rospy.Time) -> Optional[rospy.Time]:
        """Returns the stamp for a location that was received at `received`. None: it must not be
        published.

        A location is refused if it is too old, or not newer than the previous one. If `now` is
        earlier than the last stamp by more than the maximum age, the clock was set back. Then the
        last stamp does not count any more.
        """
        if now + self._max_age < self._last:
            self._last = rospy.Time(0)
        stamp = min(received, now)
        if now - stamp > self._max_age or stamp <= self._last:
            return None
        self._last = stamp
        return stamp


class RobotStatePublisher:
    """The node: see the module's text.

    The class has many attributes because it connects the parts of the node.
    """

    def __init__(self) -> None:
        self._map_frame = parameter('~map_frame', 'map')
        self._base_frame = shared_parameters.base_frame()
        self._odom_frame = parameter('~odom_frame', '')
        self._filter = LocationFilter(rospy.Duration(number('~max_age', 1.0, 0.05, 60.0)))
        self._last: Optional[float] = None  # time of the last location, s, monotonic

        self._pose = rospy.Publisher('pose', PoseStamped, queue_size=10, tcp_nodelay=True)
        self._transforms = tf2_ros.TransformBroadcaster()
        self._odometer = MotionMeter()
        self._odometry = rospy.Publisher('odom', Odometry, queue_size=10, tcp_nodelay=True)
        with_scan = parameter('~laser_scan', False, bool)
        self._buffer = tf2_ros.Buffer() if self._odom_frame or with_scan else None
        self._listener = tf2_ros.TransformListener(self._buffer) if self._buffer else None
        self._scans = None
        if with_scan:
            self._scans = LaserScans(self._map_frame, self._base_frame,
                                     shared_parameters.laser_frame(), self._buffer)
        rospy.Subscriber(
            'robot_status', RobotStatus, self._on_status, queue_size=10, tcp_nodelay=True)
        publish_diagnostics(rospy.get_namespace().strip('/') or 'none',
                            {'locations': self._diagnose})

    def _on_status(self, status: RobotStatus) -> None:
        if not status.has_pose:
            return
        if not poses.is_plausible(status.pose):
            rospy.logwarn_throttle(REFUSALS_TOLD, 'A location is not published: no robot can be at '
                                   '(%g, %g) m.', status.pose.position.x, status.pose.position.y)
            return
        stamp = self._filter.stamp_for(status.header.stamp, rospy.Time.now())
        if stamp is None:
            return
        self._last = time.monotonic()
        pose = PoseStamped(pose=status.pose)
        pose.header.stamp = stamp
        pose.header.frame_id = self._map_frame
        self._pose.publish(pose)
        self._publish_transform(stamp, status.pose)
        self._publish_motion(stamp, status.pose)
        if self._scans is not None:
            self._scans.on_location(stamp, status.pose)

    def _publish_motion(self, stamp: rospy.Time, pose: Pose) -> None:
        yaw = yaw_from_quaternion(pose.orientation)
        motion = self._odometer.add(
            TimedPose(stamp.to_sec(), pose.position.x, pose.position.y, yaw))
        if motion is not None:
            self._odometry.publish(
                odometry_of(motion, pose, stamp, self._map_frame, self._base_frame))

    def _publish_transform(self, stamp: rospy.Time, pose: Pose) -> None:
        buffer = self._buffer
        transform = TransformStamped()
        transform.header.stamp = stamp
        transform.header.frame_id = self._map_frame
        transform.child_frame_id = self._base_frame
        if self._odom_frame and buffer is not None:
            try:
                odometry = wait_for_transform(ODOMETRY_TIMEOUT, lambda: buffer.lookup_transform(
                    self._odom_frame, self._base_frame, stamp))
            except tf2_ros.TransformException as error:
                rospy.logwarn_throttle(
                    10.0, '%s -> %s is not published: no odometry for this location (%s). Start '
                    'what publishes %s -> %s, or leave ~odom_frame empty.', self._map_frame,
                    self._odom_frame, error, self._odom_frame, self._base_frame)
                return
            transform.child_frame_id = self._odom_frame
            pose = poses.map_to_odom(pose, odometry.transform)
        transform.transform.translation.x = pose.position.x
        transform.transform.translation.y = pose.position.y
        transform.transform.rotation = pose.orientation
        self._transforms.sendTransform(transform)

    def _diagnose(self, status: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        if self._last is None:
            status.summary(DiagnosticStatus.WARN, 'no location came on robot_status yet')
            return status
        age = time.monotonic() - self._last
        if age > SILENCE:
            status.summary(DiagnosticStatus.WARN, 'the robot sends no location any more')
        else:
            status.summary(DiagnosticStatus.OK, 'the robot sends its location')
        status.add('last location (s ago)', f'{age:.1f}')
        return status


def odometry_of(motion: MeanMotion, pose: Pose, stamp: rospy.Time, map_frame: str,
                base_frame: str) -> Odometry:
    """Returns the motion at a location as a message, with the variances of pose and motion."""
    message = Odometry(child_frame_id=base_frame)
    message.header.stamp = stamp
    message.header.frame_id = map_frame
    message.pose.pose = pose
    message.pose.covariance = _diagonal(
        motion.position_variance, motion.position_variance, motion.yaw_variance)
    message.twist.twist.linear.x = motion.speed
    message.twist.twist.angular.z = motion.turn_rate
    message.twist.covariance = _diagonal(
        motion.speed_variance, UNUSED_AXES, motion.turn_rate_variance)
    return message


def _diagonal(x: float, y: float, yaw: float) -> List[float]:
    matrix = [0.0] * 36
    matrix[::7] = [x, y, UNUSED_AXES, UNUSED_AXES, UNUSED_AXES, yaw]
    return matrix


def main() -> None:
    """Runs the node."""
    run('robot_state_publisher', RobotStatePublisher)
