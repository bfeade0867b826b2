"""The process of the door. It is forked at the start, while the page's process has no threads.

The page's process sends its settings once, as a line of JSON. The door answers with its port, or
with a sentence that says why it cannot work. The door ends when the page's process ends.
"""
from __future__ import annotations

import asyncio
import json
import logging
import os
import resource
import selectors
import signal
import socket
from dataclasses import asdict, dataclass
from typing import Any, Callable, Dict, NoReturn, Tuple

from browser_guard.certificates import WrongCertificate, certificates_of
from fleet_page.core.acts import ActOutcome
from fleet_page.core.roles import TokenFile, TokenFileError
from fleet_page.door.door import Access, Door
from fleet_page.door.files import PageFiles
from fleet_page.door.security import Addresses
from fleet_page.door.worker import Worker

OPEN_WITHIN = 10.0        # s within which the door must begin to listen
_DESCRIPTORS = 2048       # enough for all connections that the limits of the door allow
_FORMAT = '[%(levelname)s] [door of fleet_page]: %(message)s'


class DoorError(Exception):
    """The door cannot work. The text is one sentence."""


@dataclass(frozen=True)
class DoorSettings:
    """The settings of the door. worker: Unix socket of the page's process; files: folder of files.
    """

    listen: str
    port: int
    worker: str
    files: str
    names: Tuple[str, ...] = ()
    token_file: str = ''
    certificate: str = ''
    key: str = ''

    @property
    def is_secure(self) -> bool:
        """Whether the page is served by TLS."""
        return bool(self.certificate or self.key)


class DoorProcess:
    """The door's process, for use in the page's process."""

    def __init__(self, stop: Callable[[str], ActOutcome],
                 begin: Callable[[], None] = lambda: None) -> None:
        """Forks the door's process, which first calls `begin`. `stop` stops the fleet in the door's
        process, and may take seconds.
        """
        here, there = socket.socketpair()
        self._ended, lives = os.pipe()  # `lives` stays open until the door ends
        self._pid = os.fork()
        if not self._pid:
            here.close()
            _be_the_door(there, stop, begin)
        there.close()
        os.close(lives)
        self._channel = here

    def open(self, settings: DoorSettings) -> int:
        """Opens the door. Returns its port. Raises DoorError."""
        self._channel.settimeout(OPEN_WITHIN)
        try:
            self._channel.sendall(json.dumps(asdict(settings)).encode() + b'\n')
            with self._channel.makefile('rb') as stream:
                answer: Dict[str, Any] = json.loads(stream.readline())
        except (OSError, ValueError) as error:
            raise DoorError(f'The door of the page does not answer ({error}).') from None
        if 'error' in answer:
            raise DoorError(answer['error'])
        return int(answer['port'])

    def wait(self) -> None:
        """Waits until the door's process has ended. The thread waits for an event, so that the
        watchdog of the node does not count it as blocked.
        """
        with selectors.DefaultSelector() as events:
            events.register(self._ended, selectors.EVENT_READ)
            events.select()
        os.close(self._ended)
        os.waitpid(self._pid, 0)

    def close(self) -> None:
        """Ends the door."""
        self._channel.close()


def _be_the_door(channel: socket.socket, stop: Callable[[str], ActOutcome],
                 begin: Callable[[], None]) -> NoReturn:
    """Runs the door's process until it ends."""
    for number in (signal.SIGINT, signal.SIGTERM):  # only the page's process obeys them
        signal.signal(number, signal.SIG_IGN)
    logging.basicConfig(level=logging.INFO, format=_FORMAT)
    status = 1
    try:
        begin()
        _allow_connections()
        with channel.makefile('rb') as stream:
            line = stream.readline()
        if line:
            values = json.loads(line)
            settings = DoorSettings(**{**values, 'names': tuple(values['names'])})
            asyncio.run(_serve(settings, channel, stop))
        status = 0
    except BaseException:
        logging.getLogger(__name__).exception('The door of the page has failed.')
    finally:
        os._exit(status)  # the rest of the program is for the page's process


def _allow_connections() -> None:
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft != resource.RLIM_INFINITY and soft < _DESCRIPTORS:
        most = _DESCRIPTORS if hard == resource.RLIM_INFINITY else min(_DESCRIPTORS, hard)
        resource.setrlimit(resource.RLIMIT_NOFILE, (most, hard))


async def _serve(settings: DoorSettings, channel: socket.socket,
                 stop: Callable[[str], ActOutcome]) -> None:
    worker = Worker(settings.worker)
    door = None
    try:
        tokens = TokenFile(settings.token_file) if settings.token_file else None
        certificates = certificates_of(
            settings.certificate, settings.key) if settings.is_secure else None
        addresses = Addresses.of(settings.listen, settings.names, settings.is_secure)
        door = Door(Access(addresses, tokens, settings.is_secure), PageFiles(settings.files), stop,
                    worker)
        answer: Dict[str, Any] = {
            'port': await door.listen(settings.listen, settings.port, certificates)}
    except (TokenFileError, WrongCertificate) as error:
        answer = {'error': str(error)}
    except OSError as error:
        answer = {'error': f'The page cannot listen at {settings.listen}, port {settings.port} '
                           f'({error}): end the program that uses the port, or choose another '
                           'with ~port.'}
    channel.sendall(json.dumps(answer).encode() + b'\n')
    ended = asyncio.Event()
    asyncio.get_event_loop().add_reader(channel, ended.set)  # is called until the reader is removed
    await ended.wait()
    asyncio.get_event_loop().remove_reader(channel)
    if door is not None:
        await door.close()
    await worker.close()
