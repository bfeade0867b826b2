"""Starts the fleet with roslaunch, finds its processes, and measures their use of resources."""
from __future__ import annotations

import os
import signal
import socket
import subprocess
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any, List
from xmlrpc.client import ServerProxy

import rosgraph
import rospkg
from measuring.processes import arguments, descendants, proportional

from ports import free_port

PLANTS = Path(__file__).resolve().parents[1] / 'plants'
TRUE_ANSWERS = '/plan_answer_of_planner'


class Launch:
    """roslaunch with the fleet's launch file. The file is changed so that the answers of the
    planner pass through the soak.
    """

    def __init__(self, words: List[str], speed: float, folder: Path, log: Path, plant: str) -> None:
        first = _free_ports(60)
        self.control_port = first + 2
        made = subprocess.run(
            ['rosrun', 'fleet_bringup', 'fleet_launch', *words, f'sim_speed:={speed:g}',
             'rviz:=false', 'page:=false', 'hosted:=true', f'arcl_port:={first}',
             f'outgoing_port:={first + 5}', f'control_port:={self.control_port}'],
            check=True, stdout=subprocess.PIPE, text=True).stdout.strip()
        self.folder = Path(made).parent
        self._edit(Path(made), folder)
        environment = dict(os.environ)
        if plant:
            environment['SOAK_PLANT'] = plant
            environment['PYTHONPATH'] = f'{PLANTS}:{environment["PYTHONPATH"]}'
        with log.open('w', encoding='utf-8') as output:
            self._process = subprocess.Popen(['roslaunch', made], stdout=output, stderr=output,
                                             start_new_session=True, env=environment)

    @staticmethod
    def _edit(launch: Path, folder: Path) -> None:
        """Changes the launch file in four points.

        - The supervisor checks each event against the model of allocations.
        - The planner publishes its answers on TRUE_ANSWERS, and the soak forwards them.
        - The bridges keep their routes in files, as on real robots.
        - The simulated AGVs run outside the node host, because the soak kills the host, and this
          must not end robots.
        """
        manager = folder / 'fleet_manager.launch'
        original = Path(rospkg.RosPack().get_path('graph_fleet_manager'),
                        'launch/fleet_manager.launch')
        tree = ET.parse(original)
        planner = next(node for node in tree.iter('node') if node.get('name') == 'path_planner')
        ET.SubElement(planner, 'remap', {'from': '/plan_answer', 'to': TRUE_ANSWERS})
        checks = next(arg for arg in tree.iter('arg') if arg.get('name') == 'check_every')
        checks.set('default', '1')
        tree.write(manager)
        tree = ET.parse(launch)
        for include in tree.iter('include'):
            file = include.get('file', '')
            if file.endswith('/fleet_manager.launch'):
                include.set('file', str(manager))
            for argument in include.iter('arg'):
                if argument.get('name') == 'route_file':
                    name = next(other.get('value') for other in include.iter('arg')
                                if other.get('name') == 'robot_name')
                    argument.set('value', str(folder / f'{name}_route.json'))
        for node in tree.iter('node'):
            if node.get('name') == 'agv_sim':
                del node.attrib['launch-prefix']
        tree.write(launch)

    @property
    def is_running(self) -> bool:
        """Whether roslaunch still runs."""
        return self._process.poll() is None

    def pids(self) -> List[int]:
        """Returns the ids of all processes of the fleet, without the simulators."""
        return [pid for pid in descendants(self._process.pid)
                if not any(_is_called(pid, name) for name in ('ld90_sim', 'agv_sim'))]

    def host(self) -> int:
        """Returns the process id of the node host."""
        return next(pid for pid in descendants(self._process.pid)
                    if any(Path(word).name == 'node_host' for word in _words(pid)[:3]))

    def stop(self) -> None:
        """Stops the fleet in the way that Ctrl-C does; kills it after 60 s."""
        self._process.send_signal(signal.SIGINT)
        try:
            self._process.wait(60)
        except subprocess.TimeoutExpired:
            os.killpg(self._process.pid, signal.SIGKILL)


def process_of(node: str) -> int:
    """Asks the ROS master and the node for the node's process id. Returns this id.

    Raises OSError, rosgraph.MasterException or xmlrpc.client.Error.
    """
    answer: Any = ServerProxy(rosgraph.Master('/soak').lookupNode(node)).getPid('/soak')
    return int(answer[2])


def resources(pids: List[int]) -> List[float]:
    """Returns the sums over all processes: MB of memory (PSS), threads, sockets, other files."""
    memory = threads = sockets = files = 0
    for pid in pids:
        try:
            memory += proportional(pid)
            threads += len(os.listdir(f'/proc/{pid}/task'))
            links = [os.readlink(link) for link in Path(f'/proc/{pid}/fd').iterdir()]
        except (OSError, StopIteration):  # the process has ended meanwhile
            continue
        open_sockets = sum(link.startswith('socket:') for link in links)
        sockets, files = sockets + open_sockets, files + len(links) - open_sockets
    return [memory / 2 ** 20, threads, sockets, files]


def _words(pid: int) -> List[str]:
    try:
        return arguments(pid)
    except OSError:
        return []


def _is_called(pid: int, program: str) -> bool:
    return any(Path(word).name == program for word in _words(pid)[:4])


def _free_ports(count: int) -> int:
    """Returns the first of `count` consecutive free ports."""
    while True:
        first = free_port()
        try:
            for port in range(first, first + count):
                with socket.socket() as probe:
                    probe.bind(('', port))
        except OSError:
            continue
        return first
