#!/usr/bin/env python3
"""Measures a fleet on one computer that `scripts/run.sh fleet:=4 longest_edge:=1.5` starts.

The fleet has four simulated LD-90s, four simulated AGVs, the fleet manager, and RViz in software
rendering. The benchmark measures:

- the time from the command until all robots are ready; the floor is roslaunch with the same number
  of bare rospy nodes
- CPU and memory of each part, and the frame rate of RViz, while the robots drive
- missions per hour at real speed

`--only SECTION` runs one part (see SECTIONS).
"""
from __future__ import annotations

import argparse
import multiprocessing
import os
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List, NamedTuple, Optional, Tuple

from measuring.processes import arguments, cpu_seconds, descendants, node_name, proportional
from measuring.tables import print_table
from rviz_support import Screen, missing_programs

from ports import free_port
from rviz import frames_in

ROOT = Path(__file__).resolve().parents[2]
COUNT = 4  # number of LD-90s; the number of AGVs is the same
RUNS = 3
WARM_UP = 20.0  # s for the robots to spread over the graph
MEASURE = 40.0  # s in which CPU and frames are measured
MISSION_TIME = 210.0  # s in which missions are counted
READY_LIMIT = 120.0
BARE_NODE = ('<node name="bare_{0}" pkg="rostopic" type="rostopic" '
             'args="pub -r 2 /bare_{0} std_msgs/String {{}}"/>')
MANAGER = ('graph_server', 'path_planner', 'path_supervisor')
Message = Tuple[str, float]
"""An observation, and its time in s of the monotonic clock."""


class Usage(NamedTuple):
    """The use of resources by one part: processes, share of a core, and MB of private memory."""

    processes: int
    share: float
    memory: float


def watch_fleet(master: str, count: int, seen: multiprocessing.Queue) -> None:
    """Puts `ready` into `seen` when `count` robots take missions, and `mission` at each success."""
    import rosgraph
    import rospy

    from itrci_nav_msgs.msg import FleetRobot, FleetState, MissionStatus
    os.environ['ROS_MASTER_URI'] = master
    while not rosgraph.Master('/bench').is_online():
        time.sleep(0.01)
    rospy.init_node('bench', anonymous=True, disable_signals=True)

    def on_state(state: FleetState) -> None:
        ready = sum(one.state in (FleetRobot.IDLE, FleetRobot.BUSY) for one in state.robots)
        if ready == count:
            subscriber.unregister()
            seen.put(('ready', time.monotonic()))

    def on_status(status: MissionStatus) -> None:
        if status.state == MissionStatus.SUCCEEDED:
            seen.put(('mission', time.monotonic()))
    subscriber = rospy.Subscriber('/fleet_state', FleetState, on_state, queue_size=1)
    rospy.Subscriber('/mission_status', MissionStatus, on_status, queue_size=100)
    rospy.spin()


def watch_topics(master: str, count: int, seen: multiprocessing.Queue) -> None:
    """Puts `ready` into `seen` when each of `count` bare nodes has sent a message."""
    import rosgraph
    import rospy
    from std_msgs.msg import String
    os.environ['ROS_MASTER_URI'] = master
    while not rosgraph.Master('/bench').is_online():
        time.sleep(0.01)
    rospy.init_node('bench', anonymous=True, disable_signals=True)
    for number in range(count):
        rospy.wait_for_message(f'/bare_{number}', String)
    seen.put(('ready', time.monotonic()))


class Run(NamedTuple):
    """One run of a launch: its process id, s until it was ready, and the queue of observations."""

    pid: int
    ready_after: float
    seen: Any


@contextmanager
def running(command: Callable[[str], List[str]], watch: Callable[..., None], count: int,
            more: Optional[Dict[str, str]] = None) -> Iterator[Run]:
    """Starts a command and waits until it is ready; `command` gets the port of its ROS master."""
    port = str(free_port())
    environment = {**os.environ, **(more or {}), 'ROS_MASTER_URI': f'http://127.0.0.1:{port}'}
    context = multiprocessing.get_context('spawn')
    seen = context.Queue()
    watcher = context.Process(target=watch, args=(environment['ROS_MASTER_URI'], count, seen),
                              daemon=True)
    watcher.start()
    time.sleep(2.0)  # the time in which the watcher imports its modules must not be measured
    begun = time.monotonic()
    process = subprocess.Popen(command(port), env=environment, stdout=subprocess.DEVNULL,
                               stderr=subprocess.DEVNULL)
    try:
        yield Run(process.pid, seen.get(timeout=READY_LIMIT)[1] - begun, seen)
    finally:
        process.send_signal(signal.SIGINT)
        process.wait(60)
        watcher.terminate()


def factory(*options: str) -> Callable[[str], List[str]]:
    """Starts the fleet with the user's command, on free ports."""
    first = free_ports_of_a_fleet()
    return lambda _port: [str(ROOT / 'scripts/run.sh'), f'fleet:={COUNT}', 'longest_edge:=1.5',
                          'page:=false',
                          f'arcl_port:={first}', f'outgoing_port:={first + 5}',
                          f'control_port:={first + 2}', *options]


def free_ports_of_a_fleet() -> int:
    """Returns the first port of a range whose ports are all free, for the simulated robots."""
    from fleet_bringup.ports import is_taken
    return next(first for first in range(22000, 32000, 50)
                if not any(is_taken(first + number) for number in range(10 * COUNT)))


@contextmanager
def screen_with_frames() -> Iterator[Tuple[Dict[str, str], Callable[[], List[float]]]]:
    """Yields the environment in which RViz counts its frames, and a function that returns the
    counts so far. See rviz.py.
    """
    screen = Screen()
    with tempfile.TemporaryDirectory() as folder:
        try:
            yield {'DISPLAY': screen.environment['DISPLAY'], 'LIBGL_ALWAYS_SOFTWARE': '1',
                   'GALLIUM_HUD': 'fps', 'GALLIUM_HUD_PERIOD': '1', 'GALLIUM_HUD_VISIBLE': 'false',
                   'GALLIUM_HUD_DUMP_DIR': folder}, lambda: frames_in(folder)
        finally:
            screen.close()


def part_of(pid: int) -> str:
    """Returns the name of a process: the name of its ROS node, or else of its program."""
    words = arguments(pid)
    python = 'python' in os.path.basename(words[0]) and len(words) > 1
    return node_name(pid) or os.path.basename(words[1] if python else words[0])


def usage_of(pid: int) -> Dict[str, Usage]:
    """Observes a launch for MEASURE s. Returns the resources that each part has used. The shells of
    the script do not count.
    """
    before = {one: (part_of(one), cpu_seconds(one)) for one in descendants(pid)}
    time.sleep(MEASURE)
    parts: Dict[str, Usage] = {}
    for one, (name, used) in [*before.items(), (pid, (part_of(pid), 0.0))]:
        if name in ('bash', 'tail', 'run.sh'):
            continue
        share = (cpu_seconds(one) - used) / MEASURE if one != pid else 0.0
        processes, total, memory = parts.get(name, Usage(0, 0.0, 0.0))
        parts[name] = Usage(processes + 1, total + share, memory + proportional(one) / 2 ** 20)
    return parts


def start() -> None:
    """Measures the time from the command until all robots are ready, with and without RViz."""
    with tempfile.NamedTemporaryFile('w', suffix='.launch') as bare, \
            screen_with_frames() as (environment, _):
        with running(factory('rviz:=false'), watch_fleet, 2 * COUNT) as run:
            nodes = len(nodes_of(run.pid))
        bare.write('<launch>' + ''.join(map(BARE_NODE.format, range(nodes))) + '</launch>')
        bare.flush()

        def median(*case: Any) -> str:
            seconds = []
            for _ in range(RUNS):
                with running(*case) as run:
                    seconds.append(run.ready_after)
            return f'{statistics.median(seconds):.1f} s ({min(seconds):.1f} to {max(seconds):.1f})'
        shown = median(factory('rviz:=true'), watch_fleet, 2 * COUNT, environment)
        hidden = median(factory('rviz:=false'), watch_fleet, 2 * COUNT)
        floor = median(lambda port: ['roslaunch', '-p', port, bare.name], watch_topics, nodes)
    print_table([('with RViz', shown, floor, '< 8 s'), ('without', hidden, floor, '')],
                (f'`run.sh fleet:={COUNT}` to all {2 * COUNT} robots ready, median of {RUNS} runs',
                 'measured', f'floor ({nodes} bare rospy nodes)', 'goal'))


def nodes_of(pid: int) -> List[int]:
    """Returns the ROS nodes among the child processes of a process."""
    return [one for one in descendants(pid) if node_name(one)]


def load() -> None:
    """Measures CPU and memory of each part, and RViz's frames per second, while all robots drive.
    """
    with screen_with_frames() as (environment, frames), running(
            factory('rviz:=true', 'demo:=true'), watch_fleet, 2 * COUNT, environment) as run:
        time.sleep(WARM_UP)
        drawn = len(frames())
        parts = usage_of(run.pid)
        rates = frames()[drawn:]
    print(f'RViz, software rendering, 1280 x 900, {2 * COUNT} robots at work: '
          f'{statistics.median(rates):.1f} frames a second (median of {len(rates)} seconds; '
          f'least {min(rates):.1f}); goal >= 10\n')
    rows = [(f'`{name}`', use) for name, use in sorted(parts.items(),
                                                       key=lambda item: -item[1].share)]
    everything = Usage(*map(sum, zip(*parts.values())))
    print_table([(name, str(use.processes), f'{100 * use.share:.1f}', f'{use.memory:.0f}')
                 for name, use in (*rows, ('all', everything))],
                ('part, all at work', 'processes', '% of a core', 'MB'))


def missions() -> None:
    """Counts the missions that succeed in some minutes at real speed, as missions per hour."""
    with running(factory('rviz:=false', 'demo:=true'), watch_fleet, 2 * COUNT) as run:
        time.sleep(WARM_UP)
        begun = time.monotonic()
        time.sleep(MISSION_TIME)
        ends = [run.seen.get() for _ in range(run.seen.qsize())]
    count = sum(what == 'mission' and begun <= at < begun + MISSION_TIME for what, at in ends)
    print(f'{count} missions of one or two random destinations succeeded in {MISSION_TIME:.0f} s '
          f'at real speed: {3600 * count / MISSION_TIME:.0f} an hour, by {2 * COUNT} robots')


SECTIONS: Dict[str, Callable[[], None]] = {'start': start, 'load': load, 'missions': missions}


def main() -> None:
    """Prints the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--only', choices=SECTIONS, help='run only this section')
    only = parser.parse_args().only
    missing = missing_programs()
    if missing and only != 'missions':
        sys.exit(f'RViz cannot be measured, not installed: {", ".join(missing)}')
    for section in [only] if only else list(SECTIONS):
        SECTIONS[section]()
        print(flush=True)


if __name__ == '__main__':
    main()
