"""Assigns each process of a fleet to a part, and measures what the parts use."""
from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Dict, Iterable, List

from measuring.processes import arguments, cpu_seconds, descendants, node_name, proportional

STACK = ('omron_controller', 'omron_connection_receiver', 'omron_edges_to_vertices',
         'robot_state_publisher')
MANAGER = ('graph_server', 'path_planner', 'path_supervisor')
HOST = 'node host'
PARTS = ('stacks', 'fleet manager', HOST, 'simulators', 'roslaunch and roscore', 'pictures')


@dataclass(frozen=True)
class Part:
    """Processes with the same purpose."""

    pids: List[int]

    @property
    def memory(self) -> float:
        """Memory in MB; shared memory counts once (PSS)."""
        return sum(map(proportional, self.pids)) / 2 ** 20

    @property
    def threads(self) -> int:
        """The number of threads in all processes."""
        return sum(len(os.listdir(f'/proc/{pid}/task')) for pid in self.pids)

    @property
    def sockets(self) -> int:
        """The number of sockets in all processes, found among the open files."""
        return sum(os.readlink(link).startswith('socket:') for pid in self.pids
                   for link in Path(f'/proc/{pid}/fd').iterdir())

    @property
    def cpu(self) -> float:
        """CPU seconds so far. For each process, the larger of two sums counts: the exact times of
        the present threads, or the times in whole ticks of all threads that have existed.
        """
        return sum(max(cpu_seconds(pid), _whole_ticks(pid)) for pid in self.pids)


def parts_of(launch: int) -> Dict[str, Part]:
    """Returns the parts of a roslaunch: its child processes and itself."""
    found: Dict[str, List[int]] = {part: [] for part in PARTS}
    for pid in [launch, *descendants(launch)]:
        found[part_of(pid)].append(pid)
    return {part: Part(pids) for part, pids in found.items()}


def part_of(pid: int) -> str:
    """Returns the part to which a process belongs."""
    name, words = node_name(pid), arguments(pid)
    programs = {Path(word).name for word in words[:3]}
    if programs & {'hosted', 'node_host'}:
        return HOST
    if name in STACK:
        return 'stacks'
    if name in MANAGER:
        return 'fleet manager'
    if name == 'ld90_sim':
        return 'simulators'
    return 'pictures' if name and name != 'rosout' else 'roslaunch and roscore'


def _whole_ticks(pid: int) -> float:
    times = Path(f'/proc/{pid}/stat').read_text().rsplit(')', 1)[1].split()[11:13]
    return sum(map(int, times)) / os.sysconf('SC_CLK_TCK')


def cpu_shares(parts: Dict[str, Part], before: Dict[str, float],
               seconds: float) -> Dict[str, float]:
    """Returns the number of cores that each part has used since `before`."""
    return {name: (parts[name].cpu - used) / seconds for name, used in before.items()}


def used(parts: Dict[str, Part], names: Iterable[str] = PARTS) -> Dict[str, float]:
    """Returns the CPU seconds that each part has used so far."""
    return {name: parts[name].cpu for name in names}
