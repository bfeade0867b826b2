"""Missions that wait for others never form a ring, in any order of requests and ends."""
from __future__ import annotations

from itertools import combinations, permutations, product
from typing import Dict, Iterator, List, Tuple

import pytest
from fleet_builders import AGV, corridor

from fleet_core.supervision.mission_book import MOST_AFTER, MOST_OPEN, MissionBook
from fleet_core.supervision.missions import Acceptance, MissionState, Request, RequestRefused
from fleet_core.work.dependencies import Dependency, Until

ACCEPTANCE = Acceptance(corridor(5), {'a': AGV})
IDS = (1, 2, 3)
ENDS = (MissionState.SUCCEEDED, MissionState.CANCELLED)


def wishes() -> Iterator[Tuple[Tuple[Dependency, ...], ...]]:
    """All sets of dependencies of the three missions, even on themselves and in rings."""
    sets = [some for count in range(3) for some in combinations(IDS, count)]
    for ids in product(sets, repeat=3):
        for until in Until:
            yield tuple(tuple(Dependency(id, until) for id in some) for some in ids)


def accept(book: MissionBook, id: int, after: Tuple[Dependency, ...]) -> bool:
    try:
        return book.add(Request(id, (2,), stamp=float(id), after=after), ACCEPTANCE) is not None
    except RequestRefused:
        return False


def check(book: MissionBook, after: Dict[int, Tuple[Dependency, ...]]) -> None:
    """Fails if a mission begins too early, waits in vain, or waits in a ring."""
    for id, given in after.items():
        mission = book.find(id)
        if not mission.state.is_open:
            continue
        others = [book.find(one.mission) for one in given]
        waits = any(other.state.is_open for other in others)
        assert mission.state is (MissionState.BLOCKED if waits else MissionState.PENDING)
        assert (mission in book.pending) is not waits
        assert all(one.serial < mission.serial for one in mission.request.after), 'a ring'


def open_of(book: MissionBook) -> List[int]:
    return [mission.request.id for mission in book.open]


@pytest.mark.parametrize('order', permutations(IDS))
def test_in_every_order_of_requests_and_ends_no_mission_waits_in_vain(order):
    for given, ends in product(wishes(), product(ENDS, repeat=3)):
        book, after = MissionBook(), {}
        for id in order:
            if accept(book, id, given[id - 1]):
                after[id] = given[id - 1]
            check(book, after)
        for _ in IDS:
            ready = [mission for mission in book.open if mission.state is MissionState.PENDING]
            assert bool(ready) is bool(open_of(book)), 'all missions wait for each other'
            for mission in ready[:1]:
                book.set(mission, ends[mission.request.id - 1])
                check(book, after)
        assert not open_of(book)


@pytest.mark.parametrize('until, end, state', [
    (Until.DONE, MissionState.SUCCEEDED, MissionState.PENDING),
    (Until.DONE, MissionState.CANCELLED, MissionState.FAILED),
    (Until.ENDED, MissionState.CANCELLED, MissionState.PENDING)])
def test_the_end_of_a_mission_lets_the_next_one_begin_or_fail(until, end, state):
    book = MissionBook()
    accept(book, 1, ())
    accept(book, 2, (Dependency(1, until),))
    second = book.find(2)
    assert second.reason == 'it waits for the end of mission M1'
    restarted = MissionBook(book.open, 3)
    restarted.set(restarted.find(1), end)
    assert restarted.find(2).state is state


@pytest.mark.parametrize('after, told', [
    (2, 'mission 2, but there is no'), (9, 'mission 9, but there is no'), (1, 'has ended: FAILED')])
def test_a_mission_comes_only_after_missions_that_can_still_be_done(after, told):
    book = MissionBook()
    accept(book, 1, ())
    book.set(book.find(1), MissionState.FAILED)
    with pytest.raises(RequestRefused, match=told):
        book.add(Request(2, (2,), after=(Dependency(after),)), ACCEPTANCE)


def test_a_request_that_could_not_be_stored_waits_for_nothing():
    book = MissionBook()
    accept(book, 1, ())
    accept(book, 2, (Dependency(1),))
    book.withdraw(book.find(2), None)
    book.set(book.find(1), MissionState.SUCCEEDED)
    assert book.find(2) is None and not open_of(book)


@pytest.mark.parametrize('untils', product(Until, repeat=3))
@pytest.mark.parametrize('end', ENDS)
def test_a_mission_that_is_named_several_times_is_waited_for_as_if_it_were_named_by_all_once(
        untils, end):
    book = MissionBook()
    accept(book, 1, ())
    accept(book, 2, tuple(Dependency(1, until) for until in untils))
    book.set(book.find(1), end)
    fails = end is MissionState.CANCELLED and Until.DONE in untils
    assert book.find(2).state is (MissionState.FAILED if fails else MissionState.PENDING)


@pytest.mark.parametrize('end, state', [
    (MissionState.CANCELLED, MissionState.FAILED), (MissionState.SUCCEEDED, MissionState.BLOCKED)])
def test_a_chain_of_all_open_missions_ends_as_its_first_mission_does(end, state):
    book = MissionBook()
    accept(book, 1, ())
    for id in range(2, MOST_OPEN + 1):
        accept(book, id, (Dependency(id - 1),))
    book.set(book.find(1), end)
    assert book.find(MOST_OPEN).state is state


def test_a_mission_comes_after_a_limited_number_of_missions():
    book = MissionBook()
    accept(book, 1, ())
    assert accept(book, 2, (Dependency(1),) * MOST_AFTER)
    with pytest.raises(RequestRefused, match='after more than 100 missions'):
        book.add(Request(3, (2,), after=(Dependency(1),) * (MOST_AFTER + 1)), ACCEPTANCE)
