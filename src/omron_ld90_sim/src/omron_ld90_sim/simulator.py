"""A simulated robot inside a test: `with Simulator(map_path) as robot: ... robot.port`."""
from __future__ import annotations

import threading
from pathlib import Path
from typing import Dict, Optional, Tuple, Union

from omron_ld90.maps import MapDocument
from omron_ld90_sim.clock import Clock
from omron_ld90_sim.floor import Floor
from omron_ld90_sim.kinematics import Pose
from omron_ld90_sim.robot import Robot
from omron_ld90_sim.server import ArclServer
from omron_ld90_sim.transport import Loop, TcpServer

DEFAULT_LISTS: Dict[int, tuple] = {1: (0.5, 'Status'), 2: (0.5, 'RangeDeviceGetCurrent Laser_1')}


class Simulator:
    """One robot with its ARCL interface on TCP, run by a thread of its own."""

    def __init__(self, map_path: Union[str, Path], port: int = 0, password: str = 'adept',
                 outgoing: Optional[Tuple[str, int]] = None, speed: float = 1.0,
                 start: Optional[Tuple[float, float, float]] = None, seed: int = 0,
                 host: str = '127.0.0.1',
                 outgoing_lists: Optional[Dict[int, tuple]] = None) -> None:
        """`start` is mm, mm, degrees; `speed` is a factor on the robot's whole clock."""
        document = MapDocument.load(str(map_path))
        clock = Clock()
        self.loop = Loop(clock, speed)
        self.robot = Robot(clock, document, Floor.from_map(document),
                           Pose(*start) if start is not None else None, seed)
        self.server = ArclServer(clock, self.robot, password)
        self._tcp = TcpServer(self.loop, self.server, port, host, outgoing,
                              outgoing_lists or DEFAULT_LISTS)
        self.port = self._tcp.port
        self._thread: Optional[threading.Thread] = None

    @property
    def pose(self) -> Tuple[float, float, float]:
        """Where the robot really is: mm, mm, degrees."""
        pose = self.robot.true_pose
        return pose.x, pose.y, pose.theta

    def run(self) -> None:
        """Runs in this thread until `stop`."""
        try:
            self.loop.run()
        finally:
            self._tcp.close()
            self.loop.close()

    def start(self) -> None:
        """Runs in a thread of its own."""
        self._thread = threading.Thread(target=self.run, name='ld90_sim', daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Ends the run and frees the ports."""
        self.loop.stop()
        if self._thread is not None:
            self._thread.join(5.0)
            self._thread = None

    def __enter__(self) -> Simulator:
        self.start()
        return self

    def __exit__(self, *exception: object) -> None:
        self.stop()
