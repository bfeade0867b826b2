"""Plan answers that are wrong in ways of which no planner should be capable."""
from __future__ import annotations

import copy
import math
from random import Random
from typing import Any, Callable, Dict


def _without_order(answer: Any, _: Random) -> None:
    answer.precedence = []


def _swapped(answer: Any, chance: Random) -> None:
    if len(answer.plans) > 1:
        one, other = chance.sample(answer.plans, 2)
        one.robot, other.robot = other.robot, one.robot


def _turned(answer: Any, chance: Random) -> None:
    for plan in answer.plans:
        for drive in plan.drives:
            if chance.random() < 0.2:
                drive.edge_id = -drive.edge_id


def _elsewhere(answer: Any, chance: Random) -> None:
    for plan in answer.plans:
        for drive in plan.drives:
            if chance.random() < 0.2:
                drive.edge_id = chance.choice((0, 1, -1, 7, 2 ** 31 - 1, -2 ** 31))


def _shortened(answer: Any, chance: Random) -> None:
    for plan in answer.plans:
        del plan.drives[chance.randint(0, len(plan.drives)):]


def _incomplete(answer: Any, chance: Random) -> None:
    if answer.plans:
        del answer.plans[chance.randrange(len(answer.plans))]


def _out_of_range(answer: Any, chance: Random) -> None:
    for precedence in answer.precedence:
        precedence.fraction = chance.choice((math.nan, -1.0, 1e9))
        precedence.before_drive = chance.choice((0, 2 ** 32 - 1))


def _reversed(answer: Any, _: Random) -> None:
    for rule in answer.precedence:
        rule.before, rule.robot = rule.robot, rule.before
        rule.before_drive, rule.drive = rule.drive, rule.before_drive


def _of_unknown(answer: Any, chance: Random) -> None:
    if answer.plans:
        chance.choice(answer.plans).robot = 'nobody'


def _timeless(answer: Any, chance: Random) -> None:
    for plan in answer.plans:
        for drive in plan.drives:
            drive.start.secs, drive.end.secs = chance.randrange(2 ** 31), 0


CORRUPTIONS: Dict[str, Callable[[Any, Random], None]] = {
    'no order of use': _without_order, 'plans of two robots swapped': _swapped,
    'edges turned': _turned, 'edges elsewhere': _elsewhere, 'plans cut short': _shortened,
    'one plan missing': _incomplete, 'order out of range': _out_of_range,
    'order reversed': _reversed, 'plan of an unknown robot': _of_unknown,
    'times without sense': _timeless}


def corrupted(answer: Any, kind: str, chance: Random) -> Any:
    """A copy of a `PlanAnswer` that is wrong in this way."""
    wrong = copy.deepcopy(answer)
    CORRUPTIONS[kind](wrong, chance)
    return wrong
