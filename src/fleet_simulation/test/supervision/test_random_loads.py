"""The random machine over work, with loads that need more room than the robots that carry them.

The load is so wide that no other robot may stand at the next vertex, and it may not use one of the
two lanes. `test_loads` leaves each guard out.
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
