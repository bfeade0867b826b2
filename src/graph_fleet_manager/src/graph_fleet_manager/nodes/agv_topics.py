"""The topics of one simulated AGV."""
from __future__ import annotations

import math
import threading
from typing import Optional

import rospy
from geometry_msgs.msg import PoseStamped, TransformStamped, Vector3
from sensor_msgs.msg import BatteryState

from fleet_simulation.agv.vehicle import AgvVehicle
from itrci_nav_msgs.msg import (
    EdgeState,
    ExecutionRouteStates,
    RouteRefused,
    StepCommand,
    StepState,
    StepStates,
    TargetRoute,
)
from node_lifecycle.headings import quaternion_from_yaw
from route_protocol.messages import fill_refusal, fill_report, order_of
from route_protocol.step_messages import WrongStepMessage, command_of, fill_step_report
from route_protocol.values import RouteRefusal, RouteReport

REPORT_PERIOD, IDLE_PERIOD = 0.1, 1.0  # s, with a route and without
BATTERY_PERIOD = 1.0                   # s
EARLY = 0.02                           # s; a message due this soon is sent at the present tick


class AgvTopics:
    """Receives the orders for one vehicle, and publishes its messages.

    lock     -- the lock of the simulation
    software -- name and version of the software that the vehicle reports

    There is an attribute for each topic, and one for what was last published on it.
    """

    def __init__(self, vehicle: AgvVehicle, lock: threading.Lock, software: str) -> None:
        self._vehicle, self._lock, self._software = vehicle, lock, software
        self._reported = self._charge_told = self._steps_told = -math.inf
        self._told_of_steps: object = None
        self._emergency_told = False
        name = f'/{vehicle.name}/'
        self._frame = f'{vehicle.name}/base_link'
        self._states = rospy.Publisher(name + 'execution_route_states', ExecutionRouteStates,
                                       queue_size=10, latch=True, tcp_nodelay=True)
        self._refusals = rospy.Publisher(name + 'route_refused', RouteRefused, queue_size=10,
                                         tcp_nodelay=True)
        self._battery = rospy.Publisher(name + 'battery_state', BatteryState, queue_size=2,
                                        latch=True)
        self._pose = rospy.Publisher(name + 'pose', PoseStamped, queue_size=2)
        self._steps = rospy.Publisher(name + 'step_states', StepStates, queue_size=10, latch=True,
                                      tcp_nodelay=True)
        rospy.Subscriber(name + 'target_route', TargetRoute, self._on_route, queue_size=100,
                         tcp_nodelay=True)
        rospy.Subscriber(name + 'step_command', StepCommand, self._on_step, queue_size=100,
                         tcp_nodelay=True)

    def publish_due(self, now: float) -> Optional[TransformStamped]:
        """Publishes the messages that are due. Returns the vehicle's frame; None if it is silent.

        The caller holds the lock. `now` is in s of any monotonic clock.
        """
        self._pass_on(now)
        if self._vehicle.silent:
            return None
        period = REPORT_PERIOD if self._vehicle.running else IDLE_PERIOD
        if now - self._reported >= period - EARLY:
            self._report(self._vehicle.report(), now)
        if (now - self._steps_told >= IDLE_PERIOD - EARLY
                or self._vehicle.steps.news != self._told_of_steps):
            self._publish_steps(now)
        stamp = rospy.Time(*divmod(self._vehicle.stamp, 1_000_000_000))
        if now - self._charge_told >= BATTERY_PERIOD - EARLY:
            self._charge_told = now
            self._battery.publish(_battery_message(self._vehicle, stamp))
        pose = _pose_message(self._vehicle, stamp)
        self._pose.publish(pose)
        frame = TransformStamped(header=pose.header, child_frame_id=self._frame)
        position = pose.pose.position
        frame.transform.translation = Vector3(position.x, position.y, position.z)
        frame.transform.rotation = pose.pose.orientation
        return frame

    def _on_route(self, message: TargetRoute) -> None:
        with self._lock:
            self._vehicle.handle(order_of(message, rospy.Time.now().to_nsec()))
            self._pass_on(self._reported)

    def _on_step(self, message: StepCommand) -> None:
        try:
            command = command_of(message)
        except WrongStepMessage as wrong:
            rospy.logwarn('A step command for %s is ignored: %s.', self._vehicle.name, wrong)
            return
        with self._lock:
            if not self._vehicle.silent:
                self._vehicle.steps.receive(command)
                self._publish_steps(self._steps_told)

    def _publish_steps(self, now: float) -> None:
        self._steps_told, self._told_of_steps = now, self._vehicle.steps.news
        message = fill_step_report(StepStates(), self._vehicle.steps.report(), StepState)
        message.header.stamp = rospy.Time.now()
        self._steps.publish(message)

    def _pass_on(self, now: float) -> None:
        for message in self._vehicle.new_messages():
            if isinstance(message, RouteReport):
                self._report(message, now)
            else:
                self._log_refusal(message)
                self._refusals.publish(fill_refusal(RouteRefused(), message,
                                                    rospy.Time.now().to_nsec()))

    def _log_refusal(self, refusal: RouteRefusal) -> None:
        """Logs a refusal. The supervisor repeats its orders, so during an emergency stop only the
        first refusal is logged.
        """
        if not (self._vehicle.emergency and self._emergency_told):
            rospy.logwarn('%s refused route %d: %s.', self._vehicle.name, refusal.route_id,
                          refusal.reason)
        self._emergency_told = self._vehicle.emergency

    def _report(self, report: RouteReport, now: float) -> None:
        self._reported = now
        self._states.publish(fill_report(
            ExecutionRouteStates(software=self._software), report, EdgeState))


def _pose_message(vehicle: AgvVehicle, stamp: rospy.Time) -> PoseStamped:
    x, y, heading = vehicle.pose
    message = PoseStamped()
    message.header.stamp, message.header.frame_id = stamp, 'map'
    message.pose.position.x, message.pose.position.y = x, y
    message.pose.orientation = quaternion_from_yaw(heading)
    return message


def _battery_message(vehicle: AgvVehicle, stamp: rospy.Time) -> BatteryState:
    battery = vehicle.battery
    unknown = math.nan
    message = BatteryState(
        percentage=battery.charge / 100.0, present=True, voltage=unknown, current=unknown,
        charge=unknown, capacity=unknown, design_capacity=unknown, temperature=unknown,
        power_supply_status=(BatteryState.POWER_SUPPLY_STATUS_CHARGING if battery.charging
                             else BatteryState.POWER_SUPPLY_STATUS_DISCHARGING))
    message.header.stamp = stamp
    return message
