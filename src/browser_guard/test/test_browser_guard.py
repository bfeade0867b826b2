"""Requests of browsers and requests of programs differ in parts that neither can leave out."""
from __future__ import annotations

import re
from pathlib import Path
from typing import List

import pytest
from hypothesis import given
from hypothesis import strategies as st

from browser_guard import LARGEST_BODY, OwnHosts, is_http_request, reason_to_refuse

PROGRAM = {'Host': 'fleet:11311', 'Content-Type': 'text/xml', 'Content-Length': '200',
           'User-Agent': 'Python-xmlrpc/3.8'}
LOOKED_UP: List[str] = []


def looked_up() -> str:
    LOOKED_UP.append('once')
    return 'fleet.factory.example'


HOSTS = OwnHosts({'ROS_MASTER_URI': 'http://master.factory.example:11311',
                  'ROS_HOSTNAME': 'controller.other.example'}, lambda: 'Fleet', looked_up)


def refused(method: str = 'POST', **changes) -> object:
    headers = {**PROGRAM, **{name.replace('_', '-'): value for name, value in changes.items()}}
    return reason_to_refuse(method, [(k, v) for k, v in headers.items() if v is not None], HOSTS)


@pytest.mark.every_python
def test_a_request_of_a_program_is_accepted():
    assert refused() is None
    assert refused(Content_Type='text/xml; charset=utf-8') is None
    assert refused(Host=None) is None, 'HTTP/1.0 has no Host, and every browser sends it'


@pytest.mark.every_python
@pytest.mark.parametrize('headers', [
    {'Origin': 'http://evil.example'}, {'Origin': 'null'}, {'origin': ''},
    {'Sec_Fetch_Site': 'cross-site'}, {'Sec_Fetch_Mode': 'no-cors'}, {'sec_ch_ua': '"Chromium"'},
    {'Content_Type': 'text/plain;charset=UTF-8'}, {'Content_Type': None},
    {'Content_Type': 'application/x-www-form-urlencoded'}, {'Content_Type': 'text/xmlish'},
    {'Content_Type': 'multipart/form-data; boundary=text/xml'},
    {'Host': 'evil.example:11311'}, {'Host': 'fleet.evil.example'},
    {'Host': '127.0.0.1.evil.example'},
    {'Host': 'fleet.local.evil.example:11311'}, {'Host': '1.2.3.4%evil.example'},
], ids=str)
def test_what_a_page_lets_a_browser_send_is_refused(headers):
    assert refused(**headers)


@pytest.mark.every_python
@pytest.mark.parametrize('method', ['GET', 'OPTIONS', 'HEAD', 'PUT', 'DELETE', 'post'])
def test_only_post_is_accepted(method):
    assert 'POST' in str(refused(method))


@pytest.mark.every_python
@pytest.mark.parametrize('host', [
    '127.0.0.1:11311', '10.0.0.5', '192.168.7.1:45123', '[::1]:11311', '[fe80::1%eth0]:11311',
    '[fe80::2]', '::1', 'localhost:11311', 'LOCALHOST', 'robots.localhost:1', 'fleet:11311',
    'Fleet', 'fleet.', 'robot-7:11311', 'fleet.local:11311', 'master.factory.example:11311',
    'controller.other.example:40001', 'fleet.factory.example:11311',
])
def test_programs_reach_the_computer_by_every_address_and_by_its_names(host):
    assert refused(Host=host) is None


@pytest.mark.every_python
def test_a_full_name_is_looked_up_only_if_no_other_rule_fits():
    LOOKED_UP.clear()
    for host in ('10.0.0.5:1', 'fleet:1', 'fleet.local', 'master.factory.example'):
        assert host in HOSTS
    assert not LOOKED_UP
    assert 'evil.example' not in HOSTS
    assert LOOKED_UP


@pytest.mark.every_python
@pytest.mark.parametrize('length', [None, '', '-1', '1e3', str(LARGEST_BODY + 1), '9' * 400, '١٢'])
def test_a_body_without_a_sensible_length_is_refused(length):
    assert 'length' in str(refused(Content_Length=length))
    assert refused(Content_Length=str(LARGEST_BODY)) is None


@given(st.from_regex(r'[a-z0-9-]{1,9}(\.[a-z0-9-]{1,9}){0,2}\.[a-z]{2,8}\.?(:[0-9]{1,5})?',
                     fullmatch=True).filter(lambda host: '.localhost' not in host))
def test_no_other_name_with_a_dot_is_accepted(host):
    assert host not in OwnHosts({}, lambda: 'FLEET', lambda: 'FLEET.EXAMPLE')


@given(st.text(max_size=60))
def test_no_text_in_the_header_host_raises_an_error(host):
    assert (host in HOSTS) in (True, False)


@pytest.mark.every_python
@pytest.mark.parametrize('line', [
    b'POST / HTTP/1.1\r\n', b'GET /where HTTP/1.0\n', b'OPTIONS * HTTP/1.1', b'where / HTTP/1.1\r',
    b'POST /RPC2?speed=2 HTTP/2\r\n', b'PRI * HTTP/2.0\r\n'])
def test_the_first_line_of_an_http_request_is_recognised(line):
    assert is_http_request(line)


@pytest.mark.every_python
@pytest.mark.parametrize('line', [
    b'', b'\r\n', b'where', b'speed 2', b'Status: Stopped', b'goto 7', b'HTTP/1.1 400 Bad Request',
    b'say POST / HTTP/1.1 now', b'EStop: HTTP/1.1', b'Goal: a b c HTTP/1.1'])
def test_lines_of_other_protocols_are_none(line):
    assert not is_http_request(line)


SOURCES = Path(__file__).resolve().parents[2]
LISTENS = re.compile(r'\.listen\(\w|create_server\(|TCPServer\)|start_server\(|TCPSite\(')
#: Packages that listen but need neither is_http_request nor is_from_browser, each with the reason.
OTHERWISE = {
    'fleet_page': 'it serves browsers',
    'node_host': 'a browser cannot use a Unix socket',
    'node_lifecycle': 'a connection of a topic begins with a header: see bounded_messages',
    'omron_arcl': 'the session of a connection recognises them',
}
KNOWS = re.compile(r'is_http_request\(|is_from_browser\(')
#: As on the real robot, the first line on this connection is the password.
ROBOT = 'omron_ld90_sim/src/omron_ld90_sim/interface/transport.py'


def test_every_program_that_listens_knows_browsers():
    listening = {str(file.relative_to(SOURCES)): file.read_text(encoding='utf-8')
                 for file in SOURCES.glob('*/src/**/*.py')
                 if LISTENS.search(file.read_text(encoding='utf-8'))}
    assert len(listening) >= 6
    forgotten = [name for name, text in listening.items()
                 if not KNOWS.search(text) and name != ROBOT
                 and name.split('/')[0] not in OTHERWISE]
    assert not forgotten, 'it must ask is_http_request or is_from_browser'
