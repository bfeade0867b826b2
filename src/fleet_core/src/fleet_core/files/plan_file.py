"""The plan file: the result of `plan_fleet` as JSON."""
from __future__ import annotations

import json
import os
from typing import Any, Dict, Iterable, Mapping, Union

from file_replacement import replace_file
from fleet_core.planning.tasks import PlanningOutcome


def solved_plan(outcome: PlanningOutcome, planning_time: float,
                geometry_time: float) -> Dict[str, Any]:
    """Returns the content of the file for a plan of all robots; times in s."""
    ends = [drives[-1].end if drives else 0.0 for drives in outcome.drives.values()]
    return {
        'solved': True, 'reason': '',
        'planning_time': planning_time, 'geometry_time': geometry_time,
        'sum_of_costs': sum(ends), 'lower_bound': min(outcome.lower_bound, sum(ends)),
        'makespan': max(ends, default=0.0),
        'robots': {name: [drive._asdict() for drive in drives]
                   for name, drives in outcome.drives.items()},
        'precedence': [list(constraint) for constraint in outcome.precedence],
    }


def unsolved_plan(reason: str, lower_bound: float, robots: Iterable[str],
                  planning_time: float, geometry_time: float) -> Dict[str, Any]:
    """Returns the content of the file if no plan was found: the reason, and no drives."""
    return {
        'solved': False, 'reason': reason,
        'planning_time': planning_time, 'geometry_time': geometry_time,
        'sum_of_costs': 0.0, 'lower_bound': lower_bound, 'makespan': 0.0,
        'robots': {name: [] for name in robots}, 'precedence': [],
    }


def save_plan(plan: Mapping[str, Any], path: Union[str, os.PathLike]) -> None:
    """Writes a plan with full precision. An older file stays until the new one is complete."""
    text = json.dumps(plan, allow_nan=False)
    if os.path.exists(path) and not os.path.isfile(path):  # /dev/stdout, a pipe
        with open(path, 'w', encoding='utf-8') as stream:
            stream.write(text)
        return
    replace_file(path, text + '\n')
