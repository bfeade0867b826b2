#!/usr/bin/env python3
"""Measures ten ROS masters that fkie multimaster joins: the masters of nine robots and one manager.

All masters are on loopback addresses of a network namespace, in which bytes are counted. This needs
root. Each robot is a simulated AGV. The floor of the network traffic is one robot whose master is
not joined.
"""
from __future__ import annotations

import argparse
import os
import sys
import tempfile
import time
from pathlib import Path
from typing import Dict, List, NamedTuple, Set, Tuple

import rospy
from joined_fleet import fleet_text
from joined_masters import Computer, has_fkie, join, loopback_addresses
from measuring.processes import cpu_seconds, descendants, node_name, proportional
from measuring.tables import print_table
from network_namespaces import transmitted

from fleet_bringup.made_fleet import parking_places
from fleet_core.fleet import RobotType
from itrci_nav_msgs.msg import FleetRobot, FleetState
from system_support import Recorder, wait_until
from trajectory_graph import load_graph

ROOT = Path(__file__).resolve().parents[2]
GRAPH = ROOT / 'maps/lab_graph.yaml'
AGV = RobotType('agv', 0.35, 1.0, 0.0, False)
JOINING = ('master_discovery', 'master_sync', 'peer_watch')
COUNTED = 30.0  # s in which bytes and CPU are counted
SETTLE = 15.0  # s from the start of the last robot until the measurement
WITHIN = 180.0  # s


class Use(NamedTuple):
    """What the joining nodes of one computer use on average: memory in bytes, CPU in cores."""

    memory: float
    cores: float


class Site:
    """The computers of a fleet manager and of `count` robots, before their start."""

    def __init__(self, folder: Path, count: int) -> None:
        hub, *others = loopback_addresses(count + 1)
        names = [f'agv_{number + 1}' for number in range(count)]
        addresses = dict(zip(names, others))
        places = dict(zip(names, parking_places(load_graph(GRAPH), [AGV], 0.1, count)))
        file = folder / 'fleet.yaml'
        file.write_text(fleet_text(addresses, places=places))
        self.hub = Computer('fleet', hub, [[
            'graph_fleet_manager', 'fleet_manager.launch', f'graph_file:={GRAPH}',
            f'fleet_file:={file}', f'journal:={folder / "fleet.sqlite"}',
            f'closed_edges_file:={folder / "closed.json"}',
            f'graph_in_force_file:={folder / "graph.yaml"}']],
            folder / 'fleet.log', peers_from_file=True)
        self.robots = [self._robot(folder, name, addresses, places) for name in addresses]
        join(self.hub, self.robots)

    @staticmethod
    def _robot(folder: Path, name: str, addresses: Dict[str, str],
               places: Dict[str, int]) -> Computer:
        file = folder / f'{name}.yaml'
        file.write_text(fleet_text(addresses, driven=name, places=places))
        return Computer(name, addresses[name], [[
            ROOT / 'test/multimaster_agv.launch', f'robot:={name}', f'fleet_file:={file}',
            f'graph_file:={GRAPH}']], folder / f'{name}.log')

    def stop(self) -> None:
        """Ends all processes."""
        for computer in [*self.robots, self.hub]:
            computer.kill()


def heard_robots(states: Recorder) -> Set[str]:
    """Returns the robots that have reported to the fleet manager."""
    return {robot.name for state in states.messages[-1:] for robot in state.robots
            if robot.state in (FleetRobot.IDLE, FleetRobot.BUSY)}


def joining_nodes(computer: Computer) -> List[int]:
    """Returns the ids of the processes that join the computer's master with other masters."""
    own = f'ROS_IP={computer.address}'
    return [pid for pid in descendants(os.getpid()) if node_name(pid) in JOINING
            and own in Path(f'/proc/{pid}/environ').read_text().split('\0')]


def use_of(computers: List[Computer]) -> Use:
    """Measures the computers for COUNTED s. Returns the mean use of one computer."""
    pids = [pid for computer in computers for pid in joining_nodes(computer)]
    before, begun = sum(map(cpu_seconds, pids)), time.monotonic()
    time.sleep(COUNTED)
    cores = (sum(map(cpu_seconds, pids)) - before) / (time.monotonic() - begun)
    return Use(sum(map(proportional, pids)) / len(computers), cores / len(computers))


def bytes_a_second() -> float:
    """Returns the bytes per second now, of all computers together."""
    before, begun = transmitted('lo'), time.monotonic()
    time.sleep(COUNTED)
    return (transmitted('lo') - before) / (time.monotonic() - begun)


def measure(count: int, folder: Path) -> List[Tuple[str, str, str]]:
    """Returns the rows for `count` robots."""
    site = Site(folder, count)
    try:
        apart = Site(folder, count).robots[0]  # not joined: measures the bytes of one robot alone
        apart.fkie = False
        apart.start()
        wait_until(lambda: apart.publishes('/agv_1/execution_route_states'), 60.0, 'a robot')
        floor = bytes_a_second()
        apart.kill()

        site.hub.start()
        *most, last = site.robots
        begun = time.monotonic()
        for robot in most:
            robot.start()
        os.environ.update(site.hub.environment)
        wait_until(lambda: site.hub.publishes('/fleet_state'), WITHIN, 'the fleet manager')
        rospy.init_node('masters_bench', disable_signals=True)
        states = Recorder('/fleet_state', FleetState)
        names = {robot.name for robot in most}
        wait_until(lambda: names <= heard_robots(states), WITHIN, 'all robots but the last')
        together = time.monotonic() - begun
        last.start()
        wait_until(lambda: last.publishes(f'/{last.name}/execution_route_states'), WITHIN,
                   'the last robot at its own master')
        up = time.monotonic()
        wait_until(lambda: last.name in heard_robots(states), WITHIN, 'the last robot')
        late = time.monotonic() - up
        time.sleep(SETTLE)
        joined = bytes_a_second()
        hub, robots = use_of([site.hub]), use_of(site.robots)
    finally:
        site.stop()
    rows = [
        (f'{count + 1} masters started at once: until the fleet manager has heard of all',
         f'{together:.1f} s', ''),
        (f'robot {count} started: from its own first report until the fleet manager has it',
         f'{late:.1f} s', '< 5 s'),
        ('network traffic for each robot that stands: masters joined; not joined',
         f'{joined / count / 1000:.1f}; {floor / 1000:.1f} kB/s', '')]
    for name, use in (("the fleet manager's", hub), ("each robot's", robots)):
        rows.append((f'what joins masters, on {name} computer: memory, cores',
                     f'{use.memory / 1e6:.0f} MB, {use.cores:.3f}', ''))
    return rows


def main() -> None:
    """Prints the table. Runs in a network namespace of its own."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--robots', type=int, default=9, help='number of robots')
    given = parser.parse_args()
    if not has_fkie():
        print('Skipped: fkie multimaster is not installed; run scripts/multimaster.sh.')
        return
    if 'MASTERS_BENCH' not in os.environ:
        os.execvpe('unshare', ['unshare', '--net', 'sh', '-c', 'ip link set lo up && exec "$@"',
                               'sh', sys.executable, *sys.argv],
                   {**os.environ, 'MASTERS_BENCH': '1'})
    with tempfile.TemporaryDirectory() as folder:
        print_table(measure(given.robots, Path(folder)),
                    (f'{given.robots + 1} ROS masters, fkie multimaster', 'measured', 'goal'))


if __name__ == '__main__':
    main()
