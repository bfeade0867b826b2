"""The watchdog of the node, and clients of the AGV simulator's control socket."""
from __future__ import annotations

import socket
import time
from typing import List

import pytest

from fleet_simulation.agv.control_socket import AgvControlServer
from node_lifecycle.watchdog import ThreadWatch

SILENT = 2.0  # s


def test_a_client_that_says_nothing_is_no_standstill_of_the_node() -> None:
    """A silent client once blocked the node, and the watchdog asked for a restart of the simulator.
    """
    server = AgvControlServer(0, lambda line: None, dict)
    with socket.create_connection(('127.0.0.1', server.port), timeout=20.0) as connection:
        connection.sendall(b'where\n')
        assert connection.recv(100) == b'{}\n'
        watch = ThreadWatch(('graph_fleet_manager',), standstill=SILENT)
        watch.blocked(time.monotonic())
        time.sleep(1.1 * SILENT)  # the client is silent for this time
        assert watch.blocked(time.monotonic()) == []
    server.shutdown()
    server.server_close()


@pytest.mark.parametrize('first', [b'POST / HTTP/1.1', b'where / HTTP/1.0',
                                   b'POST /' + 2000 * b'a' + b' HTTP/1.1'], ids=len)
def test_a_request_of_a_web_browser_carries_out_none_of_its_lines(first) -> None:
    injected: List[str] = []
    server = AgvControlServer(0, injected.append, dict)
    with socket.create_connection(('127.0.0.1', server.port), timeout=20.0) as page:
        page.sendall(first + b'\r\nHost: 127.0.0.1\r\nOrigin: null\r\n\r\nlose r1\nwhere\n')
        assert ends_without_an_answer(page)
    server.shutdown()
    server.server_close()
    assert injected == []


def ends_without_an_answer(connection: socket.socket) -> bool:
    try:
        return connection.recv(100) == b''
    except ConnectionResetError:
        return True
