"""rospy's topic connections work even if many nodes start at once."""
from __future__ import annotations

import socket
import threading
from contextlib import ExitStack
from pathlib import Path
from typing import Dict, List

import pytest
from rosgraph.network import write_ros_handshake_header
from rospy.impl.masterslave import ROSHandler
from rospy.impl.tcpros_base import TCPROSServer, TCPServer

from node_lifecycle import topic_connections
from node_lifecycle.topic_connections import one_at_a_time

MANY = 60
SOURCES = Path(__file__).resolve().parents[3]


class Subscriber:
    """Connects like rospy: looks for a connection, asks the publisher, and makes a connection."""

    def __init__(self) -> None:
        self.made: List[str] = []
        self.asked: Dict[str, int] = {}
        self.answer = threading.Event()
        self.asking = threading.Semaphore(0)

    def connect(self, topic: str, publisher: str) -> None:
        """Replaces rospy's function `_connect_topic`."""
        if publisher in self.made:
            return
        self.asked[publisher] = self.asked.get(publisher, 0) + 1
        self.asking.release()
        assert self.answer.wait(10.0)
        self.made.append(publisher)


def test_a_publisher_that_is_told_of_twice_is_connected_to_once():
    one = Subscriber()
    connect = one_at_a_time(Subscriber.connect)
    threads = [threading.Thread(target=connect, args=(one, '/graph', 'http://a')) for _ in range(5)]
    for thread in threads:
        thread.start()
    assert one.asking.acquire(timeout=10.0)
    one.answer.set()
    for thread in threads:
        thread.join(10.0)
    assert (one.made, one.asked) == (['http://a'], {'http://a': 1})


def test_a_publisher_that_does_not_answer_keeps_no_other_one_waiting():
    one = Subscriber()
    connect = one_at_a_time(Subscriber.connect)
    threads = [threading.Thread(target=connect, args=(one, '/graph', f'http://{name}'))
               for name in 'ab']
    for thread in threads:
        thread.start()
    assert one.asking.acquire(timeout=10.0)
    assert one.asking.acquire(timeout=10.0), 'the second publisher had to wait for the first one'
    one.answer.set()
    for thread in threads:
        thread.join(10.0)


def test_many_connections_may_wait_for_a_node_that_is_busy(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv('ROS_IP', '127.0.0.1')
    topic_connections.mend()
    server = TCPServer(lambda *_: None)  # the server does not run, so it accepts no connection
    with ExitStack() as stack:
        stack.callback(server.server_sock.close)
        for _ in range(MANY):
            stack.enter_context(socket.create_connection(('127.0.0.1', server.port), 0.5))


@pytest.mark.parametrize('words', [b'', b'POST /RPC2 HTTP/1.1\r\nHost: localhost\r\n\r\n'])
def test_a_client_that_sends_no_header_keeps_no_other_one_out(words: bytes,
                                                               monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv('ROS_IP', '127.0.0.1')
    topic_connections.mend()
    server, welcomed = TCPROSServer(), threading.Event()
    server.topic_connection_handler = lambda *_: welcomed.set()
    server.start_server()
    address = '127.0.0.1', server.get_address()[1]
    with ExitStack() as stack:
        stack.callback(server.shutdown)
        silent, subscriber = (stack.enter_context(socket.create_connection(address, 5.0))
                              for _ in range(2))
        silent.sendall(words)
        write_ros_handshake_header(subscriber, {'topic': '/graph', 'callerid': '/test'})
        assert welcomed.wait(5.0), 'the subscriber had to wait for the silent client'


def test_to_mend_twice_changes_nothing():
    topic_connections.mend()
    mended = ROSHandler._connect_topic, TCPServer._create_server_sock
    topic_connections.mend()
    assert mended == (ROSHandler._connect_topic, TCPServer._create_server_sock)


def test_each_program_becomes_a_node_by_this_package():
    others = [str(path) for path in SOURCES.glob('*/src/**/*.py')
              if 'rospy.init_node(' in path.read_text() and path.name != 'log_file.py']
    assert others == []
