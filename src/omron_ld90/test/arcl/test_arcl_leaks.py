"""A thousand connections leave nothing behind: no thread, no descriptor, no memory."""
from __future__ import annotations

import gc
import os
import socket
import threading
import tracemalloc

from arcl_builders import PASSWORD, STATUS, Noted, ScriptedRobot, lines, wait_for

from omron_ld90.arcl import Backoff, Client, Listener, Outcome

RECONNECTS = 1000
KEPT = 200_000  # bytes that may stay: caches of the interpreter


def resources() -> tuple:
    gc.collect()
    return threading.active_count(), len(os.listdir('/proc/self/fd'))


def memory() -> int:
    gc.collect()
    return tracemalloc.get_traced_memory()[0]


class NoBackoff(Backoff):
    """For tests that reconnect a thousand times."""

    def after(self, cause: Exception) -> float:
        return 0.0


def test_a_client_that_reconnects_a_thousand_times_leaks_nothing():
    with ScriptedRobot() as robot:
        before = resources()
        lost = Noted()
        client = Client('127.0.0.1', robot.port, PASSWORD, backoff=NoBackoff(),
                        on_login=lambda _: client.execute('goto 12', on_end=lost))
        with client:
            for number in range(RECONNECTS):
                wait_for(lambda number=number: robot.heard.count(b'goto 12') == number + 1,
                         f'login {number}', 10.0)
                robot.drop()
                if number == 99:
                    tracemalloc.start()
                    start = memory()
            wait_for(lambda: len(lost.all) >= RECONNECTS, 'the end of every command')
            during = resources()
        assert {result.outcome for result in lost.all[:RECONNECTS]} == {Outcome.LOST}
        lost.all.clear()
        robot.heard.clear()
        wait_for(lambda: all(c.fileno() < 0 for c in robot.connections), 'the robot to close all')
        robot.forget_closed()
        wait_for(lambda: resources()[1] <= before[1] + 1, f'descriptors; before {before}, during '
                 f'{during}, now {resources()}')
        assert during[0] <= before[0] + 2
        assert memory() - start < KEPT
        tracemalloc.stop()


def test_a_listener_to_which_the_robot_connects_a_thousand_times_leaks_nothing():
    received = Noted()
    before = resources()
    tracemalloc.start()
    start = memory()
    with Listener('127.0.0.1', 0, '127.0.0.1', on_line=received) as listener:
        for number in range(RECONNECTS):
            with socket.create_connection(('127.0.0.1', listener.port)) as robot:
                robot.sendall(lines(*STATUS))
                wait_for(lambda number=number: len(received.all) == (number + 1) * len(STATUS),
                         f'the status of connection {number}')
        assert resources()[0] == before[0] + 1
    received.all.clear()
    assert resources() == before
    assert memory() - start < KEPT
    tracemalloc.stop()
