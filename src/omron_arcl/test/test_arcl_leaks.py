"""Hundreds of connections leave no thread, no descriptor and no memory behind."""
from __future__ import annotations

import gc
import os
import socket
import sys
import threading
import tracemalloc

from arcl_builders import PASSWORD, STATUS, Noted, ScriptedRobot, lines, wait_for

from omron_arcl import Backoff, Client, Listener, Outcome

RECONNECTS = 1000 if os.environ.get('LD90_LONG_TESTS') == '1' else 300
WARM = 100  # number of connections before memory is measured
KEPT = 200_000  # bytes that may remain, in caches of the interpreter
IS_TRACED = sys.gettrace() is not None  # coverage keeps data for each thread that has ever run


def resources() -> tuple:
    gc.collect()
    return threading.active_count(), len(os.listdir('/proc/self/fd'))


def memory() -> int:
    """Returns the bytes in use, without the interpreter's own set of threads.

    The table of this set grows with each thread that the test's robot starts, and shrinks later.
    """
    gc.collect()
    others = tracemalloc.take_snapshot().filter_traces(
        [tracemalloc.Filter(False, '*/_weakrefset.py')])
    return sum(trace.size for trace in others.traces)


class NoBackoff(Backoff):
    """No waiting time, for tests that reconnect many times."""

    def after(self, cause: Exception) -> float:
        return 0.0


def test_a_client_that_reconnects_many_times_leaks_nothing():
    with ScriptedRobot() as robot:
        robot.hangs_up_on = b'goto 12'
        before = resources()
        lost = Noted()
        client = Client('127.0.0.1', robot.port, PASSWORD, backoff=NoBackoff(),
                        on_login=lambda _: client.execute('goto 12', on_end=lost))
        with client:
            wait_for(lambda: len(lost.all) >= WARM, 'the first connections', 30.0)
            tracemalloc.start()
            start = memory()
            wait_for(lambda: len(lost.all) >= RECONNECTS, 'the end of every command', 60.0)
        outcomes = [result.outcome for result in lost.all]
        assert set(outcomes) <= {Outcome.LOST, Outcome.NEVER_SENT}
        assert robot.heard.count(b'goto 12') - outcomes.count(Outcome.LOST) in (-1, 0, 1)
        lost.all.clear()
        robot.heard.clear()
        wait_for(lambda: all(c.fileno() < 0 for c in robot.connections), 'the robot to close all')
        robot.forget_closed()
        wait_for(lambda: resources() == before, f'threads and descriptors; before {before}')
        assert IS_TRACED or memory() - start < KEPT
        tracemalloc.stop()


def test_a_listener_to_which_the_robot_connects_many_times_leaks_nothing():
    heard = threading.Semaphore(0)
    before = resources()
    tracemalloc.start()
    start = memory()
    with Listener('127.0.0.1', 0, '127.0.0.1', on_line=lambda _: heard.release()) as listener:
        for number in range(RECONNECTS):
            with socket.create_connection(('127.0.0.1', listener.port)) as robot:
                robot.sendall(lines(*STATUS))
                for _ in STATUS:
                    assert heard.acquire(timeout=10.0), f'no status of connection {number}'
        assert resources()[0] == before[0] + 1
    assert resources() == before
    assert IS_TRACED or memory() - start < KEPT
    tracemalloc.stop()
