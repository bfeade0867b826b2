"""A thread that hangs is found; a thread that waits, sleeps or works is not reported."""
from __future__ import annotations

import queue
import threading
import time
from pathlib import Path
from typing import Callable, List

import pytest

from node_lifecycle.watchdog import Standstill, ThreadWatch


@pytest.fixture
def running() -> Callable[[Callable[[], object]], threading.Thread]:
    def start(work: Callable[[], object]) -> threading.Thread:
        thread = threading.Thread(target=work, name=work.__name__, daemon=True)
        thread.start()
        return thread
    return start


def watched(seconds: float = 0.6) -> List[Standstill]:
    """Watches this module's threads for this time. Returns those that hang."""
    watch = ThreadWatch((__name__,), standstill=0.3)
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        found = watch.blocked(time.monotonic())
        time.sleep(0.05)
    return [one for one in found if one.thread != 'MainThread']


def test_two_threads_that_wait_for_each_others_locks_stand_still(running):
    first, second = threading.Lock(), threading.RLock()
    both = threading.Barrier(3)

    def one_way() -> None:
        with first:
            both.wait(5.0)
            with second:
                pass

    def other_way() -> None:
        with second:
            both.wait(5.0)
            first.acquire(timeout=1.5)

    threads = [running(one_way), running(other_way)]
    both.wait(5.0)
    found = watched()
    assert {one.thread for one in found} == {'one_way', 'other_way'}
    assert all(one.seconds >= 0.3 for one in found)
    assert f'one_way ({__name__}, line' in ' '.join(one.place for one in found)
    for thread in threads:
        thread.join(10.0)


def test_a_thread_that_waits_to_enter_a_condition_stands_still(running):
    condition = threading.Condition()

    def enters() -> None:
        with condition:
            pass

    with condition:
        running(enters)
        assert [one.thread for one in watched()] == ['enters']


def test_threads_that_wait_for_something_to_do_do_not_stand_still(running):
    event, jobs, condition = threading.Event(), queue.Queue(), threading.Condition()

    def waits() -> None:
        event.wait()

    def takes() -> None:
        jobs.get()

    def listens() -> None:
        with condition:
            condition.wait_for(event.is_set)

    for work in (waits, takes, listens):
        running(work)
    assert watched() == []
    event.set()
    jobs.put(None)
    with condition:
        condition.notify_all()


def test_no_thread_waits_without_an_end_in_a_queue_that_cannot_be_watched():
    """A SimpleQueue waits outside `threading`, so a thread that waits there would be reported."""
    sources = Path(__file__).resolve().parents[3].glob('*/src/**/*.py')
    users = [path.name for path in sources if 'SimpleQueue' in path.read_text(encoding='utf-8')]
    assert users == ['event_loop.py']  # each wait in this file has a time limit


def test_a_thread_that_sleeps_or_works_again_and_again_does_not_stand_still(running):
    done = threading.Event()

    def sleeps() -> None:
        while not done.is_set():
            time.sleep(0.1)

    def works() -> None:
        while not done.is_set():
            sum(range(300_000))

    threads = [running(sleeps), running(works)]
    assert watched() == []
    done.set()
    for thread in threads:
        thread.join(5.0)


def test_threads_of_other_packages_are_not_judged(running):
    lock = threading.Lock()

    def enters() -> None:
        with lock:
            pass

    watch = ThreadWatch(('omron_ld90',), standstill=0.1)
    with lock:
        running(enters)
        watch.blocked(time.monotonic())
        assert watch.blocked(time.monotonic() + 1.0) == []


def test_a_thread_that_moves_on_is_forgiven(running):
    lock, done = threading.Lock(), threading.Event()

    def enters() -> None:
        with lock:
            pass
        done.wait()

    with lock:
        running(enters)
        assert watched()
    assert watched() == []
    done.set()
