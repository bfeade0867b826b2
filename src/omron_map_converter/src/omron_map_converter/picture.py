"""A picture of a converted map: the content of `ld_map draw`, with corridors, curves and fences."""
from __future__ import annotations

import numpy as np

from omron_map import MapDocument
from omron_map.canvas import PAPER
from omron_map.picture import MapPicture
from omron_map_converter.converter import Conversion
from omron_map_converter.fence_check import shape_of
from omron_map_converter.fences import is_fence
from trajectory_graph import Graph

LONG_SIDE = 2000  # pixels
CORRIDOR, CURVE = (214, 232, 250), (20, 90, 190)
FENCE, FORBIDDEN = (245, 140, 20), (200, 60, 40)


def draw(document: MapDocument, graph: Graph, conversion: Conversion, path: str) -> None:
    """Draws the converted map into the PNG file `path`; raises MapError when it cannot be written.

    Corridors are light blue, curves blue, fences orange, other forbidden areas and lines red.
    """
    floor = conversion.corridors.floor
    bounds = [shape.bounds for shape in (floor, *map(shape_of, conversion.fences))]
    picture = MapPicture(document, LONG_SIDE, also=[
        corner for each in bounds for corner in (each[:2], each[2:])])
    for part in getattr(floor, 'geoms', [floor]):
        picture.canvas.polygon(np.array(part.exterior.coords), CORRIDOR)
        for hole in part.interiors:
            picture.canvas.polygon(np.array(hole.coords), PAPER)
    picture.net()
    picture.forbidden(lambda obj: FENCE if is_fence(obj) else FORBIDDEN)
    picture.sectors()
    picture.walls()
    for id in graph.edges:
        picture.canvas.polyline(graph.curve(id).points * 1000.0, CURVE, 2)
    picture.places()
    picture.canvas.write(path)
