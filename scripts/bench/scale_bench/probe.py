"""Measures how long a line takes from a robot to a subscriber; the benchmark plays the robot."""
from __future__ import annotations

import socket
import threading
import time
from typing import Dict, List

import rospy
from std_msgs.msg import String

PERIOD = 0.1  # s


class Probe:
    """Sends numbered locations until it is closed, and notes when each location is received."""

    def __init__(self, robot: str, port: int) -> None:
        self._sent: Dict[str, float] = {}
        self.delays: List[float] = []
        self._closed = threading.Event()
        self._topic = rospy.Subscriber(f'/{robot}/status/location', String, self._hear)
        self._socket = socket.create_connection(('127.0.0.1', port))
        self._thread = threading.Thread(target=self._send, daemon=True)

    def start(self) -> None:
        """Waits until the subscriber is connected, then starts to send."""
        while not self._topic.get_num_connections():
            time.sleep(0.01)
        self._thread.start()

    def close(self) -> int:
        """Ends the probe. Returns the number of lines that were not received."""
        self._closed.set()
        self._thread.join()
        time.sleep(1.0)  # for lines that are still on their way
        self._socket.close()
        return len(self._sent)

    def _send(self) -> None:
        number = 0
        while not self._closed.wait(PERIOD):
            number += 1
            line = f'Location: {number} -900000 0'  # mm, far away: robots near it would stop
            self._sent[line] = time.monotonic()
            self._socket.sendall(line.encode() + b'\r\n')

    def _hear(self, message: String) -> None:
        heard = time.monotonic()
        begun = self._sent.pop(message.data, None)
        if begun is not None:
            self.delays.append(1e3 * (heard - begun))
