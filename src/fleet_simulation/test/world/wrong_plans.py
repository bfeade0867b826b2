"""Makes plans wrong, with errors that no correct planner makes, for chaos, soak and other tests."""
from __future__ import annotations

import math
from dataclasses import replace
from random import Random
from typing import Callable, Dict

from fleet_core.planning.tasks import PlanningOutcome

ELSEWHERE = (0, 1, -1, 7, 2 ** 31 - 1, 1 - 2 ** 31)
"""Edge ids that replace other ids; a typical graph has some of these edges and lacks the rest."""


def without_order(outcome: PlanningOutcome, _: Random) -> PlanningOutcome:
    """Removes the order constraints: no robot waits for another one."""
    return replace(outcome, precedence=())


def with_holes(outcome: PlanningOutcome, _: Random) -> PlanningOutcome:
    """Removes the second drive of each robot."""
    return replace(outcome, precedence=(), drives={
        name: drives[:1] + drives[2:] for name, drives in outcome.drives.items()})


def exchanged(outcome: PlanningOutcome, _: Random) -> PlanningOutcome:
    """Gives each robot the drives of another robot."""
    names = list(outcome.drives)
    return replace(outcome, precedence=(), drives={
        name: outcome.drives[other] for name, other in zip(names, names[1:] + names[:1])})


def without_drives(outcome: PlanningOutcome, _: Random) -> PlanningOutcome:
    """Removes all drives, but still claims that the robots are served."""
    return replace(outcome, precedence=(), drives=dict.fromkeys(outcome.drives, ()))


def shortened(outcome: PlanningOutcome, chance: Random) -> PlanningOutcome:
    """Removes the last drives of each robot; the order constraints still name them."""
    return replace(outcome, drives={name: drives[:chance.randint(0, len(drives))]
                                    for name, drives in outcome.drives.items()})


def incomplete(outcome: PlanningOutcome, chance: Random) -> PlanningOutcome:
    """Removes the plan of one robot."""
    left_out = chance.choice(sorted(outcome.drives)) if outcome.drives else ''
    return replace(outcome, drives={name: drives for name, drives in outcome.drives.items()
                                    if name != left_out})


def turned(outcome: PlanningOutcome, chance: Random) -> PlanningOutcome:
    """Reverses the direction of some drives."""
    return _with_edges(outcome, chance, lambda edge: -edge)


def elsewhere(outcome: PlanningOutcome, chance: Random) -> PlanningOutcome:
    """Replaces some edges by others that the graph may lack."""
    return _with_edges(outcome, chance, lambda _: chance.choice(ELSEWHERE))


def _with_edges(outcome: PlanningOutcome, chance: Random,
                other: Callable[[int], int]) -> PlanningOutcome:
    return replace(outcome, drives={
        name: tuple(drive._replace(edge=other(drive.edge)) if chance.random() < 0.2 else drive
                    for drive in drives) for name, drives in outcome.drives.items()})


def of_an_unknown_robot(outcome: PlanningOutcome, chance: Random) -> PlanningOutcome:
    """Gives the plan of one robot to a robot that is not in the fleet."""
    if not outcome.drives:
        return outcome
    drives = dict(outcome.drives)
    drives['unknown'] = drives.pop(chance.choice(sorted(drives)))
    return replace(outcome, drives=drives)


def reversed_order(outcome: PlanningOutcome, _: Random) -> PlanningOutcome:
    """Reverses each order constraint: each robot waits for the robots that should wait for it."""
    return replace(outcome, precedence=tuple(
        one._replace(first=one.then, before=one.drive, then=one.first, drive=one.before)
        for one in outcome.precedence))


def impossible_order(outcome: PlanningOutcome, chance: Random) -> PlanningOutcome:
    """Lets the order constraints name drives and fractions that do not exist."""
    return replace(outcome, precedence=tuple(
        one._replace(before=chance.choice((0, 2 ** 32 - 1)),
                     fraction=chance.choice((math.nan, -1.0, 1e9)))
        for one in outcome.precedence))


def without_time(outcome: PlanningOutcome, chance: Random) -> PlanningOutcome:
    """Sets times such that drives end long before they begin."""
    return replace(outcome, drives={
        name: tuple(drive._replace(start=float(chance.randrange(2 ** 30)), end=0.0)
                    for drive in drives) for name, drives in outcome.drives.items()})


Spoil = Callable[[PlanningOutcome, Random], PlanningOutcome]

WRONG: Dict[str, Spoil] = {spoil.__name__: spoil for spoil in (
    without_order, with_holes, exchanged, without_drives, shortened, incomplete, turned, elsewhere,
    of_an_unknown_robot, reversed_order, impossible_order, without_time)}
"""All functions that make a plan wrong, by name."""
