"""The REST port with clients over loopback: the password, TLS, streams, and bad clients."""
from __future__ import annotations

import asyncio
import base64
import json
import shutil
import ssl
import subprocess
from typing import Any, Awaitable, Callable, Optional

import pytest

pytest.importorskip('aiohttp')

import contextlib
import ipaddress  # noqa: E402

from aiohttp import BasicAuth, ClientError, ClientSession, TCPConnector  # noqa: E402
from test_rest_api import Site  # noqa: E402

from browser_guard.certificates import certificates_of  # noqa: E402
from omron_jobs.network import rest_port  # noqa: E402
from omron_jobs.network.rest_port import RestPort  # noqa: E402

PASSWORD = 'only-for-rest'
LOGIN = BasicAuth('toolkitadmin', PASSWORD)
HEAD = (b'GET /Job/Stream HTTP/1.1\r\nHost: a\r\nAuthorization: Basic '
        + base64.b64encode(f'toolkitadmin:{PASSWORD}'.encode()) + b'\r\n\r\n')
PATIENCE = 20.0


class Served:
    """A REST server that listens, and a client with its password."""

    def __init__(self, certificates: Optional[ssl.SSLContext] = None) -> None:
        self.site = Site()
        self.inputs = 0
        self.certificates = certificates
        self.port = RestPort(self.site.api, self.site.records, PASSWORD.encode(), (), self.count)
        self.number = 0

    def count(self) -> None:
        self.inputs += 1

    @property
    def url(self) -> str:
        return f'http{"s" if self.certificates else ""}://127.0.0.1:{self.number}'

    async def ask(self, method: str, path: str, **more: Any) -> Any:
        more.setdefault('auth', LOGIN)
        async with ClientSession(connector=TCPConnector(force_close=True)) as session, \
                session.request(method, self.url + path, **more) as answer:
            return answer.status, json.loads(await answer.read())


def served(act: Callable[[Served], Awaitable[None]],
           certificates: Optional[ssl.SSLContext] = None) -> None:
    async def run() -> None:
        one = Served(certificates)
        one.number = await one.port.open('127.0.0.1', 0, certificates)
        try:
            await asyncio.wait_for(act(one), PATIENCE)
        finally:
            one.port.close()
    asyncio.run(run())


def test_a_job_is_queued_and_watched(monkeypatch):
    monkeypatch.setattr(rest_port, 'SIGN_OF_LIFE', 0.05)

    async def act(one: Served) -> None:
        async with ClientSession(auth=LOGIN) as session, \
                session.get(one.url + '/JobSegment/Stream') as stream:
            assert stream.headers['Content-Type'] == 'text/event-stream'
            assert await stream.content.readline() == b': begins\n'
            status, made = await one.ask('POST', '/Pickup', json={'goal': 'x'})
            assert (status, made['assignedJobId'], one.inputs) == (201, 'JOB1', 1)
            line = b''
            while not line.startswith(b'data:'):
                line = await stream.content.readline()
            assert json.loads(line[5:]) == one.site.ask('/JobSegment/ByKey/PICKUP1')
            assert await stream.content.readline() == b'\n'
            while line != b':\n':  # a sign of life
                line = await stream.content.readline()
        status, found = await one.ask('GET', '/Job/UpdatedSince?sinceTime=0')
        assert status == 200 and [job['jobId'] for job in found] == ['JOB1']
    served(act)


@pytest.mark.parametrize('more, status', [
    ({'auth': None}, 401), ({'auth': BasicAuth('toolkitadmin', 'wrong')}, 401),
    ({'auth': BasicAuth('admin', PASSWORD)}, 401),
    ({'auth': None, 'headers': {'Authorization': 'Basic \u00e4'}}, 401),
    ({'headers': {'Origin': 'http://elsewhere'}}, 403),
    ({'headers': {'Sec-Fetch-Mode': 'cors'}}, 403)])
def test_nobody_without_the_password_and_no_browser_queues_a_job(monkeypatch, more, status):
    monkeypatch.setattr(rest_port, 'HELD_BACK', 0.0)

    async def act(one: Served) -> None:
        found, record = await one.ask('POST', '/Pickup', json={'goal': 'x'}, **more)
        assert found == record['status'] == status and PASSWORD not in record['message']
        assert not one.site.book.jobs and one.inputs == 0
    served(act)


def test_a_request_that_is_too_large_or_compressed_is_refused():
    async def act(one: Served) -> None:
        status, _ = await one.ask('POST', '/Pickup', data=b' ' * (rest_port.LARGEST_REQUEST + 1))
        assert status == 413
        status, _ = await one.ask('POST', '/Pickup', json={'goal': 'x'}, compress='deflate')
        assert status == 415
        assert not one.site.book.jobs
        assert (await one.ask('POST', '/Pickup', json={'goal': 'x'}))[0] == 201
    served(act)


def test_a_connection_of_another_address_is_ended(monkeypatch):
    monkeypatch.setattr(rest_port, 'is_peer', lambda address, peers: False)

    async def act(one: Served) -> None:
        with pytest.raises((ClientError, ConnectionError)):
            await one.ask('GET', '/Job/UpdatedSince?sinceTime=0')
    served(act)


def test_the_peers_are_those_of_the_port():
    network = ipaddress.ip_network('10.1.0.0/16')
    assert rest_port.is_peer('10.1.2.3', (network,))
    assert not rest_port.is_peer('10.2.0.1', (network,))


def test_a_client_that_reads_no_stream_loses_only_its_own_connection(monkeypatch):
    monkeypatch.setattr(rest_port, 'MOST_UNREAD', 2000)

    async def act(one: Served) -> None:
        _, slow = await asyncio.open_connection('127.0.0.1', one.number, limit=1)
        slow.write(HEAD)
        async with ClientSession(auth=LOGIN) as session, \
                session.get(one.url + '/Goal/Stream') as other:
            await other.content.readline()
            while len(one.port._streams) < 2:
                await asyncio.sleep(0.01)
            for _ in range(40):  # without a pause, so that nothing is written in between
                one.site.made('/Pickup', {'goal': 'x'})
            while len(one.port._streams) > 1:
                await asyncio.sleep(0.01)
            one.site.site.goals = {'x': 1, 'new': 9}
            one.site.records.refresh()
            line = b''
            while b'new' not in line:
                line = await other.content.readline()
        slow.close()
        assert len(one.site.book.jobs) == 40
    served(act)


def test_a_request_that_does_not_come_ends_its_connection(monkeypatch):
    monkeypatch.setattr(rest_port, 'REQUEST_TIME', 0.1)

    async def act(one: Served) -> None:
        for begin in (b'', b'POST /Pickup HTTP/1.1\r\n', HEAD.replace(
                b'GET /Job/Stream', b'POST /Pickup').replace(
                b'Host: a', b'Host: a\r\nContent-Length: 50')):
            reader, writer = await asyncio.open_connection('127.0.0.1', one.number)
            writer.write(begin)
            with contextlib.suppress(ConnectionError):
                assert await reader.read() == b''
            writer.close()
        assert not one.port._connections and not one.site.book.jobs
    served(act)


def test_there_is_a_limit_of_clients_and_of_streams(monkeypatch):
    monkeypatch.setattr(rest_port, 'MOST_CLIENTS', 3)
    monkeypatch.setattr(rest_port, 'MOST_STREAMS', 1)

    async def act(one: Served) -> None:
        async with ClientSession(auth=LOGIN) as session, \
                session.get(one.url + '/Job/Stream') as stream:
            await stream.content.readline()
            assert (await one.ask('GET', '/Job/Stream'))[0] == 500
            idle = [await asyncio.open_connection('127.0.0.1', one.number) for _ in range(2)]
            while len(one.port._connections) < 3:
                await asyncio.sleep(0.01)
            with pytest.raises((ClientError, ConnectionError)):
                await one.ask('GET', '/Job/UpdatedSince')
            for _, writer in idle:
                writer.close()
            while len(one.port._connections) > 1:
                await asyncio.sleep(0.01)
            assert (await one.ask('GET', '/Job/UpdatedSince'))[0] == 200
    served(act)


@pytest.mark.parametrize('data', [
    b'\0' * 9000, b'GET \xff\xfe HTTP/1.1\r\n\r\n', b'A' * 70000, b'POST / HTTP/9.9\r\n\r\n',
    b'GET /Job/ByKey/%00%ff%zz HTTP/1.1\r\nHost: a\r\n\r\n', b'queuePickup x\r\n'])
def test_no_bytes_end_the_server_or_make_a_job(monkeypatch, data):
    monkeypatch.setattr(rest_port, 'REQUEST_TIME', 0.2)
    monkeypatch.setattr(rest_port, 'HELD_BACK', 0.0)

    async def act(one: Served) -> None:
        reader, writer = await asyncio.open_connection('127.0.0.1', one.number)
        writer.write(data)
        with contextlib.suppress(ConnectionError):
            assert b' 200 ' not in await reader.read()
        writer.close()
        assert (await one.ask('GET', '/Job/UpdatedSince'))[0] == 200
        assert not one.site.book.jobs
    served(act)


@pytest.mark.skipif(shutil.which('openssl') is None, reason='openssl is not installed')
def test_it_is_served_by_tls(tmp_path):
    certificate, key = str(tmp_path / 'rest.pem'), str(tmp_path / 'rest.key')
    subprocess.run(
        ['openssl', 'req', '-x509', '-newkey', 'ec', '-pkeyopt', 'ec_paramgen_curve:prime256v1',
         '-days', '2', '-subj', '/CN=localhost', '-addext', 'subjectAltName=IP:127.0.0.1', '-nodes',
         '-out', certificate, '-keyout', key], check=True, stderr=subprocess.DEVNULL)

    async def act(one: Served) -> None:
        trust = ssl.create_default_context(cafile=certificate)
        assert (await one.ask('POST', '/Pickup', json={'goal': 'x'}, ssl=trust))[0] == 201
        reader, writer = await asyncio.open_connection('127.0.0.1', one.number)
        writer.write(HEAD)
        with contextlib.suppress(ConnectionError):
            assert b'HTTP' not in await reader.read()
        writer.close()
    served(act, certificates_of(certificate, key))
