#!/usr/bin/env python3
"""Measures many LD-90s on one computer that `scripts/run.sh fleet:=FILE` starts.

The robots run with the node host and without it. The load of the simulators is in separate rows.
The floor is the same number of bare publishers at 2 Hz, with the host and without it. `--robots 10
--hosted true` measures only this case, in less than four minutes.
"""
from __future__ import annotations

import argparse
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from contextlib import contextmanager
from pathlib import Path
from typing import Dict, Iterator, List

import rosgraph
import rospy
from measuring.processes import cpu_seconds, descendants, proportional
from measuring.tables import print_row, print_table
from measuring.timing import p50_and_p99
from scale_bench.hall import PROBE, write_hall
from scale_bench.parts import HOST, PARTS, Part, cpu_shares, part_of, parts_of, used
from scale_bench.probe import Probe

from itrci_nav_msgs.msg import FleetRobot, FleetState, MissionStatus
from omron_ld90_msgs.msg import RobotStatus
from ports import free_port

ROOT = Path(__file__).resolve().parents[2]
PASSWORD = ROOT / 'src/omron_ld90_sim/config/simulator_password'
LOG = ROOT / 'build/scale.log'
ROBOTS = (1, 4, 10, 25, 50)
NODES_EACH = 4
BARE = Path(__file__).parent / 'scale_bench/bare_publisher.py'
READY_WITHIN = 150.0  # s
SETTLE, STANDING, START_DRIVING, DRIVING = 8.0, 15.0, 15.0, 30.0  # s
WORKING = (FleetRobot.IDLE, FleetRobot.BUSY, FleetRobot.CHARGING)
AIMS = {'ready': '< 40 s', 'memory': '< 3000 MB', 'standing': '< 0.9 cores',
        'driving': '< 1.2 cores', 'delay': 'p99 < 50 ms', 'lost': '0'}


class Fleet:
    """The reports on all topics of the robots."""

    def __init__(self, robots: int) -> None:
        self._robots = robots
        self.ready = threading.Event()
        self.lost = 0
        self.reports = 0
        self.missions: Counter = Counter()
        self._last: Dict[str, int] = {}
        rospy.Subscriber('/fleet_state', FleetState, self._on_state)
        rospy.Subscriber('/mission_status', MissionStatus, self._on_mission)
        for k in range(1, robots + 1):
            name = f'ld90_{k}'
            rospy.Subscriber(f'/{name}/robot_status', RobotStatus, self._on_status, name)

    def _on_state(self, state: FleetState) -> None:
        if sum(robot.state in WORKING for robot in state.robots) == self._robots:
            self.ready.set()

    def _on_status(self, status: RobotStatus, name: str) -> None:
        number = status.header.seq
        self.reports += 1
        self.lost += max(0, number - self._last.get(name, number - 1) - 1)
        self._last[name] = number

    def _on_mission(self, status: MissionStatus) -> None:
        if status.state in (MissionStatus.SUCCEEDED, MissionStatus.FAILED, MissionStatus.REFUSED):
            self.missions[status.state] += 1


@contextmanager
def launched(command: List[str]) -> Iterator[subprocess.Popen]:
    """Starts a program, and ends it in the way that Ctrl-C does."""
    with LOG.open('a', encoding='utf-8') as log:
        process = subprocess.Popen(command, stdout=log, stderr=log, start_new_session=True)
        try:
            yield process
        finally:
            process.send_signal(signal.SIGINT)
            process.wait(60)


def measure(robots: int, hosted: bool, speed: float) -> None:
    """Prints the rows of one fleet. It needs a separate process, which becomes a ROS node."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        os.environ['ROS_HOME'] = str(folder / 'ros_home')
        os.environ['ROS_MASTER_URI'] = f'http://127.0.0.1:{free_port()}'
        probe_port, first = free_port(), 30000
        hall = write_hall(folder, robots, probe_port, PASSWORD)
        words = [f'{key}:={value}' for key, value in hall.items()]
        begun = time.monotonic()
        with launched([str(ROOT / 'scripts/run.sh'), *words, 'rviz:=false',
                       f'sim_speed:={speed}', f'hosted:={str(hosted).lower()}',
                       f'arcl_port:={first}', f'outgoing_port:={first + 8}',
                       f'control_port:={first + 4}']) as process:
            while not rosgraph.Master('/bench').is_online():
                time.sleep(0.05)
            rospy.init_node('bench', anonymous=True, disable_signals=True)
            fleet = Fleet(robots)
            if not fleet.ready.wait(READY_WITHIN):
                sys.exit(f'{robots} robots are not ready within {READY_WITHIN:.0f} s.')
            title = f'{robots} LD-90s, {"hosted" if hosted else "not hosted"}'
            if speed != 1.0:
                title += f', {speed:g} x speed'
            print_row((f'**{title}**', '', '', ''))
            print_row(('from the command to all robots ready',
                       f'{time.monotonic() - begun:.1f} s', '', AIMS['ready']))
            time.sleep(SETTLE)
            parts = parts_of(process.pid)
            show_standing(parts)
            show_driving(parts, robots, fleet, probe_port)


def show_standing(parts: Dict[str, Part]) -> None:
    """Shows the rows for robots that stand: memory, threads, sockets and CPU."""
    before, begun = used(parts), time.monotonic()
    for name in PARTS:
        part = parts[name]
        if part.pids:
            print_row((f'{name}: {len(part.pids)} processes', f'{part.memory:.0f} MB (PSS), '
                       f'{part.threads} threads, {part.sockets} sockets', '', ''))
    total = sum(parts[name].memory for name in ('stacks', HOST))
    print_row(('stacks with their node host, memory', f'{total:.0f} MB, '
               f'{total / len(parts["stacks"].pids):.1f} MB a node', '', AIMS['memory']))
    time.sleep(max(0.0, begun + STANDING - time.monotonic()))
    show_cpu('standing', parts, before, time.monotonic() - begun)


def show_driving(parts: Dict[str, Part], robots: int, fleet: Fleet, port: int) -> None:
    """Shows the rows for robots that drive missions: CPU, delays and losses."""
    with launched(['rosrun', 'graph_fleet_manager', 'random_missions', '_seed:=1']):
        time.sleep(START_DRIVING)
        probe = Probe(PROBE, port)
        probe.start()
        before, begun, reports = used(parts), time.monotonic(), fleet.reports
        time.sleep(DRIVING)
        seconds = time.monotonic() - begun
        show_cpu('driving', parts, before, seconds)
        unheard = probe.close()
    print_row(("from the robot's byte to the subscriber", p50_and_p99(probe.delays) +
               f' ({len(probe.delays)} lines)', '', AIMS['delay']))
    print_row(('reports', f'{(fleet.reports - reports) / seconds / robots:.1f} a second and robot; '
               f'lost {fleet.lost} of {fleet.reports}, and {unheard} lines of the probe', '',
               AIMS['lost']))
    done, failed, refused = (fleet.missions[state] for state in (
        MissionStatus.SUCCEEDED, MissionStatus.FAILED, MissionStatus.REFUSED))
    print_row(('missions', f'{done} done, {failed} failed, {refused} refused', '', '0 failed'))


def show_cpu(when: str, parts: Dict[str, Part], before: Dict[str, float], seconds: float) -> None:
    """Shows one row: the CPU of the stacks with their node host, then that of the other parts."""
    shares = cpu_shares(parts, before, seconds)
    own = shares['stacks'] + shares[HOST]
    others = ', '.join(f'{name} {share:.2f}' for name, share in shares.items()
                       if name not in ('stacks', HOST) and parts[name].pids)
    print_row((f'stacks {when}', f'{own:.2f} cores ({others})', '', AIMS[when]))


def measure_floor(nodes: int, hosted: bool) -> None:
    """Measures `nodes` bare publishers."""
    hosted_by = '$(find node_host)/hosted ' if hosted else ''
    host = '''<include file="$(find node_host)/launch/node_host.launch">
      <arg name="modules" value="rospy std_msgs.msg"/></include>''' if hosted else ''
    # roslaunch starts only programs of packages, but a launch-prefix can be any program
    rows = [f'<node name="bare_{k}" pkg="rostopic" type="rostopic" '
            f'launch-prefix="{hosted_by}{BARE}"/>' for k in range(nodes)]
    with tempfile.TemporaryDirectory() as folder:
        os.environ['ROS_HOME'] = folder
        port = free_port()
        os.environ['ROS_MASTER_URI'] = f'http://127.0.0.1:{port}'
        launch = Path(folder) / 'bare.launch'
        launch.write_text('\n'.join(['<launch>', host, *rows, '</launch>']))
        begun = time.monotonic()
        with launched(['roslaunch', '-p', str(port), str(launch)]) as process:
            while registered() < nodes:
                time.sleep(0.05)
            seconds = time.monotonic() - begun
            time.sleep(SETTLE)
            pids = [pid for pid in descendants(process.pid)
                    if part_of(pid) != 'roslaunch and roscore']
            before, since = sum(map(cpu_seconds, pids)), time.monotonic()
            memory = sum(map(proportional, pids)) / 2 ** 20
            time.sleep(STANDING)
            cores = (sum(map(cpu_seconds, pids)) - before) / (time.monotonic() - since)
    print_row((f'floor: {nodes} bare publishers, {"hosted" if hosted else "not hosted"}',
               f'{seconds:.1f} s, {memory:.0f} MB ({memory / nodes:.1f} MB each), '
               f'{cores:.2f} cores', '', ''))


def registered() -> int:
    """Returns the number of bare publishers that the master knows."""
    try:
        publishers, _, _ = rosgraph.Master('/bench').getSystemState()
    except (OSError, rosgraph.MasterException):
        return 0
    return sum(topic.startswith('/bare/') for topic, _ in publishers)


def main() -> None:
    """Prints the table; each point is measured in a separate process."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--robots', type=int, choices=ROBOTS, action='append')
    parser.add_argument('--hosted', choices=('true', 'false'), action='append')
    parser.add_argument('--speed', type=float, default=1.0, help='of the simulated robots')
    parser.add_argument('--part', choices=('fleet', 'floor'))
    given = parser.parse_args()
    robots, hosted = given.robots or list(ROBOTS), given.hosted or ['true', 'false']
    if given.part and len(robots) == len(hosted) == 1:
        if given.part == 'fleet':
            measure(robots[0], hosted[0] == 'true', given.speed)
        else:
            measure_floor(NODES_EACH * robots[0], hosted[0] == 'true')
        return
    print_table([])
    for count in robots:
        for one in hosted:
            for part in (given.part,) if given.part else ('fleet', 'floor'):
                subprocess.run([sys.executable, __file__, '--robots', str(count), '--hosted', one,
                                '--speed', str(given.speed), '--part', part], check=False)


if __name__ == '__main__':
    main()
