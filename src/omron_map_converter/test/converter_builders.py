"""Common graphs and maps of the converter's tests."""
from __future__ import annotations

import importlib.util
import math
import os
from pathlib import Path
from typing import Iterable, Tuple

import pytest

from omron_map import MapDocument
from trajectory_graph import Edge, Graph, Vertex

REPOSITORY = Path(__file__).resolve().parents[3]
LAB = REPOSITORY / 'maps'
# /nowhere: LD90_REAL_MAPS names no folder
REAL_MAPS = Path(os.environ.get('LD90_REAL_MAPS') or '/nowhere')

EMPTY_MAP = b'''2D-Map
MapInfo: GoalType Name=Goal
MapInfo: DockType "Name=DockLynx"
RouteInfo: GoalAfter "Pick"
%sDATA
'''


def map_with(*cairns: str) -> MapDocument:
    """Returns a map of these objects, such as `Goal 1000 2000 0 "" ICON "3"`, without walls."""
    lines = ''.join(f'Cairn: {cairn}\n' for cairn in cairns)
    return MapDocument.from_bytes(EMPTY_MAP % lines.encode(), 'base.map')


def graph_of(vertices: Iterable[Tuple], edges: Iterable[Tuple[int, int]]) -> Graph:
    """Returns a graph of straight edges, numbered from 1.

    A vertex is (id, x, y[, heading]) in m and degrees. An edge is (origin, destination).
    """
    return Graph([Vertex(id, x, y, math.radians(heading[0] if heading else 0.0))
                  for id, x, y, *heading in vertices],
                 [Edge(id, *ends) for id, ends in enumerate(edges, 1)])


def lab_generator():
    """Returns the module `maps/make_lab.py`."""
    spec = importlib.util.spec_from_file_location('make_lab', str(LAB / 'make_lab.py'))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def real_maps() -> list:
    """Returns test parameters: the maps of real robots. Without maps, the test is skipped."""
    paths = sorted(REAL_MAPS.glob('*.map'))
    if not paths:
        reason = f'no real maps in {REAL_MAPS}'
        return [pytest.param(None, marks=pytest.mark.skip(reason=reason))]
    return [pytest.param(path, id=path.stem) for path in paths]
