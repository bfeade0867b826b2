"""Measures CPU and memory of other processes, from /proc."""
from __future__ import annotations

from pathlib import Path
from typing import Dict, List


def descendants(pid: int) -> List[int]:
    """Returns the ids of all processes below `pid` in the process tree."""
    children: Dict[int, List[int]] = {}
    for folder in Path('/proc').glob('[0-9]*'):
        try:
            fields = (folder / 'stat').read_text().rsplit(')', 1)[1].split()
        except OSError:  # the process has ended meanwhile
            continue
        children.setdefault(int(fields[1]), []).append(int(folder.name))
    found, waiting = [], [pid]
    while waiting:
        below = children.get(waiting.pop(), [])
        found += below
        waiting += below
    return found


def arguments(pid: int) -> List[str]:
    """Returns the command line of a process."""
    return Path(f'/proc/{pid}/cmdline').read_text().split('\0')


def node_name(pid: int) -> str:
    """Returns the name that roslaunch gave a node; empty for other processes."""
    return next((word[len('__name:='):] for word in arguments(pid)
                 if word.startswith('__name:=')), '')


def cpu_seconds(pid: int) -> float:
    """Returns the CPU time (s) that a process has used so far.

    The scheduler's account is used: /proc/PID/stat counts whole ticks and misses short wake-ups.
    """
    return sum(int(task.read_text().split()[0])
               for task in Path(f'/proc/{pid}/task').glob('*/schedstat')) / 1e9


def resident(pid: int) -> int:
    """Returns the memory of a process in bytes, with all memory that it shares with others (RSS).
    """
    return _kilobytes(Path(f'/proc/{pid}/status'), 'VmRSS:')


def proportional(pid: int) -> int:
    """Returns the memory of a process in bytes: its own, and its share of shared memory (PSS)."""
    return _kilobytes(Path(f'/proc/{pid}/smaps_rollup'), 'Pss:')


def _kilobytes(file: Path, name: str) -> int:
    line = next(line for line in file.read_text().splitlines() if line.startswith(name))
    return 1024 * int(line.split()[1])
