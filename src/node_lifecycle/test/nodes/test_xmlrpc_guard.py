"""The XML-RPC servers of ROS answer programs, but do nothing for a web page."""
from __future__ import annotations

import http.client
import logging
import socket
import threading
import xmlrpc.client
from typing import Any, Dict, Iterator, List

import pytest
import rosgraph.xmlrpc

import xmlrpc_guard
from xmlrpc_guard import GuardedRequestHandler, guard_servers

#: Headers that Chromium adds to `fetch(url, {method: 'POST', mode: 'no-cors', body: text})`.
#: Chromium leaves out Sec-Fetch-* if the address is not "potentially trustworthy", i.e. not
#: loopback.
FETCH = {'Content-Type': 'text/plain;charset=UTF-8', 'Origin': 'http://evil.example',
         'Sec-Fetch-Site': 'cross-site', 'Sec-Fetch-Mode': 'no-cors', 'Sec-Fetch-Dest': 'empty',
         'Accept': '*/*', 'Referer': 'http://evil.example/', 'User-Agent': 'Mozilla/5.0'}
CALLS = {
    'registerPublisher': ('/page', '/mission_request', 'itrci_nav_msgs/MissionRequest',
                          'http://127.0.0.1:9/'),
    'setParam': ('/page', '/path_supervisor/speed', 9),
    'shutdown': ('/page', 'for fun'),
    'system.multicall': ([{'methodName': 'shutdown', 'params': ['/page', 'for fun']}],),
}


class Handler(rosgraph.xmlrpc.XmlRpcHandler):
    """Records the calls that are carried out."""

    def __init__(self) -> None:
        self.calls: List[str] = []
        self.is_ready = threading.Event()

    def _ready(self, uri: str) -> None:
        self.is_ready.set()

    def _dispatch(self, name: str, arguments: Any) -> Any:
        self.calls.append(name)
        return [1, name, len(arguments)]


@pytest.fixture(name='server', scope='module')
def _server() -> Iterator[rosgraph.xmlrpc.XmlRpcNode]:
    node = rosgraph.xmlrpc.XmlRpcNode(0, Handler())
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv('ROS_IP', '127.0.0.1')
        patch.setenv('ROS_MASTER_URI', 'http://127.0.0.1:11311')
        patch.setattr(rosgraph.xmlrpc, 'SilenceableXMLRPCRequestHandler', None)
        guard_servers()
        node.start()
        assert node.handler.is_ready.wait(10)
        yield node
    node.is_shutdown = True  # `shutdown` only closes the socket; the loop would run for ever
    node.server.shutdown()
    node.shutdown('the end of the tests')


@pytest.fixture(name='handler')
def _handler(server) -> Handler:
    server.handler.calls.clear()
    return server.handler


@pytest.fixture(name='port')
def _port(server, monkeypatch) -> int:
    monkeypatch.setattr(GuardedRequestHandler, '_next_log', 0.0)
    return server.port


def sent(port: int, headers: Dict[str, str], method: str = 'POST', call: str = 'setParam') -> int:
    """Sends the call as a browser would send it. Returns the status of the answer."""
    connection = http.client.HTTPConnection('127.0.0.1', port, timeout=10)
    try:
        connection.request(method, '/', xmlrpc.client.dumps(CALLS[call], call), headers)
        return connection.getresponse().status
    finally:
        connection.close()


@pytest.mark.parametrize('call', CALLS)
def test_a_fetch_of_a_foreign_page_calls_nothing(port, handler, call):
    assert sent(port, FETCH, call=call) == 403
    assert handler.calls == []


@pytest.mark.parametrize('header', ['Origin', 'Sec-Fetch-Site', 'Content-Type'])
def test_each_sign_of_a_browser_is_enough(port, handler, header):
    assert sent(port, {'Content-Type': 'text/xml', header: FETCH[header]}) == 403
    assert handler.calls == []


@pytest.mark.parametrize('method', ['GET', 'OPTIONS', 'PUT', 'HEAD', 'POST'])
def test_a_name_that_was_bound_to_this_address_anew_is_refused(port, handler, method):
    assert sent(port, {'Content-Type': 'text/xml', 'Host': f'evil.example:{port}'}, method) == 403
    assert handler.calls == []


def test_a_form_without_a_script_is_refused(port, handler):
    form = {**FETCH, 'Content-Type': 'text/plain', 'Sec-Fetch-Mode': 'navigate', 'Origin': 'null'}
    assert sent(port, form) == 403
    assert handler.calls == []


def test_nothing_behind_a_refused_request_is_carried_out(port, handler):
    body = xmlrpc.client.dumps(CALLS['setParam'], 'setParam').encode()
    good = (b'POST / HTTP/1.1\r\nHost: localhost\r\nContent-Type: text/xml\r\n'
            b'Content-Length: %d\r\n\r\n%s' % (len(body), body))
    with socket.create_connection(('127.0.0.1', port), 10) as page:
        page.sendall(b'POST / HTTP/1.1\r\nHost: localhost\r\nOrigin: null\r\nContent-Length: %d\r\n'
                     b'\r\n%s' % (len(good), good))
        answer = b''
        while True:
            try:
                piece = page.recv(4096)
            except ConnectionResetError:
                break
            if not piece:
                break
            answer += piece
    assert answer.startswith(b'HTTP/1.1 403') or not answer
    assert handler.calls == []


def test_an_endless_body_is_not_collected(port, handler):
    with socket.create_connection(('127.0.0.1', port), 10) as page:
        page.sendall(b'POST / HTTP/1.1\r\nHost: localhost\r\nContent-Type: text/xml\r\n'
                     b'Content-Length: 9999999999\r\n\r\n')
        assert page.recv(4096).startswith(b'HTTP/1.1 403')
    assert handler.calls == []


@pytest.mark.parametrize('host', ['127.0.0.1', 'localhost'])
def test_programs_are_answered_on_one_connection(port, handler, host):
    with xmlrpc.client.ServerProxy(f'http://{host}:{port}/') as program:
        assert program.setParam(*CALLS['setParam']) == [1, 'setParam', 3]
        assert program.getPid('/me') == [1, 'getPid', 1]
    assert handler.calls == ['setParam', 'getPid']


def test_the_log_names_the_first_refusal_only(port, caplog, monkeypatch):
    monkeypatch.setattr(xmlrpc_guard, '_LOG_PERIOD', 1000.0)
    with caplog.at_level(logging.WARNING, 'xmlrpc'):
        for _ in range(5):
            sent(port, {'Content-Type': 'text/xml', 'Host': 'evil.example\x1b[2J'})
    lines = [record.getMessage() for record in caplog.records if record.name == 'xmlrpc']
    assert len(lines) == 1
    assert '127.0.0.1' in lines[0] and 'evil.example' in lines[0] and '\x1b' not in lines[0]
