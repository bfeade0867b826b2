"""The robot's outgoing connection: the lines that it sends by itself, and their times.

The times are multiples of the interval, counted on the robot's clock. So they do not drift.
"""
from __future__ import annotations

from functools import partial
from typing import Callable, List

from omron_ld90_sim.clock import Ticker
from omron_ld90_sim.interface.commands.state import one_line_status
from omron_ld90_sim.interface.configuration_table import LISTS, OUTGOING, OUTGOING_COMMANDS
from omron_ld90_sim.interface.server import ArclServer
from omron_ld90_sim.interface.session import SimSession

MINIMUM_STATUS_INTERVAL = 0.1   # s, lower limit of SendStatusInterval
MINIMUM_LIST_INTERVAL = 0.01    # s, not from the sources; leaves time for other work
MINIMUM_TIMEOUT = 5.0           # s, lower limit of OutgoingSocketTimeoutInMins


class OutgoingLink:
    """The command lists, the status lines and the timeout of one outgoing session."""

    def __init__(self, server: ArclServer, session: SimSession) -> None:
        self._server, self._session = server, session
        self._tickers: List[Ticker] = []
        settings, clock = server.configuration, server.clock
        for n in LISTS:
            seconds = settings.number(OUTGOING_COMMANDS, f'OutgoingCommands{n}Seconds')
            commands = [part.strip() for part in
                        settings.text(OUTGOING_COMMANDS, f'OutgoingCommands{n}').split('|')]
            if seconds > 0 and any(commands):
                self._every(max(seconds, MINIMUM_LIST_INTERVAL), partial(self._run, commands))
        interval = settings.number(OUTGOING, 'SendStatusInterval') / 1000.0
        if interval > 0:
            self._every(max(interval, MINIMUM_STATUS_INTERVAL),
                        lambda: session.send(one_line_status(server.robot, server.dialect)))
        minutes = settings.number(OUTGOING, 'OutgoingSocketTimeoutInMins')
        if minutes >= 0:
            self._limit = max(minutes * 60.0, MINIMUM_TIMEOUT)
            session.last_received = clock.now
            self._every(1.0, self._drop_when_silent)

    def _every(self, seconds: float, action: Callable[[], None]) -> None:
        def run() -> None:
            if self._session.closed:
                self.stop()
            else:
                action()

        self._tickers.append(Ticker(self._server.clock, seconds, run))

    def _run(self, commands: List[str]) -> None:
        for command in commands:
            if command and not self._session.closed:
                self._server.execute(self._session, command)

    def _drop_when_silent(self) -> None:
        if self._server.clock.now - self._session.last_received >= self._limit:
            self._session.close()

    def stop(self) -> None:
        """Stops sending."""
        for ticker in self._tickers:
            ticker.stop()
