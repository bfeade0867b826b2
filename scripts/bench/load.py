#!/usr/bin/env python3
"""Measures the fleet manager under the load of hundreds of robots; each figure has its floor.

    robots_50, robots_200   the nodes as users run them; this process plays the robots
    devices_200             200 robots with 50 doors, and the same fleet without doors
    history                 a journal with a million ended missions (no ROS)
    planning                first plans and replans on 5,000 vertices (no ROS)
    decisions               reports, ticks and plans of 200 robots (no ROS)

`--only SECTION` runs one part.
"""
from __future__ import annotations

import math
import subprocess
import sys
import threading
import time
from concurrent.futures import ProcessPoolExecutor
from contextlib import suppress
from multiprocessing import get_context
from pathlib import Path
from typing import Callable, Dict, Iterator, List, Mapping, NamedTuple, Sequence, Tuple

import rospy
from load_bench.decisions import decisions
from load_bench.endless_missions import EndlessMissions
from load_bench.history import history
from load_bench.light_fleet import PERIOD, LightFleet, Release
from load_bench.planning import planning
from load_bench.site import save_site
from measuring.processes import cpu_seconds, descendants, node_name, proportional
from measuring.sections import print_sections
from measuring.tables import Row
from measuring.timing import p50_and_p99
from supervisor_bench.stacks import MANAGER, MANAGER_AT_WORK, Stack

from itrci_nav_msgs.msg import FleetState, PlanAnswer, PlanRequest, TargetRoute
from system_support import Recorder, wait_until

OPEN = 5000  # open missions
SETTLING = 45.0  # s from the first missions to the measurement; nearly all first plans exist then
SECONDS = 60.0  # duration of a measurement, s
DOORS = 50
FLOOR = 10.0  # duration of the measurement of the floor, s


class Planning:
    """The times in which the planner works: from each request to its answer."""

    def __init__(self) -> None:
        self.times: List[float] = []
        """The times (s), measured by the planner's own clock."""
        self.unserved = 0
        self.failed = 0
        self._begun: Dict[int, float] = {}
        self._spans: List[Tuple[float, float]] = []
        rospy.Subscriber('/plan_request', PlanRequest, self._on_request)
        rospy.Subscriber('/plan_answer', PlanAnswer, self._on_answer)

    def _on_request(self, request: PlanRequest) -> None:
        self._begun[request.plan_id] = time.monotonic()

    def _on_answer(self, answer: PlanAnswer) -> None:
        now = time.monotonic()
        self._spans.append((self._begun.get(answer.plan_id, now), now))
        if answer.result == PlanAnswer.PLANNED:
            self.times.append(answer.planning_time)
            self.unserved += len(answer.unserved)
        else:
            self.failed += 1

    def overlaps(self, release: Release) -> bool:
        """Returns whether the planner worked between the report and the release."""
        begun = release.moment - release.seconds
        return any(start <= release.moment and end >= begun for start, end in self._spans)

    def share(self, begun: float, ended: float) -> float:
        """Returns the share of a period in which the planner worked on a request."""
        return sum(max(min(end, ended) - max(start, begun), 0.0)
                   for start, end in self._spans) / (ended - begun)


class Commits:
    """Counts the commits to a journal in its write-ahead log, to which SQLite writes first."""

    def __init__(self, path: Path) -> None:
        self.count = 0
        self._log = Path(f'{path}-wal')
        self._frame = (0, 0)  # the salt of the log, and the number of frames read so far
        threading.Thread(target=self._watch, daemon=True).start()

    def _watch(self) -> None:
        while not rospy.is_shutdown():
            with suppress(OSError):
                self._read_log()
            time.sleep(0.25)

    def _read_log(self) -> None:
        """Reads the log. The second number of a frame is the size of the database if the frame ends
        a commit; otherwise it is 0.
        """
        with self._log.open('rb') as log:
            header = log.read(32)
            if len(header) < 32:
                return
            page, salt = int.from_bytes(header[8:12], 'big'), header[16:24]
            key = int.from_bytes(salt, 'big')
            frames = self._frame[1] if self._frame[0] == key else 0
            log.seek(32 + frames * (page + 24))
            while True:
                frame = log.read(page + 24)
                if len(frame) < page + 24 or frame[8:16] != salt:
                    break
                frames += 1
                self.count += frame[4:8] != bytes(4)
            self._frame = key, frames


def floors(names: Sequence[str]) -> Tuple[str, str]:
    """Returns the time of a bare round trip, and the CPU of a bare subscriber to all reports."""
    hops: List[float] = []
    rospy.Subscriber('/bare_answer', TargetRoute, lambda message: hops.append(
        1e3 * (rospy.Time.now() - message.header.stamp).to_sec()), tcp_nodelay=True)
    program = Path(__file__).parent / 'load_bench/bare_subscriber.py'
    process = subprocess.Popen([sys.executable, str(program), *names])
    try:
        wait_until(lambda: hops, 60, 'answers of the bare subscriber')
        time.sleep(3.0)
        before, heard, begun = cpu_seconds(process.pid), len(hops), time.monotonic()
        time.sleep(FLOOR)
        share = (cpu_seconds(process.pid) - before) / (time.monotonic() - begun)
    finally:
        process.terminate()
        process.wait(20)
    return p50_and_p99(hops[heard:]), f'{100 * share:.0f} %'


class Measured(NamedTuple):
    """The measurements of a fleet during SECONDS; rates are per second."""

    shares: Mapping[str, float]
    reports: float
    latest: float
    busy: int
    open: int
    memory: float
    releases: Sequence[Release]
    commits: float
    travelled: float
    planning: Planning
    planned: Sequence[float]
    span: Tuple[float, float]
    ended: Mapping[int, int]
    reasons: Mapping[str, int]
    edges: int
    hop: str
    bare: str


def measured(count: int, side: int, doors: int = 0) -> Measured:
    """Measures `count` robots at 10 Hz, all on missions, on a grid of side x side vertices.

    doors -- number of edges of the grid that lead through a simulated door
    """
    with Stack() as stack:
        site = save_site(stack.folder, side, count, doors)
        graph = site.graph
        rospy.init_node('bench', anonymous=True, disable_signals=True)
        fleet = LightFleet(graph, site.places)
        hop, bare = floors(list(site.places))
        manager = stack.launch(MANAGER_AT_WORK if doors else MANAGER, speed=1.0, **site.files)
        plans = Planning()
        states = Recorder('/fleet_state', FleetState)
        states.wait_for(lambda state: all(robot.seen for robot in state.robots), 300,
                        'all robots')
        commits = Commits(stack.folder / 'fleet.sqlite')
        missions = EndlessMissions(site.grid, site.rings)
        missions.send_round()
        missions.send(OPEN - len(site.rings))
        states.wait_for(lambda state: sum(robot.has_mission for robot in state.robots)
                        >= 0.9 * count, 120, 'a busy fleet')
        time.sleep(SETTLING)
        nodes = {node_name(pid): pid for pid in descendants(manager.pid) if node_name(pid)}
        before = {name: cpu_seconds(pid) for name, pid in nodes.items()}
        counts = fleet.reports, commits.count, fleet.travelled, len(plans.times)
        begun = time.monotonic()
        time.sleep(SECONDS)
        ended = time.monotonic()
        seconds = ended - begun
        shares = {name: 100 * (cpu_seconds(pid) - before[name]) / seconds
                  for name, pid in nodes.items()}
        reports, committed, travelled = (
            (now - then) / seconds for now, then in zip(
                (fleet.reports, commits.count, fleet.travelled), counts))
        return Measured(
            shares, reports, fleet.latest,
            sum(robot.has_mission for robot in states.messages[-1].robots), len(missions.open),
            proportional(nodes['path_supervisor']) / 2 ** 20,
            [one for one in fleet.releases if begun <= one.moment - one.seconds], committed,
            travelled, plans, plans.times[counts[3]:], (begun, ended), missions.ended,
            missions.reasons, len(graph.edges), hop, bare)


class Load(NamedTuple):
    """Figures to compare fleets, such as the CPU share of `path_supervisor`.

    `releases` has the times from report to release (ms).
    """

    share: float
    reports: float
    releases: List[float]
    travelled: float
    ended: str


def load_of(count: int, side: int, doors: int) -> Load:
    """Measures a fleet in this process."""
    one = measured(count, side, doors)
    return Load(one.shares['path_supervisor'], one.reports,
                [1e3 * release.seconds for release in one.releases], one.travelled, ended(one))


def in_a_process(count: int, side: int, doors: int) -> Load:
    """Measures a fleet in a separate process, because a process is one ROS node."""
    with ProcessPoolExecutor(1, mp_context=get_context('spawn')) as executor:
        return executor.submit(load_of, count, side, doors).result()


def devices(count: int, side: int) -> Iterator[Row]:
    """Measures a fleet first without doors, then with 50 simulated doors."""
    plain, doors = (in_a_process(count, side, doors) for doors in (0, DOORS))
    what = f'{count} robots with {DOORS} doors'
    cpu = doors.share, plain.share
    yield Row(f'{what}: CPU of `path_supervisor`, {doors.reports:.0f} and {plain.reports:.0f} '
              'reports a second', f'{cpu[0]:.0f} % ({100 * (cpu[0] / cpu[1] - 1):+.0f} %)',
              f'{cpu[1]:.0f} %: the same fleet without doors', '+10 %')
    times, floor = doors.releases or [math.nan], plain.releases or [math.nan]
    yield Row(f'{what}: report to release, {len(times)} and {len(floor)} of robots on rings '
              'of their own', p50_and_p99(times),
              f'{p50_and_p99(floor)}: the same fleet without doors',
              'p50 +10 %')
    yield Row(f'{what}: robots drive', f'{doors.travelled / count:.2f} m/s each; missions ended '
              f'{doors.ended}', f'{plain.travelled / count:.2f} m/s each: the same fleet without '
              'doors', '')


def ended(one: Measured) -> str:
    """Returns a text about the missions that have ended, by their state."""
    states = {state: number for state, number in one.ended.items() if number}
    return f'by state {states} {one.reasons or ""}'


def robots(count: int, side: int) -> Iterator[Row]:
    """Measures `count` robots at 10 Hz, all on missions, on a grid of side x side vertices."""
    one = measured(count, side)
    plans, found, hop = one.planning, one.releases, one.hop
    what = f'{count} robots, {one.edges} edges'
    yield Row(f'{what}: CPU; {one.reports:.0f} reports a second ({count / PERIOD:.0f} are due, at '
              f'most {one.latest:.2f} s late), {one.busy} robots on missions, {one.open} open',
              ', '.join(f'`{name}` {share:.0f} %' for name, share in sorted(one.shares.items()))
              + f'; `path_supervisor` {one.memory:.0f} MB',
              f'{one.bare}: a bare subscriber to as many reports', '`path_supervisor` < 100 %')
    during = [release for release in found if plans.overlaps(release)]
    for kind, some in (('', found), (' while the planner works', during)):
        yield Row(f'{what}: report to release{kind}, {len(some)} of robots on rings of their own',
                  p50_and_p99([1e3 * release.seconds for release in some]) if some else 'none',
                  f'{hop}: a bare hop there and back', 'p99 < 200 ms')
    yield Row(f'{what}: commits a second', f'{one.commits:.1f}', '', '<= 25')
    begun, over = one.span
    yield Row(f'{what}: planner, {len(one.planned) / (over - begun):.2f} plans a second, at work '
              f'{100 * plans.share(begun, over):.0f} % of the time; {plans.failed} failed, '
              f'{plans.unserved} unserved',
              p50_and_p99([1e3 * time for time in one.planned or [0.0]])
              + f', first {1e3 * plans.times[0]:.0f} ms', '', '')
    yield Row(f'{what}: robots drive', f'{one.travelled / count:.2f} m/s each; missions ended '
              f'so far {ended(one)}', '1.00 m/s', '')


SECTIONS: Dict[str, Callable[[], Iterator[Row]]] = {
    'robots_50': lambda: robots(50, 36), 'robots_200': lambda: robots(200, 71),
    'devices_200': lambda: devices(200, 71), 'history': history, 'planning': planning,
    'decisions': decisions}


if __name__ == '__main__':
    print_sections(SECTIONS, __doc__)
