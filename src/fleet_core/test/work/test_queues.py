"""Queues before stations: turns, queue places and their order, in any situation."""
from __future__ import annotations

from random import Random
from typing import Dict, List, Optional, Set, Tuple

import pytest
from proofs import is_whole

from fleet_core.work.queues import EMPTY_QUEUE, Others, Queue, Waiter, advanced, has_place_for
from fleet_core.work.stations import Station, StationKind

LIVES = 60 if is_whole(__file__) else 20

PRESS = Station('press', (18,), (20, 22))
SHELVES = Station('shelves', (39, 42), (50,), 2, StationKind.GROUP)
AWAY = 99  # a vertex outside the station


def waiter(robot: str, places: Tuple[int, ...] = (18,), rank: int = 0,
           ends_at: Optional[int] = AWAY, is_inside: bool = False) -> Waiter:
    return Waiter(robot, places, (0, rank), ends_at, is_inside)


def after(*steps: Tuple[Tuple[Waiter, ...], Others], station: Station = PRESS) -> Queue:
    queue = EMPTY_QUEUE
    for waiters, others in steps:
        queue = advanced(queue, station, waiters, others)
    return queue


def test_the_oldest_mission_gets_the_turn_and_the_others_the_queue_places_in_order() -> None:
    queue = after(((waiter('c', rank=3), waiter('a', rank=1), waiter('b', rank=2),
                    waiter('d', rank=4)), Others()))
    assert queue.turns == {'a': 18}
    assert queue.waits == {'b': 20, 'c': 22, 'd': None}


def test_a_robot_keeps_its_turn_although_an_older_mission_comes() -> None:
    queue = after(((waiter('b', rank=2),), Others()),
                  ((waiter('a', rank=1), waiter('b', rank=2)), Others()))
    assert queue.turns == {'b': 18}


def test_a_robot_that_arrives_first_goes_before_one_that_is_still_on_its_way() -> None:
    busy = Others(inside=1)
    queue = after(((waiter('a', rank=1), waiter('b', rank=2)), busy),
                  ((waiter('a', rank=1), waiter('b', rank=2, ends_at=22)), busy))
    assert queue.waits == {'b': 20, 'a': 22}


def test_the_queue_moves_up_when_a_robot_gets_its_turn() -> None:
    waiting = (waiter('a', ends_at=20), waiter('b', ends_at=22), waiter('c', rank=9))
    queue = after((waiting, Others(inside=1)), (waiting, Others()))
    assert queue.turns == {'a': 18}
    assert queue.waits == {'b': 20, 'c': 22}


def test_a_robot_that_moves_up_has_still_arrived() -> None:
    busy = Others(inside=1)
    queue = after(((waiter('a', ends_at=22),), busy), ((waiter('a', ends_at=None),), busy),
                  ((waiter('a', ends_at=None), waiter('b', ends_at=22)), busy))
    assert queue.arrived == ('a', 'b')


def test_after_a_restart_the_robot_at_the_first_queue_place_is_first() -> None:
    queue = after(((waiter('a', rank=1, ends_at=22), waiter('b', rank=2, ends_at=20)), Others()))
    assert queue.turns == {'b': 18}


def test_a_robot_that_claims_the_station_has_its_turn_after_a_restart() -> None:
    queue = after(((waiter('a', rank=1), waiter('b', rank=2, is_inside=True)), Others()))
    assert queue.turns == {'b': 18}


def test_a_queue_place_in_which_a_robot_stays_is_left_out() -> None:
    queue = after(((waiter('a'),), Others(1, frozenset({18, 20}), frozenset({18, 20}))))
    assert queue.waits == {'a': 22}


def test_a_turn_ends_when_a_robot_that_is_no_waiter_claims_the_station() -> None:
    queue = after(((waiter('a'),), Others()), ((waiter('a'),), Others(inside=1)))
    assert queue.turns == {} and queue.waits == {'a': 20}


def test_the_nearest_free_place_of_a_group_is_chosen_at_the_turn() -> None:
    queue = after(((waiter('a', (42, 39)), waiter('b', (42, 39), rank=1)), Others()),
                  station=SHELVES)
    assert queue.turns == {'a': 42, 'b': 39}


def test_another_place_is_chosen_when_a_robot_stands_in_the_chosen_one() -> None:
    queue = after(((waiter('a', (42, 39)),), Others()),
                  ((waiter('a', (42, 39)),), Others(1, frozenset({42}), frozenset({42}))),
                  station=SHELVES)
    assert queue.turns == {'a': 39}


def test_a_chosen_place_stays_although_another_one_is_nearer_by_now() -> None:
    queue = after(((waiter('a', (42, 39)),), Others()), ((waiter('a', (39, 42)),), Others()),
                  station=SHELVES)
    assert queue.turns == {'a': 42}


def test_two_robots_that_want_each_others_places_have_no_turn_until_one_leaves() -> None:
    station = Station('twins', (18, 19), (20,), 2)
    both = (waiter('a', (19,), ends_at=18, is_inside=True),
            waiter('b', (18,), rank=1, ends_at=19, is_inside=True))
    queue = after((both, Others()), station=station)
    assert queue.turns == {} and queue.waits == {'a': 20, 'b': None}
    left = (waiter('a', (19,), ends_at=20), both[1])
    assert after((both, Others()), (left, Others()), station=station).turns == {'b': 18}


@pytest.mark.parametrize('station, waiters, others, place, is_so', [
    (PRESS, 0, Others(), (18,), True),
    (PRESS, 2, Others(), (18,), True),                        # the second queue place
    (PRESS, 3, Others(), (18,), False),
    (PRESS, 2, Others(1), (18,), False),                      # another robot stays in the press
    (PRESS, 2, Others(0, frozenset(), frozenset({20})), (18,), False),   # ... or in the queue
    (SHELVES, 2, Others(), (39, 42), True),
    (SHELVES, 3, Others(), (39, 42), False),
    (SHELVES, 1, Others(0, frozenset(), frozenset({39})), (39, 42), True),
    (SHELVES, 2, Others(0, frozenset(), frozenset({39})), (39, 42), False)])
def test_a_station_has_a_place_for_one_more_until_it_and_its_queue_are_full(
        station: Station, waiters: int, others: Others, place: Tuple[int, ...], is_so: bool
        ) -> None:
    assert has_place_for(place, [place] * waiters, station, others) is is_so


def test_robots_that_go_to_one_place_of_a_station_need_the_queue_although_another_is_free() -> None:
    twins = Station('twins', (18, 19), (20,), 2)
    assert has_place_for((18,), [(18,)], twins, Others())
    assert not has_place_for((18,), [(18,), (18,)], twins, Others())
    assert has_place_for((19,), [(18,), (18,)], twins, Others())
    assert not has_place_for((19,), [(18,), (19,), (19,)], twins, Others())


class Yard:
    """Robots that come to a station, work and leave, in a random order of events.

    The yard has no roads: a robot is sent to a place, and arrives there at a random time if the
    place is free.
    """

    def __init__(self, station: Station, seed: int, robots: int) -> None:
        self.station, self.draw = station, Random(seed)
        self.at: Dict[str, Optional[int]] = {f'r{k}': AWAY for k in range(robots)}
        self.wants: Dict[str, Tuple[int, ...]] = {}
        self.rank: Dict[str, int] = {}
        self.inside: Set[str] = set()
        self.working: Set[str] = set()
        self.broken: Set[str] = set()
        self.queue = EMPTY_QUEUE
        self.served: List[str] = []
        self.count = 0

    def waiters(self) -> List[Waiter]:
        return [Waiter(name, self.wants[name], (0, self.rank[name]), self.at[name],
                       name in self.inside) for name in self.wants if name not in self.broken]

    def others(self) -> Others:
        outside = {name for name in self.at if name not in self.wants or name in self.broken}
        at = {self.at[name] for name in outside} - {None, AWAY}
        kept = {self.at[name] for name in outside & self.broken} - {None, AWAY}
        return Others(len(outside & self.inside), frozenset(at), frozenset(kept))

    def event(self, quiet: bool = False) -> None:
        events = [self.drive, self.claim, self.work, self.make_room]
        if not quiet:
            events += [self.ask, self.ask, self.break_down, self.mend, self.restart, self.cancel]
        self.draw.choice(events)(self.draw.choice(sorted(self.at)))
        before = self.queue
        self.queue = advanced(before, self.station, self.waiters(), self.others())
        self.check(before)

    # -- events -----------------------------------------------------------------------------------

    def ask(self, name: str) -> None:
        if name not in self.wants and name not in self.broken:
            places = list(self.station.places)
            self.draw.shuffle(places)
            is_group = self.station.kind is StationKind.GROUP
            self.wants[name] = tuple(places if is_group else places[:1])
            self.count += 1
            self.rank[name] = self.count

    def drive(self, name: str) -> None:
        if name in self.broken or name in self.working:
            return
        target = self.queue.turns.get(name, self.queue.waits.get(name))
        if target is None or target == self.at[name]:
            return
        if target in self.station.places and name not in self.inside:
            return
        if self.at[name] is not None:  # it leaves a queue place or a place of the station
            self.at[name] = None
        elif target not in self.at.values():
            self.at[name] = target
            if target not in self.station.places:
                self.inside.discard(name)
            else:
                self.served.append(name)

    def claim(self, name: str) -> None:
        if name in self.queue.turns and len(self.inside) < self.station.capacity:
            self.inside.add(name)

    def work(self, name: str) -> None:
        if name in self.working:
            self.working.discard(name)
            del self.wants[name]
        elif name in self.queue.turns and self.at[name] == self.queue.turns[name]:
            if name not in self.broken:
                self.working.add(name)

    def make_room(self, name: str) -> None:
        is_waiting = name in self.queue.waits and self.queue.waits[name] is None
        if name not in self.broken and (name not in self.wants or is_waiting):
            self.at[name] = AWAY
            self.inside.discard(name)

    def break_down(self, name: str) -> None:
        if self.draw.random() < 0.3:
            self.broken.add(name)

    def mend(self, name: str) -> None:
        self.broken.discard(name)

    def restart(self, _: str) -> None:
        if self.draw.random() < 0.2:
            self.queue = EMPTY_QUEUE

    def cancel(self, name: str) -> None:
        if name not in self.working:
            self.wants.pop(name, None)

    # -- invariants -------------------------------------------------------------------------------

    def check(self, before: Queue) -> None:
        queue, station, others = self.queue, self.station, self.others()
        known = {one.robot: one for one in self.waiters()}
        inside = {name for name, one in known.items() if one.is_inside}
        assert queue.turns.keys() | queue.waits.keys() == known.keys()
        assert not queue.turns.keys() & queue.waits.keys()
        assert len(inside | queue.turns.keys()) + others.inside <= max(
            station.capacity, len(inside) + others.inside)
        targets = [*queue.turns.values(), *(q for q in queue.waits.values() if q is not None)]
        assert len(targets) == len(set(targets))
        for name, place in queue.turns.items():
            assert place in known[name].places
            assert all(at != place for other, at in self.at.items() if other != name)
        free = [place for place in station.queue if place not in others.kept]
        used = [queue.waits[name] for name in (*queue.arrived, *queue.coming)
                if queue.waits[name] is not None]
        assert used == free[:len(used)]
        assert len(used) == min(len(free), len(queue.waits))
        stayed = [name for name in before.arrived if name in queue.arrived]
        assert stayed == [name for name in queue.arrived if name in stayed]
        self._check_order(before)
        self._check_nobody_waits_in_vain(known, inside, others)

    def _check_order(self, before: Queue) -> None:
        """While a robot waits, no robot behind it gets a turn for a place that the waiting robot
        may use.
        """
        new = {name: place for name, place in self.queue.turns.items()
               if name not in before.turns and name not in self.inside}
        for waiting in self.queue.arrived:
            for name, place in new.items():
                is_behind = name not in before.arrived or (
                    waiting in before.arrived
                    and before.arrived.index(waiting) < before.arrived.index(name))
                if waiting in before.arrived and is_behind and waiting not in self.inside:
                    assert place not in self.wants[waiting]

    def _check_nobody_waits_in_vain(self, known: Dict[str, Waiter], inside: Set[str],
                                    others: Others) -> None:
        if len(inside | self.queue.turns.keys()) + others.inside >= self.station.capacity:
            return
        for name in self.queue.waits:
            taken = {at for other, at in self.at.items() if other != name} | {
                *self.queue.turns.values()}
            assert name in inside or set(known[name].places) <= taken


STATIONS = (PRESS, SHELVES, Station('bare', (18,)), Station('pair', (18, 19), (20, 22, 24), 2),
            Station('one_of_two', (18, 19), (20,), 1),
            Station('cells', (1, 2, 3), (20, 22), 2, StationKind.GROUP))


@pytest.mark.parametrize('station', STATIONS, ids=lambda one: one.name)
def test_in_any_order_of_events_the_queue_keeps_its_order_and_its_bounds(station: Station) -> None:
    for seed in range(LIVES):
        yard = Yard(station, seed, robots=5)
        for _ in range(300):
            yard.event()


@pytest.mark.parametrize('station', STATIONS, ids=lambda one: one.name)
def test_when_all_robots_work_again_each_waiter_is_served(station: Station) -> None:
    for seed in range(LIVES):
        yard = Yard(station, seed, robots=5)
        for _ in range(100):
            yard.event()
        yard.broken.clear()
        for _ in range(5000):
            yard.event(quiet=True)
            if not yard.wants:
                break
        assert not yard.wants, (seed, yard.queue, yard.at)
