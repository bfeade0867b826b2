"""The random machine over the work of a fleet: what must hold does, and each mission ends.

Lives are drawn from seeds. --long lets 2,000,000 steps happen.
"""
from __future__ import annotations

import pytest
from proofs import LONG, is_whole

from world.random_work import lived

WHOLE = is_whole(__file__)
STEPS = 2_000_000 if LONG else 100_000 if WHOLE else 5_000
PARTS = 8 if WHOLE else 1  # of these steps, so that several processes share them
LIFE = 2500                # steps of a life before all faults end


@pytest.mark.parametrize('part', range(PARTS))
def test_work_keeps_its_rules_and_ends_in_each_random_life(part: int) -> None:
    steps, seed = 0, part
    while steps < STEPS // PARTS:
        steps += lived(seed, LIFE)
        seed += PARTS
