"""Fences: how few, how fast and how tight, on the example laboratory, a real map, and grids.

Times are CPU seconds, median of several runs; the floor of each is Shapely's union of the
corridors alone, without which no fence can be.
"""
from __future__ import annotations

import statistics
import sys
import time
from pathlib import Path
from typing import Callable, List, NamedTuple, Optional

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / 'src' / 'omron_ld90' / 'test' / 'converter'))

from fence_builders import NO_WALLS, grid, real_site_graph  # noqa: E402

from omron_ld90.graph.corridors import CorridorRules, corridors_of  # noqa: E402
from omron_ld90.graph.fence_check import check_fences  # noqa: E402
from omron_ld90.graph.fences import Fences, fence_objects, is_fence  # noqa: E402
from omron_ld90.graph.goals import dock_pose  # noqa: E402
from omron_ld90.graph.obstacles import obstacle_points  # noqa: E402
from omron_ld90.maps import MapDocument  # noqa: E402
from trajectory_graph import Graph, load_graph  # noqa: E402

REAL = ROOT.parent / 'shared' / 'maps' / 'omron-ld-site-a.map'
HEADINGS = ('graph', 'edges', 'objects', 'objects per edge', 'aim', 'leaks', 'floor lost, m2',
            'seconds', 'union alone, s', 'check, s')


class Case(NamedTuple):
    """A graph on a map."""

    name: str
    graph: Graph
    walls: np.ndarray
    aim: float  # objects per edge
    runs: int
    dock: Optional[int] = None
    kind: Fences = Fences.AREAS


def cases() -> List[Case]:
    """What is measured."""
    lab = load_graph(str(ROOT / 'maps' / 'lab_graph.yaml'))
    lab_walls = walls_of(ROOT / 'maps' / 'lab_base.map')
    found = [Case('lab_graph.yaml', lab, lab_walls, 2.5, 5, 16),
             Case('lab_graph.yaml, lines', lab, lab_walls, 2.5, 5, 16, Fences.LINES)]
    if REAL.exists():
        found.append(Case('real map', real_site_graph(), walls_of(REAL), 2.5, 5))
    return found + [Case('grid', grid(8, 7), NO_WALLS, 1.0, 5),
                    Case('grid, turned 17 degrees', grid(23, 23, degrees=17.0), NO_WALLS, 1.0, 3),
                    Case('grid', grid(23, 23), NO_WALLS, 1.0, 5),
                    Case('grid', grid(71, 71), NO_WALLS, 1.0, 1)]


def walls_of(path: Path) -> np.ndarray:
    """What keeps a robot back on a map."""
    return obstacle_points(MapDocument.load(str(path)), ignored=is_fence)


def measure(case: Case) -> List[str]:
    """One row of the table."""
    rules = CorridorRules()
    dock = None if case.dock is None else dock_pose(case.graph, case.dock)

    def fence() -> list:
        corridors = corridors_of(case.graph, rules, dock)
        return fence_objects(corridors.floor, case.walls, case.kind)

    fences = fence()
    corridors = corridors_of(case.graph, rules, dock)
    check = check_fences(case.graph, corridors, fences, case.walls)
    edges = len(case.graph.edges)
    return [case.name, f'{edges:,}', f'{len(fences):,}', f'{len(fences) / edges:.2f}',
            f'<= {case.aim:g}', str(len(check.leaks)), f'{check.lost_area / 1e6:.3f}',
            f'{seconds(fence, case.runs):.2f}',
            f'{seconds(lambda: corridors_of(case.graph, rules, dock), case.runs):.2f}',
            f'{seconds(lambda: check_fences(case.graph, corridors, fences, case.walls), 1):.2f}']


def seconds(run: Callable[[], object], runs: int) -> float:
    """Median CPU time of `run`."""
    times = []
    for _ in range(runs):
        begin = time.process_time()
        run()
        times.append(time.process_time() - begin)
    return statistics.median(times)


def main() -> None:
    """Print the table; `--markdown` as a Markdown table."""
    rows = [measure(case) for case in cases()]
    if '--markdown' in sys.argv[1:]:
        for row in [HEADINGS, ['---'] * len(HEADINGS), *rows]:
            print(f'| {" | ".join(row)} |')
    else:
        for row in rows:
            print(', '.join(f'{heading} {value}' for heading, value in zip(HEADINGS, row)))


if __name__ == '__main__':
    main()
