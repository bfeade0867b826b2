"""The port, with clients over loopback: the clients that may connect, and bad clients."""
from __future__ import annotations

import asyncio
import contextlib
from typing import Awaitable, Callable, Tuple

import pytest
from job_fleet import Disk

from omron_jobs.core.client_session import JobServer
from omron_jobs.core.job_book import JobBook, JobCounters
from omron_jobs.core.job_commands import JobCommands, JobSite
from omron_jobs.network import job_port
from omron_jobs.network.job_port import JobPort, WrongPeer, is_peer, read_peers

Streams = Tuple[asyncio.StreamReader, asyncio.StreamWriter]
PATIENCE = 20.0


def with_port(act: Callable[[JobPort, int], Awaitable[None]]) -> None:
    """Calls `act` with a job server that listens."""
    async def run() -> None:
        site = JobSite()
        site.goals = {'x': 1}
        ids = iter(range(1, 10 ** 6))
        book = JobBook((), JobCounters(), Disk(), lambda: 1, lambda: next(ids))
        port = JobPort(JobServer(JobCommands(book, site), b'secret'), (), lambda: None)
        number = await port.open('127.0.0.1', 0)
        try:
            await asyncio.wait_for(act(port, number), PATIENCE)
        finally:
            port.close()
    asyncio.run(run())


async def log_in(number: int) -> Streams:
    reader, writer = await asyncio.open_connection('127.0.0.1', number)
    writer.write(b'secret\n')
    await reader.readuntil(b'End of commands\r\n')
    return reader, writer


def test_a_client_logs_in_queues_a_job_and_leaves():
    async def act(port: JobPort, number: int) -> None:
        reader, writer = await log_in(number)
        writer.write(b'queuePickup x\r\nqui')
        assert (await reader.readline()).startswith(b'queuepickup goal "x" with priority 10 ')
        assert (await reader.readline()).startswith(b'QueueUpdate: PICKUP1 JOB1 10 Pending None ')
        writer.write(b't\r\n')
        assert await reader.read() == b'Closing connection\r\n'
        assert port.server.sessions == []
        writer.close()
    with_port(act)


@pytest.mark.parametrize('first', [b'wrong\n', b'GET / HTTP/1.1\r\n', b'\0' * 6000])
def test_without_the_password_the_connection_ends(first):
    async def act(port: JobPort, number: int) -> None:
        reader, writer = await asyncio.open_connection('127.0.0.1', number)
        writer.write(first)
        try:
            told = await reader.read()
        except ConnectionResetError:
            told = b'Enter password:\r\n'
        assert told.startswith(b'Enter password:\r\n') and b'Welcome' not in told
        writer.close()
    with_port(act)


def test_a_client_that_does_not_log_in_is_not_waited_for(monkeypatch):
    monkeypatch.setattr(job_port, 'LOGIN_TIME', 0.05)

    async def act(port: JobPort, number: int) -> None:
        reader, writer = await asyncio.open_connection('127.0.0.1', number)
        assert await reader.read() == b'Enter password:\r\n'
        writer.close()
    with_port(act)


def test_a_client_that_reads_nothing_loses_its_own_connection_only(monkeypatch):
    monkeypatch.setattr(job_port, 'MOST_UNREAD', 20_000)

    async def act(port: JobPort, number: int) -> None:
        stalled, good = await log_in(number), await log_in(number)
        with contextlib.suppress(ConnectionError):  # the server ends the connection
            while len(port.server.sessions) == 2:
                stalled[1].write(b'help\n' * 10)
                await stalled[1].drain()
                await asyncio.sleep(0)
        good[1].write(b'getGoals\n')
        assert await good[0].readline() == b'Goal: x\r\n'
        stalled[1].close()
        good[1].close()
    with_port(act)


@pytest.mark.parametrize('address, peers, is_one', [
    ('127.0.0.1', '', True), ('::1', '', True), ('::ffff:127.0.0.1', '', True),
    ('10.0.0.7', '', False), ('10.0.0.7', '10.0.0.7', True), ('10.0.0.7', '10.0.0.8', False),
    ('10.0.0.7', '10.0.1.0/24, 10.0.0.0/24', True), ('::ffff:10.0.0.7', '10.0.0.7', True),
    ('fe80::1%eth0', 'fe80::/10', True), ('fe80::1', '10.0.0.0/8', False)])
def test_peers_are_loopback_and_what_is_configured(address, peers, is_one):
    assert is_peer(address, read_peers(peers)) is is_one


@pytest.mark.parametrize('text', ['host', '10.0.0.7/24', '300.0.0.1', '10.0.0.1 x'])
def test_a_wrong_peer_is_named(text):
    with pytest.raises(WrongPeer, match='neither an address nor a network'):
        read_peers(text)
