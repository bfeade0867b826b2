#!/usr/bin/env python3
"""Measures the fleet page: the load of the node, and the delay until a browser shows a change.

The real node runs under a separate ROS master. In place of the fleet manager, this program
publishes 60 robots that drive, at 5 Hz, on a graph of 1,000 vertices. Nine clients read everything;
a tenth client reads nothing. The benchmark takes a minute and a half.
"""
from __future__ import annotations

import argparse
import math
import os
import socket
import statistics
import subprocess
import sys
import tempfile
import threading
import time
import urllib.request
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Iterator, List, Set, Tuple

import numpy as np
import rospy
from measuring.processes import cpu_seconds, descendants, proportional
from measuring.ros_master import own_ros_master
from measuring.tables import Row, print_table

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / 'src/fleet_page/test'))
from browser import MISSING, Browser  # noqa: E402
from page_builders import graph  # noqa: E402

from fleet_core.supervision.waits import WaitCode  # noqa: E402
from itrci_nav_msgs.msg import (  # noqa: E402  # noqa: E402
    Edge,
    FleetPlan,
    FleetPose,
    FleetPoses,
    FleetRobot,
    FleetState,
    PlannedDrives,
    RobotPlan,
    SymbolicPose,
    Vertex,
)
from itrci_nav_msgs.msg import Graph as GraphMessage  # noqa: E402
from node_lifecycle.periodic import Periodic  # noqa: E402
from ports import free_port  # noqa: E402
from trajectory_graph.messages import fill_message  # noqa: E402

ROBOTS, COLUMNS, ROWS = 60, 40, 25
GOOD_CLIENTS = 9
SECONDS = 30.0
CHANGES = 60
WATCH = '''
window.seen = {};
const group = document.querySelector('.robot[data-name=probe]');
new MutationObserver(() => requestAnimationFrame(() => setTimeout(() => {
  const place = group.getAttribute('transform');
  if (!(place in window.seen)) window.seen[place] = Date.now() / 1000;
}))).observe(group, {attributes: true});'''
FRAMES = '''
const done = arguments[0];
import('/page/map.js').then(map => {
  const begun = performance.now(), before = map.framesDrawn();
  const step = () => {
    if (performance.now() - begun > 3000) done((map.framesDrawn() - before) / 3);
    else { map.redraw(); requestAnimationFrame(step); }
  };
  step();
});'''


class Fleet:
    """Publishes robots that drive, in place of path_supervisor and graph_server."""

    def __init__(self) -> None:
        self.graph = graph(COLUMNS, ROWS)
        self._graphs = rospy.Publisher('/graph', GraphMessage, queue_size=1, latch=True)
        self._states = rospy.Publisher('/fleet_state', FleetState, queue_size=1, latch=True)
        self._plans = rospy.Publisher('/fleet_plan', FleetPlan, queue_size=1, latch=True)
        self._poses = rospy.Publisher('/fleet_poses', FleetPoses, queue_size=1)
        message = fill_message(GraphMessage(), self.graph, Vertex, Edge)
        message.header.stamp = rospy.Time.now()
        self._graphs.publish(message)
        self.probe = 0.0
        """The position (m) of the robot whose changes are timed."""
        self._lock = threading.Lock()
        self._ticks = 0
        Periodic('fleet', 0.1, self._tick)

    def move_probe(self, x: float) -> float:
        """Publishes another position at once. Returns the time of publication (s since 1970)."""
        with self._lock:
            self.probe = x
            now = time.time()
            self._poses.publish(FleetPoses(poses=[
                FleetPose('probe', x, -2.0, 0.0, rospy.Time.now())]))
        return now

    def _tick(self) -> None:
        self._ticks += 1
        now, angle = rospy.Time.now(), time.time()
        if self._ticks % 2 == 0:
            with self._lock:
                self._poses.publish(FleetPoses(poses=[
                    FleetPose('probe', self.probe, -2.0, 0.0, now), *(
                        FleetPose(f'robot_{k}', 2.0 * k + math.cos(angle), math.sin(angle) + k, 0.0,
                                  now) for k in range(ROBOTS))]))
        if self._ticks % 5 == 0:
            names = ['probe', *(f'robot_{k}' for k in range(ROBOTS))]
            self._states.publish(FleetState(robots=[FleetRobot(
                name=name, type='agv', state=FleetRobot.BUSY, pose=SymbolicPose(1 + k, 50.0),
                seen=now, battery=0.5, has_mission=True, request_id=k, destination=2,
                waits_for_code=WaitCode.TRAFFIC if k % 5 == 0 else WaitCode.NOTHING,
                waits_for=f'robot_{self._ticks % 7}' if k % 5 == 0 else '')
                for k, name in enumerate(names)]))
            first = self._ticks // 20
            self._plans.publish(FleetPlan(plans=[RobotPlan(
                name, PlannedDrives([1 + (first + k + n) % 900 for n in range(12)],
                                    12 * [0.0], 12 * [0.0]), 3)
                for k, name in enumerate(names)]))


class Reader(threading.Thread):
    """A client that reads all events."""

    def __init__(self, port: int) -> None:
        super().__init__(daemon=True)
        self._stream = connection(port)
        self.bytes = 0

    def run(self) -> None:
        """Counts bytes until the server closes the connection."""
        while True:
            got = len(self._stream.recv(65536))
            if not got:
                return
            self.bytes += got


def connection(port: int, buffer: int = 0) -> socket.socket:
    """Returns a connection that has requested the events."""
    stream = socket.socket()
    if buffer:
        stream.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffer)
    stream.connect(('127.0.0.1', port))
    stream.sendall(f'GET /api/events HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n'.encode())
    return stream


@contextmanager
def node(port: int, folder: str) -> Iterator[subprocess.Popen]:
    """Starts the node. Yields its process when the page answers."""
    program = subprocess.Popen(
        [sys.executable, str(ROOT / 'src/fleet_page/nodes/fleet_page'), f'_port:={port}',
         f'_folder:={folder}', f'_journal:={folder}/none.sqlite'],
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        deadline = time.monotonic() + 30.0
        while not answers(port):
            assert time.monotonic() < deadline, 'the page does not answer'
            time.sleep(0.1)
        yield program
    finally:
        program.terminate()
        program.wait(20)


def answers(port: int) -> bool:
    """Returns whether the page answers."""
    try:
        return urllib.request.urlopen(f'http://127.0.0.1:{port}/api/me', timeout=1).status == 200
    except OSError:
        return False


def used_by(program: subprocess.Popen) -> float:
    """Returns the CPU time (s) of the node and its door."""
    return sum(map(cpu_seconds, (program.pid, *descendants(program.pid))))


def cost(program: subprocess.Popen, seconds: float) -> float:
    """Returns the CPU use during some time, in % of a core."""
    begun, used = time.monotonic(), used_by(program)
    time.sleep(seconds)
    return 100.0 * (used_by(program) - used) / (time.monotonic() - begun)


def seen_since(window: Browser, known: Set[str]) -> List[float]:
    """Returns when the page drew each place that is not in `known`."""
    return [at for place, at in window.script('return window.seen').items() if place not in known]


def changes(window: Browser, fleet: Fleet) -> Tuple[float, float]:
    """Returns median and p95 of the time (ms) from a change in /fleet_poses to the frame that shows
    it.
    """
    window.wait(lambda: window.driver.find_elements('css selector', '.robot[data-name=probe]'))
    window.script(WATCH)
    delays: List[float] = []
    for number in range(CHANGES):
        known = set(window.script('return Object.keys(window.seen)'))
        moved = fleet.move_probe(3.0 + 0.5 * number)
        found = window.wait(partial(seen_since, window, known))
        delays.append(1e3 * (min(found) - moved))
        time.sleep(0.05 + 0.013 * (number % 7))
    return statistics.median(delays), float(np.percentile(delays, 95))


def first_paint(window: Browser, port: int) -> float:
    """Returns the median time (ms) from the request of the page to its first paint with content."""
    found = []
    for _ in range(5):
        window.open(f'http://127.0.0.1:{port}/')
        found.append(window.wait(lambda: window.script(
            "return performance.getEntriesByName('first-contentful-paint')[0]?.startTime")))
    return statistics.median(found)


def page_bytes(port: int) -> int:
    """Returns the total size of the page's files in transfer, with Chart.js."""
    total = 0
    names = [f'/page/{path.name}' for path in (ROOT / 'src/fleet_page/page').iterdir()]
    for path in ('/', '/chart.js', *(name for name in names if not name.endswith('.html'))):
        request = urllib.request.Request(f'http://127.0.0.1:{port}{path}',
                                         headers={'Accept-Encoding': 'gzip'})
        total += len(urllib.request.urlopen(request).read())
    return total


def figures(port: int, program: subprocess.Popen, fleet: Fleet) -> Iterator[Row]:
    """Yields the rows of all figures."""
    floor = cost(program, SECONDS / 3)
    readers = [Reader(port) for _ in range(GOOD_CLIENTS)]
    stalled = connection(port, 4096)
    for reader in readers:
        reader.start()
    time.sleep(2.0)
    share = cost(program, SECONDS)
    yield Row(f'node and door: {ROBOTS} robots at 5 Hz, {GOOD_CLIENTS} clients, one reads nothing',
              f'{share:.0f} % of a core', f'{floor:.0f} % without clients', '< 20 %')
    memory = [proportional(pid) / 1e6 for pid in (program.pid, *descendants(program.pid))]
    yield Row('the same, memory (PSS) of the node and of its door',
              ' + '.join(f'{each:.0f}' for each in memory) + ' MB', aim='< 100 MB')
    least = min(reader.bytes for reader in readers) / 1e6
    most = max(reader.bytes for reader in readers) / 1e6
    yield Row('what each good client got', f'{least:.2f} to {most:.2f} MB', aim='all the same')
    stalled.close()
    yield Row('the page, as sent, Chart.js included', f'{page_bytes(port) / 1e3:.0f} kB',
              aim='< 300 kB')
    if MISSING:
        yield Row('in a browser', MISSING)
        return
    window = Browser()
    try:
        yield Row('first paint', f'{first_paint(window, port):.0f} ms', aim='< 1000 ms')
        median, late = changes(window, fleet)
        yield Row('change to pixel', f'p50 {median:.0f} ms, p95 {late:.0f} ms', aim='p95 < 300 ms')
        window.driver.set_script_timeout(20)
        rate = window.driver.execute_async_script(FRAMES)
        yield Row(f'{COLUMNS * ROWS} vertices moved, software rendering', f'{rate:.0f} frames/s',
                  aim='> 30')
    finally:
        window.close()


def main() -> None:
    """Prints the table."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    os.environ.setdefault('ROS_IP', '127.0.0.1')
    with tempfile.TemporaryDirectory() as folder, own_ros_master():
        rospy.init_node('bench', anonymous=True, disable_signals=True)
        fleet, port = Fleet(), free_port()
        with node(port, folder) as program:
            time.sleep(3.0)
            print_table(figures(port, program, fleet))


if __name__ == '__main__':
    main()
