"""The loop serves sockets and the clock in turn, so no socket keeps the clock waiting for long."""
from __future__ import annotations

import socket
from typing import List, Tuple

import pytest

from omron_ld90_sim.clock import SimClock
from omron_ld90_sim.interface import loop as loop_module
from omron_ld90_sim.interface.loop import LONGEST_ROUND, Loop


class WallClock:
    """The clock of the computer: it advances only while a socket is served."""

    def __init__(self) -> None:
        self.now = 100.0

    def monotonic(self) -> float:
        return self.now


def ready_pairs(count: int) -> List[Tuple[socket.socket, socket.socket]]:
    pairs = [socket.socketpair() for _ in range(count)]
    for _, theirs in pairs:
        theirs.send(b'.')
    return pairs


def test_inputs_that_take_long_do_not_keep_statuses_waiting(
        monkeypatch: pytest.MonkeyPatch) -> None:
    wall = WallClock()
    monkeypatch.setattr(loop_module, 'time', wall)
    clock, happened = SimClock(), []
    loop = Loop(clock, 1.0)
    pairs = ready_pairs(8)

    def plan(ours: socket.socket) -> None:
        ours.recv(1)
        wall.now += 0.08    # s; a robot needs this time to plan a path
        happened.append('planned')
        if happened.count('planned') == len(pairs):
            loop.stop()

    def status() -> None:
        happened.append('status')
        clock.after(0.1, status)
    clock.after(0.1, status)
    for ours, _ in pairs:
        loop.selector.register(ours, loop_module.selectors.EVENT_READ,
                               lambda mask, ours=ours: plan(ours))
    loop.run()
    loop.close()
    between = ' '.join(happened).split('status')
    most = max(part.split().count('planned') for part in between)
    assert most <= LONGEST_ROUND / 0.08 + 1, happened
    assert happened.count('planned') == 8, 'each input is served'
    for _, theirs in pairs:
        theirs.close()
