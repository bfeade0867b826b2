"""The connection that the job server opens by itself, to one program, in the loop of its port.

    state      event                          next state
    LOST       RETRY s have passed            DIALLING
    DIALLING   the program accepts            LINKED; the program need not log in
    DIALLING   DIAL_TIME s have passed        LOST
    LINKED     the connection ends            LOST
    all        `close`                        CLOSED

OMRON's outgoing connections have no password and no welcome. So the program at the address may send
commands without a login. If the program disappears silently, the connection counts as lost after
about SILENCE s.
"""
from __future__ import annotations

import asyncio
import logging
import socket
from typing import NamedTuple, Optional, Tuple

from omron_jobs.network.job_port import JobPort

RETRY = 2.0         # s from a loss to the next attempt
DIAL_TIME = 10.0    # s in which the program must accept
SILENCE = 20        # s without an answer of the other computer until the connection ends
_PROBE = 5          # s between two keepalive probes of TCP
_log = logging.getLogger(__name__)


class DialledAddress(NamedTuple):
    """The address to which the server connects, and the commands that it repeats for that program.

    commands -- carried out every `seconds` (0: never), as if the program had sent them
    """

    host: str
    port: int
    commands: Tuple[str, ...] = ()
    seconds: float = 0.0


class DialledLink:
    """Keeps one connection to a program. `trouble`: why there is none; empty: there is one."""

    def __init__(self, port: JobPort, address: DialledAddress) -> None:
        self.trouble = 'it is opened'
        self._port, self._address = port, address
        self._task: Optional[asyncio.Task[None]] = None

    def start(self) -> None:
        """Begins to dial."""
        self._task = asyncio.get_running_loop().create_task(self._keep())

    def close(self) -> None:
        """Ends the dialling. The port ends the connection."""
        if self._task is not None:
            self._task.cancel()

    async def _keep(self) -> None:
        while True:
            try:
                await self._talk()
                self._say('the connection has ended')
            except (OSError, asyncio.TimeoutError) as error:
                self._say(str(error) or f'no answer in {DIAL_TIME:.0f} s')
            await asyncio.sleep(RETRY)

    def _say(self, trouble: str) -> None:
        if trouble != self.trouble:
            host, port = self._address[:2]
            _log.warning('Port %d of %s: %s. It is dialled again every %.0f s.', port, host,
                         trouble, RETRY)
        self.trouble = trouble

    async def _talk(self) -> None:
        """Connects, and returns when the connection has ended. Raises OSError, TimeoutError."""
        loop = asyncio.get_running_loop()
        ended: asyncio.Future[None] = loop.create_future()
        transport, client = await asyncio.wait_for(loop.create_connection(
            lambda: self._port.dialled(ended), self._address.host, self._address.port), DIAL_TIME)
        find_out_loss(transport.get_extra_info('socket'))
        self.trouble = ''
        while not ended.done():
            await asyncio.wait([ended], timeout=self._address.seconds or None)
            if not ended.done():
                for command in self._address.commands:
                    client.carry_out(command)


def find_out_loss(connection: socket.socket) -> None:
    """Makes TCP check whether the other computer is there, and end the connection if not."""
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    for option, value in ((socket.TCP_KEEPIDLE, _PROBE), (socket.TCP_KEEPINTVL, _PROBE),
                          (socket.TCP_KEEPCNT, SILENCE // _PROBE - 1),
                          (socket.TCP_USER_TIMEOUT, SILENCE * 1000)):
        connection.setsockopt(socket.IPPROTO_TCP, option, value)
