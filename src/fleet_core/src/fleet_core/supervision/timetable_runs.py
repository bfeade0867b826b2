"""The runs of the timetables. A run is a mission; its id and stamp follow from the run's time.

The time of the last run is stored together with its mission. So a restart neither repeats nor loses
a run.

A person may pause a timetable. The pause outlasts restarts. Runs that are due in the pause are not
made.
"""
from __future__ import annotations

from datetime import datetime
from hashlib import blake2b
from typing import Callable, Dict, Iterator, List, Mapping, NamedTuple, Optional

from fleet_core.supervision.missions import Request
from fleet_core.work.timetables import (
    DueRun,
    Timetable,
    WallMinute,
    due,
    next_run,
    shown_at,
    wall_minute,
)

_LARGEST_ID = 2 ** 31 - 1


class TimetableRun(NamedTuple):
    """A run that a timetable requests now, or runs that it has missed.

    request -- the request of the due run; None: no run is due
    due     -- the due run, and the number of missed runs
    """

    timetable: Timetable
    due: DueRun
    request: Optional[Request]


class TimetableView(NamedTuple):
    """A timetable as it is shown to people.

    next -- time of its next run, s since 1970; None: it is paused
    """

    timetable: Timetable
    next: Optional[float]


class TimetableRuns:
    """Finds the runs that are due.

    stored -- returns the number that is stored under a name; 0: none is stored
    clock  -- returns ms since 1970; local time is that of this computer
    """

    def __init__(self, timetables: Mapping[str, Timetable], stored: Callable[[str], int],
                 clock: Callable[[], int]) -> None:
        self._timetables, self._clock = timetables, clock
        self._last: Dict[str, WallMinute] = {
            name: stored(stored_name(name)) for name in timetables}
        self._paused = {name for name in timetables if stored(paused_name(name))}
        self._looked: Optional[WallMinute] = None

    def due(self) -> Iterator[TimetableRun]:
        """Yields the due or missed runs of all timetables, once in each minute.

        The caller must call `done` for each.
        """
        now = self._now
        if now == self._looked:
            return
        for name, timetable in self._timetables.items():
            if name in self._paused:
                continue
            found = due(timetable, self._last[name] or None, now)
            if found.last != self._last[name]:
                yield TimetableRun(timetable, found, None if found.run is None else
                                   request_of(timetable, found.run))
        self._looked = now

    def done(self, run: TimetableRun) -> None:
        """Notes that the run was requested, and that `due.last` will be stored now."""
        self._last[run.timetable.name] = run.due.last

    def pause(self, name: str, paused: bool) -> Dict[str, int]:
        """Pauses a timetable, or lets it go on with the next minute.

        Returns the numbers to be stored, by name.
        """
        values = {paused_name(name): int(paused)}
        if paused:
            self._paused.add(name)
        elif name in self._paused:
            self._paused.remove(name)
            values[stored_name(name)] = self._last[name] = self._now
        return values

    @property
    def views(self) -> List[TimetableView]:
        """All timetables, in the order of the file."""
        return [TimetableView(timetable, None if name in self._paused else shown_at(
            next_run(timetable, self._last[name] or None, self._now)).timestamp())
            for name, timetable in self._timetables.items()]

    @property
    def names(self) -> List[str]:
        """The names of all timetables."""
        return list(self._timetables)

    @property
    def _now(self) -> WallMinute:
        return wall_minute(datetime.fromtimestamp(self._clock() / 1000.0))


def stored_name(timetable: str) -> str:
    """Returns the name under which the time of the last run is stored."""
    return f'timetable/{timetable}'


def paused_name(timetable: str) -> str:
    """Returns the name of the stored number that says whether a timetable is paused."""
    return f'timetable paused/{timetable}'


def giver_of(timetable: str) -> str:
    """Returns the name of the giver of all missions of a timetable."""
    return f'timetable {timetable}'


def request_of(timetable: Timetable, run: WallMinute) -> Request:
    """Returns the request of a run. A run always has the same request."""
    shown = shown_at(run)
    stamp = shown.timestamp()
    digest = blake2b(f'{timetable.name} {shown.isoformat()}'.encode(), digest_size=4).digest()
    return Request(max(int.from_bytes(digest, 'big') & _LARGEST_ID, 1), (),
                   priority=timetable.priority, stamp=stamp, requested_by=giver_of(timetable.name),
                   template=timetable.template, arguments=timetable.arguments,
                   deadline=stamp + 60.0 * timetable.deadline if timetable.deadline else 0.0)
