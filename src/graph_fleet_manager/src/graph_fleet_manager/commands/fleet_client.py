"""The parts of ROS that commands use: the connection to the master, topics, services, errors."""
from __future__ import annotations

import getpass
import os
import platform
import socket
import sys
import threading
import time
from typing import Any, Callable, FrozenSet, List, Optional, Protocol, Sequence, Type

import rosgraph
import rospy
from std_srvs.srv import Trigger

import fleet_requests
from fleet_requests import NotSent, Sender, ServiceRefused, ServiceSilent
from graph_fleet_manager.commands.command_line import NOT_DONE, WRONG, CommandProblem
from node_lifecycle.log_file import init_node

PATIENCE = 10.0  # s to wait for the fleet manager
REPEAT = 0.5     # s after which a message that has no answer yet is sent again


def run(name: str, command: Callable[[List[str]], int],
        arguments: Optional[Sequence[str]] = None) -> int:
    """Runs a command with the arguments of the command line; returns its exit status."""
    given = rospy.myargv()[1:] if arguments is None else list(arguments)
    try:
        return command(given)
    except CommandProblem as error:
        print(f'{name}: {error}', file=sys.stderr)
        return error.status
    except NotSent as reason:  # the receiver was found, but has ended since
        print(f'{name}: {reason}', file=sys.stderr)
        return WRONG
    except rospy.ROSInterruptException:
        return 130


def connect(name: str, argv: Optional[List[str]] = None) -> None:
    """Makes this process a ROS node. Raises CommandProblem if there is no ROS master.

    argv -- words in which ROS looks for remappings; None: the words of the command line
    """
    if not rosgraph.is_master_online():
        raise CommandProblem(f'There is no ROS master at {rosgraph.get_master_uri()}: start the '
                             'fleet manager, or set ROS_MASTER_URI.')
    init_node(name, argv=argv, anonymous=True, disable_signals=True)


class TopicListener:
    """Keeps the messages of a topic, and waits for more."""

    def __init__(self, topic: str, kind: Type[Any]) -> None:
        self.topic = topic
        self.messages: List[Any] = []
        self._changed = threading.Condition()
        self._subscriber = rospy.Subscriber(topic, kind, self._on_message, queue_size=1000)

    def _on_message(self, message: Any) -> None:
        with self._changed:
            self.messages.append(message)
            self._changed.notify_all()

    def unread(self) -> List[Any]:
        """Returns the messages that came since the last call."""
        with self._changed:
            messages, self.messages = self.messages, []
            return messages

    def wait(self, seconds: float) -> None:
        """Waits until there is a message, at most this time (s)."""
        with self._changed:
            if not self.messages:
                self._changed.wait(seconds)

    def publishers(self) -> FrozenSet[int]:
        """Returns one number for each connection to a publisher. Each new connection gets a new
        number.
        """
        return frozenset(id for id, *_ in self._subscriber.impl.get_stats_info())

    def last(self) -> Any:
        """Waits for a message and returns the last one. Raises CommandProblem if none comes."""
        deadline = time.monotonic() + PATIENCE
        while not self.messages:
            if time.monotonic() > deadline:
                raise CommandProblem(f'No message comes on {self.topic}: is the fleet manager '
                                     'running? Start it with fleet_manager.launch.')
            self.wait(0.2)
        return self.messages[-1]


class MessageSource(Protocol):
    """The part of a listener that `first_message` uses."""

    def wait(self, seconds: float) -> None:
        """Waits until there is a message, at most this time (s)."""

    def unread(self) -> List[Any]:
        """Returns the messages that came since the last call."""


def first_message(source: MessageSource, is_wanted: Callable[[Any], bool], seconds: float) -> Any:
    """Returns the first wanted message; None if none comes within this time (s)."""
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        source.wait(deadline - time.monotonic())
        for message in source.unread():
            if is_wanted(message):
                return message
    return None


def first_answer(message: Any, source: MessageSource, is_answer: Callable[[Any], bool]) -> Any:
    """Sends a message, and repeats it until its answer comes. None: no answer comes.

    A message is lost if its receiver ends before it has handled the message. Therefore a message
    that arrives twice must do no harm.
    """
    sender = connected_sender(type(message))
    sender.send(message)
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline:
        answer = first_message(source, is_answer, REPEAT)
        if answer is not None:
            return answer
        sender.repeat(message)
    return None


def connected_sender(kind: Type[Any]) -> Sender:
    """Returns a sender that is connected. Raises CommandProblem if no program listens."""
    sender = Sender(kind)
    deadline = time.monotonic() + PATIENCE
    while not sender.is_heard:
        if time.monotonic() > deadline:
            raise CommandProblem(name_problem(rosgraph.network.get_host_name())
                                 or sender.complaint)
        time.sleep(0.02)
    return sender


def name_problem(host: str) -> str:
    """Returns why nodes cannot reach a program with the address `host`; empty if they can."""
    try:
        socket.getaddrinfo(host, None)
    except OSError:
        return (f"This computer's own name, {host}, has no address, so no node can reach programs "
                'here: export ROS_IP=ADDRESS, or put the name into /etc/hosts.')
    return ''


def call(service: str, kind: Type[Any] = Trigger, *arguments: Any) -> str:
    """Calls a service whose answer has the fields of Trigger. Returns the message of the answer.

    Raises CommandProblem if the service does not answer or does not succeed.
    """
    try:
        return fleet_requests.call(service, kind, *arguments, wait=PATIENCE,
                                   requested_by=requested_by('fleet'))
    except ServiceSilent as error:
        raise CommandProblem(f'The service {error}: is the fleet manager running?') from None
    except ServiceRefused as reason:
        raise CommandProblem(str(reason), NOT_DONE) from None


def ask(service: str, kind: Type[Any], *arguments: Any) -> Any:
    """Calls a service that only returns information. Returns its answer.

    Raises CommandProblem if the service does not answer.
    """
    try:
        rospy.wait_for_service(service, PATIENCE)
        return rospy.ServiceProxy(service, kind)(*arguments)
    except (rospy.ROSException, rospy.ServiceException) as error:
        raise CommandProblem(f'The service {service} does not answer ({error}): is the fleet '
                             'manager running?') from None


def requested_by(command: str) -> str:
    """Returns the user, the computer and the command that make a request, for the records."""
    try:
        user = getpass.getuser()
    except (KeyError, OSError):  # a user without a name, as in containers
        user = str(os.getuid())
    return f'{user}@{platform.node()} ({command})'
