"""A clock that stops while the process is suspended."""
from __future__ import annotations

from omron_ld90.bridge.running_clock import LONGEST_STEP, RunningClock


def test_it_runs_with_the_time_as_long_as_it_is_read_and_not_through_a_standstill():
    readings = iter([100.0, 100.1, 100.3, 110.3, 110.4])
    clock = RunningClock(lambda: next(readings))
    times = [clock.read() for _ in range(4)]
    assert [round(time, 6) for time in times] == [
        0.1, 0.3, 0.3 + LONGEST_STEP, 0.4 + LONGEST_STEP]
