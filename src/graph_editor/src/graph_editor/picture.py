"""Draws a picture of a graph on its site: walls, corridors, lanes, vertices with their ids."""
from __future__ import annotations

import math
from typing import Sequence, Tuple, Union

import numpy as np
from PIL import Image, ImageDraw
from PIL.PngImagePlugin import PngInfo

from graph_editor.checking.findings import Finding, Severity
from graph_editor.errors import SiteError
from graph_editor.floor import Floor
from graph_editor.site import MappedSite
from omron_map.canvas import label_font
from trajectory_graph import CurveType, Graph

MADE_BY = 'written by make_graph'  # text in each picture; scripts/new_site.sh looks for it
LARGEST_SIDE = 2000  # px
PIXELS_PER_METRE = 60.0
SUPERSAMPLING = 2
BORDER = 0.6  # m; margin around the contents
PAPER, OUTSIDE, WALL = (255, 255, 255), (236, 237, 242), (20, 20, 20)
CORRIDOR, LINE, SPLINE = (206, 227, 248), (20, 90, 190), (130, 60, 190)
VERTEX, PARKING, PLACE, DOCK = (40, 60, 90), (230, 130, 0), (0, 140, 60), (150, 0, 150)
ERROR, WARNING = (220, 20, 20), (240, 150, 0)
Pixels = Sequence[Tuple[float, float]]


def draw_graph(site: MappedSite, graph: Graph, path: str, corridor: float,
               findings: Sequence[Finding] = ()) -> None:
    """Writes the PNG file `path`; raises SiteError if it cannot be written.

    Corridors are light blue, lines blue, splines violet. Goals are green, docks purple, parking
    vertices orange. A dash shows the heading of a vertex. A red ring shows an error, an orange ring
    a warning.
    """
    sheet = _Sheet(site.floor, graph)
    sheet.corridors(graph, corridor)
    sheet.walls(site.floor)
    for edge in graph.edges.values():
        sheet.line(graph.curve(edge.id).points,
                   SPLINE if edge.curve_type is CurveType.SPLINE else LINE, 2.5)
    named = {place.name for place in site.places}
    for vertex in graph.vertices.values():
        colour = (DOCK if vertex.dock else PARKING if vertex.parking
                  else PLACE if vertex.label in named else VERTEX)
        name = f'{vertex.id} {vertex.label}' if vertex.label in named or vertex.dock else vertex.id
        sheet.vertex(vertex.position, vertex.theta, str(name), colour)
    for finding in findings:
        if finding.place is not None:
            sheet.ring(finding.place, ERROR if finding.severity is Severity.ERROR else WARNING)
    sheet.save(path)


class _Sheet:
    """An image in the coordinates of the map."""

    def __init__(self, floor: Floor, graph: Graph) -> None:
        seen = np.argwhere(floor.inside | floor.occupied)
        points = np.vstack((floor.centres(*seen.T) if len(seen) else np.empty((0, 2)),
                            [vertex.position for vertex in graph.vertices.values()]))
        self._low, high = points.min(axis=0) - BORDER, points.max(axis=0) + BORDER
        size = high - self._low
        self._scale = SUPERSAMPLING * min(PIXELS_PER_METRE, LARGEST_SIDE / size.max())
        width, height = np.ceil(size * self._scale).astype(int).tolist()
        self._size = width, height
        self._image = Image.new('RGB', self._size, PAPER)
        self._pen = ImageDraw.Draw(self._image)
        self._font = label_font(12 * SUPERSAMPLING)

    def _pixels(self, points: Union[np.ndarray, Tuple[float, float]]) -> Pixels:
        x, y = np.asarray(points, float).reshape(-1, 2).T
        return list(zip(((x - self._low[0]) * self._scale).tolist(),
                        (self._size[1] - (y - self._low[1]) * self._scale).tolist()))

    def corridors(self, graph: Graph, corridor: float) -> None:
        """Draws a broad band along every edge."""
        radius = corridor / 2.0 * self._scale
        for id in graph.edges:
            pixels = self._pixels(graph.curve(id).sample(0.1))
            self._pen.line(pixels, fill=CORRIDOR, width=int(2 * radius))
            for x, y in pixels:
                self._pen.ellipse((x - radius, y - radius, x + radius, y + radius), fill=CORRIDOR)

    def walls(self, floor: Floor) -> None:
        """Draws the occupied cells and the cells outside the floor."""
        colours = np.zeros((*floor.occupied.shape, 4), np.uint8)
        colours[~floor.inside] = (*OUTSIDE, 255)
        colours[floor.occupied] = (*WALL, 255)
        rows, columns = floor.occupied.shape
        cells = Image.fromarray(colours[::-1])
        (left, top), = self._pixels((floor.origin[0], floor.origin[1] + rows * floor.resolution))
        (right, bottom), = self._pixels((floor.origin[0] + columns * floor.resolution,
                                         floor.origin[1]))
        scaled = cells.resize((max(int(right - left), 1), max(int(bottom - top), 1)),
                              Image.NEAREST)
        self._image.paste(scaled, (int(left), int(top)), scaled)

    def line(self, points: np.ndarray, colour: Tuple[int, int, int], width: float) -> None:
        """Draws a polyline."""
        self._pen.line(self._pixels(points), fill=colour, width=int(width * SUPERSAMPLING),
                       joint='curve')

    def vertex(self, position: Tuple[float, float], theta: float, name: str,
               colour: Tuple[int, int, int]) -> None:
        """Draws a vertex: a dot, a dash for the heading, and a name."""
        (x, y), = self._pixels(position)
        radius, dash = 4.5 * SUPERSAMPLING, 11 * SUPERSAMPLING
        self._pen.line((x, y, x + dash * math.cos(theta), y - dash * math.sin(theta)),
                       fill=colour, width=2 * SUPERSAMPLING)
        self._pen.ellipse((x - radius, y - radius, x + radius, y + radius), fill=colour)
        self._pen.text((x + radius, y - radius - 13 * SUPERSAMPLING), name, fill=colour,
                       font=self._font)

    def ring(self, position: Tuple[float, float], colour: Tuple[int, int, int]) -> None:
        """Draws a ring around the place of a finding."""
        (x, y), = self._pixels(position)
        radius = 13 * SUPERSAMPLING
        self._pen.ellipse((x - radius, y - radius, x + radius, y + radius), outline=colour,
                          width=3 * SUPERSAMPLING)

    def save(self, path: str) -> None:
        """Scales the image down and writes it; raises SiteError."""
        small = self._image.resize((self._size[0] // SUPERSAMPLING, self._size[1] // SUPERSAMPLING),
                                   Image.LANCZOS)
        notes = PngInfo()
        notes.add_text('Software', MADE_BY)
        try:
            small.save(path, 'PNG', optimize=True, pnginfo=notes)
        except (OSError, ValueError) as error:
            raise SiteError(f'{path}: the picture cannot be written ({error}).') from None
