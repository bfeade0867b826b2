"""The random machine over work, with loads that need more room than the robots that carry them.

The load is so wide that no other robot may stand at the next vertex, and it may not use one of the
two lanes. With a guard left out, the machine finds a flaw: the table names a life that finds it.
"""
from __future__ import annotations

from typing import Any, Mapping, Tuple

import pytest
from proofs import LONG, is_whole
from random_work import lived

from fleet_core.interlocking import interlocking
from fleet_core.interlocking.interlocking import Interlocking
from fleet_core.supervision.load_room import LoadRoom
from fleet_core.work.loads import LoadType
from fleet_core.work.work import RobotLoad

WHOLE = is_whole(__file__)
STEPS = 300_000 if LONG else 40_000 if WHOLE else 800
LIFE = 2500
PALLET = LoadType('pallet', 1.6, closed=frozenset({3}))


def test_no_load_meets_a_robot_in_each_random_life() -> None:
    steps, seed = 0, 0
    while steps < STEPS:
        steps += lived(seed, min(LIFE, STEPS), PALLET)
        seed += 1


def _without(name: str) -> Tuple[interlocking.Condition, ...]:
    return tuple(one for one in interlocking.CONDITIONS if one.__name__ != name)


GUARDS: Mapping[str, Tuple[Any, str, Any, int]] = {
    'an edge is open to the load': (
        interlocking, 'CONDITIONS', _without('_edge_is_open_to_load'), 2),
    'a load is taken when there is room for it': (
        LoadRoom, 'lacks_room', lambda *_: False, 0),
    'a robot becomes larger when no robot is in its way': (
        Interlocking, 'without_room', lambda *_: '', 0),
    'what a robot may carry counts': (
        RobotLoad, 'may_be', property(lambda self: frozenset()), 0)}
"""Where a guard is, what stands in its place, and the life that finds that it is left out."""


@pytest.mark.parametrize('name', GUARDS)
def test_a_guard_that_is_left_out_is_found(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    owner, attribute, instead, life = GUARDS[name]
    monkeypatch.setattr(owner, attribute, instead)
    with pytest.raises(AssertionError):
        lived(life, LIFE, PALLET)
