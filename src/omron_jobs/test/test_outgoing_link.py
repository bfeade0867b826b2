"""The outgoing connection, with programs on loopback that accept, leave, and do not read."""
from __future__ import annotations

import asyncio
from typing import Awaitable, Callable, Tuple

import pytest
from test_job_port import log_in, with_port

from omron_jobs.network import job_port, outgoing_link
from omron_jobs.network.job_port import JobPort
from omron_jobs.network.outgoing_link import DialledAddress, DialledLink

Streams = Tuple[asyncio.StreamReader, asyncio.StreamWriter]


class Program:
    """A program that listens."""

    def __init__(self) -> None:
        self.port = 0
        self._accepted: asyncio.Queue[Streams] = asyncio.Queue()

    async def listen(self) -> None:
        async def accept(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            self._accepted.put_nowait((reader, writer))
        self._server = await asyncio.start_server(accept, '127.0.0.1', self.port)
        self.port = self._server.sockets[0].getsockname()[1]

    async def connection(self) -> Streams:
        return await self._accepted.get()

    async def leave(self) -> None:
        self._server.close()


@pytest.fixture(autouse=True)
def _dials_soon(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(outgoing_link, 'RETRY', 0.01)


def with_link(act: Callable[[JobPort, int, Program, DialledLink], Awaitable[None]],
              *commands: str) -> None:
    """Calls `act` with a job server that dials to a program."""
    async def run(port: JobPort, number: int) -> None:
        program = Program()
        await program.listen()
        link = DialledLink(port, DialledAddress(
            '127.0.0.1', program.port, commands, 0.02 if commands else 0.0))
        link.start()
        try:
            await act(port, number, program, link)
        finally:
            link.close()
            await program.leave()
    with_port(run)



def test_the_program_is_a_client_without_login_and_hears_of_the_jobs_of_others():
    async def act(port: JobPort, number: int, program: Program, link: DialledLink) -> None:
        reader, writer = await program.connection()
        writer.write(b'queuePickup x 10 mine\r\n')
        assert (await reader.readline()).startswith(b'queuepickup goal "x" with priority 10 ')
        assert (await reader.readline()).startswith(b'QueueUpdate: PICKUP1 mine 10 Pending ')
        assert link.trouble == ''
        other = await log_in(number)
        other[1].write(b'queuePickup x\r\n')
        assert (await reader.readline()).startswith(b'QueueUpdate: PICKUP2 JOB2 10 Pending ')
        other[1].close()
        writer.close()
    with_link(act)


def test_a_lost_connection_is_dialled_again_also_if_nobody_listens_for_a_while():
    async def act(port: JobPort, number: int, program: Program, link: DialledLink) -> None:
        _, writer = await program.connection()
        await program.leave()
        writer.close()
        while 'refused' not in link.trouble and 'Connect' not in link.trouble:
            await asyncio.sleep(0.005)
        await program.listen()
        reader, writer = await program.connection()
        writer.write(b'getGoals\r\n')
        assert await reader.readline() == b'Goal: x\r\n'
        assert link.trouble == '' and len(port.server.sessions) == 1
        writer.close()
    with_link(act)


def test_quit_ends_the_connection_and_it_is_dialled_again():
    async def act(port: JobPort, number: int, program: Program, link: DialledLink) -> None:
        reader, writer = await program.connection()
        writer.write(b'quit\r\n')
        assert await reader.read() == b'Closing connection\r\n'
        writer.close()
        _, again = await program.connection()
        again.close()
    with_link(act)


def test_commands_are_carried_out_for_the_program_again_and_again():
    async def act(port: JobPort, number: int, program: Program, link: DialledLink) -> None:
        reader, writer = await program.connection()
        for _ in range(3):
            assert await reader.readline() == b'EndQueueShowRobot\r\n'
            assert await reader.readline() == b'EndPayloadQuery\r\n'
        writer.close()
    with_link(act, 'queueShowRobot default echoit', 'payloadQuery')


def test_a_program_that_does_not_read_loses_its_own_connection_only(monkeypatch):
    monkeypatch.setattr(job_port, 'MOST_UNREAD', 20_000)

    async def act(port: JobPort, number: int, program: Program, link: DialledLink) -> None:
        stalled = await program.connection()
        good = await log_in(number)
        again = asyncio.ensure_future(program.connection())
        while not again.done():
            await asyncio.sleep(0)
        good[1].write(b'getGoals\n')
        assert await good[0].readline() == b'Goal: x\r\n'
        for one in (stalled, good, await again):
            one[1].close()
    with_link(act, *['help'] * 200)
