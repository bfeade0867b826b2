"""Common parts of the system tests: waiting for conditions, recording topics, results for rostest.

A test waits for a condition; on a timeout, the error names the condition. No test sleeps for a
fixed time.
"""
from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any, Callable, List, Optional, Type
from xmlrpc.client import ServerProxy

import pytest
import rosgraph
import roslib.packages
import rospy
from std_msgs.msg import String

from node_lifecycle import topic_connections
from omron_ld90_msgs.msg import ExecuteCommandActionGoal, LinkState

topic_connections.mend()  # a test has as many connections as a node, so it needs this, too


class Recorder:
    """Subscribes to a topic, and keeps every message with its time of arrival."""

    def __init__(self, topic: str, message_type: Type) -> None:
        self.topic = topic
        self.messages: List[Any] = []
        self._changed = threading.Condition()
        self._subscriber = rospy.Subscriber(topic, message_type, self._add)

    def is_connected(self) -> bool:
        """Returns whether a publisher is connected: none of its later messages is then missed."""
        return self._subscriber.get_num_connections() > 0

    def _add(self, message: Any) -> None:
        with self._changed:
            self.messages.append(message)
            self._changed.notify_all()

    def wait_for(self, predicate: Callable[[Any], bool], timeout: float, what: str,
                 after: int = 0) -> Any:
        """Returns the first message with index `after` or more for which `predicate` is true. Waits
        at most `timeout` s.
        """
        deadline = time.monotonic() + timeout
        seen = after
        with self._changed:
            while True:
                while seen < len(self.messages):
                    if predicate(self.messages[seen]):
                        return self.messages[seen]
                    seen += 1
                left = deadline - time.monotonic()
                if left <= 0:
                    tail = self.messages[-1] if self.messages else 'nothing'
                    raise AssertionError(
                        f'{self.topic}: no {what} within {timeout:.0f} s; '
                        f'{len(self.messages)} messages came, last: {tail}')
                self._changed.wait(left)


def wait_until(condition: Callable[[], Any], timeout: float, what: str) -> Any:
    """Polls `condition` until its value is truthy. Returns this value. Fails after `timeout` s."""
    deadline = time.monotonic() + timeout
    while time.monotonic() < deadline:
        value = condition()
        if value:
            return value
        time.sleep(0.02)
    raise AssertionError(f'not within {timeout:.0f} s: {what}')


def program(package: str, name: str) -> str:
    """Returns the path of a program.

    `rosrun` also finds the path, but it starts further programs for this, which take as long as the
    program itself. `fleet_mission` starts its commands with `rosrun`, as a user does.
    """
    return str(roslib.packages.find_node(package, name)[0])


def process_of(node: str) -> int:
    """Returns the process id of a node."""
    caller = rospy.get_name()
    _, _, pid = ServerProxy(rosgraph.Master(caller).lookupNode(node)).getPid(caller)
    return pid


def kill_node(node: str) -> None:
    """Kills a node's process. Waits until roslaunch has started the node again."""
    master = rosgraph.Master(rospy.get_name())
    uri = master.lookupNode(node)
    os.kill(process_of(node), signal.SIGKILL)
    wait_until(lambda: master.lookupNode(node) != uri, 30, f'{node} is back')


def connected_publisher(topic: str, message_type: Type, timeout: float = 30.0,
                        subscribers: int = 1, to: str = '') -> rospy.Publisher:
    """Returns a publisher that already has its subscribers, so that its first message is not lost.

    to -- name (without namespace) of a node that must be among the subscribers
    """
    publisher = rospy.Publisher(topic, message_type, queue_size=10)

    def connected() -> bool:
        nodes = [info[1] for info in publisher.impl.get_stats_info()]
        return len(nodes) >= subscribers and (
            not to or any(node.endswith(f'/{to}') for node in nodes))

    wait_until(connected, timeout, f'{to or subscribers} as subscriber(s) of {topic}')
    return publisher


class CommandRecorder:
    """The commands that a robot's controller gets through its action, in order."""

    def __init__(self, robot: str) -> None:
        self._goals = Recorder(f'/{robot}/execute_command/goal', ExecuteCommandActionGoal)

    @property
    def messages(self) -> List[ExecuteCommandActionGoal]:
        """The goals of the action."""
        return self._goals.messages

    @property
    def texts(self) -> List[str]:
        """The ARCL commands."""
        return [message.goal.command for message in self.messages]

    def wait_for(self, command: str, timeout: float = 10.0, after: int = 0) -> None:
        """Waits until this command has come."""
        wait_until(lambda: command in self.texts[after:], timeout, f'the command {command}')


def drive_to(robot: str, goal: str, timeout: float = 90.0) -> None:
    """Publishes `goto <goal>` as soon as the robot accepts commands. Returns at its arrival."""
    Recorder(f'/{robot}/link_state', LinkState).wait_for(
        lambda message: (message.link, message.state) == (LinkState.COMMANDS, LinkState.CONNECTED),
        60, 'connected link to the robot')
    answers = Recorder(f'/{robot}/arcl_response', String)
    commands = connected_publisher(f'/{robot}/send_command', String, to='omron_controller')
    wait_until(answers.is_connected, 30, f'connection to /{robot}/arcl_response')
    commands.publish(f'goto {goal}')
    answers.wait_for(lambda message: message.data == f'Arrived at {goal}', timeout,
                     f'arrival at {goal}')


class Launched:
    """A launch file of the project that runs under this test's ROS master; for a `with` statement.

    The output of the nodes is what a user sees on the screen. `/rosout` would not be complete: it
    lacks the messages that a node logs before rosout has connected to the node.
    """

    def __init__(self, launch_file: str, package: str = 'omron_ld90', **args: object) -> None:
        self._folder = tempfile.TemporaryDirectory()
        self._output = Path(self._folder.name) / 'output.log'
        with self._output.open('w') as output:
            self._process = subprocess.Popen(
                ['roslaunch', package, launch_file]
                + [f'{name}:={value}' for name, value in args.items()],
                stdout=output, stderr=subprocess.STDOUT)

    def __enter__(self) -> Launched:
        return self

    def __exit__(self, *_: object) -> None:
        self._process.send_signal(signal.SIGINT)
        try:
            self._process.wait(30)
        except subprocess.TimeoutExpired:
            self._process.kill()
        self._folder.cleanup()

    @property
    def output(self) -> str:
        """Everything that has been printed so far."""
        return self._output.read_text(encoding='utf-8', errors='replace')

    def wait_for_line(self, *words: str, timeout: float = 60.0) -> str:
        """Returns the first printed line that contains all `words`."""
        def find() -> Optional[str]:
            return next((line for line in self.output.splitlines()
                         if all(word in line for word in words)), None)
        try:
            return wait_until(find, timeout, f'a printed line with {words}')
        except AssertionError as error:
            raise AssertionError(f'{error}; printed was:\n{self.output}') from None


def run_cases(file: str) -> None:
    """Runs the test cases of a file under rostest. The program ends with pytest's exit status.

    pytest writes the result file, in which a skipped test is marked as skipped. rostest's own
    result would count such a test as passed.
    """
    reports = [argument.partition('xml:')[2] for argument in sys.argv
               if argument.startswith('--gtest_output=xml:')]
    sys.exit(pytest.main([file, '-v', '--capture=no',
                          *(f'--junitxml={report}' for report in reports)]))
