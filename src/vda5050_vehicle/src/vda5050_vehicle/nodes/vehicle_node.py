"""The VDA 5050 adapter: it makes a ROS 1 robot a vehicle of any VDA 5050 master.

MQTT, under ~interface_name/v2/~manufacturer/~serial_number (v3 if ~version is 3.0.0)
    in: order, instantActions; out: state, connection, factsheet, visualization
Subscribes
    pose, odom, battery_state, and the topics of the vehicle file's signals (`robot_watch`)
    execution_route_states, /graph (driver route)
Publishes
    target_route (itrci_nav_msgs/TargetRoute; driver route)
    initialpose (geometry_msgs/PoseWithCovarianceStamped): for initPosition
    /diagnostics
Client of
    the actions of the actions file; move_base (driver move_base)
Parameters
    ~broker            string  127.0.0.1:1883  host:port of the MQTT broker
    ~credentials_file  string  (empty)  YAML file with username and password
    ~ca_file, ~cert_file, ~key_file  string (empty)  PEM files; ~ca_file switches TLS on
    ~keepalive         int     15 s     MQTT keep-alive interval
    ~version           string  2.1.0    version of the standard in the messages; or 2.0.0, 3.0.0
    ~interface_name    string  uagv     first level of the topics
    ~manufacturer      string  (required)
    ~serial_number     string  (required)
    ~map_id            string  map      the map of all positions; orders on other maps are rejected
    ~map_version       string  1        version of the map in the state
    ~driver            string  route    or move_base
    ~graph_file        string  (empty)  trajectory graph (YAML); if it is empty, driver route
                                        waits for /graph
    ~vehicle_file      string  (required)  the factsheet, and the topics of the state
    ~actions_file      string  (empty)  the actions of the vehicle other than driving
    ~ignored_fields    string  (empty)  fields of orders that are ignored although the vehicle
                                        does not support them, separated by blanks: theta ...
    ~match_radius      float   0.3 m    a node's position matches a vertex within this distance
    ~start_radius      float   0.5 m    an order may begin at a node within this distance, or
                                        within the deviation of the node
    ~pose_timeout      float   3 s      an older pose is not reported; the robot counts as lost
    ~pose_source       string  topic    or tf: map frame to ~base_frame
    ~base_frame        string  base_link
    ~map_frame         string  map      frame of poses
    ~journal           string  (in ROS_HOME/vda5050)  file that keeps the state during a restart
    ~log_folder        string  (in ROS_HOME/vda5050)  folder of the log reports
    ~visualization_period  float  0 s   between two messages on visualization; 0: none
"""
from __future__ import annotations

import time
from collections import deque
from typing import Any, Callable, Deque, List, Optional, Tuple, Union

import rospy
from geometry_msgs.msg import PoseWithCovarianceStamped

from node_lifecycle import run
from node_lifecycle.event_loop import EventLoop
from node_lifecycle.headings import quaternion_from_yaw
from node_lifecycle.ready_line import announce_ready
from node_lifecycle.worker import start_worker
from vda5050_mqtt.link import MqttLink
from vda5050_protocol.fields import write_json
from vda5050_protocol.headers import Headers
from vda5050_protocol.values import ConnectionMessage, ConnectionState, Visualization
from vda5050_vehicle.core import effects as fx
from vda5050_vehicle.core import factsheet as sheet
from vda5050_vehicle.core import journal
from vda5050_vehicle.core.vehicle import VdaVehicle
from vda5050_vehicle.drivers.driver import Driver
from vda5050_vehicle.drivers.pose_driver import PoseDriver
from vda5050_vehicle.drivers.robot_view import RobotPose
from vda5050_vehicle.drivers.route_driver import RouteDriver
from vda5050_vehicle.nodes.diagnostics import show_state
from vda5050_vehicle.nodes.move_base_link import MoveBaseLink
from vda5050_vehicle.nodes.robot_watch import RobotWatch
from vda5050_vehicle.nodes.ros_actions import RosActions
from vda5050_vehicle.nodes.route_link import RouteLink
from vda5050_vehicle.nodes.settings import VehicleSettings

TICK = 0.1    # s between two periodic steps
AT_ONCE = 50  # messages of the master that are processed together

Call = Callable[[float], Optional[Tuple[fx.Effect, ...]]]


class VehicleNode:
    """See the module's docstring. One thread owns the vehicle; callbacks queue calls for it.

    The class has many attributes, because it puts the parts of the node together.
    """

    def __init__(self, settings: VehicleSettings) -> None:
        self._settings = settings
        identity = settings.identity
        self._headers = Headers(settings.codec.version, identity.manufacturer,
                                identity.serial_number, time.time)
        self._loop = EventLoop(lambda: self._perform_all(self._tick), TICK)
        self._mqtt_problem = 'connecting'
        self._visualized = 0.0
        self._look_is_due = self._is_ready_told = False
        self._messages: Deque[Tuple[str, bytes]] = deque()  # oldest first
        self._vehicle = VdaVehicle(identity, settings.codec, settings.table, settings.make_driver,
                                   settings.abilities)
        self._factsheet = sheet.factsheet(settings.document, self._vehicle.context.table,
                                          self._vehicle.driver.longest)
        self._restore()

        self._link = self._make_link(self._vehicle.driver)
        self._actions = RosActions(lambda name, succeeded, text: self._put(
            lambda now: self._vehicle.action_ended(name, succeeded, text, now)))
        self._actions.prepare(settings.table)
        self._poses = rospy.Publisher('initialpose', PoseWithCovarianceStamped, queue_size=1)
        self._watch = RobotWatch(settings.signals, settings.pose_timeout, settings.tf_base,
                                 settings.map_frame, self._on_robot)
        self._mqtt = MqttLink(
            settings.broker, settings.prefix, f'{identity.manufacturer}_{identity.serial_number}',
            self._connection, self._on_message, self._on_mqtt_change)
        show_state(settings, self._vehicle, self._mqtt, lambda: self._mqtt_problem)
        # A vehicle that is ONLINE but does not react would be worse than no vehicle. So if this
        # thread ends, the process ends, and the broker publishes the last will.
        self._thread = start_worker('vehicle', self._loop.run)
        self._mqtt.start()

    def close(self) -> None:
        """Disconnects from the broker; the order stays in the journal."""
        self._loop.end()
        self._thread.join(0.5)
        self._mqtt.close()

    def _restore(self) -> None:
        vehicle = self._vehicle
        try:
            stored = self._settings.journal.read(type(vehicle.state.drive))
        except journal.WrongRecord as problem:
            rospy.logwarn('The journal cannot be used, so the vehicle starts without an order: %s',
                          problem)
            return
        if stored is not None:
            vehicle.restore(*stored, time.monotonic())
            rospy.loginfo('Order "%s" is restored.', vehicle.state.order.order_id)

    def _make_link(self, driver: Driver[Any]) -> Union[RouteLink, MoveBaseLink]:
        if isinstance(driver, RouteDriver):
            return RouteLink(driver, self._call_driver)
        assert isinstance(driver, PoseDriver)
        return MoveBaseLink(driver, self._call_driver, self._settings.map_frame)

    # --- callbacks --------------------------------------------------------------------------------

    def _put(self, call: Call) -> None:
        self._loop.put(lambda: self._perform_all(call))

    def _call_driver(self, call: Callable[[float], None]) -> None:
        def told(now: float) -> Tuple[fx.Effect, ...]:
            call(now)
            return self._vehicle.tick(now)
        self._put(told)

    def _on_robot(self) -> None:
        """Notes that a report of the robot came; several reports at once cause one evaluation."""
        if not self._look_is_due:
            self._look_is_due = True
            self._put(self._show_robot)

    def _on_message(self, topic: str, payload: bytes, kept: bool) -> None:
        if kept:
            rospy.logwarn('A retained message on %s is ignored: masters do not retain %s, and the '
                          'vehicle does not repeat a motion by itself.', topic, topic)
        else:
            self._messages.append((topic, payload))
            self._put(self._receive)

    def _on_mqtt_change(self, connected: bool, problem: str) -> None:
        self._mqtt_problem = problem
        address = f'{self._settings.broker.host}:{self._settings.broker.port}'
        if connected:
            rospy.loginfo('Connected to the broker at %s; the topics begin with %s/.', address,
                          self._settings.prefix)
            self._put(self._vehicle.connected)
        else:
            rospy.logwarn('Not connected to the broker at %s: %s', address, problem)

    def _connection(self, state: str) -> bytes:
        return self._payload('connection', ConnectionMessage(ConnectionState(state)))

    # --- in the thread that owns the vehicle ------------------------------------------------------

    def _perform_all(self, call: Call) -> None:
        for effect in call(time.monotonic()) or ():
            self._perform(effect)

    def _receive(self, now: float) -> Tuple[fx.Effect, ...]:
        """Processes all messages that wait, at most AT_ONCE together."""
        messages: List[Tuple[str, bytes]] = []
        while self._messages and len(messages) < AT_ONCE:
            messages.append(self._messages.popleft())
        return self._vehicle.receive(messages, now) if messages else ()

    def _show_robot(self, now: float) -> Tuple[fx.Effect, ...]:
        self._look_is_due = False
        return self._vehicle.robot_seen(self._watch.view(), now)

    def _tick(self, now: float) -> Tuple[fx.Effect, ...]:
        self._actions.check()
        if isinstance(self._link, MoveBaseLink):
            self._link.check()
        self._visualize(now)
        self._say_ready()
        return (*self._show_robot(now), *self._vehicle.tick(now))

    def _say_ready(self) -> None:
        """Announces once that a master can drive: the broker is connected, and the pose is known.
        """
        settings = self._settings
        if self._is_ready_told or not self._mqtt.connected or (
                self._vehicle.context.robot.pose is None):
            return
        self._is_ready_told = True
        announce_ready('Ready: a VDA 5050 master can drive the robot over the broker at '
                       f'{settings.broker.host}:{settings.broker.port}; the topics begin with '
                       f'{settings.prefix}/.')

    def _visualize(self, now: float) -> None:
        period = self._settings.visualization_period
        if period and now - self._visualized >= period:
            self._visualized = now
            self._send('visualization', Visualization(
                self._vehicle.position(), self._vehicle.context.robot.velocity,
                self._headers.last('state')))

    def _perform(self, effect: fx.Effect) -> None:
        if isinstance(effect, fx.SendState):
            self._send('state', effect.state)
        elif isinstance(effect, fx.DriverCommand):
            self._link.carry_out(effect.command)
        elif isinstance(effect, fx.Keep):
            self._keep(effect)
        elif isinstance(effect, fx.StartAction):
            self._actions.start(effect.action_id, effect.spec, effect.arguments)
        elif isinstance(effect, fx.CancelAction):
            self._actions.cancel(effect.action_id)
        elif isinstance(effect, fx.SetPose):
            self._set_pose(effect.pose)
        elif isinstance(effect, fx.WriteLog):
            self._write_log(effect)
        else:
            self._send('factsheet', self._factsheet)

    def _send(self, topic: str, message: Any) -> None:
        if self._mqtt.connected:
            self._mqtt.publish(topic, self._payload(topic, message))

    def _payload(self, topic: str, message: Any) -> bytes:
        return write_json(self._settings.codec.write(topic, self._headers.make(topic), message))

    def _keep(self, effect: fx.Keep) -> None:
        try:
            self._settings.journal.write(effect.before, effect.now)
        except OSError as error:
            rospy.logerr_throttle(10.0, 'The journal cannot be written, so a restart will lose '
                                        'the order: %s', error)

    def _write_log(self, effect: fx.WriteLog) -> None:
        try:
            name, written = self._settings.reports.write(effect.reason, effect.lines), True
        except OSError as error:
            name, written = f'the report cannot be stored: {error.strerror}', False
        self._put(lambda now: self._vehicle.action_ended(
            effect.action_id, written, name, now))

    def _set_pose(self, pose: RobotPose) -> None:
        message = PoseWithCovarianceStamped()
        message.header.frame_id = self._settings.map_frame
        message.header.stamp = rospy.Time.now()
        message.pose.pose.position.x, message.pose.pose.position.y = pose.x, pose.y
        message.pose.pose.orientation = quaternion_from_yaw(pose.theta)
        self._poses.publish(message)


def main() -> None:
    """Runs the node."""
    run('vda5050_vehicle', lambda: VehicleNode(VehicleSettings()))
