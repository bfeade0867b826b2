"""Provides a small site for the tests of this package, and makes the builders of fleet_core
importable.
"""
from __future__ import annotations

import sys
from functools import partial
from pathlib import Path
from typing import Callable, Dict

import pytest

from trajectory_graph import Edge, Graph, Vertex, save_graph

sys.path.append(str(Path(__file__).resolve().parents[2] / 'fleet_core/test'))

FLEET = '''
clearance: 0.1
robot_types:
- {name: agv, radius: 0.4, speed: 1.0, release_ahead: 3.0}
robots:
- {name: one, type: agv, vertex: 21}
- {name: two, type: agv, vertex: 22}
'''
DEMAND = 'flows:\n- {to: 25, from: 21, per_hour: 60}\n'


@pytest.fixture(scope='session')
def yard() -> Graph:
    """Returns a graph like a ladder: two rows of vertices, with a spur at each upper vertex."""
    places, ends = {}, {}
    for k in range(5):
        for row in range(3):
            places[1 + k + 10 * row] = 2.0 * k, 2.0 * row
        ends[100 + k], ends[200 + k] = (k + 1, k + 11), (k + 11, k + 21)
        if k:
            ends[k], ends[k + 10] = (k, k + 1), (k + 10, k + 11)
    return Graph([Vertex(id, *place, 0.0) for id, place in places.items()],
                 [Edge(id, *pair, velocity_forward=1.0, velocity_backwards=1.0)
                  for id, pair in ends.items()])


@pytest.fixture(scope='session')
def files_in(yard: Graph) -> Callable[..., Dict[str, str]]:
    """Returns a function that writes graph, fleet and demand files into a folder. It also writes
    a work file if work is given.

    The function returns the paths; the keys are the names of the files.
    """
    def write(folder: Path, demand: str = DEMAND, fleet: str = FLEET,
              work: str = '') -> Dict[str, str]:
        save_graph(yard, folder / 'graph.yaml')
        (folder / 'fleet.yaml').write_text(fleet)
        (folder / 'demand.yaml').write_text(demand)
        (folder / 'work.yaml').write_text(work)
        names = ('graph', 'fleet', 'demand', *(('work',) if work else ()))
        return {name: str(folder / f'{name}.yaml') for name in names}
    return write


@pytest.fixture
def files(files_in: Callable[..., Dict[str, str]], tmp_path: Path) -> Callable[..., Dict[str, str]]:
    """Returns the function of `files_in` for the folder of one test."""
    return partial(files_in, tmp_path)
