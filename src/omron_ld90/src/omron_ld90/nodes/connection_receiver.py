"""Accepts the robot's outgoing connection and publishes what the robot sends over it.

Topics out, each line byte for byte (std_msgs/String):
  status/state, status/extended_status, status/state_of_charge, status/battery_voltage,
  status/location, status/localization_score, status/temperature
  laser_points: `RangeDeviceGetCurrent: <device> x y ...`, of every device
Topics out, typed, in SI units, with the time of reception (lines that waited while this node was
suspended, or while the network stalled, are not published):
  robot_status (omron_ld90_msgs/RobotStatus), battery_state (sensor_msgs/BatteryState)
  laser_cloud (sensor_msgs/PointCloud2, frame `~map_frame`): scans of `~laser_device`
  laser_cloud/<device>: scans of each other device; laser_cloud/<device>_cumulative: its cumulative
      points
  link_state (omron_ld90_msgs/LinkState, latched): link `outgoing`
  /diagnostics
Parameters:
  ~robot_ip (required): name or address of the robot, the only host that may connect
  ~port (7179): port to listen on
  ~bind_address (''): address to listen on; '': the loopback address for a robot on this computer,
      otherwise every address
  ~map_frame (map), ~laser_device (Laser_1)
  ~laser_height (0.203 m): height of the laser above the floor
  ~silence (4.0 s): seconds without a line after which the link counts as dead
  ~session_log (''): file for all that the robot sends; an older file is kept as <file>.old
  ~session_log_size (50.0 MB): a file that has grown to this size becomes <file>.old
"""
from __future__ import annotations

import re
from typing import Any, Callable, Dict, Optional

import rospy
from sensor_msgs.msg import BatteryState, PointCloud2

from node_lifecycle import ConfigurationError, number, parameter, publish_diagnostics, run, warn
from omron_arcl import (
    Link,
    Listener,
    Received,
    Reply,
    SessionLog,
    StatusAssembler,
    ignored_fields,
    printable,
    read_activity,
)
from omron_arcl.connection import resolve
from omron_arcl.replies import (
    BatteryVoltage,
    DockingStatus,
    ExtendedStatus,
    LocalizationScore,
    Location,
    OneLineStatus,
    RangeReading,
    StateOfCharge,
    StatusText,
    Temperature,
)
from omron_ld90.nodes.receiver_messages import battery_state, point_cloud, robot_status
from omron_ld90.nodes.support.link_reports import (
    LinkReporter,
    misconfigured,
    robot_host,
    session_log,
)
from omron_ld90.nodes.support.publishing import LineMessage, publish_checked
from omron_ld90.nodes.support.robot_health import RobotHealth
from omron_ld90_msgs.msg import LinkState, RobotStatus

_LINE_TOPICS = {
    StatusText: 'status/state',
    OneLineStatus: 'status/state',
    ExtendedStatus: 'status/extended_status',
    StateOfCharge: 'status/state_of_charge',
    BatteryVoltage: 'status/battery_voltage',
    Location: 'status/location',
    LocalizationScore: 'status/localization_score',
    Temperature: 'status/temperature',
}
_DEVICE_NAME = re.compile(r'[A-Za-z]\w{0,40}$', re.ASCII)
_MAXIMUM_DEVICES = 16


class ConnectionReceiver:
    """The node; `make_listener` makes its listener with the given callbacks.

    The class has many attributes because it connects the parts of the node.
    """

    def __init__(self, make_listener: Callable[..., Listener], map_frame: str,
                 laser_device: str, laser_height: float, log: Optional[SessionLog]) -> None:
        self._map_frame = map_frame
        self._laser_height = laser_height
        self._log = log
        self._assembler = StatusAssembler()
        self._docking: Optional[DockingStatus] = None
        self._reporter = LinkReporter(LinkState.OUTGOING, log)
        self._health = RobotHealth()
        topics = {topic: _publisher(topic, LineMessage) for topic in set(_LINE_TOPICS.values())}
        self._lines = {kind: topics[topic] for kind, topic in _LINE_TOPICS.items()}
        self._laser_lines = _publisher('laser_points', LineMessage)
        self._clouds: Dict[str, rospy.Publisher] = {
            laser_device: _publisher('laser_cloud', PointCloud2)}
        self._statuses = _publisher('robot_status', RobotStatus)
        self._batteries = _publisher('battery_state', BatteryState)
        self._listener: Listener = make_listener(on_line=self._on_line, on_link=self._on_link,
                                                 on_refused=_on_refused)
        publish_diagnostics(self._listener.link.peer, {
            'link from the robot': self._reporter.diagnose, 'robot': self._health.diagnose})
        self._listener.start()

    def close(self) -> None:
        """Closes the connection."""
        self._listener.close()
        if self._log:
            self._log.close()

    def _on_link(self, link: Link) -> None:
        self._assembler.drop()
        self._docking = None
        self._health.forget()
        self._reporter.report(link)

    def _on_line(self, line: Received) -> None:
        reply = line.reply
        if line.late:  # the time of sending is unknown, so the line must not be published as new
            self._assembler.drop()
            warn('late', 'This node was suspended, or the network stalled, for a while. The lines '
                 'that the robot sent meanwhile are not published, because their time is unknown.')
        else:
            self._publish(line, rospy.Time.now())
        if isinstance(reply, DockingStatus):
            self._docking = reply
        for field in ignored_fields(reply):
            warn(field.partition(':')[0].lower(), f'"{printable(field)}" of the robot is ignored: '
                 'it is not a possible value.')
        self._reporter.line()
        self._health.observe(reply)

    def _publish(self, line: Received, stamp: rospy.Time) -> None:
        publisher = self._lines.get(type(line.reply))
        if publisher:
            publisher.publish(LineMessage(line.raw))
        elif isinstance(line.reply, RangeReading):
            self._on_scan(line.raw, line.reply, stamp)
        self._on_status(line.reply, stamp)

    def _on_status(self, reply: Reply, stamp: rospy.Time) -> None:
        status = self._assembler.add(reply, stamp)
        if status is None:
            return
        activity = read_activity(status.status)
        if isinstance(activity.reply, DockingStatus):
            self._docking = activity.reply
        if status.location:
            stamp = self._assembler.located
        publish_checked(self._statuses, robot_status(status, activity, self._docking, stamp,
                                                     self._map_frame))
        if status.state_of_charge or status.battery_voltage:
            publish_checked(self._batteries, battery_state(status, self._docking, stamp))

    def _on_scan(self, raw: bytes, reading: RangeReading, stamp: rospy.Time) -> None:
        name = reading.device + ('_cumulative' if reading.cumulative else '')
        if not reading.cumulative:
            self._laser_lines.publish(LineMessage(raw))
        if name not in self._clouds:
            if len(self._clouds) >= _MAXIMUM_DEVICES or not _DEVICE_NAME.match(name):
                return
            self._clouds[name] = _publisher(f'laser_cloud/{name}', PointCloud2)
        publisher = self._clouds[name]
        if publisher.get_num_connections():
            publish_checked(publisher, point_cloud(reading, stamp, self._map_frame,
                                                   self._laser_height))


def _publisher(topic: str, kind: type) -> rospy.Publisher:
    return rospy.Publisher(topic, kind, queue_size=10, tcp_nodelay=True)


def _on_refused(address: str) -> None:
    warn('stranger', f'A connection from {address} was refused: only the robot (~robot_ip) may '
         'connect.')


def _bind_address(robot: str) -> str:
    """Returns the loopback address if the robot is on this computer, so that no other computer can
    connect. Otherwise returns an empty text.
    """
    try:
        addresses = {entry[4][0] for entry in resolve(robot)}
    except OSError:
        return ''
    local = all(address.startswith('127.') or address == '::1' for address in addresses)
    return '127.0.0.1' if local else ''


def start() -> ConnectionReceiver:
    """Reads the parameters and builds the node."""
    robot = robot_host()
    port = int(number('~port', 7179, 0, 65535))
    bind = parameter('~bind_address', '') or _bind_address(robot)
    silence = number('~silence', 4.0, 0.2, 120.0)
    log = session_log()

    def make_listener(**callbacks: Any) -> Listener:
        try:
            return Listener(bind, port, robot, timeout=silence, log=log, **callbacks)
        except OSError as error:
            raise ConfigurationError(f'Cannot listen on {bind or "every address"}, port {port}: '
                                     f'{error.strerror}. Choose another ~port or '
                                     '~bind_address.') from None

    return ConnectionReceiver(make_listener, parameter('~map_frame', 'map'),
                              parameter('~laser_device', 'Laser_1'),
                              number('~laser_height', 0.203, -10.0, 10.0), log)


def main() -> None:
    """Runs the node."""
    run('omron_connection_receiver', start, misconfigured(LinkState.OUTGOING), ('omron_arcl',))
