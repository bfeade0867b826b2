"""Doors, lights and other devices: the requests for them, and the reports of `fleet_devices`.

A requester holds a device open with one request, and releases it with another. Its requests have
*numbers*, which only grow, even after a restart. Each request is taken once: if its number is not
above the last number of this requester, it is a repetition. So a requester repeats its newest
request, even one that releases the device, until a report shows the number of this request.

A report that says OPEN shows only requests that were taken before the device was read. So if a
requester finds its newest number in such a report, the device was open when it was read after the
request. Reports have the number of a run and a count. So an old report is never taken for a new
one, even if it arrives very late.
"""
from __future__ import annotations

from dataclasses import dataclass, replace
from enum import IntEnum
from typing import Optional, Tuple

UNKNOWN_REQUESTER = 'unknown'
"""Stands for any requester after the memory was lost: an unknown robot may be in the device."""


class DeviceMode(IntEnum):
    """What a device shows, as in itrci_nav_msgs/DeviceState and in Open-RMF's messages of doors."""

    CLOSED = 0
    MOVING = 1
    OPEN = 2
    OFFLINE = 3
    UNKNOWN = 4


class DeviceFault(IntEnum):
    """Why a device cannot be used, as in itrci_nav_msgs/DeviceState."""

    NONE = 0
    NOT_READ = 1   # the device does not answer
    TIMED_OUT = 2  # the device has not shown the requested mode within its timeout


@dataclass(frozen=True)
class DeviceRequest:
    """The mode that a requester wants: OPEN, or CLOSED to release the device."""

    requester: str
    device: str
    mode: DeviceMode
    number: int


@dataclass(frozen=True)
class DeviceUse:
    """A request that a device obeys now. `since`: when the request was taken (s)."""

    requester: str
    mode: DeviceMode
    number: int
    since: float

    @property
    def holds(self) -> bool:
        """Whether the requester holds the device open."""
        return self.mode is DeviceMode.OPEN


@dataclass(frozen=True)
class DeviceReport:
    """The report of `fleet_devices` about one device. Times are in s.

    since   -- when the mode began
    read_at -- when the device was read; None: never
    reason  -- the fault, for people
    run     -- number of the run of fleet_devices; a later run has a higher number
    count   -- grows with each report of a run
    """

    device: str
    mode: DeviceMode
    since: float
    read_at: Optional[float]
    obeyed: Tuple[DeviceUse, ...] = ()
    fault: DeviceFault = DeviceFault.NONE
    reason: str = ''
    run: int = 0
    count: int = 0

    def is_newer_than(self, other: Optional[DeviceReport]) -> bool:
        """Returns whether this report was made later than the other one of this device."""
        return other is None or (self.run, self.count) > (other.run, other.count)

    def at(self, since: float, read_at: Optional[float]) -> DeviceReport:
        """Returns the same report with times of another clock."""
        return replace(self, since=since, read_at=read_at)

    def use_of(self, requester: str) -> Optional[DeviceUse]:
        """Returns the request of a requester that the device obeys; None: there is none."""
        return next((use for use in self.obeyed if use.requester == requester), None)

    def shows(self, request: DeviceRequest) -> bool:
        """Returns whether this request has been taken. If not, the requester must repeat it."""
        use = self.use_of(request.requester)
        return use is not None and use.number >= request.number

    def is_open_for(self, requester: str, number: int) -> bool:
        """Returns whether a reading showed OPEN after the request `number` of this requester was
        taken.
        """
        use = self.use_of(requester)
        return (self.mode is DeviceMode.OPEN and use is not None and use.holds
                and use.number == number)
