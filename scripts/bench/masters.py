#!/usr/bin/env python3
"""Many ROS masters joined with the fleet manager's by fkie multimaster, on loopback addresses.

Each robot's computer is a ROS master, discovery, synchronisation, peer_watch and one publisher of
reports, all in a network of their own, whose bytes are counted: needs root. The floor are the same
masters and publishers without what joins them.
"""
from __future__ import annotations

import argparse
import contextlib
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Dict, Iterator, List

import rosgraph
import rospy
from joined_masters import has_fkie
from measuring.processes import cpu_seconds, descendants, node_name, proportional
from measuring.tables import print_row, print_table

from itrci_nav_msgs.msg import ExecutionRouteStates

LOG = Path(__file__).resolve().parents[2] / 'build/masters.log'
FIRST_PORT = 12311
COUNTED = 20.0  # s over which bytes and CPU are counted
WITHIN = 60.0  # s
REPORTS = 2.0  # a second, of each robot
TOPIC = '/{}/execution_route_states'
JOINING = ('master_discovery', 'master_sync', 'peer_watch')


class Computer:
    """A ROS master on an address of its own."""

    def __init__(self, number: int) -> None:
        self.number, self.name = number, f'robot_{number}'
        self.address = f'127.0.77.{number + 2}'
        self._port = FIRST_PORT + number
        self.environment = {**os.environ, 'ROS_IP': self.address,
                            'ROS_MASTER_URI': f'http://{self.address}:{self._port}'}
        self._processes: List[subprocess.Popen] = []

    def start_master(self) -> None:
        """Returns at once."""
        self._run('rosmaster', '--core', '-p', str(self._port))

    def wait_for_master(self) -> None:
        """Until it answers."""
        while not rosgraph.is_master_online(self.environment['ROS_MASTER_URI']):
            time.sleep(0.05)

    def join(self, peers: List[str]) -> None:
        """Joins this master with those of the peers."""
        self._run('roslaunch', '--wait', 'graph_fleet_manager', 'join_masters.launch',
                  f'peer:={",".join(peers)}')

    def report(self) -> None:
        """Publishes reports from now on."""
        self._run('rostopic', 'pub', '-r', str(REPORTS), TOPIC.format(self.name),
                  'itrci_nav_msgs/ExecutionRouteStates', '{route_id: 1}')

    def _run(self, *words: str) -> None:
        with LOG.open('a', encoding='utf-8') as log:
            self._processes.append(subprocess.Popen(
                words, env=self.environment, stdout=log, stderr=log))

    def joining(self) -> Dict[str, int]:
        """The processes that join it, by name."""
        below = [pid for process in self._processes for pid in descendants(process.pid)]
        return {node_name(pid): pid for pid in below if node_name(pid) in JOINING}

    def stop(self) -> None:
        """Ends all of it."""
        for process in reversed(self._processes):
            process.send_signal(signal.SIGINT)
        for process in reversed(self._processes):
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()


class Reports:
    """What the fleet manager's computer hears of robots."""

    def __init__(self, robots: List[Computer]) -> None:
        self._heard: Dict[str, int] = {robot.name: 0 for robot in robots}
        self._lock = threading.Lock()
        for name in self._heard:
            rospy.Subscriber(TOPIC.format(name), ExecutionRouteStates, self._take, name)

    def _take(self, _: ExecutionRouteStates, name: str) -> None:
        with self._lock:
            self._heard[name] += 1

    def wait_for(self, names: List[str]) -> float:
        """s until each of these was heard."""
        begun = time.monotonic()
        while not all(self._heard[name] for name in names):
            if time.monotonic() > begun + WITHIN:
                silent = [name for name in names if not self._heard[name]]
                sys.exit(f'not heard within {WITHIN:.0f} s: {silent}')
            time.sleep(0.01)
        return time.monotonic() - begun

    @property
    def count(self) -> int:
        """Of all."""
        return sum(self._heard.values())


def loopback_bytes() -> int:
    """So many have passed in this network, each counted once."""
    line = next(line for line in Path('/proc/net/dev').read_text().splitlines()
                if line.strip().startswith('lo:'))
    return int(line.split(':')[1].split()[0])


def bytes_a_second() -> float:
    """Now."""
    before, begun = loopback_bytes(), time.monotonic()
    time.sleep(COUNTED)
    return (loopback_bytes() - before) / (time.monotonic() - begun)


@contextlib.contextmanager
def running(computers: List[Computer]) -> Iterator[None]:
    """With their masters; all that they started ends."""
    try:
        for computer in computers:
            computer.start_master()
        for computer in computers:
            computer.wait_for_master()
        yield
    finally:
        for computer in computers:
            computer.stop()


def measure(count: int) -> None:
    """Prints the rows of so many robots."""
    hub, *robots = [Computer(number) for number in range(count + 1)]
    with running([hub, *robots]):
        for robot in robots:
            robot.report()
        os.environ.update(hub.environment)
        rospy.init_node('masters_bench', disable_signals=True)
        reports = Reports(robots)
        time.sleep(5.0)
        floor = bytes_a_second()
        begun = time.monotonic()
        hub.join([robot.address for robot in robots])
        for robot in robots[:-1]:
            robot.join([hub.address])
        reports.wait_for([robot.name for robot in robots[:-1]])
        together = time.monotonic() - begun
        robots[-1].join([hub.address])
        late = reports.wait_for([robots[-1].name])
        time.sleep(10.0)  # discovery has settled
        nodes = hub.joining()
        used, heard, since = sum(map(cpu_seconds, nodes.values())), reports.count, time.monotonic()
        joined = bytes_a_second()
        seconds = time.monotonic() - since
        cores = (sum(map(cpu_seconds, nodes.values())) - used) / seconds
        lost = REPORTS * count * seconds - (reports.count - heard)
        print_row((f'**{count} robots**', '', '', ''))
        print_row((f'{count - 1} computers that join at once, until each is heard',
                   f'{together:.1f} s', '', ''))
        print_row(('one more, until it is heard', f'{late:.1f} s', '', '< 10 s'))
        print_row(('all bytes, within the computers too, each robot',
                   f'{joined / count / 1e3:.1f} kB/s', f'{floor / count / 1e3:.1f} kB/s not joined',
                   '< 20 kB/s'))
        for computer, what in ((hub, "the fleet manager's computer"), (robots[0], "a robot's")):
            memory = {name: proportional(pid) / 2 ** 20
                      for name, pid in computer.joining().items()}
            print_row((f'memory of what joins, {what} (PSS)', f'{sum(memory.values()):.0f} MB: '
                       + ', '.join(f'{name} {size:.0f}' for name, size in memory.items()), '', ''))
        print_row(("cores of what joins, the fleet manager's computer", f'{cores:.3f}', '', ''))
        print_row(('reports that did not come', f'{max(0.0, lost):.0f} of '
                   f'{REPORTS * count * seconds:.0f}', '', '0'))


def main() -> None:
    """Prints the table, each count of robots from a process in a network of its own."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--robots', type=int, action='append')
    parser.add_argument('--inside', action='store_true', help=argparse.SUPPRESS)
    given = parser.parse_args()
    if not has_fkie():
        sys.exit('fkie multimaster is not there: run scripts/multimaster.sh once.')
    counts = given.robots or [2, 5, 10]
    if given.inside:
        measure(counts[0])
        return
    print_table([])
    for count in counts:
        subprocess.run(['unshare', '--net', 'sh', '-c', 'ip link set lo up && exec "$@"', 'sh',
                        sys.executable, __file__, '--inside', '--robots', str(count)], check=False)


if __name__ == '__main__':
    main()
