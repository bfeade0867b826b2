"""The runs of the timetables: each is a mission, whose id and stamp follow from its time.

The time of the last run is stored together with its mission. So a restart neither repeats nor loses
a run.
"""
from __future__ import annotations

from datetime import datetime
from hashlib import blake2b
from typing import Callable, Dict, Iterator, Mapping, NamedTuple, Optional

from fleet_core.supervision.missions import Request
from fleet_core.work.timetables import (
    DueRun,
    Timetable,
    WallMinute,
    due,
    shown_at,
    wall_minute,
)

_LARGEST_ID = 2 ** 31 - 1


class TimetableRun(NamedTuple):
    """What a timetable asks for now.

    request -- of the run that is due; None: there is none
    due     -- the run, and how many were missed
    """

    timetable: Timetable
    due: DueRun
    request: Optional[Request]


class TimetableRuns:
    """Finds the runs that are due.

    stored -- returns the stored number of a name; 0: none is stored
    clock  -- returns ms since 1970; local time is that of this computer
    """

    def __init__(self, timetables: Mapping[str, Timetable], stored: Callable[[str], int],
                 clock: Callable[[], int]) -> None:
        self._timetables, self._clock = timetables, clock
        self._last: Dict[str, WallMinute] = {
            name: stored(stored_name(name)) for name in timetables}
        self._looked: Optional[WallMinute] = None

    def due(self) -> Iterator[TimetableRun]:
        """What the timetables ask for in a new minute, each until `done` is told."""
        now = wall_minute(datetime.fromtimestamp(self._clock() / 1000.0))
        if now == self._looked:
            return
        for name, timetable in self._timetables.items():
            found = due(timetable, self._last[name] or None, now)
            if found.last != self._last[name]:
                yield TimetableRun(timetable, found, None if found.run is None else
                                   request_of(timetable, found.run))
        self._looked = now

    def done(self, run: TimetableRun) -> None:
        """The run was requested, and `due.last` is about to be stored."""
        self._last[run.timetable.name] = run.due.last


def stored_name(timetable: str) -> str:
    """The name under which the time of the last run is stored."""
    return f'timetable/{timetable}'


def giver_of(timetable: str) -> str:
    """The name of the giver of all missions of a timetable."""
    return f'timetable {timetable}'


def request_of(timetable: Timetable, run: WallMinute) -> Request:
    """The request of a run. It is the same one whenever it is made."""
    shown = shown_at(run)
    stamp = shown.timestamp()
    digest = blake2b(f'{timetable.name} {shown.isoformat()}'.encode(), digest_size=4).digest()
    return Request(max(int.from_bytes(digest, 'big') & _LARGEST_ID, 1), (),
                   priority=timetable.priority, stamp=stamp, requested_by=giver_of(timetable.name),
                   template=timetable.template, arguments=timetable.arguments,
                   deadline=stamp + 60.0 * timetable.deadline if timetable.deadline else 0.0)
