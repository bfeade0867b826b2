"""The interlocking always keeps robots apart, and each of its conditions is necessary."""
from __future__ import annotations

import os
from random import Random
from typing import Dict, Optional

import pytest
from fleet_builders import graph_of
from yard_model import Found, Limits, Yard, walk

from graph_fleet_manager.fleet import RobotType
from graph_fleet_manager.interlocking import interlocking

AGV = RobotType('agv', 0.4, 1.0)
LONG = os.environ.get('LD90_LONG_TESTS') == '1'
STAR = graph_of({1: (0, 0), 2: (2, 0), 3: (4, 0), 4: (2, 2)},
                {1: (1, 2), 2: (2, 3), 3: (2, 4)})
BEGINS = {'a': 1, 'b': -2, 'c': -3}
WALK = 2500  # steps on one random graph
STEPS = 1_000_000 if LONG else 50_000
EVER = Limits(10 ** 9, 10 ** 9, 6)


def told(found: Optional[Found]) -> str:
    """The text of a failing test."""
    return '' if found is None else '\n'.join((found.what, *found.history))


@pytest.mark.parametrize('robots, limits, most', [
    (2, Limits(1, 1), None), (2, Limits(2, 1), 300_000 if LONG else 6_000),
    (3, Limits(2, 2), 300_000 if LONG else 4_000)])
def test_nothing_that_can_happen_in_a_small_yard_brings_robots_too_near(robots, limits, most,
                                                                        capsys):
    yard = Yard(STAR, AGV, dict(list(BEGINS.items())[:robots]), limits, spare=3)
    found = yard.search(most)
    with capsys.disabled():
        print(f'\n{robots} robots, at most {limits.grants} grants, {limits.faults} faults and '
              f'{limits.flights} messages on their way: {yard.states} states'
              f'{"" if most is None else ", the first ones"}')
    assert found is None, told(found)


def random_yard(random: Random) -> Yard:
    """Four robots on an irregular grid with edges that cross without a vertex."""
    places = {3 * row + column + 1: (2.2 * column + random.uniform(-0.3, 0.3),
                                     2.2 * row + random.uniform(-0.3, 0.3))
              for row in range(3) for column in range(3)}
    pairs = [(v, v + 1) for v in places if v % 3] + [(v, v + 3) for v in places if v <= 6]
    pairs += random.sample([(1, 5), (2, 4), (5, 9), (6, 8), (2, 6), (3, 5)], 3)
    graph = graph_of(places, dict(enumerate(pairs, 1)))
    begins: Dict[str, int] = {name: random.choice(graph.edges_from(vertex))
                              for name, vertex in zip('abcd', random.sample(sorted(places), 4))}
    return Yard(graph, AGV, begins, EVER, spare=random.choice(sorted(graph.edges)))


def test_random_plans_faults_and_people_bring_no_robots_too_near():
    """No plan is followed, so nearly all requested grants are wrong."""
    for seed in range(STEPS // WALK):
        random = Random(seed)
        found = walk(random_yard(random), random, WALK)
        assert found is None, f'seed {seed}: {told(found)}'


# -- every condition is necessary -----------------------------------------------------------------


def first_fault(make=random_yard, **more) -> Optional[Found]:
    """The first fault within the given number of steps."""
    for seed in range(80):
        random = Random(seed)
        yard = make(random)
        for name, value in more.items():
            setattr(yard, name, value)
        found = walk(yard, random, WALK, trouble=0.1)
        if found is not None:
            return found
    return None


@pytest.mark.parametrize('name, conditions', [
    (condition.__name__, table) for table in ('GATES', 'CONDITIONS')
    for condition in getattr(interlocking, table)])
def test_without_any_one_of_its_conditions_something_goes_wrong(monkeypatch, name, conditions):
    kept = tuple(c for c in getattr(interlocking, conditions) if c.__name__ != name)
    monkeypatch.setattr(interlocking, conditions, kept)
    unheard = {'unheard': frozenset('d')} if name == '_others_are_known' else {}
    assert first_fault(**unheard) is not None, f'no search finds the lack of {name}'


def test_an_order_that_is_sent_before_it_is_stored_is_found():
    found = first_fault(sends_before_commit=True)
    assert found is not None, 'no search finds that a restart forgets a sent order'
