"""Draws charts and maps as inline SVG."""
from __future__ import annotations

import math
from html import escape
from typing import Callable, List, Mapping, NamedTuple, Sequence, Tuple, Union

import numpy as np

from trajectory_graph import Graph

WIDTH, HEIGHT = 640, 300
_LEFT, _RIGHT, _TOP, _BOTTOM = 64, 16, 16, 44
COLOURS = ('#2266aa', '#88aacc', '#66aa66', '#bb9944', '#cc4433', '#9966aa', '#cccccc', '#333333')


class Line(NamedTuple):
    """A line of a chart: points (x, y), and half the height of the band around each point."""

    name: str
    points: Sequence[Tuple[float, float]]
    halves: Sequence[float] = ()


def ticks(highest: float, count: int = 5) -> List[float]:
    """Returns round numbers for an axis, from 0 to at least `highest`."""
    if highest <= 0.0:
        return [0.0, 1.0]
    rough = highest / count
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(factor * power for factor in (1.0, 2.0, 2.5, 5.0, 10.0)
                if factor * power >= rough * (1.0 - 1e-9))
    return [step * k for k in range(math.ceil(highest / step - 1e-9) + 1)]


def chart(lines: Sequence[Line], across: str, up: str, mark: float = math.nan) -> str:
    """Returns a line chart over whole numbers.

    across, up -- labels of the axes
    mark       -- x of a dashed vertical line; NaN: no such line
    """
    xs = sorted({x for line in lines for x, _ in line.points})
    halves = [half for line in lines for half in line.halves if half < math.inf]
    scale = ticks(max((y for line in lines for _, y in line.points if y == y), default=1.0)
                  + max(halves, default=0.0))
    axes = _Axes(xs[0], xs[-1] if xs[-1] > xs[0] else xs[0] + 1, scale[-1])
    parts = [_frame(up, scale, axes.height)]
    every = max(1, math.ceil(len(xs) / 16))
    parts += [_text(axes.across(x), HEIGHT - _BOTTOM + 16, f'{x:g}', 'middle')
              for x in xs[::every]]
    parts.append(_text((_LEFT + WIDTH) / 2, HEIGHT - 8, across, 'middle'))
    if mark == mark:
        x = axes.across(mark)
        parts.append(f'<line x1="{x:.1f}" x2="{x:.1f}" y1="{_TOP}" '
                     f'y2="{HEIGHT - _BOTTOM}" stroke="#cc4433" stroke-dasharray="4 3"/>')
    for number, line in enumerate(lines):
        parts += _drawn_line(line, number, axes)
    return _svg(WIDTH, HEIGHT, parts)


class _Axes(NamedTuple):
    """Where the points of a line chart lie in the picture."""

    low: float
    high: float
    top: float

    def across(self, x: float) -> float:
        return _LEFT + (x - self.low) / (self.high - self.low) * (WIDTH - _LEFT - _RIGHT)

    def height(self, y: float) -> float:
        return HEIGHT - _BOTTOM - max(y, 0.0) / self.top * (HEIGHT - _TOP - _BOTTOM)

    def place(self, x: float, y: float) -> Tuple[float, float]:
        return self.across(x), self.height(y)


def _drawn_line(line: Line, number: int, axes: _Axes) -> List[str]:
    """Returns one line of a chart with its band and its entry in the legend."""
    colour = COLOURS[(0, 4, 2, 3)[number % 4]]
    parts = []
    known = [(x, y, half) for (x, y), half in zip(line.points, line.halves) if half < math.inf]
    if known:
        outline = [axes.place(x, y + half) for x, y, half in known] + [
            axes.place(x, y - half) for x, y, half in reversed(known)]
        parts.append(f'<polygon points="{_points(outline)}" fill="{colour}" '
                     'fill-opacity="0.18"/>')
    drawn = [axes.place(x, y) for x, y in line.points if y == y]
    parts.append(f'<polyline points="{_points(drawn)}" fill="none" stroke="{colour}" '
                 'stroke-width="2"/>')
    parts += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="{colour}"/>' for x, y in drawn]
    parts.append(f'<rect x="{_LEFT + 12}" y="{_TOP + 6 + 18 * number}" width="12" height="4" '
                 f'fill="{colour}"/>')
    parts.append(_text(_LEFT + 30, _TOP + 12 + 18 * number, line.name, 'start'))
    return parts


def stacks(names: Sequence[str], columns: Mapping[int, Sequence[float]], across: str,
           up: str) -> str:
    """Returns a chart with one column per key of `columns`, a stack of shares (0..1).

    names      -- legend, one name per share
    across, up -- labels of the axes
    """
    legend = 18 * math.ceil(len(names) / 2) + 10
    step = (WIDTH - _LEFT - _RIGHT) / max(len(columns), 1)

    def y_of(share: float) -> float:
        return HEIGHT - _BOTTOM - share * (HEIGHT - _TOP - _BOTTOM)
    parts = [_frame(up, [0.0, 0.25, 0.5, 0.75, 1.0], y_of, percent=True)]
    for number, (x, shares) in enumerate(columns.items()):
        left, below = _LEFT + (number + 0.15) * step, 0.0
        for share, colour in zip(shares, COLOURS):
            parts.append(f'<rect x="{left:.1f}" y="{y_of(below + share):.1f}" '
                         f'width="{0.7 * step:.1f}" height="{y_of(0.0) - y_of(share):.1f}" '
                         f'fill="{colour}"/>')
            below += share
        parts.append(_text(left + 0.35 * step, HEIGHT - _BOTTOM + 16, str(x), 'middle'))
    parts.append(_text((_LEFT + WIDTH) / 2, HEIGHT - 8, across, 'middle'))
    for number, (name, colour) in enumerate(zip(names, COLOURS)):
        x, y = _LEFT + 300 * (number % 2), HEIGHT + 6 + 18 * (number // 2)
        parts.append(f'<rect x="{x}" y="{y}" width="12" height="12" fill="{colour}"/>')
        parts.append(_text(x + 18, y + 10, name, 'start'))
    return _svg(WIDTH, HEIGHT + legend, parts)


def site_map(graph: Graph, heat: Mapping[int, float], labelled: Sequence[int]) -> str:
    """Returns a map of the graph.

    heat     -- by edge id: share (0..1) of all waiting; edges are drawn from grey to red
    labelled -- drawn ids of the edges whose id is written on the map
    """
    lines = {id: _line(graph, id) for id in graph.edges}
    points = np.concatenate([*lines.values(), [v.position for v in graph.vertices.values()]])
    low, high = points.min(axis=0), points.max(axis=0)
    width, tall = np.maximum(high - low, 1.0)
    scale = min((WIDTH * 1.4 - 60) / width, 620.0 / tall)

    def at(point: Union[Sequence[float], np.ndarray]) -> Tuple[float, float]:
        return 30 + (point[0] - low[0]) * scale, 30 + (high[1] - point[1]) * scale
    most = max(heat.values(), default=0.0) or 1.0
    parts = []
    for id, line in sorted(lines.items(), key=lambda item: heat.get(item[0], 0.0)):
        share = heat.get(id, 0.0) / most
        parts.append(f'<polyline points="{_points([at(point) for point in line])}" fill="none" '
                     f'stroke="{_heat(share)}" stroke-width="{2 + 6 * share:.1f}" '
                     f'stroke-linecap="round"><title>edge {graph.edges[id].drawn_id}: '
                     f'{100 * heat.get(id, 0.0):.1f} % of all waiting</title></polyline>')
    for vertex in graph.vertices.values():
        x, y = at(vertex.position)
        colour = '#2266aa' if vertex.dock else '#555555'
        parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{5 if vertex.dock else 2}" '
                     f'fill="{colour}"><title>vertex {vertex.id} {escape(vertex.label)}</title>'
                     '</circle>')
    for id in labelled:
        sections = sorted(graph.whole_edges((id,)))
        line = lines[sections[len(sections) // 2]]
        x, y = at(line[len(line) // 2])
        parts.append(f'<text x="{x + 7:.1f}" y="{y - 7:.1f}" font-weight="bold" '
                     f'stroke="white" stroke-width="3" paint-order="stroke">{id}</text>')
    return _svg(round(width * scale + 60), round(tall * scale + 60), parts)


def _line(graph: Graph, id: int) -> np.ndarray:
    curve = graph.curve(id)
    return np.array([curve.point_at(curve.length * k / 12) for k in range(13)], dtype=float)


def _heat(share: float) -> str:
    cold, hot = (200, 204, 208), (204, 34, 17)
    return '#' + ''.join(f'{round(c + (h - c) * math.sqrt(share)):02x}' for c, h in zip(cold, hot))


def _frame(up: str, scale: Sequence[float], y_of: Callable[[float], float],
           percent: bool = False) -> str:
    parts = [f'<text transform="translate(14 {(HEIGHT - _BOTTOM + _TOP) / 2}) rotate(-90)" '
             f'text-anchor="middle">{escape(up)}</text>']
    for value in scale:
        y = y_of(value)
        parts.append(f'<line x1="{_LEFT}" x2="{WIDTH - _RIGHT}" y1="{y:.1f}" y2="{y:.1f}" '
                     'stroke="#dddddd"/>')
        parts.append(_text(_LEFT - 6, y + 4, f'{100 * value:.0f} %' if percent else f'{value:g}',
                           'end'))
    return ''.join(parts)


def _points(points: Sequence[Tuple[float, float]]) -> str:
    return ' '.join(f'{x:.1f},{y:.1f}' for x, y in points)


def _text(x: float, y: float, text: str, anchor: str) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{escape(text)}</text>'


def _svg(width: int, height: int, parts: Sequence[str]) -> str:
    return (f'<svg viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
            f'role="img">{"".join(parts)}</svg>')
