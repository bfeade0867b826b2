"""Chargers: which robot gets a turn for which place, and which robot yields, in any situation."""
from __future__ import annotations

from random import Random
from typing import Dict, List, Optional, Set, Tuple

import pytest

from fleet_core.work.chargers import Candidate, Charger, Occupied, turns_of

DOCK = Charger('dock_6', (6,))
BAY = Charger('bay', (16, 24), 1)
FREE = Occupied()


def test_the_emptiest_robot_gets_the_nearest_place_and_the_others_wait() -> None:
    assert turns_of((DOCK,), (Candidate('a', (6,), 0.2), Candidate('b', (6,), 0.1)),
                    FREE) == {'b': 6}
    assert turns_of((DOCK, BAY), (Candidate('a', (24, 6), 0.2), Candidate('b', (24, 6), 0.1)),
                    FREE) == {'a': 6, 'b': 24}


def test_a_robot_keeps_its_turn_although_an_emptier_one_comes() -> None:
    assert turns_of((DOCK,), (Candidate('a', (6,), 0.2, had=6), Candidate('b', (6,), 0.1)),
                    FREE) == {'a': 6}


def test_a_chosen_place_stays_although_another_one_is_nearer_by_now() -> None:
    assert turns_of((DOCK, BAY), (Candidate('a', (6, 24), had=24),), FREE) == {'a': 24}


@pytest.mark.parametrize('occupied', [
    Occupied({16}, {'bay': 0}), Occupied({16}, {'bay': 1}), Occupied(frozenset(), {'bay': 1})])
def test_another_place_is_chosen_when_a_robot_stays_in_the_chosen_one(occupied: Occupied) -> None:
    one = Candidate('a', (16, 6), had=16)
    assert turns_of((DOCK, BAY), (one,), occupied) == {'a': 6}


def test_a_charger_for_fewer_robots_than_it_has_places_gives_as_few_turns() -> None:
    both = Candidate('a', (16, 24)), Candidate('b', (16, 24))
    assert turns_of((BAY,), both, FREE) == {'a': 16}
    assert turns_of((Charger('bay', (16, 24), 2),), both, FREE) == {'a': 16, 'b': 24}


def test_a_place_that_would_not_do_is_never_chosen() -> None:
    assert turns_of((DOCK, BAY), (Candidate('a', ()),), FREE) == {}
    assert turns_of((DOCK, BAY), (Candidate('a', (6,), had=16),), FREE) == {'a': 6}


def test_who_needs_to_charge_and_claims_the_charger_goes_before_who_had_a_turn() -> None:
    assert turns_of((DOCK,), (Candidate('a', (6,), 0.1, had=6),
                              Candidate('b', (6,), 0.2, is_inside=True)), FREE) == {'b': 6}


def test_who_tops_up_yields_to_who_needs_to_charge_also_by_the_capacity() -> None:
    tops_up = Candidate('a', (24,), 0.1, needs=False, had=24, is_inside=True)
    assert turns_of((BAY,), (tops_up, Candidate('b', (16,), 0.2)), FREE) == {'b': 16}
    assert turns_of((BAY, DOCK), (tops_up, Candidate('b', (6,), 0.2)), FREE) == {'a': 24, 'b': 6}


def test_who_tops_up_yields_to_a_mission_that_goes_to_its_place() -> None:
    wanted = Occupied(wanted=frozenset({6}))
    assert turns_of((DOCK,), (Candidate('a', (6,), needs=False, had=6),), wanted) == {}
    assert turns_of((DOCK,), (Candidate('a', (6,), had=6),), wanted) == {'a': 6}


class Yard:
    """Robots that charge at chargers, are parked in them, or break down in them, at random.

    The yard has no roads: a robot with a turn arrives at its place at a random time.
    """

    def __init__(self, seed: int) -> None:
        self.draw = Random(seed)
        places = iter(range(1, 9))
        self.chargers = [Charger(f'c{k}', tuple(next(places) for _ in range(count)),
                                 self.draw.randint(1, count))
                         for k, count in enumerate(self.draw.choice(
                             ((1,), (1, 1), (2,), (3, 1), (2, 2))))]
        self.at = {place: one for one in self.chargers for place in one.places}
        self.robots = 'abcde'[:self.draw.randint(1, 5)]
        self.docks = {name: tuple(place for place in self.at if self.draw.random() < 0.7)
                      for name in self.robots}
        self.charge: Dict[str, float] = {}
        self.needs: Dict[str, bool] = {}
        self.broken: Set[str] = set()
        self.place: Dict[str, Optional[int]] = dict.fromkeys(self.robots)
        self.wanted: Set[int] = set()
        self.turns: Dict[str, int] = {}

    def event(self) -> None:
        name, draw = self.draw.choice(self.robots), self.draw
        what = draw.choice(('needs', 'tops up', 'is charged', 'arrives', 'breaks', 'is repaired',
                            'leaves', 'a mission goes there', 'missions have ended'))
        if what in ('needs', 'tops up'):
            self.charge[name], self.needs[name] = draw.random(), what == 'needs'
        elif what == 'is charged':
            self.charge.pop(name, None)
        elif what == 'arrives' and name in self.turns:
            self._arrive(name, self.turns[name])
        elif what == 'breaks':
            self.broken.add(name)
        elif what == 'is repaired':
            self.broken.discard(name)
        elif what == 'leaves' and name not in self.broken:
            self.place[name] = None
        elif what == 'a mission goes there':
            self.wanted.add(draw.choice(list(self.at)))
        elif what == 'missions have ended':
            self.wanted.clear()

    def _arrive(self, name: str, place: int) -> None:
        """Lets a robot enter if the claims allow it. Robots that do not stay leave first."""
        charger = self.at[place]
        for other in self.robots:
            if other not in (*self.turns, *self.broken) and self.place[other] in charger.places:
                self.place[other] = None
        inside = [one for one in self.robots if self.place[one] in charger.places and one != name]
        if len(inside) < charger.capacity and all(self.place[one] != place for one in inside):
            self.place[name] = place

    def candidates(self) -> List[Candidate]:
        return [Candidate(name, self._would_do(name), self.charge[name], self.needs[name],
                          self.turns.get(name), self.place[name] is not None)
                for name in self.robots if name in self.charge and name not in self.broken]

    def _would_do(self, name: str) -> Tuple[int, ...]:
        here = self.place[name]
        return tuple(sorted(self.docks[name], key=lambda place: place != here))

    def occupied(self) -> Occupied:
        stay = [place for place in (self.place[name] for name in self.broken) if place is not None]
        return Occupied(frozenset(stay), {
            one.name: sum(place in one.places for place in stay) for one in self.chargers},
            frozenset(self.wanted))

    def step(self) -> None:
        self.event()
        candidates, occupied, before = self.candidates(), self.occupied(), self.turns
        self.turns = turns_of(self.chargers, candidates, occupied)
        self._check(candidates, occupied, before)

    def _check(self, candidates: List[Candidate], occupied: Occupied,
               before: Dict[str, int]) -> None:
        turns = self.turns
        assert len(set(turns.values())) == len(turns)
        assert not occupied.kept & set(turns.values())
        used = {one.name: [name for name, place in turns.items() if place in one.places]
                for one in self.chargers}
        for one in self.chargers:
            assert not used[one.name] or (
                len(used[one.name]) + occupied.inside[one.name] <= one.capacity)
        needing = {one.robot for one in candidates if one.needs}
        for one in candidates:
            assert turns.get(one.robot, None) in (None, *one.places)
            if one.robot in turns or not one.needs:
                continue
            for place in one.places:
                charger = self.at[place]
                own = [name for name in used[charger.name] if name in needing]
                owner = next((name for name, other in turns.items() if other == place), None)
                assert place in occupied.kept or owner in needing or (
                    len(own) + occupied.inside[charger.name] >= charger.capacity)
        for one in candidates:
            if one.needs and one.is_inside and one.had == self.place[one.robot] and (
                    one.had in one.places and self.place[one.robot] not in occupied.kept):
                assert turns.get(one.robot) == before[one.robot] or any(
                    other.needs and other.is_inside and other is not one for other in candidates)


@pytest.mark.parametrize('seed', range(40))
def test_the_rules_hold_after_any_events(seed: int) -> None:
    yard = Yard(seed)
    for _ in range(150):
        yard.step()
