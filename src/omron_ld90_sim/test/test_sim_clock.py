"""The simulated clock."""
from __future__ import annotations

from typing import List

from hypothesis import given
from hypothesis import strategies as st

from omron_ld90_sim.clock import SimClock, Ticker


@given(st.lists(st.floats(0.0, 100.0), max_size=30))
def test_callbacks_run_at_their_times_in_order(times: List[float]) -> None:
    clock, seen = SimClock(), []
    for time in times:
        clock.at(time, lambda: seen.append(clock.now))
    clock.advance(100.0)
    assert seen == sorted(times) and clock.now == 100.0


def test_equal_times_keep_the_order_of_asking() -> None:
    clock, seen = SimClock(), []
    for name in 'abc':
        clock.at(1.0, lambda name=name: seen.append(name))
    clock.advance(1.0)
    assert seen == ['a', 'b', 'c']


def test_a_cancelled_callback_does_not_run_nor_wake_anybody() -> None:
    clock, seen = SimClock(), []
    clock.at(1.0, lambda: seen.append(1)).cancel()
    assert clock.next_time is None
    clock.advance(2.0)
    assert seen == []


def test_what_is_late_runs_at_once_and_never_goes_back_in_time() -> None:
    clock, seen = SimClock(), []
    clock.advance(5.0)
    clock.at(1.0, lambda: seen.append(clock.now))
    clock.advance(5.0)
    assert seen == [5.0]


def test_a_ticker_does_not_drift_over_a_day() -> None:
    clock, seen = SimClock(), []
    ticker = Ticker(clock, 0.1, lambda: seen.append(clock.now))
    clock.advance(86400.05)
    ticker.stop()
    clock.advance(86500.0)
    assert len(seen) == 864000 and abs(seen[-1] - 86400.0) < 1e-6
