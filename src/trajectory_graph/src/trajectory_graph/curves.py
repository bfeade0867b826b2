"""The curves of edges in the plane: length, points along the curve, projection onto the curve.

Units are metres and radians. A curve is stored as a polyline that is at most 0.1 mm away from the
curve. Arc lengths are measured along the curve; the polyline is slightly shorter.
"""
from __future__ import annotations

import math
from bisect import bisect_right
from typing import List, NamedTuple, Optional, Tuple, cast

import numpy as np

FLATNESS = 1e-4  # m, greatest distance between a spline and its polyline
_SHARP = 0.02  # a stop that is this near to a real parameter causes a kink in the speed
_GRADES = 0.5 ** np.arange(4.0, 24.0)  # shorter and shorter steps on both sides of a stop
_GRADES = np.concatenate((-_GRADES, -0.75 * _GRADES, [0.0], 0.75 * _GRADES, _GRADES))
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)  # Gauss-Legendre quadrature on -1..1


class Projection(NamedTuple):
    """The point of a curve nearest to a given point."""

    distance: float    # m, from the given point
    arc_length: float  # m, from the curve's start
    fraction: float    # 0..1 of the curve's length


class Curve:
    """A curve in driving direction, parametrised by arc length s in 0..length (m)."""

    def __init__(self, points: np.ndarray, arc: Optional[np.ndarray] = None) -> None:
        """
        points -- (N,2), N >= 2, m: the polyline; repeated points are dropped
        arc    -- (N,), m: the curve's arc length at each point; None: the length of the polyline
        """
        steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        kept = np.concatenate(([True], steps > 1e-9))
        self.points = points[kept]
        """(N,2) m, the polyline."""
        self._steps = np.diff(self.points, axis=0)
        if arc is None:
            arc = np.concatenate(([0.0], np.cumsum(steps)))
        self._arc = arc[kept]
        self._lengths = np.diff(self._arc)
        self.length = float(self._arc[-1])
        """The arc length, in m; 0 if all points coincide."""
        self._corners = cast(  # lists are faster than numpy for one point
            List[Tuple[float, float, float]], np.column_stack((self._arc, self.points)).tolist())

    def reversed(self) -> Curve:
        """Returns the same curve in the opposite direction."""
        return Curve(self.points[::-1], self.length - self._arc[::-1])

    def point_at(self, s: float) -> Tuple[float, float]:
        """Returns x, y (m) at arc length `s` (m); `s` is limited to 0..length."""
        corners = self._corners
        index = bisect_right(corners, [s, math.inf])
        if index in (0, len(corners)):
            _, x, y = corners[min(index, len(corners) - 1)]
            return x, y
        (begun, x, y), (ended, end_x, end_y) = corners[index - 1:index + 1]
        part = (s - begun) / (ended - begun)
        return x + part * (end_x - x), y + part * (end_y - y)

    def heading_at(self, s: float) -> float:
        """Returns the driving direction (rad, -pi..pi) at arc length `s`, limited to 0..length."""
        index = int(np.searchsorted(self._arc, s, side='right')) - 1
        dx, dy = self._steps[min(max(index, 0), len(self._steps) - 1)]
        return math.atan2(dy, dx)

    def turned(self, s: np.ndarray) -> np.ndarray:
        """Returns the angle (rad) that a robot has turned up to each arc length `s` (N,).

        Turns to the left and to the right add up.
        """
        if len(self._steps) < 2:
            return np.zeros_like(s)
        headings = np.arctan2(self._steps[:, 1], self._steps[:, 0])
        turns = np.abs((np.diff(headings) + math.pi) % (2.0 * math.pi) - math.pi)
        middles = self._arc[:-1] + self._lengths / 2.0
        return np.interp(s, middles, np.concatenate(([0.0], np.cumsum(turns))))

    def sample(self, step: float) -> np.ndarray:
        """Returns points (N,2) along the curve, at most `step` m apart; both ends are included."""
        count = max(2, int(math.ceil(self.length / step)) + 1)
        s = np.linspace(0.0, self.length, count)
        return np.column_stack((np.interp(s, self._arc, self.points[:, 0]),
                                np.interp(s, self._arc, self.points[:, 1])))

    def project(self, x: float, y: float, start: float = 0.0, end: float = math.inf) -> Projection:
        """Returns the nearest point to x, y (m) between the arc lengths `start` and `end` (m).

        If several points are equally near, the first point along the curve is returned.
        """
        start = min(max(start, 0.0), self.length)
        end = min(max(end, start), self.length)
        if len(self._corners) == 2:
            return self._project_on_line(x, y, start, end)
        along = np.clip(self._nearest_arcs(x, y), start, end)
        # A segment completely outside start..end is clipped to `start` or `end`. Both are on the
        # curve, so each distance is the distance to a point of the curve.
        distances = np.hypot(np.interp(along, self._arc, self.points[:, 0]) - x,
                             np.interp(along, self._arc, self.points[:, 1]) - y)
        best = int(np.argmin(distances))
        s = float(along[best])
        fraction = s / self.length if self.length else 0.0
        return Projection(float(distances[best]), s, fraction)

    def _project_on_line(self, x: float, y: float, start: float, end: float) -> Projection:
        """Returns the same as `project`, but far faster; only for a single straight line."""
        (_, x0, y0), (length, x1, y1) = self._corners
        dx, dy = x1 - x0, y1 - y0
        part = ((x - x0) * dx + (y - y0) * dy) / (dx * dx + dy * dy)
        s = min(max(part * length, start), end)
        fraction = s / length
        return Projection(math.hypot(x0 + fraction * dx - x, y0 + fraction * dy - y), s, fraction)

    def _nearest_arcs(self, x: float, y: float) -> np.ndarray:
        """Returns for each segment the arc length of its point that is nearest to x, y."""
        if not len(self._steps):
            return np.zeros(1)
        ahead = ((np.array((x, y)) - self.points[:-1]) * self._steps).sum(axis=1)
        fractions = np.clip(ahead / (self._steps ** 2).sum(axis=1), 0.0, 1.0)
        return self._arc[:-1] + fractions * self._lengths


def line(start: Tuple[float, float], end: Tuple[float, float]) -> Curve:
    """Returns the straight line from `start` to `end`."""
    return Curve(np.array((start, end), dtype=float))


def cubic_bezier(control: np.ndarray) -> Curve:
    """Returns the cubic Bezier curve with the four `control` points (4,2)."""
    p0, p1, p2, p3 = control
    bend = 6.0 * max(float(np.linalg.norm(p0 - 2 * p1 + p2)),
                     float(np.linalg.norm(p1 - 2 * p2 + p3)))
    segments = max(1, int(math.ceil(math.sqrt(bend / (8.0 * FLATNESS)))))
    t = np.linspace(0.0, 1.0, segments + 1)
    arc = bezier_arc_lengths(control, t)
    if arc[-1] > 0.0:
        arc *= float(bezier_lengths(control[None])[0]) / arc[-1]
    return Curve(bezier_points(control, t), arc)


def bezier_points(control: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Returns the points (..., N, 2) at parameters `t` (N,) of curves with control (..., 4, 2)."""
    u = 1.0 - t
    basis = np.stack((u ** 3, 3.0 * u ** 2 * t, 3.0 * u * t ** 2, t ** 3), axis=-1)
    return basis @ control


def bezier_arc_lengths(control: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Returns the arc lengths (..., N), m, from parameter t[..., 0] to each parameter of `t`.

    t -- (N,) or (..., N), not decreasing
    """
    half = np.diff(t) / 2.0
    at = (t[..., :-1] + half)[..., None] + half[..., None] * _NODES
    first, second, third = np.moveaxis(3.0 * np.diff(control, axis=-2), -2, 0)[..., None, None]
    turn, bend = 2.0 * (second - first), first - 2.0 * second + third
    x, y = ((bend[..., k, :, :] * at + turn[..., k, :, :]) * at + first[..., k, :, :]
            for k in (0, 1))  # the velocity; computed in place because there may be millions
    x *= x
    y *= y
    x += y
    steps = np.sqrt(x, out=x) @ _WEIGHTS * half
    return np.concatenate((np.zeros_like(steps[..., :1]), np.cumsum(steps, axis=-1)), axis=-1)


def bezier_lengths(control: np.ndarray) -> np.ndarray:
    """Returns the arc lengths (N,), m, of cubic Bezier curves, exact to a relative 1e-9.

    control -- control points (N,4,2)
    """
    lengths = np.zeros(len(control))
    sharp = _turns_sharply(control).any(axis=-1)
    lengths[sharp] = bezier_arc_lengths(control[sharp], fine_parameters(control[sharp], 128))[:, -1]
    left = np.flatnonzero(~sharp)
    before = np.full(len(left), np.inf)
    for parts in (8, 32, 128, 512):
        if not len(left):
            break
        lengths[left] = bezier_arc_lengths(control[left], np.linspace(0.0, 1.0, parts + 1))[:, -1]
        more = ~(np.abs(lengths[left] - before) <= 1e-9 * lengths[left])
        left, before = left[more], lengths[left][more]
    return lengths


def fine_parameters(control: np.ndarray, parts: int) -> np.ndarray:
    """Returns parameters (..., N), from 0 to 1, for which `bezier_arc_lengths` is exact.

    There are at least `parts` equal steps; some parameters may be repeated. At a point where a
    curve (nearly) stops and turns on the spot, its speed has a kink that equal steps would miss.
    So the steps become shorter and shorter near this point.
    """
    even = np.linspace(0.0, 1.0, parts + 1)
    turns = np.where(_turns_sharply(control), _stops(control).real, 0.0)[..., None]
    graded = np.clip(turns + _GRADES, 0.0, 1.0)
    t = np.concatenate((np.broadcast_to(even, (*control.shape[:-2], len(even))),
                        graded.reshape(*control.shape[:-2], 2 * len(_GRADES))), axis=-1)
    return np.sort(t, axis=-1)


def bezier_speeds(control: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Returns the derivative (N,), m, of the arc length at the parameters `t` (N,) of one curve."""
    u = 1.0 - t
    velocity = np.stack((u ** 2, 2.0 * u * t, t ** 2), axis=-1) @ (3.0 * np.diff(control, axis=0))
    return np.hypot(velocity[:, 0], velocity[:, 1])


def _stops(control: np.ndarray) -> np.ndarray:
    """Returns the complex parameters (..., 2) at which the velocity of curves (..., 4, 2) is 0.

    With points as complex numbers, the velocity is a quadratic polynomial of the parameter. A
    missing root is returned as infinity.
    """
    first, second, third = np.moveaxis(np.diff(control[..., 0] + 1j * control[..., 1]), -1, 0)
    a, b, c = first - 2.0 * second + third, second - first, first
    root = np.sqrt(b * b - a * c)
    larger = -(b + np.where((np.conj(b) * root).real >= 0.0, root, -root))
    with np.errstate(divide='ignore', invalid='ignore', over='ignore'):
        stops = np.stack((larger / a, c / larger), axis=-1)
    return np.where(np.isfinite(stops), stops, np.inf)


def _turns_sharply(control: np.ndarray) -> np.ndarray:
    """Returns which of `_stops` are so near to a real parameter that the speed has a kink there."""
    stops = _stops(control)
    return ((np.abs(stops.imag) < _SHARP) & (stops.real > -_SHARP) & (stops.real < 1.0 + _SHARP))


def bezier_section(control: np.ndarray, start: float, end: float) -> np.ndarray:
    """Returns the control points (4,2) of a part of a cubic Bezier curve.

    start, end -- the parameters at the ends of the part
    """
    back = _first_part(control, end)
    return _first_part(back[::-1], 1.0 - start / end)[::-1] if start > 0.0 else back


def _first_part(control: np.ndarray, t: float) -> np.ndarray:
    """Returns the control points of the part from 0 to `t` (de Casteljau's construction)."""
    first, points = [control[0]], control
    while len(points) > 1:
        points = points[:-1] + t * np.diff(points, axis=0)
        first.append(points[0])
    return np.array(first)


def spline_control(start: Tuple[float, float], start_theta: float, param_f: float,
                   end: Tuple[float, float], end_theta: float, param_b: float) -> np.ndarray:
    """Returns the control points (4,2) of the fleet's spline, as this project understands it.

    The spline is a cubic Bezier curve. It leaves `start` in direction `start_theta`, with a control
    point `param_f` metres ahead. It enters `end` in direction `end_theta`, with a control point
    `param_b` metres behind. This is an assumption, because the editor's definition is not public.
    No other function makes this assumption.
    """
    return np.array((
        start,
        (start[0] + param_f * math.cos(start_theta), start[1] + param_f * math.sin(start_theta)),
        (end[0] - param_b * math.cos(end_theta), end[1] - param_b * math.sin(end_theta)),
        end), dtype=float)


def line_control(start: Tuple[float, float], end: Tuple[float, float]) -> np.ndarray:
    """Returns the control points (4,2) of a straight line with constant speed."""
    return np.linspace(start, end, 4)


def spline(start: Tuple[float, float], start_theta: float, param_f: float,
           end: Tuple[float, float], end_theta: float, param_b: float) -> Curve:
    """Returns the fleet's spline; see `spline_control`."""
    return cubic_bezier(spline_control(start, start_theta, param_f, end, end_theta, param_b))
