"""Measures the simulated LD-90: CPU at rest and driving, alone and as a fleet; scans; planning.

CPU is the CPU time of the simulator's process, divided by the elapsed time. A client reads
everything and checks that the statuses come on time. Scans and plans use the map of a real LD robot
if there is one beside the repository, else the laboratory.
"""
from __future__ import annotations

import contextlib
import os
import selectors
import socket
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Callable, Dict, Iterator, List, Tuple

import numpy as np
from measuring.processes import cpu_seconds
from measuring.tables import Row, print_table
from measuring.timing import milliseconds
from skimage.graph import MCP_Geometric

from omron_ld90_sim.behaviour.robot import SimRobot
from omron_ld90_sim.clock import SimClock
from omron_ld90_sim.devices import laser
from omron_ld90_sim.motion.floor import SimFloor
from omron_ld90_sim.motion.kinematics import SimPose
from omron_ld90_sim.motion.manoeuvres import manoeuvres
from omron_ld90_sim.motion.planner import NoWay, Planner
from omron_map import MapDocument

ROOT = Path(__file__).resolve().parents[2]
REAL = Path(os.environ.get('LD90_REAL_MAPS') or '/nowhere') / 'omron-ld-site-a.map'
PROGRAM = [sys.executable, '-c',
           'import sys; from omron_ld90_sim.interface.cli import main; sys.exit(main())']
FLOOR_PROGRAM = [sys.executable, '-c',
                 'import time\nwhile True: time.sleep(0.5)']
LIBRARIES = [sys.executable, '-c',
             'import numpy, yaml, scipy.ndimage, skimage.graph; print("ready", flush=True)']
STATUS_PERIOD = 0.5     # s
SECONDS = 10.0
SETTLE = 8.0  # s, in which a whole fleet plans its first paths
RUNS = 3
FLEET = 50
PAIRS = 60


class Listener:
    """Accepts the outgoing connections of all robots, reads them, and notes when statuses come."""

    def __init__(self) -> None:
        self._selector = selectors.DefaultSelector()
        server = socket.create_server(('127.0.0.1', 0), backlog=100)
        self.port = server.getsockname()[1]
        self._selector.register(server, selectors.EVENT_READ, None)
        self._statuses: Dict[socket.socket, List[float]] = {}
        threading.Thread(target=self._run, args=(server,), daemon=True).start()

    def _run(self, server: socket.socket) -> None:
        while True:
            for key, _ in self._selector.select():
                if key.data is None:
                    link, _ = server.accept()
                    self._statuses[link] = []
                    self._selector.register(link, selectors.EVENT_READ, link)
                    continue
                link, data = key.data, b''
                with contextlib.suppress(ConnectionResetError):
                    data = link.recv(65536)
                self._statuses[link] += [time.monotonic()] * data.count(b'LocalizationScore')
                if not data:
                    self._selector.unregister(link)

    def pace(self, since: float) -> float:
        """Returns the simulated seconds per real second since the time `since`."""
        recent = [sum(at >= since for at in list(times)) for times in list(self._statuses.values())]
        return max(recent) * STATUS_PERIOD / (time.monotonic() - since)

    def lateness(self, since: float) -> np.ndarray:
        """Returns the delay (s) of each status since the time `since`. The most punctual status of
        each link has the delay 0.
        """
        late = []
        for times in list(self._statuses.values()):
            recent = np.array([at for at in list(times) if at >= since])
            if len(recent):
                late.append(recent - np.arange(len(recent)) * STATUS_PERIOD)
                late[-1] -= late[-1].min()
        return np.concatenate(late)


def share_of_a_core(command: List[str], ready: int, work: Callable[[List[int]], None]
                    ) -> Tuple[float, float]:
    """Returns the share of a core (%) that a program uses (median of several periods), and the time
    when the first period began.
    """
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as program:
        try:
            output = program.stdout
            assert output is not None
            ports = [int(output.readline().split('127.0.0.1:')[1].split()[0])
                     for _ in range(ready)]
            work(ports)
            time.sleep(SETTLE)
            shares, first = [], time.monotonic()
            for _ in range(RUNS):
                begin, used = time.monotonic(), cpu_seconds(program.pid)
                time.sleep(SECONDS)
                shares.append((cpu_seconds(program.pid) - used)
                              / (time.monotonic() - begin) * 100.0)
            return statistics.median(shares), first
        finally:
            program.terminate()


def patrol(ports: List[int]) -> None:
    """Makes each robot drive without end."""
    for number, port in enumerate(ports):
        threading.Thread(target=drive, args=(port, number), daemon=True).start()


def drive(port: int, number: int) -> None:
    """Drives from goal to goal until the simulation ends."""
    with socket.create_connection(('127.0.0.1', port)) as sock, contextlib.suppress(OSError):
        sock.sendall(b'adept\ngetGoals\n')
        goals: List[str] = []
        for line in sock.makefile('r', newline='\r\n'):
            if line.startswith('Goal: '):
                goals.append(line[6:].strip())
            elif line.startswith(('End of goals', 'Arrived', 'Error')):
                number += 37
                sock.sendall(f'goto {goals[number % len(goals)]}\n'.encode())


def hall(folder: str) -> Path:
    """Returns a hall of 50 x 40 m with pillars and 99 goals, with enough room for a fleet."""
    path = Path(folder) / 'hall.map'
    walls = [(0, 0, 50000, 0), (0, 40000, 50000, 40000), (0, 0, 0, 40000),
             (50000, 0, 50000, 40000)]
    for x in range(7000, 48000, 8000):
        for y in range(6000, 38000, 8000):
            walls += [(x - 200, y, x + 200, y), (x, y - 200, x, y + 200)]
    goals = [f'Cairn: Goal {5000 + 4000 * column} {4000 + 4000 * row} 0.000000 "" ICON "{n}"'
             for n, (column, row) in enumerate((c, r) for c in range(11) for r in range(9))]
    path.write_text('\n'.join(['2D-Map', 'LineMinPos: 0 0', 'LineMaxPos: 50000 40000',
                               f'NumLines: {len(walls)}', 'LinesAreSorted: false',
                               'MapInfo: GoalType Name=Goal', *goals, 'LINES',
                               *(' '.join(map(str, wall)) for wall in walls)]) + '\n')
    return path


def fleet_file(folder: str, link: int) -> Path:
    """Returns a fleet file in which each robot sends status and laser at 2 Hz."""
    path = Path(folder) / 'fleet.yaml'
    rows = [f'- {{name: r{n}, port: 0, outgoing: "127.0.0.1:{link}"}}' for n in range(FLEET)]
    path.write_text('robots:\n' + '\n'.join(rows) + '\n')
    return path


def processes(lab: Path) -> List[Row]:
    """Returns rows: the shares of a core."""
    listener = Listener()
    floor, _ = share_of_a_core(FLOOR_PROGRAM, 0, lambda ports: None)
    base = [*PROGRAM, '--port', '0']
    link = ['--outgoing', f'127.0.0.1:{listener.port}']
    rows = []
    for what, work in (('standing', lambda ports: None), ('driving', patrol)):
        share, began = share_of_a_core([*base, '--map', str(lab), *link], 1, work)
        rows.append(Row(f'one robot {what}, status and laser at 2 Hz',
                        f'{share:.1f} % of a core, {punctuality(listener, began)}',
                        f'{floor:.1f} % (a process that wakes at 2 Hz)', 'under 5 %'))
    with tempfile.TemporaryDirectory() as folder:
        fleet, wide = str(fleet_file(folder, listener.port)), str(hall(folder))
        for what, work in (('standing', lambda ports: None), ('driving', patrol)):
            share, began = share_of_a_core([*base, '--map', wide, '--robots', fleet], FLEET, work)
            rows.append(Row(f'{FLEET} robots {what}, status and laser at 2 Hz',
                            f'{share:.0f} % of a core, {punctuality(listener, began)}',
                            f'{floor:.1f} %', 'under 100 %, clock at 100 %'))
    return rows


def punctuality(listener: Listener, since: float) -> str:
    """Returns a text that says whether the simulated clock has kept up with the real clock,
    according to the times at which a listener got statuses.
    """
    late = listener.lateness(since) * 1000.0
    return (f'clock at {100.0 * listener.pace(since):.0f} %, statuses late by '
            f'{np.median(late):.0f} ms, at most {late.max():.0f} ms')


def ready(lab: Path) -> Row:
    """Measures the time from the start of the program to its line that says that it listens."""
    def start(command: List[str]) -> None:
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as program:
            assert program.stdout is not None
            program.stdout.readline()
            program.terminate()
    ours = milliseconds(lambda: start([*PROGRAM, '--port', '0', '--map', str(lab)]), 5)
    least = milliseconds(lambda: start(LIBRARIES), 5)
    return Row(f'start on {lab.name}, to the ready line', f'{ours / 1000:.2f} s',
               f'{least / 1000:.2f} s (importing numpy, scipy and scikit-image)', '')


def scans(document: MapDocument, floor: SimFloor, start: SimPose) -> Row:
    """Measures one scan; the floor is one numpy operation on the same number of rays."""
    robot = SimRobot(SimClock(), document, floor, start)
    rays = np.linspace(0.0, 1.0, laser.RAYS)
    ours = milliseconds(robot.scan, 200)
    least = milliseconds(lambda: np.column_stack([np.cos(rays), np.sin(rays)]), 200)
    return Row(f'a scan of {laser.RAYS} rays', f'{ours:.2f} ms ({1000 / ours:.0f} a second)',
               f'{least:.2f} ms (sine and cosine of the rays)', '500 a second')


def plans(floor: SimFloor, start: SimPose) -> Row:
    """Measures plans between random places of the region in which the robot stands."""
    planner = Planner(floor)
    region = floor.regions[floor.planning_cell(start.x, start.y)]
    cells = np.argwhere(floor.regions == region)
    free = np.where(floor.planning_clearance >= floor.body.half_diagonal, 1.0, -1.0)
    random = np.random.RandomState(1)
    times: List[float] = []
    searches: List[float] = []
    while len(times) < PAIRS:
        a, b = floor.planning_points(cells[random.randint(len(cells), size=2)])
        pose = SimPose(a[0], a[1], random.uniform(-180, 180))
        begin = time.perf_counter()
        try:
            way = planner.plan(pose, b[0], b[1], 0.0)
        except NoWay:
            continue
        manoeuvres(way, planner)
        times.append((time.perf_counter() - begin) * 1000.0)
        begin = time.perf_counter()
        MCP_Geometric(free).find_costs([floor.planning_cell(*a)], [floor.planning_cell(*b)])
        searches.append((time.perf_counter() - begin) * 1000.0)
    rows, columns = floor.planning_clearance.shape
    return Row(f'planning on {columns} x {rows} cells',
               f'{statistics.median(times):.0f} ms, worst {max(times):.0f} ms',
               f'{statistics.median(searches):.0f} ms (the grid search alone, same ends)',
               'median under 100 ms')


def main() -> None:
    """Measures everything and prints the table."""
    lab = ROOT / 'maps' / 'lab.map'
    path = REAL if REAL.exists() else lab
    document = MapDocument.load(str(path))
    floor = SimFloor.from_map(document)
    goal = document.goals[0]
    start = SimPose(goal.x, goal.y, goal.theta)

    def rows() -> Iterator[Row]:
        loading = milliseconds(lambda: SimFloor.from_map(document), 5)
        reading = milliseconds(lambda: MapDocument.load(str(path)), 5)
        yield Row(f'distance fields of {path.name}', f'{loading:.0f} ms',
                  f'{reading:.0f} ms (reading the file)')
        yield scans(document, floor, start)
        yield plans(floor, start)
        yield ready(lab)
        yield from processes(lab)
    print_table(rows())


if __name__ == '__main__':
    main()
