"""The route protocol: 10 Hz while a route runs, 1 Hz without one."""
from __future__ import annotations

import random

from bridge_builders import Bench, dissertation_graph

from omron_ld90.bridge.report_schedule import TICK, ReportSchedule


def reports(running: bool, seconds: int) -> int:
    """Reports within so many seconds, by a clock whose ticks come a fifth too late or too soon."""
    schedule, dice = ReportSchedule(), random.Random(1)
    ticks = (1000.0 + count * TICK + dice.uniform(-0.2, 0.2) * TICK
             for count in range(round(seconds / TICK)))
    return sum(schedule.is_due(running, now) for now in ticks)


def test_ten_a_second_while_a_route_runs():
    assert reports(running=True, seconds=10) == 100


def test_one_a_second_without_a_route():
    assert 29 <= reports(running=False, seconds=30) <= 30


def test_a_route_that_begins_is_told_of_at_the_next_tick():
    schedule = ReportSchedule()
    assert schedule.is_due(False, 5.0)
    assert not schedule.is_due(False, 5.1)
    assert schedule.is_due(True, 5.2)
    assert schedule.is_due(True, 5.3)
    assert not schedule.is_due(False, 5.4)


def test_a_drive_is_reported_ten_times_a_second_from_its_order_to_its_end():
    bench, schedule = Bench(dissertation_graph(), 1), ReportSchedule()
    due, start = [], bench.now

    def note(bench: Bench) -> bool:
        if schedule.is_due(bench.follower.running, bench.now):
            due.append(bench.now)
        return not bench.follower.running

    bench.order(7, 1, 4, 5)
    bench.run(note)
    gaps = [later - sooner for sooner, later in zip(due, due[1:])]
    assert due[0] == start
    assert max(gaps[:-1]) < 0.11, 'the last one is the end, which is told of at once'
