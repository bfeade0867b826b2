"""The device desk: the reports of devices, and the requests that the devices have not obeyed yet.

A device is a door, a light or an air lock outside this program. Each request contains everything
that the device is to do. So a lost or repeated request does no harm. A device does not obey a
request that is older than the last one.
"""
from __future__ import annotations

import math
from dataclasses import replace
from typing import Callable, Collection, Dict, List, NamedTuple

from fleet_core.interlocking.claims import Claims
from fleet_core.interlocking.route_master import ME
from fleet_core.supervision.actions import AskDevice
from route_protocol.devices import DeviceMode, DeviceReport, DeviceUse

FRESH = 3.0   # s for which a reading counts
REPEAT = 1.0  # s after which a request that no report shows is sent again
AHEAD = 0.2   # s by which the clock of the program that reads devices may be ahead


class DeviceView(NamedTuple):
    """What is known of a device. `why`: what is wrong with it, as a clause; empty: nothing."""

    mode: DeviceMode
    why: str = ''


_NEVER_HEARD = DeviceView(DeviceMode.UNKNOWN, 'no report of it has come: is fleet_devices running?')
_OLD = DeviceView(DeviceMode.OFFLINE, 'its reports are old or have ended: is fleet_devices '
                                      'running, and is the clock of its computer right?')


class _Sent(NamedTuple):
    """The number of the last request that was sent to a device, and the time."""

    number: int = 0
    at: float = -math.inf


class DeviceDesk:
    """The newest report of each device.

    claims  -- the claims of all robots; the desk notes there which devices are open
    unknown -- returns the names of the robots that may be anywhere
    """

    def __init__(self, claims: Claims, unknown: Callable[[], Collection[str]]) -> None:
        self._claims, self._unknown = claims, unknown
        self._reports: Dict[str, DeviceReport] = {}
        self._sent: Dict[str, _Sent] = {}

    def report(self, report: DeviceReport, now: float) -> None:
        """Handles a report. A report that is older than an earlier one changes nothing.

        The times in the report are in s of the supervisor's clock. If the time of a reading is more
        than AHEAD s after `now`, a clock is wrong. Then the age of the reading is unknown.
        """
        name = report.device
        resource = self._claims.needs.resources.get(name)
        if resource is None or not resource.has_device:
            return
        if not report.is_newer_than(self._reports.get(name)):
            return
        if report.read_at is not None and report.read_at > now:
            is_wrong = report.read_at > now + AHEAD
            report = replace(report, read_at=None if is_wrong else now)
        self._reports[name] = report
        number = _own(report).number
        if number > self._claims.number:  # the journal was lost and the clock set back
            self._claims.outnumber(number)

    def update_open(self, now: float) -> None:
        """Tells the interlocking which devices are open now according to fresh reports."""
        self._claims.open_for = {
            name: own.number for name, report in self._reports.items() for own in (_own(report),)
            if report.mode is DeviceMode.OPEN and own.holds and _is_fresh(report, now)}

    def view(self, name: str, now: float) -> DeviceView:
        """Returns what is known of a device now."""
        report = self._reports.get(name)
        if report is None:
            return _NEVER_HEARD
        if _is_fresh(report, now) or report.reason:
            return DeviceView(report.mode, report.reason)
        return _OLD

    def due(self, now: float) -> List[AskDevice]:
        """Returns the requests that no fresh report shows; they must be sent now.

        While a robot may be anywhere, it may be in a door. So no requests are sent.
        """
        found: List[AskDevice] = []
        if not self._claims.requests or self._unknown():
            return found
        for name, request in self._claims.requests.items():
            report, sent = self._reports.get(name), self._sent.get(name, _Sent())
            is_shown = report is not None and _is_fresh(report, now) and report.shows(request)
            if is_shown or sent.number == request.number and now - sent.at < REPEAT:
                continue
            self._sent[name] = _Sent(request.number, now)
            found.append(AskDevice(request))
        return found


def _own(report: DeviceReport) -> DeviceUse:
    """Returns the fleet manager's request that the device obeys; without one, a request to close.
    """
    return report.use_of(ME) or DeviceUse(ME, DeviceMode.CLOSED, 0, 0.0)


def _is_fresh(report: DeviceReport, now: float) -> bool:
    return report.read_at is not None and now - report.read_at <= FRESH
