"""Work at stops is safe in every sequence of events, can always end, and needs each guard.

By default the searches visit only the states nearest to the beginning; see `proofs`.
"""
from __future__ import annotations

import pytest
from planted_guards import GUARDS
from proofs import LONG, is_whole
from work_model import Bounds, search

from fleet_core.work import tables
from fleet_core.work.stops import (
    Actor,
    Condition,
    LoadEffect,
    Policy,
    StepBlocking,
    When,
)
from fleet_core.work.stops import (
    WorkStep as Step,
)
from fleet_core.work.stops import (
    WorkStop as Stop,
)
from fleet_core.work.tables import LOAD, STEP, STOP, StepState, StopState
from route_protocol.steps import Word

MOST = None if is_whole(__file__) else 6_000  # number of states that a search visits
KNOWN = (Word.DONE, Word.FAILED)


def step(name: str, **more: object) -> Step:
    return Step(name, 1.0, **more)


TAKE = step('take', load=LoadEffect.TAKES)
GIVE = step('give', load=LoadEffect.GIVES, on_failure=Policy.FAIL)
AWAY = (Stop(20, steps=(step('away', load=LoadEffect.GIVES),), condition=Condition.LOADED),)
NONE = step('none', blocking=StepBlocking.NONE)

BOUNDS = {
    'a step': Bounds((Stop(10, steps=(step('a'),)),), manager=0),
    'a restart of the manager': Bounds((Stop(10, steps=(TAKE,)),), driver=0, timeout=0),
    'a step that is broken off': Bounds(
        (Stop(10, steps=(step('a', on_failure=Policy.FAIL, breakable=True),)),), manager=0,
        words=KNOWN),
    'a harmless step': Bounds(
        (Stop(10, steps=(step('a', on_failure=Policy.RETRY, retries=1, harmless=True),)),),
        manager=0, cancel=0),
    'two steps': Bounds((Stop(10, steps=(NONE, step('h'))),), cancel=0, driver=0, words=KNOWN),
    'a step before the entry': Bounds(
        (Stop(10, steps=(step('e', when=When.BEFORE_ENTRY), step('h', on_failure=Policy.SKIP))),),
        cancel=0, driver=0, words=KNOWN),
    'a load': Bounds((Stop(10, steps=(TAKE,)), Stop(20, steps=(GIVE,))), cancel=0, timeout=0,
                     driver=0, words=KNOWN),
    'a load that is brought away': Bounds((Stop(10, steps=(TAKE,)),), AWAY, driver=0, timeout=0,
                                          words=KNOWN),
    'a step that goes on during the drive': Bounds(
        (Stop(10, steps=(NONE,)), Stop(20, steps=(step('h'),))), driver=0, timeout=0, words=KNOWN),
    'a step that is repeated during the drive': Bounds(
        (Stop(10, steps=(step('n', blocking=StepBlocking.NONE, on_failure=Policy.RETRY, retries=1),
                         )), Stop(20, steps=(step('h'),))), orders=4, manager=0, driver=0,
        cancel=0, timeout=0, words=KNOWN),
    'a robot that is moved': Bounds((Stop(10, steps=(step('a'),)),), moved=1, cancel=0, driver=0,
                                    words=KNOWN),
    'a mission that becomes impossible': Bounds(
        (Stop(10, steps=(TAKE,)),), AWAY, fail=1, driver=0, timeout=0, words=KNOWN),
    'a robot that has worked before': Bounds(
        (Stop(10, steps=(step('a', on_failure=Policy.RETRY, retries=1),)),), last=5, cancel=0,
        driver=0, words=KNOWN),
    'other stops': Bounds(
        (Stop(10, steps=(step('e', when=When.BEFORE_ENTRY),)), Stop(20, steps=(step('h'),))),
        others=(Stop(30, steps=(step('o'),)),), changed=1, cancel=0, driver=0, timeout=0,
        words=KNOWN),
    'a load that goes elsewhere': Bounds(
        (Stop(10, steps=(TAKE,)), Stop(20, steps=(GIVE,))),
        others=(Stop(30, steps=(step('away', load=LoadEffect.GIVES),)),), changed=1, driver=0,
        timeout=0, words=KNOWN),
    'a person': Bounds((Stop(10, steps=(step('p', actor=Actor.PERSON),)),), manager=0),
}
if LONG:
    BOUNDS.update({
        'a load, and all faults': Bounds((Stop(10, steps=(TAKE,)),)),
        'a load that is brought away, and all faults': Bounds((Stop(10, steps=(TAKE,)),), AWAY),
        'a harmless step, and all faults': Bounds(
            (Stop(10, steps=(step('a', on_failure=Policy.RETRY, retries=1, harmless=True),)),)),
        'two steps, and all faults': Bounds((Stop(10, steps=(NONE, step('h'))),)),
        'three orders': Bounds((Stop(10, steps=(step('a'),)),), orders=3, manager=0),
        'a step that is broken off, and all faults': Bounds(
            (Stop(10, steps=(step('a', on_failure=Policy.FAIL, breakable=True),)),)),
    })


@pytest.mark.parametrize('name', BOUNDS)
def test_no_order_of_events_repeats_a_step_loses_a_load_or_moves_a_working_robot(name, capsys):
    found = search(BOUNDS[name], live=True, most=MOST)
    with capsys.disabled():
        print(f'\n{name}: {found.states} states')
    assert not found.flaw, str(found)


# -- each guard -----------------------------------------------------------------------------------

BOUNDS_OF = {
    'a step has a key of its own': 'a load',
    'a key is above all that the robot has taken': 'a robot that has worked before',
    'a mission that has become impossible ends its steps first':
        'a mission that becomes impossible',
    'a stop that has begun is not replaced': 'other stops',
    'a key is taken once': 'a step',
    'a command of an earlier run is ignored': 'a step',
    'a report of an earlier run is ignored': 'a restart of the driver',
    'nothing begins while a person is asked': 'two steps',
    'the robot stands where a step needs it': 'a hard step before the entry',
    'a hard step runs alone': 'two steps',
    'the gate is closed while a step runs': 'a load',
    'the stop is not entered before its steps': 'a step before the entry',
    'an unknown outcome is asked': 'a step',
    'a step that may still run is not retried': 'a step',
    'a step that may still be begun is not answered': 'a step',
    'the load is unknown while it moves': 'a load',
}
"""For each guard, the bounds of the search that finds a flaw if the guard is left out."""
SEARCHES = {
    **BOUNDS,
    'a restart of the driver': Bounds((Stop(10, steps=(TAKE,)),), cancel=0, timeout=0),
    'a hard step before the entry': Bounds(
        (Stop(10, steps=(step('e', when=When.BEFORE_ENTRY),)),), cancel=0, driver=0, timeout=0),
}


@pytest.mark.parametrize('name', GUARDS)
def test_a_guard_that_is_left_out_is_found(name, monkeypatch):
    monkeypatch.setattr(*GUARDS[name])
    # all states, because only a whole search can find a dead end
    found = search(SEARCHES[BOUNDS_OF[name]], live=True)
    assert found.flaw, f'nothing goes wrong in {found.states} states without: {name}'
    assert found.way, 'the search tells no way to the flaw'


def test_a_step_that_is_sent_before_it_is_stored_is_found():
    bounds = BOUNDS['a restart of the manager']
    found = search(Bounds(bounds.stops, driver=0, timeout=0, cancel=0, sends_unstored=True),
                   most=MOST)
    assert found.flaw.startswith('(e)'), str(found)


# -- the tables -----------------------------------------------------------------------------------


@pytest.mark.parametrize('table, states', [(STEP, StepState), (STOP, StopState)])
def test_what_has_ended_has_no_way_on(table, states):
    left = {state for state, _ in table}
    assert set(table.values()) - left == {state for state in states if state.is_final}


@pytest.mark.parametrize('table', [STEP, STOP, LOAD])
def test_each_state_of_a_table_is_reached_and_each_event_occurs(table):
    states, events = ({one[k] for one in table} for k in (0, 1))
    kind, event = type(next(iter(states))), type(next(iter(events)))
    assert states | set(table.values()) == set(kind) and events == set(event)


def test_an_event_that_a_table_does_not_have_is_a_defect():
    with pytest.raises(tables.NoTransition, match='DONE'):
        tables.after(STEP, StepState.DONE, tables.StepEvent.SEND)


