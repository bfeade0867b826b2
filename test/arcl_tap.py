"""A proxy between the controller and the robot that notes when commands are sent."""
from __future__ import annotations

import socket
import threading
import time
from typing import List

MOTIONS = (b'goto', b'dock', b'executeMacro', b'gotoPoint', b'undock')
OUTPUTS = (b'outputOn', b'outputOff')


class ArclTap:
    """A TCP proxy on loopback. Keeps the monotonic times of commands for motions and outputs."""

    def __init__(self, port: int, robot_port: int) -> None:
        self.port = port
        self.motions: List[float] = []
        self.outputs: List[float] = []
        self._robot_port = robot_port
        self._server = socket.create_server(('127.0.0.1', port))
        threading.Thread(target=self._serve, daemon=True).start()

    def _serve(self) -> None:
        while True:
            client, _ = self._server.accept()
            try:
                robot = socket.create_connection(('127.0.0.1', self._robot_port))
            except OSError:  # the simulator has not started yet; the controller will try again
                client.close()
                continue
            for source, sink, is_client in ((client, robot, True), (robot, client, False)):
                source.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                threading.Thread(target=self._pass_on, args=(source, sink, is_client),
                                 daemon=True).start()

    def _pass_on(self, source: socket.socket, sink: socket.socket, is_client: bool) -> None:
        try:
            while True:
                data = source.recv(65536)
                for commands, times in ((MOTIONS, self.motions), (OUTPUTS, self.outputs)):
                    if is_client and data.lstrip().startswith(commands):
                        times.append(time.monotonic())
                if not data:
                    break
                sink.sendall(data)
        except OSError:
            pass  # one of the two connections has ended, so the other one must end, too
        for end in (source, sink):
            end.close()
