"""Turns a path into motion: turns, and tracks with rounded corners.

A corner is a quintic Bezier curve. Its curvature is zero at both ends, so that the rotation of the
robot does not jump.
"""
from __future__ import annotations

import math
from typing import List, Optional, Sequence

import numpy as np

from omron_ld90_sim.motion.kinematics import LD90_LIMITS, Limits, normalise
from omron_ld90_sim.motion.planner import PlannedWay, Planner
from omron_ld90_sim.motion.space import Space
from omron_ld90_sim.motion.track import Manoeuvre, SmoothTrack, Turn, line, straight_track

CORNER_STEP = 15.0                                      # mm between samples
CORNER_REACHES = (1200.0, 900.0, 650.0, 450.0, 300.0)   # mm from the vertex to the tangent points
SHORTEST_REACH = 60.0
REACH_PER_DEGREE = 2.0      # mm; the least distance to the tangent points, per degree of turn
SHARPEST_CORNER = 120.0                                 # deg; at a sharper corner the robot stops
NEGLIGIBLE = 0.5                                        # mm


def manoeuvres(way: PlannedWay, planner: Planner, limits: Limits = LD90_LIMITS,
               lead_in: Optional[np.ndarray] = None, entry_speed: float = 0.0) -> List[Manoeuvre]:
    """Returns the manoeuvres with which the robot follows `way`.

    lead_in -- samples that end at the start of `way` with a straight part. The robot drives along
    them first, and rounds the corner at their end if possible
    entry_speed -- mm/s at the first sample of `lead_in`
    """
    points = _without_repeats(way.vertices)
    clearance = planner.turn_clearance
    if lead_in is not None and not way.escape:
        run = _straight_run(lead_in)
        ahead = np.array([math.cos(lead_in[-1, 2]), math.sin(lead_in[-1, 2])])
        if run > SHORTEST_REACH:
            joined = _tracks(np.vstack([points[0] - run * ahead, points]),
                             [_drop_end(lead_in, run)], way.space, clearance)
            first = SmoothTrack(joined[0], limits, final=len(joined) == 1, entry_speed=entry_speed)
            if first.entry_fits:
                return [first, *_stretches(joined[1:], limits, float(joined[0][-1, 2]), way)]
    begin: List[Manoeuvre] = []
    if lead_in is not None:     # the corner cannot be rounded: stop at it
        begin.append(SmoothTrack(lead_in, limits, final=False, entry_speed=entry_speed))
    if way.escape:
        begin.append(straight_track(way.start, way.escape, limits))
    return begin + _stretches(_tracks(points, [], way.space, clearance), limits,
                              math.radians(way.start.theta), way)


def _stretches(tracks: List[np.ndarray], limits: Limits, direction: float,
               way: PlannedWay) -> List[Manoeuvre]:
    """Returns a turn and a track for each of `tracks`, and the last turn of `way`.

    The robot stands at the beginning of each track.
    """
    result: List[Manoeuvre] = []
    for number, samples in enumerate(tracks):
        result += _turn(direction, float(samples[0, 2]), limits.path_rotation)
        result.append(SmoothTrack(samples, limits, final=number == len(tracks) - 1))
        direction = float(samples[-1, 2])
    if way.final_heading is not None:
        result += _turn(direction, math.radians(way.final_heading), limits.goal_rotation)
    return result


def _turn(before: float, after: float, rate: float) -> List[Manoeuvre]:
    """Returns a turn on the spot between two directions (rad), or nothing if they are equal."""
    if abs(math.remainder(after - before, 2 * math.pi)) < 1e-5:
        return []
    return [Turn(normalise(math.degrees(after)), rate)]


def _without_repeats(points: np.ndarray) -> np.ndarray:
    steps = np.hypot(*np.diff(points, axis=0).T) if len(points) > 1 else np.array([])
    return points[np.concatenate([[True], steps > NEGLIGIBLE])]


def _straight_run(samples: np.ndarray) -> float:
    """Returns the length of the straight part at the end of `samples`."""
    bent = np.flatnonzero(np.abs(samples[:, 3]) > 1e-9)
    first = bent[-1] + 1 if len(bent) else 0
    first = min(first, len(samples) - 1)
    return float(np.hypot(*(samples[-1, :2] - samples[first, :2])))


def _drop_end(samples: np.ndarray, length: float) -> np.ndarray:
    """Returns `samples` without the straight part of `length` at their end."""
    away = np.hypot(*(samples[:, :2] - samples[-1, :2]).T)
    bent = np.abs(samples[:, 3]) > 1e-9
    return samples[(away > length - 1e-6) | bent]


def _tracks(points: np.ndarray, lines: List[np.ndarray], space: Space,
            clearance: float) -> List[np.ndarray]:
    """Returns samples of the tracks along `points`, one track for each stretch without a stop."""
    finished: List[np.ndarray] = []
    current: List[np.ndarray] = list(lines)
    at = points[0]
    direction: Optional[float] = float(current[-1][-1, 2]) if current and len(current[-1]) else None
    for k in range(1, len(points)):
        raw = math.atan2(*(points[k] - points[k - 1])[::-1])
        direction = raw if direction is None else direction + math.remainder(raw - direction,
                                                                             2 * math.pi)
        corner = None
        if k + 1 < len(points):
            corner = _corner(points[k - 1], points[k], points[k + 1], at, space,
                             clearance)
        end = corner[0] if corner is not None else points[k]
        if np.hypot(*(end[:2] - at)) > NEGLIGIBLE:
            current.append(line(at, end[:2], direction))
        if corner is not None:
            corner = corner.copy()
            corner[:, 2] += direction - corner[0, 2]
            current.append(corner)
            at, direction = corner[-1, :2], float(corner[-1, 2])
        else:
            if current:
                finished.append(np.concatenate(current))
            current, at, direction = [], points[k], None
    return [samples for samples in finished if len(samples) > 1]


def _corner(a: np.ndarray, v: np.ndarray, b: np.ndarray, at: np.ndarray, space: Space,
            clearance: float) -> Optional[np.ndarray]:
    """Returns poses along a curve that rounds the corner a-v-b.

    The curve begins at the point `at` between a and v, or after it.

    Returns None if the robot must stop to turn.
    """
    inward, outward = v - a, b - v
    turn = abs(math.degrees(math.remainder(math.atan2(*outward[::-1]) - math.atan2(*inward[::-1]),
                                           2 * math.pi)))
    if turn > SHARPEST_CORNER:
        return None
    into = float(np.hypot(*(v - at)))
    out = float(np.hypot(*outward))
    i, o = inward / np.hypot(*inward), outward / out
    longest = min(into, out / 2, CORNER_REACHES[0])
    shortest = max(SHORTEST_REACH, turn * REACH_PER_DEGREE)
    for reach in (*(r for r in CORNER_REACHES if r < longest), longest):
        samples = _bezier(v, i, o, reach)
        if reach >= shortest and space.clearance_at(samples[:, :2]).min() >= clearance:
            return samples
    return None


_BINOMIALS: Sequence[int] = (1, 5, 10, 10, 5, 1)


def _bezier(v: np.ndarray, i: np.ndarray, o: np.ndarray, reach: float) -> np.ndarray:
    fractions = np.array([1.0, 0.6, 0.2])[:, None] * reach
    control = np.vstack([v - fractions * i, v + fractions[::-1] * o])
    count = max(9, int(2 * reach / CORNER_STEP))
    t = np.linspace(0.0, 1.0, count)[:, None]

    def curve(points: np.ndarray, degree: int, binomials: Sequence[int]) -> np.ndarray:
        return sum(n * (1 - t) ** (degree - k) * t ** k * points[k]
                   for k, n in enumerate(binomials))

    first = 5 * np.diff(control, axis=0)
    second = 4 * np.diff(first, axis=0)
    xy = curve(control, 5, _BINOMIALS)
    d1 = curve(first, 4, (1, 4, 6, 4, 1))
    d2 = curve(second, 3, (1, 3, 3, 1))
    speed = np.hypot(d1[:, 0], d1[:, 1])
    curvature = (d1[:, 0] * d2[:, 1] - d1[:, 1] * d2[:, 0]) / speed ** 3
    curvature[[0, -1]] = 0.0
    return np.column_stack([xy, np.unwrap(np.arctan2(d1[:, 1], d1[:, 0])), curvature])
