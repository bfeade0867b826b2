"""Measures the supervisor's start, and its answer to a request, after a million ended missions."""
from __future__ import annotations

import json
import sqlite3
import statistics
import tempfile
import time
from dataclasses import asdict
from pathlib import Path
from typing import Callable, Dict, Iterator, List

from measuring.tables import Row
from measuring.timing import p50_and_p99

from fleet_core.fleet import DOCK_APPROACH, Fleet, Robot, RobotType
from fleet_core.supervision.journal import Journal
from fleet_core.supervision.missions import MissionState, Request
from fleet_core.supervision.supervisor import Supervisor
from load_bench.site import grid
from trajectory_graph import Graph

ENDED = 1_000_000  # missions
ROBOTS, SIDE = 200, 71
STARTS = 5
REQUESTS = 300
_PERIOD = 86400.0  # s; all missions ended within this time before now


def fill(path: Path, count: int) -> None:
    """Writes `count` ended missions into a new journal, each with three changes."""
    Journal(str(path)).close()
    database = sqlite3.connect(path)
    now, done = time.time(), int(MissionState.SUCCEEDED)

    def moment(serial: int) -> float:
        return now - _PERIOD * (1.0 - serial / count)
    database.executemany(
        'INSERT INTO mission VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)',
        ((serial, serial, json.dumps(asdict(Request(serial, (1, 2), stamp=moment(serial)))), done,
          f'agv_{serial % ROBOTS}', 2, '', moment(serial), moment(serial))
         for serial in range(1, count + 1)))
    database.executemany(
        'INSERT INTO change VALUES (?, ?, ?, ?, ?, ?)',
        ((moment(serial), serial, state, f'agv_{serial % ROBOTS}', 0, '')
         for serial in range(1, count + 1)
         for state in (int(MissionState.PENDING), int(MissionState.ACTIVE), done)))
    database.commit()
    database.close()


def history() -> Iterator[Row]:
    """Measures starts and requests; the floor is an empty journal."""
    kind = RobotType('agv', 0.43, 1.0)
    graph = grid(SIDE)
    vertices = list(graph.vertices)
    robots = tuple(Robot(f'agv_{k}', kind, vertices[k * 25], 'agv') for k in range(ROBOTS))
    fleet = Fleet((kind,), robots, 0.1, DOCK_APPROACH)
    starts: Dict[int, List[float]] = {}
    requests: Dict[int, List[float]] = {}
    finds: Dict[int, List[float]] = {}
    with tempfile.TemporaryDirectory() as folder:
        for count in (0, ENDED):
            path = Path(folder) / f'{count}.sqlite'
            fill(path, count)
            _begin(path, graph, fleet)  # the first start stores the graph
            starts[count] = [_begin(path, graph, fleet) for _ in range(STARTS)]
            journal = Journal(str(path))
            supervisor = Supervisor(graph, fleet, {}, journal, 0.0)
            requests[count] = [_request(supervisor, Request(id, (1, 2), stamp=time.time()))
                               for id in range(ENDED + 1, ENDED + REQUESTS + 1)]
            finds[count] = [_request(supervisor, Request(7, (1, 2), stamp=1.0 + k))
                            for k in range(REQUESTS)]
            journal.close()
    yield Row(f'start of the supervisor, {ENDED} ended missions, {ROBOTS} robots, '
              f'{len(graph.edges)} edges: journal opened and read',
              f'{1e-3 * statistics.median(starts[ENDED]):.2f} s, at most '
              f'{1e-3 * max(starts[ENDED]):.2f} s',
              f'{1e-3 * statistics.median(starts[0]):.2f} s with an empty one', '< 1 s')
    yield Row(f'a request, {ENDED} ended missions', p50_and_p99(requests[ENDED]),
              f'{p50_and_p99(requests[0])} with an empty journal', '< 5 ms')
    yield Row(f'a request whose id is in use again, {ENDED} ended missions',
              p50_and_p99(finds[ENDED]), f'{p50_and_p99(finds[0])} with an empty journal', '< 5 ms')


def _begin(path: Path, graph: Graph, fleet: Fleet) -> float:
    def begin() -> None:
        journal = Journal(str(path))
        Supervisor(graph, fleet, {}, journal, 0.0).tick(0.0)
        journal.close()
    return _milliseconds(begin)


def _request(supervisor: Supervisor, request: Request) -> float:
    return _milliseconds(lambda: supervisor.request(request, 0.0))


def _milliseconds(act: Callable[[], object]) -> float:
    begun = time.perf_counter()
    act()
    return 1e3 * (time.perf_counter() - begun)
