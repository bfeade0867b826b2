"""The random test of work (`random_work`): the invariants hold, and each mission ends.

A seed determines a run, here called a life. If a guard is left out, some lives fail: for each
guard, the tables name the seed of a life that fails soon. One guard is an exception, `a report of
an earlier run is ignored`: only the search over all states finds that this guard is missing
(`test_work_model`). `test_door_yard` finds it if orders are not checked when they are sent.
"""
from __future__ import annotations

from typing import Any, Mapping, Tuple

import pytest
from planted_guards import GUARDS
from proofs import LONG, is_whole
from random_work import lived

from fleet_core.interlocking.claims import Claims
from fleet_core.supervision import device_desk
from fleet_core.supervision.work_desk import WorkDesk
from fleet_core.work import rules

WHOLE = is_whole(__file__)
STEPS = 2_000_000 if LONG else 100_000 if WHOLE else 2_500
PARTS = 8 if WHOLE else 1  # parts into which the steps are divided, for several processes
LIFE = 2500                # number of steps of a life before all faults end


@pytest.mark.parametrize('part', range(PARTS))
def test_work_keeps_its_rules_and_ends_in_each_random_life(part: int) -> None:
    steps, seed = 0, part
    while steps < STEPS // PARTS:
        steps += lived(seed, LIFE)
        seed += PARTS


@pytest.mark.parametrize('seed', [29, 151, 5031, 5085, 5112, 5115, 5223] if WHOLE else [151])
def test_lives_that_found_a_fault_once_find_none(seed: int) -> None:
    lived(seed, LIFE)


_DUE = WorkDesk.due


def _claims_nothing(self: Claims, name: str, _: object) -> None:
    self._needed[name] = frozenset()
    self._note(name)


def _sends_unstored(self: WorkDesk, now: float) -> object:
    self._stored = dict(self._works)
    return _DUE(self, now)


AROUND: Mapping[str, Tuple[Any, str, Any]] = {
    'claims never exceed the capacity': (Claims, '_is_free', lambda self, name, resource: True),
    'a claim is ready when its device is open': (
        Claims, '_is_ready', lambda self, name, resource: resource in self.stored_of(name)),
    'an edge needs its claims': (Claims, 'keeping_out', lambda *_: ''),
    'a claim ends by the place': (Claims, 'follow', _claims_nothing),
    'a report of a device counts while it is fresh': (
        device_desk, '_is_fresh', lambda report, now: True),
    'a robot at work stands': (WorkDesk, 'at_work', property(lambda self: frozenset())),
    'a robot that was moved away is not at work': (rules, '_moved', lambda work, where: work),
    'a mission without a robot is not at work': (WorkDesk, 'parted', lambda self, mission: None),
    'a laden robot begins no other mission': (
        WorkDesk, 'laden', property(lambda self: frozenset())),
    'a machine carries out one step': (WorkDesk, '_is_busy', lambda self, device: False),
    'a command is sent when its step is stored': (WorkDesk, 'due', _sends_unstored),
}
"""Guards of claims, devices and the work desk, each with the change that leaves it out.

The table has the same form as `planted_guards`.
"""
SOON = {
    'a step has a key of its own': 0, 'a key is taken once': 0,
    'the robot stands where a step needs it': 1, 'an unknown outcome is asked': 1,
    'a step that may still be begun is not answered': 3, 'an edge needs its claims': 0,
    'a laden robot begins no other mission': 2, 'a stop that has begun is not replaced': 0,
    'a command of an earlier run is ignored': 1, 'nothing begins while a person is asked': 5,
    'a hard step runs alone': 0, 'the load is unknown while it moves': 0,
    'a claim is ready when its device is open': 0, 'a claim ends by the place': 0,
    'the gate is closed while a step runs': 14, 'a robot at work stands': 14,
    'a report of a device counts while it is fresh': 76}
"""For each guard: the seed of a life that fails within 700 steps without the guard."""
LATER = {
    'a key is above all that the robot has taken': 2,
    'a mission that has become impossible ends its steps first': 18,
    'the stop is not entered before its steps': 10, 'a step that may still run is not retried': 0,
    'claims never exceed the capacity': 24, 'a machine carries out one step': 23,
    'a command is sent when its step is stored': 13,
    'a robot that was moved away is not at work': 36,
    'a mission without a robot is not at work': 5085}
"""For each guard: the seed of a life that fails without the guard."""
LIVES = {**SOON, **(LATER if WHOLE else {})}


@pytest.mark.parametrize('name', LIVES)
def test_a_guard_that_is_left_out_is_found(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(*{**GUARDS, **AROUND}[name])
    with pytest.raises(AssertionError):
        lived(LIVES[name], LIFE)


def test_each_guard_is_left_out_by_a_life_or_by_the_search() -> None:
    assert {*GUARDS, *AROUND} - {*SOON, *LATER} == {'a report of an earlier run is ignored'}
