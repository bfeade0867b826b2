"""One thread makes the queued calls of a node in order, and calls `tick` between them."""
from __future__ import annotations

import threading
import time
from typing import List

import pytest

from node_lifecycle.event_loop import EventLoop


class Clock:
    """Advances by a step each time it is read."""

    def __init__(self, step: float) -> None:
        self.now, self.step = 0.0, step

    def __call__(self) -> float:
        self.now += self.step
        return self.now


def test_calls_are_made_in_their_order_by_one_thread():
    made: List[tuple] = []
    loop = EventLoop(lambda: None, 0.01)
    thread = threading.Thread(target=loop.run)
    thread.start()
    for number in range(200):
        loop.put(lambda number=number: made.append((number, threading.current_thread())))
    loop.put(loop.end)
    thread.join(10.0)
    assert made == [(number, thread) for number in range(200)]


def test_a_tick_comes_though_calls_never_cease():
    made: List[str] = []
    loop = EventLoop(lambda: made.append('tick'), 1.0, Clock(0.1))

    def again() -> None:
        made.append('call')
        if len(made) >= 100:
            loop.end()
        loop.put(again)

    loop.put(again)
    loop.run()
    gaps = ''.join(word[0] for word in made).split('t')
    assert made.count('tick') >= 5
    assert max(map(len, gaps)) <= 12, 'a tick may be late only by the calls that waited'


def test_what_waits_when_a_tick_is_due_is_made_before_it():
    made: List[str] = []
    loop = EventLoop(lambda: made.append('tick'), 1.0, Clock(5.0))  # a tick is always due
    for number in range(50):
        loop.put(lambda number=number: made.append(f'call {number}'))
    loop.put(loop.end)
    loop.run()
    assert made == [f'call {number}' for number in range(50)]


def test_what_comes_behind_a_tick_that_is_due_waits_for_it():
    made: List[str] = []

    def tick() -> None:
        made.append('tick')
        loop.end()

    def first() -> None:
        made.append('first')
        loop.put(lambda: made.append('second'))

    loop = EventLoop(tick, 1.0, Clock(5.0))
    loop.put(first)
    loop.run()
    assert made == ['first', 'tick']


def test_ticks_do_not_pile_up_where_one_was_late():
    ticks: List[float] = []
    clock = Clock(0.0)

    def tick() -> None:
        ticks.append(clock.now)
        clock.now += 0.1 if len(ticks) == 1 else 0.004
        if len(ticks) == 4:
            loop.end()

    loop = EventLoop(tick, 0.01, clock)
    clock.step = 0.001
    loop.run()
    assert all(later - earlier >= 0.009 for earlier, later in zip(ticks[1:], ticks[2:]))


def test_a_crowded_loop_makes_a_topic_wait_and_an_ending_one_does_not():
    said: List[str] = []
    loop = EventLoop(lambda: None, 0.01)
    for _ in range(4):
        loop.put(lambda: None)
    waiting = threading.Thread(target=lambda: loop.put_if_room(
        lambda: said.append('made'), 3, lambda: said.append('crowded')))
    waiting.start()
    deadline = time.monotonic() + 10.0
    while 'crowded' not in said and time.monotonic() < deadline:
        time.sleep(0.01)
    assert 'crowded' in said and waiting.is_alive()
    loop.put(loop.end)
    loop.run()
    waiting.join(10.0)
    assert not waiting.is_alive()


def test_what_a_call_raises_ends_the_loop():
    loop = EventLoop(lambda: None, 10.0)
    loop.put(lambda: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        loop.run()
