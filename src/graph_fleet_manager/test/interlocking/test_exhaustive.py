"""Everything that can happen in a small yard does, and no two robots come too near each other."""
from __future__ import annotations

import os

import pytest
from fleet_builders import graph_of
from yard_model import Limits, Yard

from graph_fleet_manager.fleet import RobotType

AGV = RobotType('agv', 0.4, 1.0)
LONG = os.environ.get('LD90_LONG_TESTS') == '1'
STAR = graph_of({1: (0, 0), 2: (2, 0), 3: (4, 0), 4: (2, 2)},
                {1: (1, 2), 2: (2, 3), 3: (2, 4)})


def test_x():
    yard = Yard(STAR, AGV, {'a': 1, 'b': -2}, Limits(2, 1))
    found = yard.search(2000)
    print(yard.states, found)
    assert found is None
