"""Grants while the planner works, in every sequence of events: see `granting_model`."""
from __future__ import annotations

import os
from typing import Mapping, NamedTuple, Optional, Tuple

import pytest
from fleet_builders import graph_of
from granting_model import Flaw, Fleet, Found, Guard

from trajectory_graph import Graph

LONG = os.environ.get('LD90_LONG_TESTS') == '1'
SIDING = graph_of({1: (0, 0), 2: (1, 0), 3: (2, 0), 4: (3, 0), 5: (2, 1)},
                  {1: (1, 2), 2: (2, 3), 3: (3, 4), 4: (2, 5), 5: (5, 4)})
"""Robots that come from both ends can pass each other between 2 and 4."""
NECK = graph_of({1: (0, 0), 2: (1, 0), 3: (2, 0), 4: (3, 0), 5: (3, 1), 6: (4, 0), 7: (0, 1),
                 8: (5, 0)},
                {1: (1, 2), 2: (7, 2), 3: (2, 3), 4: (3, 4), 5: (4, 6), 6: (3, 5), 7: (5, 6),
                 8: (6, 8)})
"""Between 2 and 3 there is room for only one robot; between 3 and 6 robots can pass each other."""
NEAR, FAR = 0.5, 1.5  # m that a question foresees; until the answer, robots drive more (less)


class Search(NamedTuple):
    graph: Graph
    robots: Mapping[str, Tuple[int, int]]
    questions: int = 3

    def of(self, further: float, forgetful: bool = False, without: Optional[Guard] = None,
           *sought: Flaw) -> Found:
        fleet = Fleet(self.graph, self.robots, further, forgetful, without)
        return fleet.search(self.questions, sought or tuple(Flaw))


PASSING = Search(SIDING, {'a': (1, 4), 'b': (4, 1)})
TWO = Search(NECK, {'a': (1, 6), 'b': (6, 7)})
THREE = Search(NECK, {'a': (1, 6), 'b': (6, 7), 'c': (8, 1)}, 2)


@pytest.mark.parametrize('further', [NEAR, FAR])
@pytest.mark.parametrize(('search', 'forgetful'), [
    (PASSING, False), (PASSING, True), (TWO, False),
    *([(TWO, True), (THREE, False), (THREE, True)] if LONG else [])])
def test_in_no_order_of_events_is_an_edge_held_before_its_turn_or_a_robot_stuck(
        search, forgetful, further, capsys):
    found = search.of(further, forgetful)
    with capsys.disabled():
        print(f'\nall {found.states} states, {found.unused} answers did not fit')
    assert found.flaw is None, found


def test_some_answers_do_not_fit():
    """Otherwise no search would visit the states after an answer that does not fit."""
    assert TWO.of(NEAR).unused > 0


@pytest.mark.parametrize(('guard', 'search', 'further', 'forgetful', 'flaw'), [
    (Guard.DUE, TWO, NEAR, False, Flaw.ANSWERABLE),
    (Guard.FREE, PASSING, NEAR, True, Flaw.POSSIBLE),
    (Guard.LIMIT, TWO, NEAR, False, Flaw.FITS),
    (Guard.PREFIX, TWO, NEAR, False, Flaw.PLANNED),
    (Guard.TURN, TWO, NEAR, False, Flaw.IN_TURN),
    (Guard.TURN, TWO, NEAR, False, Flaw.LIVE),
])
def test_without_any_one_of_its_rules_the_search_finds_a_flaw(guard, search, further, forgetful,
                                                              flaw):
    found = search.of(further, forgetful, guard, flaw)
    assert found.flaw is flaw, f'nothing goes wrong in {found.states} states without {guard.value}'
    assert found.way
