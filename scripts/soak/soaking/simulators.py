"""The control sockets of the simulators, which return true positions and cause faults."""
from __future__ import annotations

import json
import socket
import threading
from typing import Dict, Optional, Tuple

Place = Tuple[float, float]
Pose = Tuple[float, float, float]


class Simulator:
    """The control socket of one simulator. It connects again if the connection breaks."""

    def __init__(self, port: int) -> None:
        self._port = port
        self._stream: Optional[socket.SocketIO] = None
        self._lock = threading.Lock()

    def ask(self, line: str) -> str:
        """Sends one line. Returns the answer. Raises ConnectionError if there is none."""
        with self._lock:
            for _ in range(2):
                try:
                    if self._stream is None:
                        self._stream = socket.create_connection(
                            ('127.0.0.1', self._port), 30.0).makefile('rwb', 0)
                    self._stream.write(line.encode() + b'\n')
                    answer = self._stream.readline()
                except OSError:
                    answer = b''
                if answer:
                    return answer.decode().strip()
                self._stream = None
        raise ConnectionError(f'the simulator on port {self._port} does not answer')

    def poses(self) -> Dict[str, Pose]:
        """Returns the true poses of its robots, by name: x and y in m, heading in degrees."""
        return {name: (robot['x'], robot['y'], robot['heading'])
                for name, robot in json.loads(self.ask('where'))['robots'].items()}

    def places(self) -> Dict[str, Place]:
        """Returns the true positions of its robots, by name: x and y in m."""
        return {name: (x, y) for name, (x, y, _) in self.poses().items()}


class Simulators:
    """The simulators of LD-90s and AGVs. One thread samples positions, other threads cause faults.
    """

    def __init__(self, ld90_port: int, agv_port: int) -> None:
        self._eyes = Simulator(ld90_port), Simulator(agv_port)
        self._hands = {'ld90': Simulator(ld90_port), 'agv': Simulator(agv_port)}

    def places_twice(self) -> Tuple[Dict[str, Place], Dict[str, Place]]:
        """Returns the positions of all robots twice: the LD-90s are sampled just before the AGVs,
        and just after them.
        """
        ld90s, agvs = self._eyes
        before, between, after = ld90s.places(), agvs.places(), ld90s.places()
        return {**before, **between}, {**after, **between}

    def poses(self) -> Dict[str, Pose]:
        """Returns the true poses of all robots, by name; for the threads that cause faults."""
        return {name: pose for simulator in self._hands.values()
                for name, pose in simulator.poses().items()}

    def fault(self, robot: str, words: str) -> None:
        """Causes a fault of a robot. Raises ValueError if the simulator refuses the fault."""
        answer = self._hands[robot.split('_')[0]].ask(f'@{robot} {words}')
        if answer != 'ok':
            raise ValueError(f'{words} of {robot}: {answer}')

    def ld90_speed(self, factor: float) -> None:
        """Sets the speed of all LD-90s' clocks, as a multiple of real time."""
        self._hands['ld90'].ask(f'speed {factor}')
