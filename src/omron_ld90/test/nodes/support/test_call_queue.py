"""Calls are made in order and one at a time, also after one of them fails."""
from __future__ import annotations

import threading
import time
from typing import Iterator, List

import pytest

from omron_ld90.nodes.support import call_queue
from omron_ld90.nodes.support.call_queue import CallQueue


@pytest.fixture
def calls() -> Iterator[CallQueue]:
    made = CallQueue('calls of a test')
    yield made
    made.close()


@pytest.fixture
def logged(monkeypatch) -> List[str]:
    said: List[str] = []
    monkeypatch.setattr(call_queue.rospy, 'logerr', lambda text, *with_: said.append(text % with_))
    return said


def held_up(calls: CallQueue) -> threading.Event:
    """Makes the queue's thread wait in a call. Returns the event that ends the wait."""
    begun, go_on = threading.Event(), threading.Event()

    def wait() -> None:
        begun.set()
        go_on.wait(10.0)
    calls.add(wait)
    assert begun.wait(10.0)
    return go_on


def test_calls_are_made_in_their_order_by_a_thread_of_their_own(calls):
    made = []
    for number in range(100):
        calls.add(lambda number=number: made.append((number, threading.current_thread().name)))
    calls.close()
    assert made == [(number, 'calls of a test') for number in range(100)]


def test_whoever_adds_a_call_does_not_wait_for_it(calls):
    go_on = held_up(calls)
    made = []
    calls.add(lambda: made.append(1))  # `add` returns although the thread cannot make the call
    assert made == []
    go_on.set()
    calls.close()
    assert made == [1]


def test_a_call_that_raises_is_logged_and_the_next_ones_are_made(calls, logged):
    made = []

    def fail() -> None:
        raise ValueError('no such handle')
    calls.add(fail)
    calls.add(lambda: made.append(1))
    calls.close()
    assert made == [1]
    assert logged == ["calls of a test: a call failed: ValueError('no such handle')"]


def test_optional_calls_are_left_out_where_very_many_wait_and_others_never(calls, monkeypatch):
    monkeypatch.setattr(call_queue, '_MAXIMUM_OPTIONAL', 3)
    go_on = held_up(calls)
    made = []
    for number in range(5):
        calls.add(lambda number=number: made.append(f'line {number}'), optional=True)
    calls.add(lambda: made.append('result'))
    go_on.set()
    calls.close()
    assert made == ['line 0', 'line 1', 'line 2', 'result']


def test_closing_waits_no_longer_than_it_is_told(calls):
    go_on = held_up(calls)
    made = []
    calls.add(lambda: made.append(1))
    begun = time.monotonic()
    calls.close(timeout=0.01)
    assert time.monotonic() - begun < 2.0
    assert made == []
    go_on.set()
    calls._thread.join(10.0)
    assert made == [1], 'queued calls must still be made'
