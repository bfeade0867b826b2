#!/usr/bin/env python3
"""Free TCP ports for tests: `free_port()`, or run as a program, which prints one.

They lie below the range that the kernel takes for outgoing connections: a port of that range may
be another program's outgoing one by the time it is used, if only for a moment.
"""
from __future__ import annotations

import random
import socket
from typing import Set

RANGE = range(20000, 30000)     # Linux takes 32768 to 60999 for outgoing connections
_given: Set[int] = set()


def free_port(address: str = '127.0.0.1') -> int:
    """A port of `address` that nothing uses now, another one at each call."""
    for port in random.sample(RANGE, len(RANGE)):
        if port in _given:
            continue
        with socket.socket() as probe:
            try:
                probe.bind((address, port))
            except OSError:
                continue
        _given.add(port)
        return port
    raise RuntimeError(f'no free port in {RANGE}')


if __name__ == '__main__':
    print(free_port())
