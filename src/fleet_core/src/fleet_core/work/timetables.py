"""Timetables: templates that are run at times of the day.

A run is named by the time that the site's clock on the wall shows: a `WallMinute`. So if that clock
shows the time of a run twice, the run is made only once. If the clock skips the time of a run, the
run is made at the first time that the clock shows afterwards.
"""
from __future__ import annotations

import re
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import FrozenSet, NamedTuple, Optional, Tuple

DAY = 24 * 60   # minutes
DAYS = ('mon', 'tue', 'wed', 'thu', 'fri', 'sat', 'sun')
WEEK = frozenset(range(len(DAYS)))
WallMinute = int
"""Minutes since the beginning of the year 1, as clocks on the wall show them."""
_FIRST = datetime(1, 1, 1)


def wall_minute(shown: datetime) -> WallMinute:
    """Returns the minute that a clock on the wall shows. `shown` has the local time."""
    return (shown.replace(tzinfo=None) - _FIRST) // timedelta(minutes=1)


def shown_at(minute: WallMinute) -> datetime:
    """Returns what clocks on the wall show in a minute."""
    return _FIRST + timedelta(minutes=minute)


def minute_of_day(text: str) -> int:
    """Returns the minutes since midnight, from `06:00`. Raises ValueError with a clause."""
    found = re.fullmatch(r'(\d{1,2}):(\d{2})', text, re.ASCII)
    if not found or int(found[1]) > 23 or int(found[2]) > 59:
        raise ValueError(f'{text!r} is no time of day, such as 06:00')
    return 60 * int(found[1]) + int(found[2])


def next_time(minute: int, now: datetime) -> datetime:
    """Returns the next time after `now` at which clocks on the wall show this minute of the day."""
    today = now.replace(hour=minute // 60, minute=minute % 60, second=0, microsecond=0)
    return today if today > now else today + timedelta(days=1)


@dataclass(frozen=True)
class Timetable:
    """The times at which a template is run.

    arguments -- for the parameters of the template
    every     -- minutes between two runs on one day
    begin     -- minute of the day of its first run
    end       -- latest minute of a run, counted from the beginning of the day of the first run;
                 more than a day: after midnight
    days      -- days of the week on which it begins; 0 is Monday
    priority  -- priority of its missions
    deadline  -- minutes after the time of a run by which it must be done; 0: no deadline
    """

    name: str
    template: str
    every: int
    arguments: Tuple[Tuple[str, str], ...] = ()
    begin: int = 0
    end: int = DAY - 1
    days: FrozenSet[int] = WEEK
    priority: int = 0
    deadline: int = 0


class DueRun(NamedTuple):
    """The run that is due now according to a timetable.

    run         -- the run to be made now; None: there is none
    missed      -- number of earlier runs that were not made, and will not be made any more
    last        -- the minute up to which all runs are made or missed
    is_set_back -- the clock was set back by more than a day; the runs go on from the time that the
                   clock shows now
    """

    run: Optional[WallMinute]
    missed: int
    last: WallMinute
    is_set_back: bool = False


def due(timetable: Timetable, last: Optional[WallMinute], now: WallMinute) -> DueRun:
    """Returns the newest run after `last` that is due.

    last -- `last` of the previous result; None: the timetable is new and begins at `now`
    """
    is_set_back = last is not None and last > now + DAY
    since = now - 1 if last is None or is_set_back else last
    runs = newest = 0  # no run is due if the clock shows a time again, or was set back a little
    for day in range((since - timetable.end) // DAY, now // DAY + 1):
        first = day * DAY + timetable.begin
        if shown_at(day * DAY).weekday() in timetable.days and first <= now:
            end = min(now, day * DAY + timetable.end)
            behind = max((since - first) // timetable.every + 1, 0)
            count = (end - first) // timetable.every + 1 - behind
            if count > 0:
                runs += count
                newest = first + (behind + count - 1) * timetable.every
    return DueRun(newest or None, max(runs - 1, 0), newest or since, is_set_back)


def next_run(timetable: Timetable, last: Optional[WallMinute], now: WallMinute) -> WallMinute:
    """Returns the first minute after `now` in which a run is due, if the clock is not set.

    last -- as for `due`; if the clock was set back a little, no run comes before `last`
    """
    is_set_back = last is not None and last > now + DAY
    since = now if last is None or is_set_back else max(last, now)
    first: Optional[WallMinute] = None
    day = (since - timetable.end) // DAY
    while first is None or day * DAY + timetable.begin < first:
        begin = day * DAY + timetable.begin
        if shown_at(day * DAY).weekday() in timetable.days:
            run = begin + max((since - begin) // timetable.every + 1, 0) * timetable.every
            if run <= day * DAY + timetable.end:
                first = run if first is None else min(first, run)
        day += 1
    return first
