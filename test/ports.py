#!/usr/bin/env python3
"""Free TCP ports for tests: call `free_port()`, or run this file, which prints a port.

The ports are below the range that the kernel uses for outgoing connections. Another program's
outgoing connection could take a port in that range before the test uses it.
"""
from __future__ import annotations

import random
import socket
from typing import Set

RANGE = range(20000, 30000)     # Linux takes 32768 to 60999 for outgoing connections
_given: Set[int] = set()


def free_port(address: str = '127.0.0.1') -> int:
    """Returns a port of `address` that is not in use. Each call returns another port."""
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
