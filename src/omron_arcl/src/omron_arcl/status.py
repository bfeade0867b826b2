"""From single status lines to whole statuses.

`status` prints its fields on lines of their own, in an order and number that differ between robots,
and without an end line.
"""
from __future__ import annotations

from dataclasses import replace
from typing import Any, Callable, Dict, Optional, Set, Tuple, Type

from omron_arcl.replies.reply import Reply
from omron_arcl.replies.status import (
    BatteryVoltage,
    ExtendedStatus,
    LocalizationScore,
    Location,
    OneLineStatus,
    StateOfCharge,
    StatusText,
    Temperature,
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


class StatusAssembler:
    """Collects status lines; each whole status comes out once, as a OneLineStatus.

    A field that comes again begins the next status; that teaches which fields there are. From then
    on a status is whole when it has the fields that the last one had. `located` is when the
    location of the last whole status came, by the caller's clock.
    """

    def __init__(self) -> None:
        self.located: Any = None
        self._location_came: Any = None
        self._status = OneLineStatus('')
        self._fields: Set[str] = set()
        self._expected: Optional[Set[str]] = None

    def add(self, reply: Reply, now: Any = None) -> Optional[OneLineStatus]:
        """Takes a line; returns the status that is whole with it, or was whole before it."""
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
        """Forgets the lines of the status that is not whole yet."""
        self._status, self._fields = OneLineStatus(''), set()

    def _finish(self) -> OneLineStatus:
        status = self._status
        self.located = self._location_came
        self._expected = self._fields
        self.drop()
        return status
