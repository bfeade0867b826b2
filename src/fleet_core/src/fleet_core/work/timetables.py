"""Timetables: templates that are run at times of the day.

A run is named by the time that the site's clock on the wall shows: a `WallMinute`. So a run is made
once, also if that clock shows its time twice, and a time that the clock skips is not lost: it comes
with the first time that is shown afterwards.
"""
from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import FrozenSet, Tuple

DAY = 24 * 60   # minutes
WEEK = frozenset(range(7))
WallMinute = int
"""Minutes since the beginning of the year 1, as clocks on the wall show them."""
_FIRST = datetime(1, 1, 1)


def wall_minute(shown: datetime) -> WallMinute:
    """The minute that a clock on the wall shows. `shown` has the local time."""
    return (shown.replace(tzinfo=None) - _FIRST) // timedelta(minutes=1)


def shown_at(minute: WallMinute) -> datetime:
    """What clocks on the wall show in a minute."""
    return _FIRST + timedelta(minutes=minute)


@dataclass(frozen=True)
class Timetable:
    """The times at which a template is run.

    arguments -- for the parameters of the template
    every     -- minutes from one run to the next one of a day
    begin     -- minute of the day of its first run
    end       -- minutes from the beginning of that day to the last time at which a run may be;
                 more than a day: after midnight
    days      -- days of the week on which it begins; 0 is Monday
    priority  -- of its missions
    """

    name: str
    template: str
    every: int
    arguments: Tuple[Tuple[str, str], ...] = ()
    begin: int = 0
    end: int = DAY - 1
    days: FrozenSet[int] = WEEK
    priority: int = 0
