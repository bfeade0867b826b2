"""Common fixtures of the simulator's tests. Because of this file, tests can import its folder."""
from __future__ import annotations

import socket
from pathlib import Path
from typing import Iterator

import pytest
from sim_builders import ROOM


@pytest.fixture
def map_file(tmp_path: Path) -> Path:
    """A map with a room to drive in."""
    path = tmp_path / 'room.map'
    path.write_text(ROOM)
    return path


@pytest.fixture
def listener() -> Iterator[socket.socket]:
    """A program that listens: a target of the outgoing connection, or another user of a port."""
    with socket.socket() as sock:
        sock.bind(('127.0.0.1', 0))
        sock.listen(4)
        sock.settimeout(60.0)
        yield sock
