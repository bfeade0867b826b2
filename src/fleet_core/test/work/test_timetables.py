"""Each run of a timetable is made once, even if the clock jumps, and lost runs are counted."""
from __future__ import annotations

import time
from datetime import datetime
from typing import Dict, Iterator, Optional, Tuple

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fleet_core.supervision.timetable_runs import TimetableRuns, request_of, stored_name
from fleet_core.work.timetables import DAY, Timetable, due, next_run, shown_at, wall_minute

BEGIN = wall_minute(datetime(2026, 3, 27))   # a Friday, two days before the clocks are changed
BERLIN = 'CET-1CEST,M3.5.0,M10.5.0/3'


def hourly(**values: object) -> Timetable:
    return Timetable(**{'name': 'milk', 'template': 'milk_run', 'every': 60, **values})


def runs_by_the_day(timetable: Timetable, first: int, last: int) -> Iterator[int]:
    """All runs from minute `first` to minute `last`, found minute by minute."""
    for minute in range(first, last + 1):
        for day in (minute // DAY, minute // DAY - 1):
            since = minute - day * DAY
            if timetable.begin <= since <= timetable.end and (
                    (since - timetable.begin) % timetable.every == 0
                    and shown_at(day * DAY).weekday() in timetable.days):
                yield minute
                break


timetables = st.builds(
    lambda every, begin, length, days: hourly(every=every, begin=begin, end=begin + length,
                                              days=days),
    st.sampled_from((1, 7, 30, 60, 95, 720, DAY)), st.integers(0, DAY - 1),
    st.integers(0, DAY - 1), st.frozensets(st.integers(0, 6), min_size=1))


@settings(max_examples=5 * settings.default.max_examples)
@given(timetables, st.integers(0, 3 * DAY), st.integers(1, 4 * DAY))
def test_the_newest_run_is_due_and_the_others_are_counted(timetable, offset, length):
    last, now = BEGIN + offset, BEGIN + offset + length
    expected = list(runs_by_the_day(timetable, last + 1, now))
    found = due(timetable, last, now)
    assert found.run == (expected[-1] if expected else None)
    assert found.missed == max(len(expected) - 1, 0)
    assert found.last == (found.run or last) and not found.is_set_back


@settings(max_examples=5 * settings.default.max_examples)
@given(timetables, st.lists(st.one_of(st.integers(0, 90), st.integers(-DAY, 2 * DAY)),
                            min_size=1, max_size=60))
def test_whatever_the_clock_shows_no_run_is_made_twice_and_none_is_lost_in_silence(
        timetable, jumps):
    now = latest = BEGIN
    last, made, missed = due(timetable, BEGIN - 1, now).last, [], 0
    begin = last
    for jump in jumps:  # the clock goes back at most one day from its latest time
        now = max(now + jump, latest - DAY)
        latest = max(latest, now)
        found = due(timetable, last, now)
        assert not found.is_set_back
        last, missed = found.last, missed + found.missed
        made += [] if found.run is None else [found.run]
    assert made == sorted(set(made))
    assert len(made) + missed == len(list(runs_by_the_day(timetable, begin + 1, latest)))


@settings(max_examples=5 * settings.default.max_examples)
@given(timetables, st.integers(0, 3 * DAY), st.integers(0, DAY))
def test_the_next_run_that_is_told_is_the_next_that_becomes_due(timetable, offset, behind):
    now = BEGIN + offset
    following = next_run(timetable, now - behind, now)
    assert due(timetable, now, following - 1).run is None
    assert due(timetable, now, following).run == following


@given(timetables, st.integers(1, DAY))
def test_after_a_clock_that_was_set_back_a_little_the_next_run_is_not_one_that_was_made(
        timetable, back):
    last = due(timetable, BEGIN - 8 * DAY, BEGIN).last
    following = next_run(timetable, last, BEGIN - back)
    assert following > last
    assert due(timetable, last, following).run == following


def test_a_new_timetable_begins_with_the_minute_in_which_it_is_read():
    assert due(hourly(), None, BEGIN).run == BEGIN
    assert due(hourly(), None, BEGIN + 1) == (None, 0, BEGIN, False)


def test_a_clock_that_was_set_back_by_more_than_a_day_is_told_and_runs_go_on():
    found = due(hourly(), BEGIN + 10 * DAY, BEGIN + 60)
    assert found.is_set_back and found.run == BEGIN + 60


def test_the_days_are_those_on_which_the_timetable_begins():
    night = hourly(begin=22 * 60, end=26 * 60, days=frozenset({4}))
    assert list(runs_by_the_day(night, BEGIN, BEGIN + 2 * DAY)) == [
        BEGIN + 60 * hour for hour in (22, 23, 24, 25, 26)]
    assert due(night, BEGIN, BEGIN + 26 * 60).run == BEGIN + 26 * 60
    assert due(night, BEGIN + 26 * 60, BEGIN + 3 * DAY).run is None


# -- with the clock of a site ---------------------------------------------------------------------


@pytest.fixture
def berlin(monkeypatch):
    monkeypatch.setenv('TZ', BERLIN)
    time.tzset()
    yield
    monkeypatch.undo()
    time.tzset()


class Site:
    """A fleet manager that may end at any time, and the data on its disk."""

    def __init__(self, timetable: Timetable, moment: datetime) -> None:
        self.moment = moment.timestamp()
        self.timetable = timetable
        self.stored: Dict[str, int] = {}
        self.requests: Dict[Tuple[int, float], int] = {}
        self.missed = 0
        self.restart()

    def restart(self) -> None:
        self.runs = TimetableRuns({'milk': self.timetable}, lambda name: self.stored.get(name, 0),
                                  lambda: int(1000 * self.moment))

    def look(self, dies: bool = False) -> Optional[str]:
        """Makes the runs that are due; if `dies`, the fleet manager ends before a run is stored."""
        for run in self.runs.due():
            if dies:
                self.restart()
                return None
            self.runs.done(run)
            self.stored[stored_name('milk')] = run.due.last
            self.missed += run.due.missed
            if run.request is not None:
                key = run.request.id, run.request.stamp
                self.requests[key] = self.requests.get(key, 0) + 1
                return shown_at(run.due.last).strftime('%d. %H:%M')
        return None

    def all_day(self, until: datetime) -> list:
        made = []
        while self.moment < until.timestamp():
            self.moment += 60.0
            made.append(self.look())
        return [one for one in made if one]


HALF_HOURS = hourly(every=30, begin=60, end=240)


def test_an_hour_that_the_clock_skips_is_made_up_for_by_its_newest_run(berlin):
    site = Site(HALF_HOURS, datetime(2026, 3, 29, 0, 30))
    site.look()
    assert site.all_day(datetime(2026, 3, 29, 5)) == [
        '29. 01:00', '29. 01:30', '29. 03:00', '29. 03:30', '29. 04:00']
    assert site.missed == 2   # 02:00 and 02:30, which no clock shows


def test_an_hour_that_the_clock_shows_twice_has_its_runs_once(berlin):
    site = Site(HALF_HOURS, datetime(2026, 10, 25, 0, 30))
    site.look()
    assert site.all_day(datetime(2026, 10, 25, 5)) == [
        f'25. {at}' for at in ('01:00', '01:30', '02:00', '02:30', '03:00', '03:30', '04:00')]
    assert set(site.requests.values()) == {1} and site.missed == 0


@settings(max_examples=settings.default.max_examples * 10 // 3)
@given(st.lists(st.tuples(st.integers(0, 5400), st.booleans(), st.booleans()), max_size=80))
def test_over_a_change_of_the_clock_with_restarts_each_run_is_made_or_counted(steps):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv('TZ', BERLIN)
        time.tzset()
        site = Site(HALF_HOURS, datetime(2026, 10, 24, 23, 0))
        site.look()
        first = site.stored[stored_name('milk')]
        for seconds, restarts, dies in steps:
            site.moment += seconds
            site.look(dies)
            if restarts:
                site.restart()
        site.look()
        latest = site.stored[stored_name('milk')]
    time.tzset()
    assert set(site.requests.values()) <= {1}
    expected = list(runs_by_the_day(HALF_HOURS, first + 1, latest))
    assert len(site.requests) + site.missed == len(expected)


def test_the_request_of_a_run_is_always_the_same_one_and_those_of_others_differ():
    minutes = range(BEGIN, BEGIN + 1000)
    ids = {request_of(hourly(name=name), minute).id for name in 'ab' for minute in minutes}
    assert len(ids) == 2000 and all(0 < id < 2 ** 31 for id in ids)
    assert request_of(hourly(), BEGIN) == request_of(hourly(), BEGIN)
