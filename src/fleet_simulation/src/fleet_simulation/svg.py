"""Draws charts and maps as inline SVG."""
from __future__ import annotations

import math
from html import escape
from typing import Callable, List, Mapping, NamedTuple, Sequence, Tuple

WIDTH, HEIGHT = 640, 300
_LEFT, _RIGHT, _TOP, _BOTTOM = 64, 16, 16, 44
_LEGEND_ROW, _LEGEND_COLUMN = 18, 300  # px
COLOURS = ('#2266aa', '#88aacc', '#66aa66', '#bb9944', '#cc4433', '#9966aa', '#cccccc', '#333333')
_LINE_COLOURS = tuple(COLOURS[number] for number in (0, 4, 2, 3))


class Line(NamedTuple):
    """A line of a chart: its points (x, y), and half the height of the confidence band at each
    point.
    """

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
    """Returns a line chart; the values of x are whole numbers.

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
    for line, colour in zip(lines, _LINE_COLOURS):
        parts += _drawn_line(line, colour, axes)
    return _above_legend(parts, [line.name for line in lines], _LINE_COLOURS)


class _Axes(NamedTuple):
    """The transformation from points of a line chart to points of the picture (px)."""

    low: float
    high: float
    top: float

    def across(self, x: float) -> float:
        return _LEFT + (x - self.low) / (self.high - self.low) * (WIDTH - _LEFT - _RIGHT)

    def height(self, y: float) -> float:
        return HEIGHT - _BOTTOM - max(y, 0.0) / self.top * (HEIGHT - _TOP - _BOTTOM)

    def place(self, x: float, y: float) -> Tuple[float, float]:
        return self.across(x), self.height(y)


def _drawn_line(line: Line, colour: str, axes: _Axes) -> List[str]:
    """Returns one line of a chart with its band."""
    parts = []
    known = [(x, y, half) for (x, y), half in zip(line.points, line.halves) if half < math.inf]
    if known:
        outline = [axes.place(x, y + half) for x, y, half in known] + [
            axes.place(x, y - half) for x, y, half in reversed(known)]
        parts.append(f'<polygon points="{points_of(outline)}" fill="{colour}" '
                     'fill-opacity="0.18"/>')
    drawn = [axes.place(x, y) for x, y in line.points if y == y]
    parts.append(f'<polyline points="{points_of(drawn)}" fill="none" stroke="{colour}" '
                 'stroke-width="2"/>')
    parts += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="{colour}"/>' for x, y in drawn]
    return parts


def stacks(names: Sequence[str], columns: Mapping[int, Sequence[float]], across: str,
           up: str) -> str:
    """Returns a chart with one column for each key of `columns`; a column is a stack of shares
    (0..1).

    names      -- legend, one name per share
    across, up -- labels of the axes
    """
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
    return _above_legend(parts, names, COLOURS)


def _above_legend(parts: List[str], names: Sequence[str], colours: Sequence[str]) -> str:
    """Returns a chart. Its legend is below the chart, so that it hides no line."""
    for number, (name, colour) in enumerate(zip(names, colours)):
        x = _LEFT + _LEGEND_COLUMN * (number % 2)
        y = HEIGHT + 6 + _LEGEND_ROW * (number // 2)
        parts.append(f'<rect x="{x}" y="{y}" width="12" height="12" fill="{colour}"/>')
        parts.append(_text(x + 18, y + 10, name, 'start'))
    return picture(WIDTH, HEIGHT + _LEGEND_ROW * math.ceil(len(names) / 2) + 10, parts)


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


def points_of(points: Sequence[Tuple[float, float]]) -> str:
    """Returns points (px) in the form of the SVG attribute `points`."""
    return ' '.join(f'{x:.1f},{y:.1f}' for x, y in points)


def _text(x: float, y: float, text: str, anchor: str) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{escape(text)}</text>'


def picture(width: int, height: int, parts: Sequence[str]) -> str:
    """Returns a picture of this size (px) with these parts."""
    return (f'<svg viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
            f'role="img">{"".join(parts)}</svg>')
