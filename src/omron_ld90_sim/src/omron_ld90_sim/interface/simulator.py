"""A simulation: robots on one map, their ARCL interfaces on TCP, one clock and one loop.

In a test: `with Simulator(map_path, speed=10) as robot: ... robot.port`.
"""
from __future__ import annotations

import threading
from functools import partial
from pathlib import Path
from typing import Callable, Dict, List, Optional, Sequence, TextIO, Tuple, Union

from omron_ld90_sim.behaviour.robot import SimRobot
from omron_ld90_sim.clock import SimClock
from omron_ld90_sim.interface.autonomy import Autonomy
from omron_ld90_sim.interface.commands import execute
from omron_ld90_sim.interface.configuration import RobotConfiguration
from omron_ld90_sim.interface.configuration_table import (
    FILES,
    FLEET,
    OUTGOING,
    OUTGOING_COMMANDS,
    default_configuration,
)
from omron_ld90_sim.interface.control import SimControlServer
from omron_ld90_sim.interface.faults import Faults, NoSuchFault
from omron_ld90_sim.interface.fleet import RobotSpec
from omron_ld90_sim.interface.fleet_manager import QueuedUnit, SimFleetManager
from omron_ld90_sim.interface.loop import Loop
from omron_ld90_sim.interface.numbers import speed_factor
from omron_ld90_sim.interface.outgoing import OutgoingLink
from omron_ld90_sim.interface.recording import ReplayServer, SessionRecording, Transfer
from omron_ld90_sim.interface.server import ArclServer
from omron_ld90_sim.interface.transport import TcpServer
from omron_ld90_sim.motion.floor import SimFloor
from omron_ld90_sim.motion.kinematics import SimPose
from omron_ld90_sim.motion.places import start_places
from omron_map import MapDocument

CommandLists = Sequence[Tuple[float, str]]
DEFAULT_LISTS: CommandLists = ((0.5, 'Status'), (0.5, 'RangeDeviceGetCurrent Laser_1'))
ARRIVAL_ERROR = (30.0, 1.0)     # mm, deg; lower limits of the LD-90's own goal tolerances
ANSWER_TIMEOUT = 10.0       # s of wall time for which `inject` waits for the simulation's thread


class Unit:
    """One robot with its interface."""

    def __init__(self, loop: Loop, document: MapDocument, floor: SimFloor, spec: RobotSpec,
                 place: Optional[SimPose], settings: RobotConfiguration, password: str, seed: int,
                 host: str, folder: Path, arrival_error: Tuple[float, float]) -> None:
        self.name = spec.name
        self.robot = SimRobot(loop.clock, document, floor, place, seed, spec.battery,
                              arrival_error=arrival_error)
        self.server = ArclServer(loop.clock, self.robot, password, execute, settings, folder)
        self.server.outgoing_begins = partial(OutgoingLink, self.server)
        self.faults = Faults(self.server)
        self.autonomy = Autonomy(self.server)
        self.tcp = TcpServer(loop, self.server, host, spec.port)


def settings_for(map_name: str, outgoing: Optional[Tuple[str, int]], lists: CommandLists,
                 changes: Sequence[Tuple[str, str, str]] = ()) -> RobotConfiguration:
    """Returns a robot's configuration.

    Raises ValueError if a change (section, name, value) does not fit.
    """
    settings = default_configuration()
    settings.set(FILES, 'Map', map_name)
    if outgoing is not None:
        settings.set(OUTGOING, 'OutgoingHostname', outgoing[0])
        settings.set(OUTGOING, 'OutgoingPort', outgoing[1])
    for n, (seconds, commands) in enumerate(lists, 1):
        settings.set(OUTGOING_COMMANDS, f'OutgoingCommands{n}', commands)
        settings.set(OUTGOING_COMMANDS, f'OutgoingCommands{n}Seconds', seconds)
    for change in changes:
        settings.set(*change)
    return settings


class Simulator:
    """One robot, or several; runs in this thread (`run`) or in a separate one (`with`)."""

    def __init__(self, map_path: Union[str, Path], port: int = 0, password: str = 'adept',
                 outgoing: Optional[Tuple[str, int]] = None, speed: float = 1.0,
                 start: Optional[Tuple[float, float, float]] = None, seed: int = 0,
                 host: str = '127.0.0.1', lists: CommandLists = DEFAULT_LISTS,
                 settings: Sequence[Tuple[str, str, str]] = (), battery: float = 100.0,
                 robots: Optional[Sequence[RobotSpec]] = None,
                 arrival_error: Tuple[float, float] = ARRIVAL_ERROR) -> None:
        """`start` is in mm, mm, degrees; `speed` is the speed of the robots' clock as a factor.

        `arrival_error` (mm, degrees) is the largest distance from a goal at which a robot may
        stop; docks are always reached exactly.

        `settings` are changes of the configuration (section, parameter, value). `robots`: the
        robots of the simulation; replaces port, outgoing, start and battery.
        """
        path = Path(map_path)
        document = MapDocument.load(str(path))
        floor = SimFloor.from_map(document)
        specs = list(robots or [RobotSpec('robot', port, outgoing, start, battery)])
        self.loop = Loop(SimClock(), speed)
        self.units: List[Unit] = []
        self._host = host
        self._manager: Optional[TcpServer] = None
        try:
            places = start_places(document, floor, [spec.start for spec in specs], seed)
            for number, (spec, place) in enumerate(zip(specs, places)):
                configuration = settings_for(path.name, spec.outgoing, lists,
                                             [(FLEET, 'Identifier', spec.name), *settings])
                self.units.append(Unit(self.loop, document, floor, spec, place, configuration,
                                       password, seed + number, host, path.parent,
                                       arrival_error))
        except Exception:
            self._close()
            raise
        for unit in self.units:
            unit.robot.navigation.neighbours = [other.robot.navigation for other in self.units
                                                if other is not unit]
        self.robot, self.server = self.units[0].robot, self.units[0].server
        self.port = self.units[0].tcp.port
        self._thread: Optional[threading.Thread] = None

    @property
    def pose(self) -> Tuple[float, float, float]:
        """The true pose of the (first) robot: mm, mm, degrees."""
        pose = self.robot.true_pose
        return pose.x, pose.y, pose.theta

    @property
    def ports(self) -> Dict[str, int]:
        """ARCL port of every robot, by name."""
        return {unit.name: unit.tcp.port for unit in self.units}

    def log_to(self, file: TextIO) -> None:
        """Writes the (first) robot's sessions to `file` from now on."""
        self.server.log = SessionRecording(self.loop.clock, file)

    def control_on(self, port: int) -> int:
        """Opens the control socket on loopback; returns its port."""
        return SimControlServer(self.loop, port, self._inject_here, self.where).port

    def manage_on(self, port: int, password: str) -> int:
        """Opens the port of a Fleet Manager with these robots, and returns it.

        Raises PortTaken.
        """
        robots = [QueuedUnit(unit.name, unit.robot) for unit in self.units]
        manager = SimFleetManager(
            self.loop.clock, robots,
            lambda: [goal.name for goal in self.robot.document.goals], password)
        self._manager = TcpServer(self.loop, manager, self._host, port)
        return self._manager.port

    def where(self) -> Dict[str, object]:
        """Returns the simulated time (s), and the true pose (m, m, degrees) of each robot by name.

        With the pose it returns the distance (m) that the robot has driven since the start, in both
        directions together.
        """
        robots = {unit.name: unit.robot for unit in self.units}
        return {'time': self.loop.clock.now, 'robots': {
            name: {'x': robot.true_pose.x / 1000.0, 'y': robot.true_pose.y / 1000.0,
                   'heading': robot.true_pose.theta, 'driven': robot.base.driven / 1000.0}
            for name, robot in robots.items()}}

    def inject(self, fault: str) -> None:
        """Applies a fault, e.g. `estop press`, or in a fleet `@NAME estop press`.

        Safe from any thread. Raises NoSuchFault.
        """
        self._in_loop(lambda: self._inject_here(fault))

    def set_speed(self, speed: float) -> None:
        """Sets the speed of the robots' clock, as a factor of real time; safe from any thread.

        Raises ValueError unless it is from 0.1 to 20.
        """
        factor = speed_factor(speed)
        self._in_loop(lambda: self.loop.set_speed(factor))

    def _in_loop(self, function: Callable[[], None]) -> None:
        """Runs a function in the simulation's thread, and waits until it has taken effect."""
        if self._thread is None:
            function()
            return
        done = threading.Event()
        errors: List[NoSuchFault] = []

        def call() -> None:
            try:
                function()
            except NoSuchFault as error:
                errors.append(error)
            self.loop.call(done.set)    # in the next round; by then, ports etc. have changed

        self.loop.call(call)
        if not done.wait(ANSWER_TIMEOUT):
            raise TimeoutError('the simulation does not run')
        if errors:
            raise errors[0]

    def _inject_here(self, fault: str) -> None:
        self._faults(fault)(fault.partition(' ')[2] if fault.startswith('@') else fault)

    def _faults(self, fault: str) -> Callable[[str], None]:
        if not fault.startswith('@'):
            return self.units[0].faults.schedule
        name = fault[1:].partition(' ')[0]
        for unit in self.units:
            if unit.name == name:
                return unit.faults.schedule
        raise NoSuchFault(f"no robot '{name}'")

    def run(self) -> None:
        """Runs in this thread until `stop`."""
        try:
            self.loop.run()
        finally:
            self._close()

    def _close(self) -> None:
        for unit in self.units:
            unit.tcp.close()
        if self._manager is not None:
            self._manager.close()
        self.loop.close()

    def start(self) -> None:
        """Runs in a separate thread."""
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


class Replay:
    """Plays back a recorded session instead of a robot."""

    def __init__(self, transfers: List[Transfer], port: int = 0,
                 outgoing: Optional[Tuple[str, int]] = None, speed: float = 1.0,
                 host: str = '127.0.0.1') -> None:
        self.loop = Loop(SimClock(), speed)
        settings = settings_for('', outgoing, ())
        self._tcp = TcpServer(self.loop, ReplayServer(self.loop.clock, transfers, settings), host,
                              port)
        self.port = self._tcp.port

    def run(self) -> None:
        """Runs in this thread until `stop`."""
        try:
            self.loop.run()
        finally:
            self._tcp.close()
            self.loop.close()

    def stop(self) -> None:
        """Ends the run."""
        self.loop.stop()
