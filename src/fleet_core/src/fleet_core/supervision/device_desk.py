"""The device desk: what devices report, and the requests that they have not obeyed yet.

A device is a door, a light or an air lock outside this program. It gets all that it needs in each
request, so a request that is lost or repeated does no harm, and an older one is not obeyed.
"""
from __future__ import annotations

import math
from typing import Callable, Collection, Dict, List, NamedTuple

from fleet_core.interlocking.claims import Claims
from fleet_core.interlocking.resources import DeviceReading
from fleet_core.supervision.actions import AskDevice
from route_protocol.devices import DeviceMode

FRESH = 3.0   # s for which a report counts
REPEAT = 1.0  # s between two requests that no report shows


class _Read(NamedTuple):
    """A report, and when its device was read, in s by the supervisor's clock."""

    report: DeviceReading
    at: float


class _Sent(NamedTuple):
    """Number of a request that was sent, and when."""

    number: int = 0
    at: float = -math.inf


class DeviceDesk:
    """The newest report of each device.

    claims  -- the claims of all robots; the desk tells which devices are open
    unknown -- returns the names of the robots that may be anywhere
    """

    def __init__(self, claims: Claims, unknown: Callable[[], Collection[str]]) -> None:
        self._claims, self._unknown = claims, unknown
        self._read: Dict[str, _Read] = {}
        self._sent: Dict[str, _Sent] = {}

    def report(self, report: DeviceReading, now: float) -> None:
        """Handles a report. One that was read before the newest changes nothing."""
        at = now - max(report.age, 0.0)
        before = self._read.get(report.resource)
        if before is None or at >= before.at:
            self._read[report.resource] = _Read(report, at)

    def update_open(self, now: float) -> None:
        """Tells the interlocking which devices are open now, by fresh reports."""
        self._claims.open_for = {
            name: read.report.request for name, read in self._read.items()
            if read.report.mode is DeviceMode.OPEN and self._is_fresh(read, now)}

    @staticmethod
    def _is_fresh(read: _Read, now: float) -> bool:
        return now - read.at <= FRESH

    def due(self, now: float) -> List[AskDevice]:
        """The requests to send now: those that no fresh report shows.

        While a robot may be anywhere, it may be in a door. So no device is asked for anything.
        """
        found: List[AskDevice] = []
        if not self._claims.requests or self._unknown():
            return found
        for name, request in self._claims.requests.items():
            read, sent = self._read.get(name), self._sent.get(name, _Sent())
            is_shown = read is not None and (
                self._is_fresh(read, now) and read.report.request >= request.number)
            if is_shown or sent.number == request.number and now - sent.at < REPEAT:
                continue
            self._sent[name] = _Sent(request.number, now)
            found.append(AskDevice(request))
        return found
