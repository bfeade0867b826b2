"""Draws the map of the report: walls, stations, devices, and edges coloured by waiting time."""
from __future__ import annotations

import math
from html import escape
from typing import Iterator, List, Mapping, NamedTuple, Sequence, Tuple

import numpy as np

from fleet_core.work.devices import Device
from fleet_core.work.site_work import SiteWork
from fleet_simulation import svg
from fleet_simulation.demand_file import NO_WORK
from fleet_simulation.walls import NO_WALLS, Walls
from trajectory_graph import Graph
from trajectory_graph.placing import (
    ABOVE_FIRST,
    MayCover,
    Places,
    box_around,
    box_beside,
    middle_of,
)

_LARGEST = 860.0, 620.0  # px
_BORDER = 34             # px, margin around the graph
_AROUND = 3.0            # m, margin around the graph in which walls are drawn
_HEIGHT, _LETTER = 12.0, 7.4  # px, height of a text and width of a letter
_AWAY = 6.0, 11.0, 18.0  # px, distances of a text from its point, the best first
_DOT = 6.0               # px, side of the squares along edges that texts avoid
_LEGEND = 26             # px
_WALL, _DOCK, _VERTEX = '#9aa0a6', '#2266aa', '#555555'
_STATION, _DOOR = '#117a65', '#7d3c98'
_PLACE, _QUEUE = 9.0, 5.0  # px, half of a square
Pixel = Tuple[float, float]


class _Label(NamedTuple):
    """A text beside a point (px)."""

    at: Pixel
    words: str
    colour: str


class _Sheet:
    """The transformation from points of the graph (m) to points of the picture (px)."""

    def __init__(self, points: np.ndarray) -> None:
        self._low, self._high = points.min(axis=0) - _AROUND, points.max(axis=0) + _AROUND
        width, tall = self._high - self._low
        self.scale = min((_LARGEST[0] - 2 * _BORDER) / width, (_LARGEST[1] - 2 * _BORDER) / tall)
        self.width = round(width * self.scale) + 2 * _BORDER
        self.height = round(tall * self.scale) + 2 * _BORDER

    def pixels(self, points: np.ndarray) -> np.ndarray:
        """Returns the points of the picture (N,2; px) for points of the graph (N,2; m)."""
        return _BORDER + np.column_stack((points[:, 0] - self._low[0],
                                          self._high[1] - points[:, 1])) * self.scale

    def pixel(self, x: float, y: float) -> Pixel:
        """Returns the point of the picture (px) for one point of the graph (m)."""
        across, down = self.pixels(np.array([(x, y)]))[0]
        return float(across), float(down)

    def shows(self, points: np.ndarray) -> np.ndarray:
        """Returns for each of the points (N,2; m) whether it is in the picture."""
        shown: np.ndarray = ((points >= self._low) & (points <= self._high)).all(axis=1)
        return shown


def site_map(graph: Graph, heat: Mapping[int, float], labelled: Sequence[int],
             work: SiteWork = NO_WORK, walls: Walls = NO_WALLS) -> str:
    """Returns a map of the site.

    heat     -- for each edge id: share (0..1) of all waiting, drawn from grey (0) to red (highest)
    labelled -- drawn ids of the edges whose id is written on the map
    """
    lines = {id: _line(graph, id) for id in graph.edges}
    sheet = _Sheet(np.concatenate([
        *lines.values(), [vertex.position for vertex in graph.vertices.values()]]))
    drawn = {id: sheet.pixels(line) for id, line in lines.items()}
    labels = [*_edge_labels(graph, drawn, labelled), *_work_labels(graph, drawn, sheet, work)]
    parts = [*_walls(walls, sheet), *_edges(graph, drawn, heat), *_vertices(graph, sheet),
             *_stations(graph, sheet, work), *_doors(graph, drawn, work),
             *_texts(labels, list(drawn.values())),
             *_legend(sheet, bool(len(walls.centres)), work)]
    return svg.picture(sheet.width, sheet.height + _LEGEND, parts)


def _line(graph: Graph, id: int) -> np.ndarray:
    curve = graph.curve(id)
    return np.array([curve.point_at(curve.length * k / 12) for k in range(13)], dtype=float)


def _walls(walls: Walls, sheet: _Sheet) -> Iterator[str]:
    """Yields one SVG path with strokes along the rows of occupied cells."""
    centres = walls.centres[sheet.shows(walls.centres)]
    if not len(centres):
        return
    side = max(1.0, walls.cell * sheet.scale)
    cells = np.unique(np.floor(sheet.pixels(centres)[:, ::-1] / side).astype(int), axis=0)
    begins = np.ones(len(cells), bool)
    begins[1:] = (np.diff(cells, axis=0) != (0, 1)).any(axis=1)
    lengths = np.diff(np.append(np.nonzero(begins)[0], len(cells)))
    strokes = ''.join(f'M{side * column:.1f} {side * (row + 0.5):.1f}h{side * length:.1f}'
                      for (row, column), length in zip(cells[begins].tolist(), lengths.tolist()))
    yield f'<path d="{strokes}" stroke="{_WALL}" stroke-width="{side:.1f}" fill="none"/>'


def _edges(graph: Graph, drawn: Mapping[int, np.ndarray],
           heat: Mapping[int, float]) -> Iterator[str]:
    most = max(heat.values(), default=0.0) or 1.0
    for id, line in sorted(drawn.items(), key=lambda item: heat.get(item[0], 0.0)):
        share = heat.get(id, 0.0) / most
        points = svg.points_of([(float(x), float(y)) for x, y in line])
        yield (f'<polyline points="{points}" fill="none" '
               f'stroke="{_heat(share)}" stroke-width="{2 + 6 * share:.1f}" '
               f'stroke-linecap="round"><title>edge {graph.edges[id].drawn_id}: '
               f'{100 * heat.get(id, 0.0):.1f} % of all waiting</title></polyline>')


def _vertices(graph: Graph, sheet: _Sheet) -> Iterator[str]:
    for vertex in graph.vertices.values():
        if graph.divides_an_edge(vertex.id):
            continue
        x, y = sheet.pixel(vertex.x, vertex.y)
        yield (f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{5 if vertex.dock else 2}" '
               f'fill="{_DOCK if vertex.dock else _VERTEX}"><title>vertex {vertex.id} '
               f'{escape(vertex.label)}</title></circle>')


def _stations(graph: Graph, sheet: _Sheet, work: SiteWork) -> Iterator[str]:
    """Yields a square for each place of a station, and a small dashed square for each queue place.
    """
    for station in work.stations.values():
        for ids, half, dashes, what in ((station.places, _PLACE, '', ''),
                                        (station.queue, _QUEUE, '2 2', 'queue of ')):
            for id in ids:
                x, y = sheet.pixel(*graph.vertices[id].position)
                yield (f'<rect x="{x - half:.1f}" y="{y - half:.1f}" width="{2 * half:g}" '
                       f'height="{2 * half:g}" fill="{_STATION}" fill-opacity="0.15" '
                       f'stroke="{_STATION}" stroke-width="2" stroke-dasharray="{dashes}">'
                       f'<title>{what}station {escape(station.name)}</title></rect>')


def _doors(graph: Graph, drawn: Mapping[int, np.ndarray], work: SiteWork) -> Iterator[str]:
    """Yields a bar across each edge that leads through a device."""
    for device in work.devices.values():
        for line in _lines_through(graph, drawn, device):
            (x, y), along = line[len(line) // 2], line[len(line) // 2 + 1] - line[len(line) // 2]
            aside = 8.0 * np.array((-along[1], along[0])) / max(float(np.hypot(*along)), 1e-9)
            yield (f'<line x1="{x - aside[0]:.1f}" y1="{y - aside[1]:.1f}" '
                   f'x2="{x + aside[0]:.1f}" y2="{y + aside[1]:.1f}" stroke="{_DOOR}" '
                   f'stroke-width="4"><title>{device.kind.value.replace("_", " ")} '
                   f'{escape(device.name)}</title></line>')


def _lines_through(graph: Graph, drawn: Mapping[int, np.ndarray],
                   device: Device) -> List[np.ndarray]:
    """Returns the line (px) of the middle section of each drawn edge through a device."""
    ids = {graph.edges[abs(id)].drawn_id if abs(id) in graph.edges else abs(id)
           for id in device.edges}
    return [_middle_section(graph, drawn, id) for id in sorted(ids)]


def _middle_section(graph: Graph, drawn: Mapping[int, np.ndarray], id: int) -> np.ndarray:
    sections = graph.sections.get(id) or [id]
    return drawn[sections[len(sections) // 2]]


def _edge_labels(graph: Graph, drawn: Mapping[int, np.ndarray],
                 labelled: Sequence[int]) -> Iterator[_Label]:
    for id in labelled:
        line = _middle_section(graph, drawn, id)
        x, y = line[len(line) // 2].tolist()
        yield _Label((x, y), str(id), '#000000')


def _work_labels(graph: Graph, drawn: Mapping[int, np.ndarray], sheet: _Sheet,
                 work: SiteWork) -> Iterator[_Label]:
    for station in work.stations.values():
        for id in station.places:
            yield _Label(sheet.pixel(*graph.vertices[id].position), station.name, _STATION)
    for device in work.devices.values():
        for line in _lines_through(graph, drawn, device)[:1]:
            x, y = line[len(line) // 2].tolist()
            yield _Label((x, y), device.name, _DOOR)


def _texts(labels: Sequence[_Label], lines: Sequence[np.ndarray]) -> Iterator[str]:
    """Yields the texts, placed so that no text covers another text, and few texts cover a line."""
    places = Places(cell=40.0)
    for line in lines:
        for start, end in zip(line, line[1:]):
            steps = int(np.abs(end - start).max() / _DOT) + 1
            dots = start + np.linspace(0.0, 1.0, steps + 1)[:, None] * (end - start)
            for x, y in dots.tolist():
                places.cover(box_around((x, y), (_DOT, _DOT)), is_soft=True)
    for label in labels:
        places.cover(box_around(label.at, (2 * _PLACE + 2, 2 * _PLACE + 2)), is_soft=True)
    for label in labels:
        size = _LETTER * len(label.words), _HEIGHT
        boxes = [box_beside(label.at, away, size, side) for away in _AWAY for side in ABOVE_FIRST]
        number = places.place(boxes, may=MayCover.SOFT)
        if number >= 0:
            x, y = middle_of(boxes[number])
            yield (f'<text x="{x:.1f}" y="{y + 0.35 * _HEIGHT:.1f}" text-anchor="middle" '
                   f'font-weight="bold" fill="{label.colour}" stroke="white" stroke-width="3" '
                   f'paint-order="stroke">{escape(label.words)}</text>')


def _legend(sheet: _Sheet, has_walls: bool, work: SiteWork) -> Iterator[str]:
    """Yields the meaning of each colour that the map has, in one row."""
    entries = [('#c8ccd0', 'edge'), (_heat(1.0), 'most waiting'), (_DOCK, 'dock')]
    entries += [(_STATION, 'station, queue dashed')] if work.stations else []
    entries += [(_DOOR, 'door or device')] if work.devices else []
    entries += [(_WALL, 'wall')] if has_walls else []
    x, y = float(_BORDER), sheet.height + 4
    for colour, words in entries:
        yield f'<rect x="{x:.0f}" y="{y}" width="12" height="12" fill="{colour}"/>'
        yield f'<text x="{x + 17:.0f}" y="{y + 10}">{words}</text>'
        x += 38 + 6.6 * len(words)


def _heat(share: float) -> str:
    cold, hot = (200, 204, 208), (204, 34, 17)
    return '#' + ''.join(f'{round(c + (h - c) * math.sqrt(share)):02x}' for c, h in zip(cold, hot))
