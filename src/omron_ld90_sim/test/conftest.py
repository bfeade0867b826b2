"""Common fixtures of the simulator's tests. This file also makes its folder importable."""
from __future__ import annotations

import socket
from pathlib import Path
from typing import Iterator

import pytest
from sim_builders import ROOM


@pytest.fixture
def map_file(tmp_path: Path) -> Path:
    """Returns a map with a room to drive in."""
    path = tmp_path / 'room.map'
    path.write_text(ROOM)
    return path


@pytest.fixture
def listener() -> Iterator[socket.socket]:
    """Yields a listening socket: the target of the outgoing connection, or the user of a port."""
    with socket.socket() as sock:
        sock.bind(('127.0.0.1', 0))
        sock.listen(4)
        sock.settimeout(60.0)
        yield sock
