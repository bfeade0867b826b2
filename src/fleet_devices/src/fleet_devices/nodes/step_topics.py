"""The topics of the devices that carry out steps."""
from __future__ import annotations

from functools import partial
from typing import Callable, Dict, Iterable, List

import rospy

from itrci_nav_msgs.msg import StepCommand, StepState, StepStates
from node_lifecycle import warn
from route_protocol.step_messages import WrongStepMessage, command_of, fill_step_report
from route_protocol.steps import StepCommand as Command
from route_protocol.steps import StepReport


class StepTopics:
    """Receives the commands for each device, and publishes its reports.

    on_command -- called with the name of the device and the command, in a thread of ROS
    """

    def __init__(self, devices: Iterable[str], on_command: Callable[[str, Command], None]) -> None:
        self._on_command = on_command
        self._states: Dict[str, rospy.Publisher] = {}
        self._subscribers: List[rospy.Subscriber] = []
        for name in devices:
            self._states[name] = rospy.Publisher(
                f'/devices/{name}/step_states', StepStates, queue_size=10, latch=True,
                tcp_nodelay=True)
            self._subscribers.append(rospy.Subscriber(
                f'/devices/{name}/step_command', StepCommand, partial(self._receive, name),
                queue_size=100, tcp_nodelay=True))

    def publish(self, name: str, report: StepReport) -> None:
        """Publishes the report of a device."""
        message = fill_step_report(StepStates(), report, StepState)
        message.header.stamp = rospy.Time.now()
        self._states[name].publish(message)

    def _receive(self, name: str, message: StepCommand) -> None:
        try:
            command = command_of(message)
        except WrongStepMessage as wrong:
            warn('step command', f'A step command for device {name} is ignored: {wrong}.')
            return
        self._on_command(name, command)
