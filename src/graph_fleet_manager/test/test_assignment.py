"""Missions are shared out so that the sum of the times is least."""
from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment

from graph_fleet_manager.supervision.assignment import least_sum


@pytest.mark.parametrize('seed', range(20))
def test_the_sum_is_least_whatever_the_shape(seed):
    random = np.random.default_rng(seed)
    shape = tuple(random.integers(1, 9, 2))
    costs = np.where(random.random(shape) < 0.3, 1e15, random.integers(0, 5, shape).astype(float))
    costs += 1e7 * np.arange(shape[0])[:, np.newaxis] * (costs < 1e15)
    rows, columns = least_sum(costs)
    assert len(rows) == len(set(rows)) == len(set(columns)) == min(shape)
    best = linear_sum_assignment(costs)
    assert costs[rows, columns].sum() == pytest.approx(costs[best].sum(), rel=1e-12)


def test_what_costs_nothing_is_a_choice_too():
    rows, columns = least_sum(np.array([[0.0, 5.0], [5.0, 0.0]]))
    assert dict(zip(rows.tolist(), columns.tolist())) == {0: 0, 1: 1}
