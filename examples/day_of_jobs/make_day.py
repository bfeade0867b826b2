#!/usr/bin/env python3
"""Prints a day of jobs for simulate_jobs: a shift in the example laboratory.

    examples/day_of_jobs/make_day.py > examples/day_of_jobs/day.txt

Pallets come from two receiving places (6, 18), wait in a buffer (27), and leave by two gates (39,
52). People at the desk cancel jobs, give them another priority, or another gate.
"""
from __future__ import annotations

from random import Random
from typing import List, NamedTuple, Tuple

RECEIVING, BUFFER, GATES = ('6', '18'), '27', ('39', '52')
JOBS_PER_HOUR = {6: 20, 7: 35, 8: 45, 9: 40, 10: 30, 11: 45, 12: 15, 13: 35}
RESTARTS = ((9, 'job_server'), (12, 'fleet_manager'))  # hour at whose beginning it restarts


class Line(NamedTuple):
    """A line of the day, at `at` s after midnight. `order` sorts the lines of one second."""

    at: int
    order: int
    text: str


def job(random: Random, id: str) -> Tuple[str, int]:
    """Returns the command of a job, and the number of its segments."""
    kind = random.random()
    if kind < 0.35:
        return f'queuePickupDropoff {random.choice(RECEIVING)} {BUFFER} default default {id}', 2
    if kind < 0.70:
        return f'queuePickupDropoff {BUFFER} {random.choice(GATES)} default default {id}', 2
    if kind < 0.85:
        return (f'queuePickupDropoff {random.choice(RECEIVING)} {random.choice(GATES)} 15 default '
                f'{id}'), 2
    if kind < 0.93:
        return (f'queueMulti 3 2 {RECEIVING[0]} pickup default {BUFFER} dropoff default '
                f'{GATES[0]} dropoff default {id}'), 3
    return f'queuePickup {random.choice(RECEIVING)} 5 {id}', 1


def made_day(seed: int) -> List[str]:
    """Returns the lines of a day."""
    random, lines, count = Random(seed), [], 0
    for hour, rate in JOBS_PER_HOUR.items():
        for at in sorted(3600.0 * (hour + random.random()) for _ in range(rate)):
            count += 1
            id = f'P{count:03d}'
            command, segments = job(random, id)
            lines.append(Line(int(at), 0, command))
            later, change = int(at + random.uniform(3.0, 60.0)), random.random()
            if change < 0.04:
                lines.append(Line(later, 1, f'queueCancel jobId {id} default order_withdrawn'))
            elif change < 0.08:
                lines.append(Line(later, 1, f'queueModify @{id}.1 priority 30'))
            elif change < 0.12:
                lines.append(Line(later, 1, f'queueModify @{id}.{segments} goal '
                                            f'{random.choice(GATES)}'))
    lines += [Line(3600 * hour, 2, f'restart {what}') for hour, what in RESTARTS]
    return [f'{at // 3600:02d}:{at // 60 % 60:02d}:{at % 60:02d} {text}'
            for at, _, text in sorted(lines)]


if __name__ == '__main__':
    print('# Made by make_day.py: a shift in the example laboratory')
    print('\n'.join(made_day(1)))
