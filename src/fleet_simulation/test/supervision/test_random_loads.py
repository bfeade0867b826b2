"""The random test of work (`random_work`), with loads that need more room than their robots.

The load is so wide that no other robot may stand at the next vertex, and one of the two lanes is
closed to the load. `test_loads` tests that the check finds a missing guard.
"""
from __future__ import annotations

from proofs import LONG, is_whole
from random_work import lived

from fleet_core.work.loads import LoadType

STEPS = 300_000 if LONG else 40_000 if is_whole(__file__) else 800
LIFE = 2500
PALLET = LoadType('pallet', 1.6, closed=frozenset({3}))


def test_no_load_meets_a_robot_in_each_random_life() -> None:
    steps, seed = 0, 0
    while steps < STEPS:
        steps += lived(seed, min(LIFE, STEPS), PALLET)
        seed += 1
