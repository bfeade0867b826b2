"""Collects the robot's reports from ROS topics in one view that contains no outdated values.

Subscribes
    pose (geometry_msgs/PoseStamped), or TF if ~pose_source is tf
    odom (nav_msgs/Odometry): velocity
    battery_state (sensor_msgs/BatteryState)
    topics of the vehicle file's `signals`
"""
from __future__ import annotations

import math
import threading
import time
from dataclasses import dataclass, replace
from typing import Any, Callable, Dict, Generic, Mapping, Optional, Tuple, TypeVar

import roslib.message
import rospy
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import BatteryState as BatteryMessage

from node_lifecycle import ConfigurationError
from node_lifecycle.headings import yaw_from_quaternion
from node_lifecycle.measurements import measured
from node_lifecycle.periodic import Periodic
from vda5050_protocol.values import BatteryState, EmergencyStop, Velocity
from vda5050_vehicle.drivers.robot_view import REST, RobotPose, RobotSnapshot, has_moved, silence

SIGNALS = ('emergency_stop', 'lost', 'field_violation', 'localization_score', 'standing', 'epoch',
           'halted')
TF_PERIOD = 0.2  # s between two queries of TF
T = TypeVar('T')


@dataclass(frozen=True)
class _Heard(Generic[T]):
    """A value and the time of its reception (s, monotonic)."""

    value: T
    at: float


@dataclass(frozen=True)
class Signal:
    """A field of a topic.

    wanted  -- the values that mean true; None: the value of the field is used as it is
    unknown -- the values that carry no information
    """

    name: str
    topic: str
    type: str
    field: str
    wanted: Optional[Tuple[Any, ...]] = None
    unknown: Tuple[Any, ...] = ()

    def read(self, message: Any) -> Any:
        """Returns the value of the signal in the message; None if it is unknown."""
        value = message
        for part in self.field.split('.'):
            value = getattr(value, part)
        if value in self.unknown:
            return None
        return value if self.wanted is None else value in self.wanted


def read_signals(document: Mapping[str, Any]) -> Tuple[Signal, ...]:
    """Returns the `signals` of a vehicle file; raises ConfigurationError."""
    signals = document.get('signals') or {}
    try:
        found = tuple(Signal(name, line['topic'], line['type'], line['field'],
                             tuple(line['is']) if 'is' in line else None,
                             tuple(line.get('unknown', ())))
                      for name, line in signals.items())
    except (AttributeError, KeyError, TypeError) as error:
        raise ConfigurationError(f'signals of the vehicle file: {error} is missing; each signal '
                                 'needs topic, type and field.') from None
    for signal in found:
        if signal.name not in SIGNALS:
            raise ConfigurationError(f'signal {signal.name} of the vehicle file is unknown; the '
                                     f'signals are {", ".join(SIGNALS)}.')
        if roslib.message.get_message_class(signal.type) is None:
            raise ConfigurationError(f'signal {signal.name} of the vehicle file has type '
                                     f'{signal.type}, which is not installed.')
    return found


class RobotWatch:
    """Calls `on_change` after each report (in threads of rospy); `view` returns all values."""

    def __init__(self, signals: Tuple[Signal, ...], pose_timeout: float, tf_base: str,
                 map_frame: str, on_change: Callable[[], None]) -> None:
        """`tf_base` is the robot's frame in TF; '': the pose is read from the topic `pose`."""
        self._timeout = pose_timeout
        self._frame = map_frame
        self._on_change = on_change
        self._lock = threading.Lock()
        self._heard: Dict[str, _Heard] = {}
        self._still: Optional[_Heard[RobotPose]] = None
        """The pose at which the robot stands, and the time when it came to this pose."""
        self._since = time.monotonic()
        if tf_base:
            self._follow_tf(tf_base)
        else:
            rospy.Subscriber('pose', PoseStamped, self._on_pose, queue_size=10, tcp_nodelay=True)
        rospy.Subscriber('odom', Odometry, self._on_odometry, queue_size=10, tcp_nodelay=True)
        rospy.Subscriber('battery_state', BatteryMessage, self._on_battery, queue_size=10,
                         tcp_nodelay=True)
        for signal in signals:
            rospy.Subscriber(signal.topic, roslib.message.get_message_class(signal.type),
                             lambda message, signal=signal: self._hear(
                                 signal.name, signal.read(message)),
                             queue_size=10, tcp_nodelay=True)

    def view(self) -> RobotSnapshot:
        """Returns the present values; values that are too old count as unknown."""
        with self._lock:
            heard, still = dict(self._heard), self._still
        now = time.monotonic()

        def fresh(name: str, otherwise: Any = None) -> Any:
            item = heard.get(name)
            return (otherwise if item is None or now - item.at > self._timeout
                    else item.value)

        def last(name: str) -> Any:
            """Returns the last value of a signal that is sent only on a change.

            This value has no time limit.
            """
            item = heard.get(name)
            return None if item is None else item.value

        battery, velocity, standing = heard.get('battery'), fresh('velocity'), last('standing')
        score, pose = fresh('localization_score'), heard.get('pose')
        seen_at, rests = now, False
        if velocity is not None:
            seen_at = heard['velocity'].at
        elif standing is None and pose is not None and still is not None:
            seen_at, rests = pose.at, fresh('pose') is not None and pose.at - still.at >= REST
        return RobotSnapshot(
            pose=fresh('pose'), velocity=velocity, seen_at=seen_at, rests=rests,
            standing=standing, epoch=last('epoch') or 0, halted=bool(last('halted')),
            localization_score=score if score is not None and 0.0 <= score <= 1.0 else None,
            localized=not fresh('lost', False),
            battery=battery.value if battery else BatteryState(0.0, False),
            e_stop=EmergencyStop.MANUAL if last('emergency_stop') else EmergencyStop.NONE,
            field_violation=bool(fresh('field_violation', False)),
            lost=silence(pose.at if pose else None, self._since, now, self._timeout))

    def _hear(self, name: str, value: Any) -> None:
        with self._lock:
            self._heard[name] = _Heard(value, time.monotonic())
        self._on_change()

    def _on_pose(self, message: PoseStamped) -> None:
        if message.header.frame_id.lstrip('/') != self._frame:
            rospy.logwarn_throttle(10.0, 'A pose in the frame "%s" is ignored, because the map '
                                   'frame is "%s".', message.header.frame_id, self._frame)
            return
        position = message.pose.position
        pose = RobotPose(position.x, position.y, yaw_from_quaternion(message.pose.orientation))
        if all(map(math.isfinite, (pose.x, pose.y, pose.theta))):
            self._hear_pose(pose)

    def _hear_pose(self, pose: RobotPose) -> None:
        now = time.monotonic()
        with self._lock:
            last = self._heard.get('pose')
            if (self._still is None or has_moved(self._still.value, pose)
                    or last is None or now - last.at > REST):  # it may have moved during the pause
                self._still = _Heard(pose, now)
        self._hear('pose', pose)

    def _on_odometry(self, message: Odometry) -> None:
        twist = message.twist.twist
        velocity = Velocity(twist.linear.x, twist.linear.y, twist.angular.z)
        if all(map(math.isfinite, (velocity.vx, velocity.vy, velocity.omega))):
            self._hear('velocity', velocity)

    def _on_battery(self, message: BatteryMessage) -> None:
        charge = measured(message.percentage, 0.0, 1.0, 'The percentage in battery_state')
        voltage = message.voltage if math.isfinite(message.voltage) else None
        before = self._heard.get('battery')
        battery = before.value if before else BatteryState(0.0, False)
        if charge is not None:
            battery = replace(battery, charge=charge * 100.0)
        charging = message.power_supply_status in (BatteryMessage.POWER_SUPPLY_STATUS_CHARGING,
                                                   BatteryMessage.POWER_SUPPLY_STATUS_FULL)
        self._hear('battery', replace(battery, charging=charging, voltage=voltage))

    def _follow_tf(self, base: str) -> None:
        import tf2_ros  # starts a listener thread, so it is imported only if TF is used
        buffer = tf2_ros.Buffer()
        self._listener = tf2_ros.TransformListener(buffer)
        last = [rospy.Time()]

        def read_transform() -> None:
            try:
                transform = buffer.lookup_transform(self._frame, base, rospy.Time())
            except (tf2_ros.LookupException, tf2_ros.ConnectivityException,
                    tf2_ros.ExtrapolationException):
                return
            if transform.header.stamp != last[0]:  # ignore a transform that was read before
                last[0] = transform.header.stamp
                place = transform.transform.translation
                self._hear_pose(RobotPose(place.x, place.y,
                                          yaw_from_quaternion(transform.transform.rotation)))

        Periodic('TF', TF_PERIOD, read_transform)
