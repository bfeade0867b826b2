"""Drives a plan with random delays and stalls, without any code of the planner.

Robots obey the precedence and nothing else. Each drive begins as soon as the precedence allows, and
takes a random time, with stops at random places. Afterwards the places of all robots are checked at
regular times.
"""
from __future__ import annotations

from random import Random
from typing import Dict, List, NamedTuple, Tuple

import numpy as np
from plan_checker import TOLERANCE, World


class Driven(NamedTuple):
    """One drive as it happened: at the times `at` (K,) the robot was at the fractions `share`."""

    at: np.ndarray
    share: np.ndarray


class Stuck(Exception):
    """Robots wait for each other for ever."""


def replay(world: World, plan: dict, random: Random) -> Dict[str, List[Driven]]:
    """Drives the plan once with all robots; raises Stuck if they do not reach the end."""
    needs: Dict[Tuple[str, int], List[Tuple[str, int, float]]] = {}
    for a, i, f, b, j in plan['precedence']:
        needs.setdefault((b, j), []).append((a, i, f))
    driven: Dict[str, List[Driven]] = {name: [] for name in plan['robots']}
    left = sum(map(len, plan['robots'].values()))
    while left:
        moved = False
        for name, drives in plan['robots'].items():
            while len(driven[name]) < len(drives):
                begin = _may_begin(driven, name, needs)
                if begin is None:
                    break
                drive = drives[len(driven[name])]
                driven[name].append(_drive(begin, drive['end'] - drive['start'], random,
                                           world.begun(name, len(driven[name]), drive['edge'])))
                moved = True
                left -= 1
        if not moved:
            raise Stuck(', '.join(f'{n} before drive {len(d)}' for n, d in driven.items()
                                  if len(d) < len(plan['robots'][n])))
    return driven


def _may_begin(driven, name, needs):
    j = len(driven[name])
    begin = driven[name][-1].at[-1] if j else 0.0
    for a, i, f in needs.get((name, j), ()):
        if len(driven[a]) <= i:
            return None
        before = driven[a][i]
        begin = max(begin, float(np.interp(f, before.share, before.at)))
    return begin


def _drive(begin: float, seconds: float, random: Random, begun: float = 0.0) -> Driven:
    """A drive at a random speed, perhaps with a stop, from the fraction `begun` of the edge on."""
    seconds *= random.choice((1.0, random.uniform(1.0, 1.5), random.uniform(1.0, 4.0)))
    if random.random() < 0.2:
        stop, stall = random.random(), random.uniform(0.0, 30.0)
        at = np.array((0.0, stop * seconds, stop * seconds + stall, seconds + stall))
        share = np.array((0.0, stop, stop, 1.0))
    else:
        at, share = np.array((0.0, seconds)), np.array((0.0, 1.0))
    share = begun + (1.0 - begun) * share
    return Driven(begin + at, share + np.arange(len(share)) * 1e-12)


def replay_faults(world: World, plan: dict, driven: Dict[str, List[Driven]],
                  step: float = 0.1) -> List[str]:
    """Robots that came too near to each other; checked every `step` s."""
    names = list(plan['robots'])
    last = max((d[-1].at[-1] for d in driven.values() if d), default=0.0)
    times = np.arange(0.0, last + step, step)
    records = np.array([_trajectory(world, plan, name, driven[name], times) for name in names])
    found = []
    for x, a in enumerate(names):
        gaps = np.hypot(*np.moveaxis(records[x + 1:] - records[x], 2, 0))
        for y, gap in enumerate(gaps, x + 1):
            k = int(gap.argmin())
            if gap[k] < world.apart(a, names[y]) - TOLERANCE:
                found.append(f'{a} and {names[y]} are {gap[k]:.4f} m apart at {times[k]:.1f} s')
    return found


def _trajectory(world: World, plan: dict, name: str, driven: List[Driven],
                times: np.ndarray) -> np.ndarray:
    point = world.start(name)
    places = np.tile((point.x, point.y), (len(times), 1))
    for drive, one in zip(plan['robots'][name], driven):
        later = times >= one.at[0]
        share = np.interp(times[later], one.at, one.share)
        places[later] = world.along(drive['edge'], share)
    return places
