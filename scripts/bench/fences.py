"""Measures fences on the example laboratory, a real map and grids: number, time and tightness.

Times are CPU seconds, the median of several runs. The floor of the fences is the time of Shapely's
union of the corridors, which every method needs. The conversion includes all work from the bytes of
the base map to the bytes of the new map, and the check.
"""
from __future__ import annotations

import os
import statistics
import sys
import time
from pathlib import Path
from typing import Callable, List, NamedTuple, Optional

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / 'src' / 'omron_map_converter' / 'test'))

from converter_builders import map_with  # noqa: E402
from fence_builders import grid, real_site_graph  # noqa: E402
from measuring.tables import print_table  # noqa: E402

from omron_map import MapDocument  # noqa: E402
from omron_map_converter.converter import ConversionOptions, convert  # noqa: E402
from omron_map_converter.corridors import CorridorRules, corridors_of  # noqa: E402
from omron_map_converter.fence_check import check_fences  # noqa: E402
from omron_map_converter.fences import Fences, fence_objects, is_fence  # noqa: E402
from omron_map_converter.goals import dock_pose  # noqa: E402
from omron_map_converter.obstacles import obstacle_points  # noqa: E402
from trajectory_graph import Graph, load_graph  # noqa: E402

REAL = Path(os.environ.get('LD90_REAL_MAPS') or '/nowhere') / 'omron-ld-site-a.map'
HEADINGS = ('graph', 'edges', 'objects', 'objects per edge', 'aim', 'leaks', 'floor lost, m2',
            'seconds', 'union alone, s', 'check, s', 'conversion, s')


class Case(NamedTuple):
    """A graph on a map."""

    name: str
    graph: Graph
    base: bytes  # content of the base map
    aim: float  # largest number of fence objects per edge
    runs: int
    dock: Optional[int] = None
    kind: Fences = Fences.AREAS


def cases() -> List[Case]:
    """Returns the cases to measure."""
    lab = load_graph(str(ROOT / 'maps' / 'lab_graph.yaml'))
    lab_base = (ROOT / 'maps' / 'lab_base.map').read_bytes()
    found = [Case('lab_graph.yaml', lab, lab_base, 2.5, 5, 16),
             Case('lab_graph.yaml, lines', lab, lab_base, 2.5, 5, 16, Fences.LINES)]
    if REAL.exists():
        found.append(Case('real map', real_site_graph(), REAL.read_bytes(), 2.5, 5))
    empty = map_with().to_bytes()
    return found + [Case('grid', grid(8, 7), empty, 1.0, 5),
                    Case('grid, turned 17 degrees', grid(23, 23, degrees=17.0), empty, 1.0, 3),
                    Case('grid', grid(23, 23), empty, 1.0, 5),
                    Case('grid', grid(71, 71), empty, 1.0, 1)]


def measure(case: Case) -> List[str]:
    """Returns one row of the table."""
    rules = CorridorRules()
    dock = None if case.dock is None else dock_pose(case.graph, case.dock)
    walls = obstacle_points(MapDocument.from_bytes(case.base), ignored=is_fence)

    def fence() -> list:
        corridors = corridors_of(case.graph, rules, dock)
        return fence_objects(corridors.floor, walls, case.kind)

    def conversion() -> bytes:
        document = MapDocument.from_bytes(case.base)
        convert(case.graph, document, ConversionOptions(case.dock, fences=case.kind))
        return document.to_bytes()

    fences = fence()
    corridors = corridors_of(case.graph, rules, dock)
    check = check_fences(case.graph, corridors, fences, walls)
    edges = len(case.graph.edges)
    return [case.name, f'{edges:,}', f'{len(fences):,}', f'{len(fences) / edges:.2f}',
            f'<= {case.aim:g}', str(len(check.leaks)), f'{check.lost_area / 1e6:.3f}',
            f'{seconds(fence, case.runs):.2f}',
            f'{seconds(lambda: corridors_of(case.graph, rules, dock), case.runs):.2f}',
            f'{seconds(lambda: check_fences(case.graph, corridors, fences, walls), 1):.2f}',
            f'{seconds(conversion, 1):.2f}']


def seconds(run: Callable[[], object], runs: int) -> float:
    """Returns the median CPU time of `run`."""
    times = []
    for _ in range(runs):
        begin = time.process_time()
        run()
        times.append(time.process_time() - begin)
    return statistics.median(times)


def main() -> None:
    """Prints the table."""
    print_table((measure(case) for case in cases()), HEADINGS)


if __name__ == '__main__':
    main()
