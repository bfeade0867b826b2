"""A checker that shares no code with the planner judges every plan."""
from __future__ import annotations

import os
from random import Random

import pytest
from fleet_cases import Case
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from plan_checker import faults
from plan_replay import replay, replay_faults

from fleet_core.planning.layers import layered
from fleet_core.planning.safe_intervals import find_path
from trajectory_graph import GraphError

LONG = os.environ.get('LD90_LONG_TESTS') == '1'


@pytest.mark.parametrize('search', [find_path, layered(0.5)], ids=['safe_intervals', 'layers'])
@settings(max_examples=2000 if LONG else settings.default.max_examples * 2 // 5,
          suppress_health_check=list(HealthCheck))
@given(seed=st.integers(0, 2 ** 32 - 1))
def test_a_plan_on_any_graph_is_safe_whatever_the_delays(search, seed):
    random = Random(seed)
    try:
        case = Case(random)
    except GraphError:
        assume(False)
    plan = case.plan(search, seed)
    assume(plan is not None)
    world = case.world
    assert faults(world, plan) == []
    for _ in range(3):
        assert replay_faults(world, plan, replay(world, plan, random)) == []


def test_many_drives_under_random_delays_come_near_nobody():
    """Measured in drives; with LD90_LONG_TESTS=1 a million of them."""
    driven, seed = 0, 0
    while driven < (1_000_000 if LONG else 2_000):
        seed += 1
        random = Random(seed)
        try:
            case = Case(random)
        except GraphError:
            continue
        plan = case.plan(rounds=0)
        if plan is None:
            continue
        world = case.world
        for _ in range(50 if LONG else 5):
            drives = replay(world, plan, random)
            assert replay_faults(world, plan, drives) == [], seed
            driven += sum(map(len, drives.values()))
