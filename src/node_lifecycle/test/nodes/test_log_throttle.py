"""Few messages of each kind are logged; the other messages are counted."""
from __future__ import annotations

from node_lifecycle.log_throttle import BURST, PERIOD, LogThrottle


class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


def test_a_flood_of_a_kind_is_cut_off_and_counted_when_it_goes_on():
    clock = Clock()
    throttle = LogThrottle(clock=clock)
    passed = [throttle.pass_on('refused', f'message {i}') for i in range(1000)]
    assert [message for message in passed if message] == [f'message {i}' for i in range(BURST)]
    clock.now = PERIOD
    left_out = 1000 - BURST
    assert throttle.pass_on('refused', 'next') == f'next ({left_out} more like it were omitted.)'
    assert throttle.pass_on('refused', 'after it') == 'after it'


def test_kinds_do_not_silence_each_other():
    throttle = LogThrottle(clock=Clock())
    for _ in range(100):
        throttle.pass_on('refused', 'x')
    assert throttle.pass_on('stranger', 'y') == 'y'


def test_what_comes_now_and_then_is_all_logged():
    clock = Clock()
    throttle = LogThrottle(clock=clock)
    for second in range(0, 1000, 3):
        clock.now = float(second)
        assert throttle.pass_on('refused', 'x') == 'x'
