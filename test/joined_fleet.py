"""A fleet with several ROS masters: an LD-90 that goes on if its computer is killed, AGVs, and a
fleet manager.
"""
from __future__ import annotations

import contextlib
import json
import os
import re
import shutil
import socket
import time
from pathlib import Path
from typing import Callable, Dict, List, Mapping, Tuple

from joined_masters import Computer, join, loopback_addresses, program
from network_namespaces import entering, inside

from fleet_core.supervision.history import HistoryLine, history
from fleet_core.supervision.journal_database import JournalError
from fleet_core.supervision.missions import MissionState
from ports import free_port
from system_support import wait_until

HERE = Path(__file__).resolve().parent
MAPS = HERE.parent / 'maps'
PASSWORD = HERE.parent / 'src' / 'omron_ld90_sim' / 'config' / 'simulator_password'
LD90 = 'omron_ld90'
#: The places of the AGVs: dead ends beside all routes of the LD-90.
AGVS = {'agv_1': 32, 'agv_2': 41}
FLEET = '''clearance: 0.1
robot_types:
- {name: omron_ld90, radius: 0.43, speed: 1.35, play: 0.25, obeys_edge_speed: false,
   docks: [16], release_ahead: 8.0, slack: 0.3}
- {name: agv, radius: 0.35, speed: 1.0, obeys_edge_speed: false, release_ahead: 2.0}
robots:
'''


def fleet_text(computers: Dict[str, str], driven: str = '', absent: str = '',
               places: Mapping[str, int] = AGVS) -> str:
    """Returns a fleet file with the robots of these computers, and the AGVs' places.

    driven -- an AGV to simulate
    absent -- a robot that has not been delivered yet
    """
    lines = []
    for name, address in computers.items():
        kind = 'omron_ld90' if name == LD90 else 'agv'
        driver = 'driver: agv' if name == driven else f'driver: none, computer: {address}'
        if name == absent:
            driver += ', absent: true'
        vertex = places.get(name, 16)
        lines.append(f'- {{name: {name}, type: {kind}, vertex: {vertex}, {driver}}}\n')
    return FLEET + ''.join(lines)


class JoinedFleet:
    """The computers of a fleet, before their start. Only the simulated LD-90 already runs."""

    def __init__(self, folder: Path, sim_speed: float, agvs: int = 0,
                 namespaces: Tuple[str, str] = ('', ''),
                 addresses: Tuple[str, ...] = (), pictures: bool = True,
                 absent: str = '') -> None:
        """Prepares the computers.

        namespaces -- two network namespaces: one for the LD-90 and its computer, one for the fleet
                      manager's computer
        addresses  -- of the LD-90's computer, the fleet manager's computer, and the AGVs' computers
        pictures   -- whether the LD-90's computer runs nodes that draw
        absent     -- a robot that is not at the site yet; the fleet manager knows this
        """
        self._folder = folder
        self._sim_speed = sim_speed
        self.journal = folder / 'fleet.sqlite'
        own, manager, *others = addresses or loopback_addresses(2 + agvs)
        names = dict(zip([LD90, *list(AGVS)[:agvs]], [own, *others]))
        fleet_file = folder / 'fleet.yaml'
        fleet_file.write_text(fleet_text(names, absent=absent))
        self._ports = [free_port() for _ in range(3)]  # for ARCL, outgoing connection, control
        graph = MAPS / 'lab_graph.yaml'
        self.manager = Computer('fleet', manager, [[
            'graph_fleet_manager', 'fleet_manager.launch', f'graph_file:={graph}',
            f'fleet_file:={fleet_file}', f'journal:={self.journal}',
            f'closed_edges_file:={folder / "closed.json"}',
            f'graph_in_force_file:={folder / "graph.yaml"}', f'sim_speed:={sim_speed}',
        ]], folder / 'fleet.log', peers_from_file=True, namespace=namespaces[1])
        self.robot = Computer(LD90, own, [[
            *(['omron_ld90', 'full_stack.launch', 'sim:=false', 'robot_ip:=127.0.0.1',
               'rviz:=false'] if pictures else [str(HERE / 'multimaster_ld90.launch')]),
            f'arcl_port:={self._ports[0]}', f'outgoing_port:={self._ports[1]}',
            f'password_file:={PASSWORD}', f'route_file:={folder / "route.json"}',
            'restart_timeout:=120',
        ]], folder / 'robot.log', namespace=namespaces[0])
        self.agvs = [self._agv(name, names) for name in list(names)[1:]]
        join(self.manager, [self.robot, *self.agvs])
        self._namespaces = namespaces
        self._stack = contextlib.ExitStack()

    def _agv(self, name: str, names: Dict[str, str]) -> Computer:
        file = self._folder / f'{name}.yaml'
        file.write_text(fleet_text(names, driven=name))
        return Computer(name, names[name], [[
            str(HERE / 'multimaster_agv.launch'), f'robot:={name}', f'fleet_file:={file}',
            f'graph_file:={MAPS / "lab_graph.yaml"}', f'sim_speed:={self._sim_speed}',
        ]], self._folder / f'{name}.log')

    def __enter__(self) -> JoinedFleet:
        arcl, outgoing, control = self._ports
        self._stack.enter_context(program(
            *entering(self._namespaces[0]), 'rosrun', 'omron_ld90_sim', 'ld90_sim',
            '--map', MAPS / 'lab.map', '--port', arcl, '--outgoing', f'127.0.0.1:{outgoing}',
            '--password-file', PASSWORD, '--speed', self._sim_speed, '--control', control,
            '--log', self.session,
            log=self._folder / 'ld90.log'))
        self.control().close()
        return self

    def __exit__(self, *_: object) -> None:
        for computer in self.computers:
            computer.kill()
        self._stack.close()

    @property
    def computers(self) -> List[Computer]:
        """All computers."""
        return [self.robot, self.manager, *self.agvs]

    @property
    def session(self) -> Path:
        """The file with every ARCL line between the LD-90 and its computer, as the LD-90 saw it."""
        return self._folder / 'arcl.log'

    def sent_to_ld90(self, word: str) -> List[str]:
        """Returns the commands with this name that the LD-90 got from its computer, in order."""
        return re.findall(rf'^\S+ C\d*> ({word}.*?)\s*$',
                          self.session.read_text(errors='replace'), re.MULTILINE)

    def control(self) -> socket.socket:
        """Returns a connection to the control socket of the LD-90's simulator."""
        def connect() -> socket.socket:
            with contextlib.suppress(ConnectionRefusedError):
                return socket.create_connection(('127.0.0.1', self._ports[2]), timeout=10.0)
        return wait_until(lambda: inside(self._namespaces[0], connect), 30, 'the simulated LD-90')

    def send(self, *destinations: int, robot: str = LD90) -> int:
        """Sends a mission from the fleet manager's computer. Returns its id."""
        def accepted() -> str:
            said = self.manager.run('rosrun', 'graph_fleet_manager', 'mission', *destinations,
                                    '--robot', robot, timeout=60.0).stdout
            return said if 'is accepted' in said else ''
        return int(re.search(r'Mission (\d+)', wait_until(
            accepted, 90, f'a mission to {destinations} is accepted')).group(1))

    def mission(self, number: int) -> HistoryLine:
        """Returns the state of a mission in the fleet manager's journal."""
        return next(line for line in history(str(self.journal)) if line.request_id == number)

    def is_open(self, number: int) -> bool:
        """Returns whether a mission is open; True also if the journal cannot be read now."""
        try:
            return self.mission(number).state.is_open
        except JournalError:  # the fleet manager is being killed or started
            return True

    def wait_for_mission(self, number: int, what: str, reached: Callable[[HistoryLine], bool],
                         timeout: float = 120.0) -> HistoryLine:
        """Waits until a mission has this state. Fails at once if it has ended in another state."""
        def look() -> bool:
            try:
                line = self.mission(number)
            except JournalError:  # the fleet manager is being killed or started
                return False
            if not reached(line) and not line.state.is_open:
                raise AssertionError(f'mission {number}: {line.state.name} ({line.reason}), not '
                                     f'{what}; the fleet manager said:\n'
                                     f'{self.manager.log()[-3000:]}\nthe robot\'s computer:\n'
                                     f'{self.robot.log()[-3000:]}')
            return reached(line)
        try:
            wait_until(look, timeout, f'mission {number}: {what}')
        except AssertionError as late:
            raise AssertionError(f'{late}; {self.mission(number)}\n{self.manager.log()[-3000:]}\n'
                                 f'{self.robot.log()[-3000:]}') from None
        return self.mission(number)

    def succeeded(self, number: int, timeout: float = 120.0) -> HistoryLine:
        """Waits until a mission has succeeded."""
        return self.wait_for_mission(
            number, 'it has succeeded', lambda line: line.state is MissionState.SUCCEEDED, timeout)


class Odometer:
    """Measures with the simulator how far the LD-90 really drives from now on."""

    RESTS = 1.0  # s without motion after which the robot counts as standing

    def __init__(self, fleet: JoinedFleet) -> None:
        self._control = fleet.control()
        self._answers = self._control.makefile()
        self._begin = self._driven()

    def __enter__(self) -> Odometer:
        return self

    def __exit__(self, *_: object) -> None:
        self._control.close()

    def _driven(self) -> float:
        self._control.sendall(b'where\n')
        robot, = json.loads(self._answers.readline())['robots'].values()
        return robot['driven']

    @property
    def metres(self) -> float:
        """The distance (m) driven so far."""
        return self._driven() - self._begin

    def wait_for(self, metres: float, timeout: float = 60.0) -> None:
        """Waits until the robot has driven this many metres from now on."""
        begin = self.metres
        wait_until(lambda: self.metres - begin >= metres, timeout,
                   f'the robot drives another {metres} m')

    def wait_for_rest_or(self, metres: float) -> None:
        """Waits until the robot has driven this far (m), or stands after its last command."""
        begin = last = self.metres
        moved = time.monotonic()

        def is_over() -> bool:
            nonlocal last, moved
            now = self.metres
            if now != last:
                last, moved = now, time.monotonic()
            return now - begin >= metres or time.monotonic() - moved > self.RESTS
        wait_until(is_over, 60.0, f'the robot drives another {metres} m, or stands')


def kept_folder(name: str) -> Path:
    """Makes a folder for the output of the computers, which is kept to analyse failures."""
    folder = Path(os.environ.get('SYSTEM_TEST_ARTEFACTS', '/tmp')) / name
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    return folder
