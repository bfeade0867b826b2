"""The site as data for browsers: vertices, points on the curves of edges, picture of the walls."""
from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass
from typing import Any, Collection, Dict, Optional

import numpy as np

from trajectory_graph import CurveType, Graph

STEP = 0.25        # m between two points of a drawn curve, if MOST_STEPS steps are enough
MOST_STEPS = 40.0  # steps of a curve, at most
MOST_CELLS = 4_000_000
_OCCUPIED = 50


class WrongMap(Exception):
    """A message is not a valid grid. The text says why."""


@dataclass(frozen=True)
class WallMap:
    """An occupancy grid as a PNG. x, y: the grid's lower left corner; all lengths in m."""

    png: bytes
    x: float
    y: float
    width: float
    height: float


def wall_map(cells: np.ndarray, columns: int, rows: int, resolution: float, x: float,
             y: float) -> WallMap:
    """Returns the walls of an occupancy grid; cells without a wall are transparent.

    The size is checked before any cell is read. Raises WrongMap.
    """
    if not (columns > 0 and rows > 0 and columns * rows <= MOST_CELLS
            and len(cells) == columns * rows and 0.0 < resolution < 100.0):
        raise WrongMap(f'it has {len(cells)} cells in {columns} x {rows} of {resolution:g} m; at '
                       f'most {MOST_CELLS} cells are shown')
    grid = np.asarray(cells, np.int8).reshape(rows, columns)[::-1] >= _OCCUPIED
    return WallMap(_png(grid), x, y, columns * resolution, rows * resolution)


def _png(walls: np.ndarray) -> bytes:
    """Returns a PNG with one bit per pixel: 0 is transparent, 1 is a grey that is visible on a
    light and on a dark background.
    """
    packed = np.packbits(walls, axis=1)
    rows = np.hstack([np.zeros((packed.shape[0], 1), np.uint8), packed])

    def chunk(kind: bytes, content: bytes) -> bytes:
        return (struct.pack('>I', len(content)) + kind + content
                + struct.pack('>I', zlib.crc32(kind + content)))
    header = struct.pack('>IIBBBBB', walls.shape[1], walls.shape[0], 1, 3, 0, 0, 0)
    return (b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', header)
            + chunk(b'PLTE', bytes((0, 0, 0, 128, 132, 140))) + chunk(b'tRNS', bytes((0, 255)))
            + chunk(b'IDAT', zlib.compress(rows.tobytes(), 6)) + chunk(b'IEND', b''))


def site_values(graph: Optional[Graph], parking: Collection[int], docks: Collection[int],
                walls: Optional[WallMap], radii: Dict[str, float]) -> Dict[str, Any]:
    """Returns the data that rarely change, as JSON values; positions in m, rounded to 1 cm."""
    vertices, edges = [], []
    if graph is not None:
        for vertex in graph.vertices.values():
            kind = ('dock' if vertex.id in docks or vertex.dock else
                    'parking' if vertex.id in parking else
                    'cut' if graph.divides_an_edge(vertex.id) else 'vertex')
            vertices.append([vertex.id, round(vertex.x, 2), round(vertex.y, 2), kind,
                             vertex.label])
        for id, edge in graph.edges.items():
            curve = graph.curve(id)
            is_line = edge.curve_type is CurveType.LINE
            step = curve.length if is_line else max(STEP, curve.length / MOST_STEPS)
            points = np.round(curve.sample(step), 2)
            edges.append([id, edge.origin, edge.destination, points.ravel().tolist(),
                          edge.drawn_id])
    return {'vertices': vertices, 'edges': edges, 'radii': radii,
            'map': None if walls is None else [walls.x, walls.y, walls.width, walls.height]}
