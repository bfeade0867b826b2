"""Several robots in a small yard, in every sequence of events: see `yard_model`."""
from __future__ import annotations

from dataclasses import replace
from typing import Any, Callable, Dict, FrozenSet, NamedTuple, Optional, Tuple, Type

import pytest
import yard_model
from fleet_builders import AGV, graph_of
from numbered_orders_model import Model
from proofs import LONG, is_whole
from yard_model import EVERY, Answer, Bounds, Fault, Side, Site, State, Yard

from fleet_core.interlocking import interlocking, route_master
from fleet_core.interlocking.route_master import RouteMaster
from route_protocol import master
from route_protocol.master import MasterState
from trajectory_graph import Graph

WHOLE = is_whole(__file__)
NEAREST = 8_000  # number of states that a search visits by default; with LIVE, a fifth of it
FAR = 15_000  # maximum number of states that may be needed to find a planted fault
LINE = graph_of({1: (0, 0), 2: (2.4, 0), 3: (4.8, 0)}, {1: (1, 2), 2: (2, 3)})
STAR = graph_of({1: (0, 0), 2: (2.4, 0), 3: (4.8, 0), 4: (2.4, 2.4)},
                {1: (1, 2), 2: (2, 3), 3: (2, 4)})
TOO_NEAR = graph_of({1: (2.4, 0), 2: (0, 0), 3: (2.4, 0.5), 4: (4.8, 0.5)},
                    {1: (1, 2), 2: (3, 4)})
BEGINS = {'a': 1, 'b': 3, 'c': 4}


class Search(NamedTuple):
    """A yard and bounds.

    most -- maximum number of states of a whole search; None: all states within its bounds
    """

    graph: Graph
    bounds: Bounds
    robots: int = 2
    most: Optional[int] = None
    closed: FrozenSet[int] = frozenset()

    def of(self, kind: Type[Yard] = Yard, model: Optional[Model] = None,
           live: bool = False, nearest: int = NEAREST) -> yard_model.Found:
        begins = dict(list(BEGINS.items())[:self.robots])
        most = self.most if WHOLE else nearest // 5 if live else nearest
        return kind(self.graph, AGV, begins, self.closed, model).search(self.bounds, most, live)


def at_once(grants: int, faults: int = 0, acts: int = 0, *kinds: Fault) -> Bounds:
    """Bounds for which each report arrives at once or never."""
    return Bounds(grants, faults, acts, False, frozenset(kinds) or EVERY)


SEARCHES = {
    'one grant, late reports': Search(STAR, Bounds(1)),
    'three grants': Search(STAR, at_once(3)),
    'three robots': Search(STAR, at_once(2), 3),
    'robots that begin too near to each other': Search(TOO_NEAR, at_once(1)),
    'people': Search(LINE, at_once(1, 0, 1)),
    'lost routes, refusals, restarts, a full disk': Search(LINE, at_once(
        2, 1, 0, Fault.ROUTE, Fault.REFUSAL, Fault.RESTART, Fault.DISK, Fault.CLOCK)),
    'robots without memory': Search(LINE, at_once(1, 1, 0, Fault.MEMORY)),
    'stops past the fleet manager': Search(LINE, at_once(1, 1, 0, Fault.STOP)),
    'another giver': Search(LINE, at_once(1, 1, 0, Fault.GIVER)),
    'an older journal': Search(LINE, at_once(1, 1, 0, Fault.JOURNAL), most=100_000),
}
if LONG:
    SEARCHES.update({
        'two grants, late reports': Search(STAR, Bounds(2)),
        'four grants': Search(STAR, at_once(4)),
        'three robots, late reports': Search(STAR, Bounds(1), 3),
        'all faults': Search(STAR, at_once(1, 1), most=2_000_000),
        'all faults, people, late reports': Search(STAR, Bounds(1, 1, 1), most=2_000_000),
        'two faults': Search(LINE, at_once(1, 2), most=2_000_000),
    })


@pytest.mark.parametrize('name', SEARCHES)
def test_nothing_that_can_happen_in_a_small_yard_brings_robots_too_near(name, capsys):
    found = SEARCHES[name].of()
    with capsys.disabled():
        print(f'\n{name}: {found.states} states')
    assert not found.flaw, str(found)


WALKS = 200 if LONG else 6 if WHOLE else 2
WIDE = Bounds(grants=40, faults=12, acts=8)
RING = graph_of({1: (0, 0), 2: (2.4, 0), 3: (4.8, 0), 4: (4.8, 2.4), 5: (2.4, 2.4), 6: (0, 2.4),
                 7: (7.2, 0)},
                {1: (1, 2), 2: (2, 3), 3: (3, 4), 4: (4, 5), 5: (5, 6), 6: (6, 1), 7: (2, 5),
                 8: (3, 7)})


def yard_to_walk_in(kind: Type[Yard] = Yard) -> Yard:
    return kind(RING, AGV, {'a': 1, 'b': 4, 'c': 7}, frozenset({7}))


def test_no_random_walk_in_a_larger_yard_brings_robots_too_near():
    yard = yard_to_walk_in()
    for seed in range(WALKS):
        found = yard.walk(WIDE, seed, 400)
        assert not found.flaw, f'walk {seed}: {found}'


def test_a_walk_that_found_a_fault_once_finds_none():
    found = yard_to_walk_in().walk(WIDE, 20, 400)
    assert not found.flaw, str(found)


LIVE = {
    'faults': Search(LINE, at_once(1, 1, 0, Fault.ROUTE, Fault.REFUSAL, Fault.RESTART, Fault.DISK,
                                   Fault.CLOCK)),
}
if LONG:
    LIVE.update({name: SEARCHES[name] for name in (
        'one grant, late reports', 'three robots', 'people', 'robots without memory',
        'stops past the fleet manager', 'an older journal')})


@pytest.mark.parametrize('name', LIVE)
def test_from_each_state_a_robot_can_be_brought_to_a_new_edge(name):
    found = LIVE[name].of(live=True)
    assert not found.flaw, str(found)


# -- each guard of the interlocking ----------------------------------------------------------------

GUARDS: Dict[str, Search] = {
    '_fleet_is_not_stopped': SEARCHES['people'],
    '_journal_can_be_written': Search(LINE, at_once(1, 1, 0, Fault.DISK)),
    '_no_person_is_needed': SEARCHES['people'],
    '_clock_is_right': Search(LINE, at_once(1, 1, 0, Fault.CLOCK)),
    '_robot_is_known': Search(LINE, at_once(1, 1, 0, Fault.RESTART)),
    '_others_are_known': SEARCHES['an older journal'],
    '_last_order_is_settled': SEARCHES['people'],
    '_edge_follows': Search(LINE, at_once(1)),
    '_edge_is_open': Search(LINE, at_once(1), closed=frozenset({1})),
    '_place_is_free': Search(LINE, at_once(2)),
}


SECOND_LINES = {
    '_robot_is_clear_of_others': 'robots that exclude each other by evidence need a person, and '
                                 'each edge from the place of the others is occupied',
    '_does_not_work': 'a robot at work has a stay without an end, or its errand is to stand',
}
"""Guards that can be left out without a flaw, because a second guard refuses the same cases; see
test_gates.py.
"""
OF_WORK = {'_stop_may_be_entered'}
"""Guards of the work at stops, which test_work_at_stops.py leaves out."""
OF_CLAIMS = {'_claims_are_ready'}
"""Guards of claims, which test_door_yard.py leaves out."""
OF_LOADS = {'_edge_is_open_to_load'}
"""Guards of loads, which test_loads.py leaves out."""


def test_each_guard_of_the_interlocking_is_left_out_once():
    guards = {one.__name__ for one in (*interlocking.GATES, *interlocking.CONDITIONS)}
    assert guards == {*GUARDS, *SECOND_LINES, *OF_WORK, *OF_CLAIMS, *OF_LOADS}


@pytest.mark.parametrize('name', GUARDS)
def test_a_guard_of_the_interlocking_that_is_left_out_is_found(name, monkeypatch):
    for table in ('GATES', 'CONDITIONS'):
        monkeypatch.setattr(interlocking, table, tuple(
            one for one in getattr(interlocking, table) if one.__name__ != name))
    assert GUARDS[name].of(nearest=FAR).flaw


# -- each rule that robots, the journal and the fleet manager follow -------------------------------

RULES = {
    'number': Search(LINE, at_once(2)),  # without this rule a robot obeys an order twice
    'refusal': Search(LINE, at_once(1, 1, 0, Fault.REFUSAL)),
    'epoch': SEARCHES['robots without memory'],
}


@pytest.mark.parametrize('rule', RULES)
def test_a_rule_of_the_protocol_that_robots_leave_out_is_found(rule):
    assert RULES[rule].of(model=Model(rule), nearest=FAR).flaw


class SendsBeforeItStores(Yard):
    def _taken(self, site: Site, ids: Tuple[int, ...]) -> State:
        sent = tuple(self._sent(site, id) for id in ids)
        return super()._taken(site, sent)


class StoresOnlyWhatReportsHaveChanged(Yard):
    def _answers(self, *asked: Any) -> Tuple[Answer, ...]:
        return tuple(one._replace(to_store=frozenset()) for one in super()._answers(*asked))


class DrawsNumbersWithoutAClock(Yard):
    def __init__(self, *of: Any) -> None:
        super().__init__(*of)
        self.clock.ahead = -1000


class LeavesRobotsThatExcludeEachOther(Yard):
    def _separated(self, is_starting: bool, before: Tuple[int, ...],
                   ids: Tuple[int, ...]) -> Tuple[Tuple[int, ...], bool]:
        return ids, False


class BelievesAnOlderJournal(Yard):
    def _restarted(self, side: Side, is_stopped: bool, is_wrong_run: bool) -> int:
        return super()._restarted(side, is_stopped, False)


YARDS: Dict[Type[Yard], Search] = {
    SendsBeforeItStores: Search(LINE, at_once(1)),
    StoresOnlyWhatReportsHaveChanged: SEARCHES['three grants'],
    DrawsNumbersWithoutAClock: SEARCHES['an older journal'],
    LeavesRobotsThatExcludeEachOther: SEARCHES['another giver'],
    BelievesAnOlderJournal: SEARCHES['an older journal'],
}


@pytest.mark.parametrize('kind', YARDS)
def test_a_fleet_manager_with_a_planted_fault_is_found(kind):
    assert YARDS[kind].of(kind, nearest=FAR).flaw


def test_a_planted_fault_is_found_by_a_random_walk():
    yard = yard_to_walk_in(BelievesAnOlderJournal)
    assert any(yard.walk(WIDE, seed, 400).flaw for seed in range(WALKS))


CHANGES: Dict[str, Tuple[Callable[[MasterState, MasterState], MasterState], Search]] = {
    'it forgets all open orders but the newest': (
        lambda before, after: replace(after, open=after.open[-1:]), Search(
            LINE, at_once(2, 0, 1))),
    'it holds nothing after a stop': (
        lambda before, after: replace(after, held=()), SEARCHES['people']),
    'it counts all that lies behind the robot as left': (
        lambda before, after: replace(after, behind=()), Search(STAR, at_once(2))),
    'it does not notice that another giver moves the robot': (
        lambda before, after: replace(after, is_anywhere=False), SEARCHES['another giver']),
}


@pytest.mark.parametrize('change', CHANGES)
def test_an_effect_of_reports_on_the_allocation_that_is_left_out_is_found(change, monkeypatch):
    apply, search = CHANGES[change]

    def hear(state, *said):
        after, news = master.hear(state, *said)
        return (apply(state, after) if news.is_new else after), news

    monkeypatch.setattr(route_master, 'hear', hear)
    assert search.of(nearest=FAR).flaw


def test_a_fleet_manager_that_draws_a_number_again_is_found(monkeypatch):
    monkeypatch.setattr(RouteMaster, '_next_number', lambda master: max(master.protocol.number, 1))
    assert Search(LINE, at_once(2)).of(nearest=FAR).flaw
