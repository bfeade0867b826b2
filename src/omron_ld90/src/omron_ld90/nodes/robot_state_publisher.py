"""Where the robot is, as ROS wants it: one `pose` and one transform for each location received.

The LD-90 localizes itself on its own map and sends a location about twice a second. There is no
odometry with a fixed rate to fill the time between, so the transform goes from `map` straight to
the robot's base (REP 105 puts `odom` between the two for continuous odometry, which ARCL has not).
Who brings an odometry of their own sets `~odom_frame`: then `map` -> odom is published such that
the robot is where it says it is. The name `robot_state_publisher` is this workspace's contract; the
frames of the body come from the standard node of that name, run as `body_state_publisher`.

Nothing is extrapolated or repeated: a location that is older than `~max_age` or was seen before is
not published, and a stamp from the future is set back to now.

Subscribes
    robot_status (omron_ld90_msgs/RobotStatus)
Publishes
    pose (geometry_msgs/PoseStamped), in `~map_frame`
    /tf: `~map_frame` -> `~base_frame`, or `~map_frame` -> `~odom_frame`
    /diagnostics: whether locations come
Parameters
    ~map_frame   string  map
    ~base_frame  string  <namespace>/base_link
    ~odom_frame  string  (empty)  frame of an odometry that publishes ~odom_frame -> ~base_frame
    ~max_age     float   1.0 s    a location older than this is not published
"""
from __future__ import annotations

from typing import Optional

import rospy
import tf2_ros
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper
from geometry_msgs.msg import Pose, PoseStamped, TransformStamped

from omron_ld90.nodes.support import poses, shared_parameters, startup
from omron_ld90.nodes.support.diagnostics import publish_diagnostics
from omron_ld90_msgs.msg import RobotStatus

SILENCE = 3.0  # s without a location before /diagnostics warns; the robot sends two a second


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
        self._map_frame = startup.parameter('~map_frame', 'map')
        self._base_frame = shared_parameters.base_frame()
        self._odom_frame = startup.parameter('~odom_frame', '')
        self._filter = LocationFilter(rospy.Duration(startup.number('~max_age', 1.0, 0.05, 60.0)))
        self._last: Optional[rospy.Time] = None

        self._pose = rospy.Publisher('pose', PoseStamped, queue_size=10, tcp_nodelay=True)
        self._transforms = tf2_ros.TransformBroadcaster()
        self._buffer = tf2_ros.Buffer() if self._odom_frame else None
        self._listener = tf2_ros.TransformListener(self._buffer) if self._buffer else None
        rospy.Subscriber(
            'robot_status', RobotStatus, self._on_status, queue_size=10, tcp_nodelay=True)
        publish_diagnostics(rospy.get_namespace().strip('/') or 'none',
                            {'locations': self._diagnose})

    def _on_status(self, status: RobotStatus) -> None:
        if not status.has_pose:
            return
        stamp = self._filter.stamp_for(status.header.stamp, rospy.Time.now())
        if stamp is None:
            return
        self._last = stamp
        pose = PoseStamped(pose=status.pose)
        pose.header.stamp = stamp
        pose.header.frame_id = self._map_frame
        self._pose.publish(pose)
        self._publish_transform(stamp, status.pose)

    def _publish_transform(self, stamp: rospy.Time, pose: Pose) -> None:
        transform = TransformStamped()
        transform.header.stamp = stamp
        transform.header.frame_id = self._map_frame
        transform.child_frame_id = self._base_frame
        if self._buffer is not None:
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
        age = (rospy.Time.now() - self._last).to_sec()
        if age > SILENCE:
            status.summary(DiagnosticStatus.WARN, 'the robot sends no location any more')
        else:
            status.summary(DiagnosticStatus.OK, 'the robot sends its location')
        status.add('last location (s ago)', f'{age:.1f}')
        return status


def main() -> None:
    """Run the node."""
    startup.run('robot_state_publisher', RobotStatePublisher)
