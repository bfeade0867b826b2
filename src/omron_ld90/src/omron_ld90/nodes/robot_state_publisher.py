"""Where the robot is and how it moves, as ROS wants it: once for each location received.

The LD-90 localizes itself on its own map and sends a location some two to ten times a second. There
is no odometry with a fixed rate to fill the time between, so the transform goes from `map` straight
to the robot's base (REP 105 puts `odom` between the two for continuous odometry, which ARCL has
not). A user with another odometry sets `~odom_frame`: then `map` -> odom is published such
that the robot is where it says it is. The name `robot_state_publisher` is this workspace's
contract; the frames of the body come from the standard node of that name, run as
`body_state_publisher`.

Nothing is extrapolated or repeated: a location that is older than `~max_age` or was seen before is
not published, a stamp from the future is set back to now, and a place where no robot can be (NaN,
or beyond every map) is left out with a warning.

`odom` is for software that knows nothing else than nav_msgs/Odometry. Its pose is the location, so
that its frame is `map` and not REP 105's `odom`: it is true in the long run, and jumps when the
robot is relocalised. Its twist, in the base frame, is the mean since the location before; there is
no message where the robot cannot have driven from there, or after more than 2 s. The covariances
grow with the time between locations.

`scan`, off by default, is for software that knows nothing else than sensor_msgs/LaserScan. It is
made of `laser_cloud`, and so of what the robot's own localisation has put into the map: what a real
scan is for, it cannot be. See docs/reference/robot_state_publisher.md.

Subscribes
    robot_status (omron_ld90_msgs/RobotStatus)
    laser_cloud (sensor_msgs/PointCloud2), with ~laser_scan
Publishes
    pose (geometry_msgs/PoseStamped), in `~map_frame`
    odom (nav_msgs/Odometry): pose in `~map_frame`, twist in `~base_frame`
    scan (sensor_msgs/LaserScan), in `~laser_frame`, with ~laser_scan
    /tf: `~map_frame` -> `~base_frame`, or `~map_frame` -> `~odom_frame`
    /diagnostics: whether locations come
Parameters
    ~map_frame    string  map
    ~base_frame   string  <namespace>/base_link
    ~odom_frame   string  (empty)  frame of an odometry that publishes ~odom_frame -> ~base_frame
    ~max_age      float   1.0 s    a location older than this is not published
    ~laser_scan   bool    false    true: publish `scan`
    ~laser_frame  string  <namespace>/laser_link, whose place on the robot TF tells (the URDF)
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
from omron_ld90.odometry import Location, Motion, Odometer
from omron_ld90_msgs.msg import RobotStatus

SILENCE = 3.0  # s without a location before /diagnostics warns; the robot sends two a second
REFUSALS_TOLD = 10.0  # s between two words about them
UNUSED_AXES = 1e-6  # variance of what a robot on a floor cannot do


class LocationFilter:
    """Lets each location through once, with the stamp it may be published under."""

    def __init__(self, max_age: rospy.Duration) -> None:
        self._max_age = max_age
        self._last = rospy.Time(0)

    def stamp_for(self, received: rospy.Time, now: rospy.Time) -> Optional[rospy.Time]:
        """The stamp for a location received at `received`, or None if it must not go out.

        A location is refused when it is too old, or not newer than the one before. When `now` is
        earlier than the last stamp by more than the greatest age, the clock was set back: what was
        published before that no longer counts.
        """
        if now + self._max_age < self._last:
            self._last = rospy.Time(0)
        stamp = min(received, now)
        if now - stamp > self._max_age or stamp <= self._last:
            return None
        self._last = stamp
        return stamp


class RobotStatePublisher:
    """The node: see the module's text."""

    def __init__(self) -> None:
        self._map_frame = parameter('~map_frame', 'map')
        self._base_frame = shared_parameters.base_frame()
        self._odom_frame = parameter('~odom_frame', '')
        self._filter = LocationFilter(rospy.Duration(number('~max_age', 1.0, 0.05, 60.0)))
        self._last: Optional[float] = None  # by the clock that no person sets

        self._pose = rospy.Publisher('pose', PoseStamped, queue_size=10, tcp_nodelay=True)
        self._transforms = tf2_ros.TransformBroadcaster()
        self._odometer = Odometer()
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
            Location(stamp.to_sec(), pose.position.x, pose.position.y, yaw))
        if motion is not None:
            self._odometry.publish(
                odometry_of(motion, pose, stamp, self._map_frame, self._base_frame))

    def _publish_transform(self, stamp: rospy.Time, pose: Pose) -> None:
        transform = TransformStamped()
        transform.header.stamp = stamp
        transform.header.frame_id = self._map_frame
        transform.child_frame_id = self._base_frame
        if self._odom_frame and self._buffer is not None:
            try:
                odometry = self._buffer.lookup_transform(
                    self._odom_frame, self._base_frame, stamp, rospy.Duration(0.1))
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


def odometry_of(motion: Motion, pose: Pose, stamp: rospy.Time, map_frame: str,
                base_frame: str) -> Odometry:
    """The motion at a location as a message; variances of x, y, z and of the turns about them."""
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
    """Run the node."""
    run('robot_state_publisher', RobotStatePublisher)
