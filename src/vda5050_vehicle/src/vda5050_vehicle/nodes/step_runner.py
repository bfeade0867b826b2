"""step_runner: carries out the steps of a fleet's missions with the table of actions of a robot.

Subscribes
    step_command (itrci_nav_msgs/StepCommand)
Publishes
    step_states (itrci_nav_msgs/StepStates, latched): at each change, and 1 Hz
Client of
    the actions of the actions file
Parameters
    ~actions_file  string  (required)  the actions of the robot other than driving
"""
from __future__ import annotations

import time

import rospy

from itrci_nav_msgs.msg import StepCommand, StepState, StepStates
from node_lifecycle import ConfigurationError, parameter, run
from node_lifecycle.event_loop import EventLoop
from node_lifecycle.worker import start_worker
from route_protocol.step_messages import WrongStepMessage, command_of, fill_step_report
from route_protocol.steps import StepCommand as Command
from route_protocol.vehicle import milliseconds
from vda5050_vehicle.core.action_table import ActionTable, WrongTable, read_table
from vda5050_vehicle.core.table_steps import TableSteps
from vda5050_vehicle.nodes.parameters import yaml_file
from vda5050_vehicle.nodes.ros_actions import RosActions, check_types

TICK = 0.1      # s between two checks of the actions
PERIOD = 1.0    # s between two reports if nothing changes


class StepRunner:
    """The node: see the module's text. One thread carries out everything."""

    def __init__(self) -> None:
        path = parameter('~actions_file')
        try:
            table = ActionTable(read_table(yaml_file(path, 'The actions file')))
        except WrongTable as error:
            raise ConfigurationError(f'The actions file {path}: {error}.') from None
        check_types(table)
        self._loop = EventLoop(self._tick, TICK)
        self._actions = RosActions(lambda name, succeeded, text: self._loop.put(
            lambda: self._ended(name, succeeded, text)))
        self._actions.prepare(table)
        self._steps = TableSteps(table, self._actions, milliseconds())
        self._told: object = None
        self._told_at = -PERIOD
        self._states = rospy.Publisher('step_states', StepStates, queue_size=10, latch=True,
                                       tcp_nodelay=True)
        rospy.Subscriber('step_command', StepCommand, self._on_command, queue_size=100,
                         tcp_nodelay=True)
        start_worker('steps', self._loop.run)

    def _on_command(self, message: StepCommand) -> None:
        try:
            command = command_of(message)
        except WrongStepMessage as wrong:
            rospy.logwarn('A step command is ignored: %s.', wrong)
            return
        self._loop.put(lambda: self._receive(command))

    def _receive(self, command: Command) -> None:
        now = time.monotonic()
        self._steps.receive(command, now)
        self._publish(now)

    def _ended(self, name: str, succeeded: bool, text: str) -> None:
        self._steps.ended(name, succeeded, text)
        self._publish(time.monotonic())

    def _tick(self) -> None:
        now = time.monotonic()
        self._actions.check()
        self._steps.tick(now)
        self._publish(now)

    def _publish(self, now: float) -> None:
        news = self._steps.news
        if news == self._told and now - self._told_at < PERIOD:
            return
        self._told, self._told_at = news, now
        message = fill_step_report(StepStates(), self._steps.report(), StepState)
        message.header.stamp = rospy.Time.now()
        self._states.publish(message)


def main() -> None:
    """Runs the node."""
    run('step_runner', StepRunner)
