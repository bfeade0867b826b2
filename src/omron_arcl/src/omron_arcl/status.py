"""Combines single status lines into whole statuses.

`status` prints its fields on separate lines. Their order and number differ between robots, and
there is no end line.
"""
from __future__ import annotations

from dataclasses import replace
from typing import Any, Callable, Dict, Optional, Set, Tuple, Type

from omron_arcl.readers import STATUS_FIELDS
from omron_arcl.replies import (
    BatteryVoltage,
    ExtendedStatus,
    LocalizationScore,
    Location,
    OneLineStatus,
    Reply,
    StateOfCharge,
    StatusText,
    Temperature,
    UnknownLine,
)

_FIELDS: Dict[Type[Reply], Tuple[str, Callable[[Any], Any]]] = {
    ExtendedStatus: ('extended_status', lambda reply: reply.text),
    StatusText: ('status', lambda reply: reply.text),
    StateOfCharge: ('state_of_charge', lambda reply: reply),
    BatteryVoltage: ('battery_voltage', lambda reply: reply),
    Location: ('location', lambda reply: reply),
    LocalizationScore: ('localization_score', lambda reply: reply),
    Temperature: ('temperature', lambda reply: reply),
}


def ignored_fields(reply: Reply) -> Tuple[str, ...]:
    """Returns the fields of a status line that have impossible values, as they were sent."""
    if isinstance(reply, OneLineStatus):
        return reply.ignored
    if isinstance(reply, UnknownLine) and reply.text.lower().partition(':')[0] in STATUS_FIELDS:
        return (reply.text,)
    return ()


class StatusAssembler:
    """Collects status lines, and returns each whole status once, as a OneLineStatus.

    If a field comes a second time, a new status has begun. So the assembler learns which fields a
    status has. After that, a status is whole when it has the fields of the last status. `located`
    is the time on the caller's clock at which the location of the last whole status came.
    """

    def __init__(self) -> None:
        self.located: Any = None
        self._location_came: Any = None
        self._status = OneLineStatus('')
        self._fields: Set[str] = set()
        self._expected: Optional[Set[str]] = None

    def add(self, reply: Reply, now: Any = None) -> Optional[OneLineStatus]:
        """Adds a line. Returns a status if the line completes the status or begins the next one."""
        if isinstance(reply, OneLineStatus):
            self.located = now
            return reply
        if type(reply) not in _FIELDS:
            return None
        field, value = _FIELDS[type(reply)]
        whole = self._finish() if field in self._fields else None
        self._status = replace(self._status, **{field: value(reply)})
        self._fields.add(field)
        if field == 'location':
            self._location_came = now
        if self._fields == self._expected:
            whole = self._finish()
        return whole

    def drop(self) -> None:
        """Forgets the lines of the incomplete status."""
        self._status, self._fields = OneLineStatus(''), set()

    def _finish(self) -> OneLineStatus:
        status = self._status
        self.located = self._location_came
        self._expected = self._fields
        self.drop()
        return status
