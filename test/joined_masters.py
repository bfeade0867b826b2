"""Several ROS masters on one host, each at its own loopback address, joined in pairs.

fkie multimaster joins them. If it is not installed, `master_mirror.py` joins them instead. So the
behaviour of the project's own nodes is tested on every computer.
"""
from __future__ import annotations

import contextlib
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, Dict, Iterator, List, Optional, Sequence, Set

import rosgraph
from network_namespaces import entering

from ports import free_port
from system_support import wait_until

HERE = Path(__file__).resolve().parent
CROSSING = HERE.parent / 'src' / 'graph_fleet_manager' / 'config' / 'crossing.yaml'


def has_fkie() -> bool:
    """Returns whether fkie multimaster is in this environment."""
    return subprocess.run(['rospack', 'find', 'fkie_master_sync'], stdout=subprocess.DEVNULL,
                          stderr=subprocess.DEVNULL, check=False).returncode == 0


def loopback_addresses(count: int) -> List[str]:
    """Returns addresses that no other test uses now. 127.0.0.1 is left out, because discovery would
    find itself there.
    """
    net = random.randint(16, 254)
    return [f'127.0.{net}.{number}' for number in range(2, 2 + count)]


class Computer:
    """One computer: a ROS master at its own address, and its launches.

    peers -- the computers that it joins; with `peers_from_file`, the launch itself knows them

    Each launch is the list of words after `roslaunch`. The first launch joins the masters.
    """

    def __init__(self, name: str, address: str, launches: Sequence[Sequence[object]], log: Path,
                 peers_from_file: bool = False, namespace: str = '') -> None:
        self.name, self.address = name, address
        self.port = 11311 if namespace else free_port(address)
        self.uri = f'http://{address}:{self.port}'
        self.peers: List[Computer] = []
        self.fkie = has_fkie()
        self.started = 0.0
        """The time (s, monotonic) of its last start."""
        self._launches = launches
        self._peers_from_file = peers_from_file
        self._log = log
        self.python_path = ''
        """The folder in which its programs look first for Python modules."""
        self._prefix = entering(namespace)
        self._processes: List[subprocess.Popen] = []

    @property
    def environment(self) -> Dict[str, str]:
        """The environment of a shell on this computer."""
        own = {**os.environ, 'ROS_IP': self.address, 'ROS_MASTER_URI': self.uri}
        if self.python_path:
            own['PYTHONPATH'] = f'{self.python_path}:{own["PYTHONPATH"]}'
        return own

    @property
    def master(self) -> rosgraph.Master:
        """Its ROS master, for calls by the test."""
        return rosgraph.Master('/multimaster_test', self.uri)

    def start(self) -> None:
        """Starts the master and the launches. Returns at once."""
        self.started = time.monotonic()
        first, *others = self._launches
        self._run('roslaunch', '-p', self.port, *first, *self._joining())
        for launch in others:
            self._run('roslaunch', '--wait', *launch)
        if not self.fkie:
            for peer in self.peers:
                self._run(sys.executable, HERE / 'master_mirror.py', self.uri, peer.uri, CROSSING)

    def _joining(self) -> List[str]:
        if not self.fkie:
            return []
        peers = ','.join(peer.address for peer in self.peers)
        return ['multimaster:=true', *([] if self._peers_from_file else [f'peer:={peers}'])]

    def _run(self, *words: object) -> None:
        with self._log.open('ab') as log:
            self._processes.append(subprocess.Popen(
                [*self._prefix, *map(str, words)], env=self.environment, stdout=log,
                stderr=subprocess.STDOUT))

    def kill(self) -> None:
        """Kills all programs of the computer at once, like a power failure."""
        processes = self._processes
        self._processes = []
        family = family_of([process.pid for process in processes])
        for pid in family:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        for process in processes:
            process.wait(30)
        wait_until(lambda: not any(map(is_alive, family)), 30, f'the end of {self.name}')

    def run(self, *words: object, timeout: float = 60.0) -> subprocess.CompletedProcess:
        """Runs a command on this computer as a user would. Returns the result."""
        return subprocess.run([*self._prefix, *map(str, words)], env=self.environment, text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=timeout,
                              check=False)

    def topics_of(self, other: Computer) -> Set[str]:
        """Returns the topics of the other computer's nodes that this master knows; none if there is
        no master.
        """
        try:
            publishers, subscribers, _ = self.master.getSystemState()
            nodes = {node for _, names in [*publishers, *subscribers] for node in names}
            foreign = {node for node in nodes
                       if f'//{other.address}:' in self.master.lookupNode(node)}
        except (OSError, rosgraph.MasterException):
            return set()
        return {topic for topic, names in [*publishers, *subscribers] if foreign & set(names)}

    def publishes(self, topic: str) -> bool:
        """Returns whether this master knows a publisher of the topic."""
        try:
            publishers, _, _ = self.master.getSystemState()
        except (OSError, rosgraph.MasterException):
            return False
        return topic in (name for name, _ in publishers)

    def log(self) -> str:
        """Returns the output of its programs."""
        return self._log.read_text(encoding='utf-8', errors='replace')


def join(fleet: Computer, robots: Sequence[Computer]) -> None:
    """Joins the masters: the fleet is a peer of each robot, and each robot is a peer of the fleet.
    """
    fleet.peers = list(robots)
    for robot in robots:
        robot.peers = [fleet]


def family_of(pids: Sequence[int]) -> List[int]:
    """Returns these processes and all their descendants, the oldest first."""
    children: Dict[int, List[int]] = {}
    for folder in Path('/proc').glob('[0-9]*'):
        fields = _stat(int(folder.name))
        if fields:
            children.setdefault(int(fields[1]), []).append(int(folder.name))
    found = list(pids)
    for pid in found:
        found += children.get(pid, [])
    return found


def is_alive(pid: int) -> bool:
    """Returns whether the process runs; a zombie process does not count."""
    fields = _stat(pid)
    return bool(fields) and fields[0] != 'Z'


def _stat(pid: int) -> List[str]:
    """Returns the fields of /proc/PID/stat, beginning with the state; none without the process."""
    try:
        return Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()
    except OSError:
        return []


@contextlib.contextmanager
def program(*words: object, log: Optional[Path] = None, **options: Any
            ) -> Iterator[subprocess.Popen]:
    """Runs a program without ROS during the `with` block."""
    with (log or Path(os.devnull)).open('ab') as output:
        process = subprocess.Popen([*map(str, words)], stdout=output, stderr=subprocess.STDOUT,
                                   **options)
    try:
        yield process
    finally:
        process.terminate()
        try:
            process.wait(20)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
