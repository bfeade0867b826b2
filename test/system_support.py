"""What the system tests share: waiting for conditions, recording topics, telling of skips.

A test waits for what it wants to see and says what it waited for when that does not come; nothing
sleeps for a fixed time.
"""
from __future__ import annotations

import contextlib
import os
import signal
import socket
import subprocess
import threading
import time
import unittest
from typing import Any, Callable, Iterator, List, Optional, Type

import rospy


class Recorder:
    """Subscribes to a topic and keeps every message, with the time of its arrival."""

    def __init__(self, topic: str, message_type: Type) -> None:
        self.topic = topic
        self.messages: List[Any] = []
        self._changed = threading.Condition()
        self._subscriber = rospy.Subscriber(topic, message_type, self._add)

    def _add(self, message: Any) -> None:
        with self._changed:
            self.messages.append(message)
            self._changed.notify_all()

    def wait_for(self, predicate: Callable[[Any], bool], timeout: float, what: str,
                 after: int = 0) -> Any:
        """The first message from index `after` on with `predicate`, within `timeout` s."""
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
    """Polls `condition` until it is truthy and returns its value; fails after `timeout` s."""
    deadline = time.monotonic() + timeout
    while time.monotonic() < deadline:
        value = condition()
        if value:
            return value
        time.sleep(0.02)
    raise AssertionError(f'not within {timeout:.0f} s: {what}')


def connected_publisher(topic: str, message_type: Type, timeout: float = 30.0,
                        subscribers: int = 1) -> rospy.Publisher:
    """A publisher that already has its subscribers, so that its first message is not lost."""
    publisher = rospy.Publisher(topic, message_type, queue_size=10)
    wait_until(lambda: publisher.get_num_connections() >= subscribers, timeout,
               f'{subscribers} subscriber(s) of {topic}')
    return publisher


@contextlib.contextmanager
def launched(launch_file: str, **args: object) -> Iterator[subprocess.Popen]:
    """Runs roslaunch on one of the project's launch files, under this test's master, meanwhile."""
    process = subprocess.Popen(['roslaunch', 'omron_ld90', launch_file]
                               + [f'{name}:={value}' for name, value in args.items()])
    try:
        yield process
    finally:
        process.send_signal(signal.SIGINT)
        try:
            process.wait(30)
        except subprocess.TimeoutExpired:
            process.kill()


def skip(test: unittest.TestCase, reason: str) -> None:
    """Skips the test and records it: rostest's own result files count a skipped test as passed."""
    record: Optional[str] = os.environ.get('SYSTEM_TEST_SKIPS')
    if record:
        with open(record, 'a', encoding='utf-8') as file:
            file.write(f'{test.id()}: {reason}\n')
    test.skipTest(reason)


def free_port(address: str = '127.0.0.1') -> int:
    """A TCP port of `address` that nothing uses now."""
    with socket.socket() as probe:
        probe.bind((address, 0))
        return probe.getsockname()[1]
