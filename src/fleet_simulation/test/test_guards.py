"""Chaos at the speed of virtual time: lives drawn from seeds, a tenth of the plans corrupted.

The promises hold while all guards of the interlocking do; without one of these guards they break.
The supervisor asks for nothing at all where one of the other guards would refuse (a stop, a person,
the journal, an order that is open, a robot that is too near or was never heard), so that no life
misses these: test_interlocking_proof.py asks the interlocking itself, and misses each.
The supervisor also refuses most wrong plans. Lives without a guard are lived without this check.
"""
from __future__ import annotations

import os
import random
from typing import List, Sequence

import pytest

from fleet_simulation.chaos import (
    DOCKS,
    PARKING,
    PEOPLE,
    ROBOTS,
    SAME,
    TROUBLE,
    YARD,
    Chaos,
    Event,
)
from fleet_simulation.supervised_fleet import SupervisedFleet
from fleet_simulation.wrong_plans import WRONG, Spoil, exchanged, with_holes, without_order
from graph_fleet_manager.fleet import RobotType
from graph_fleet_manager.interlocking import interlocking
from graph_fleet_manager.planning.tasks import Outcome
from graph_fleet_manager.supervision import questions
from graph_fleet_manager.supervision.actions import AskPlanner
from graph_fleet_manager.supervision.settings import RobotSettings

AGV = RobotType('agv', 0.4, 1.0, docks=frozenset(DOCKS))
LIVES = 60 if os.environ.get('LD90_LONG_TESTS') == '1' else 20  # with all guards


class CorruptedFleet(SupervisedFleet):
    """A tenth of its plans are wrong."""

    kinds: Sequence[Spoil] = tuple(WRONG.values())

    def _plan(self, question: AskPlanner) -> Outcome:
        outcome = super()._plan(question)
        if self.random.random() >= 0.1:
            return outcome
        return self.random.choice(self.kinds)(outcome, self.random)


def live(seed: int) -> None:
    """One life; raises AssertionError where a promise is broken."""
    draw = random.Random(f'life {seed}')
    fleet = CorruptedFleet(
        YARD, {name: (AGV, 21 + k) for k, name in enumerate(ROBOTS)}, seed=seed,
        loss=draw.choice((0.0, 0.05)), planning=draw.choice((0.05, 0.3)), parking=PARKING,
        settings=RobotSettings(release_ahead=draw.choice((0.0, 3.0, 8.0))))
    chaos = Chaos(fleet)
    if draw.random() < 0.25:
        chaos.hide(draw.choice(ROBOTS), draw.randrange(61))
    acts: List[str] = ['request'] * 12 + [*PEOPLE, *TROUBLE]
    for _ in range(40):
        chaos.happen(Event(draw.choice(acts), draw.choice(('now', 'now', 'order', 'plan')),
                           draw.choice((SAME, 0, 1, 2)), draw.randrange(61),
                           draw.choice((0.3, 0.8, 2.0))))
    chaos.end()


def test_with_all_guards_every_promise_is_kept() -> None:
    for seed in range(LIVES):
        live(seed)


@pytest.mark.parametrize(('table', 'guard', 'seed'), [
    ('GATES', '_clock_is_right', 44), ('GATES', '_others_are_known', 25),
    ('CONDITIONS', '_edge_follows', 48), ('CONDITIONS', '_place_is_free', 21),
])
def test_a_guard_that_is_missing_is_found(table: str, guard: str, seed: int,
                                          monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(CorruptedFleet, 'kinds', (without_order, with_holes, exchanged))
    monkeypatch.setattr(questions, 'fault_of', lambda *_: '')
    guards = getattr(interlocking, table)
    live(seed)
    without = tuple(one for one in guards if one.__name__ != guard)
    assert len(without) == len(guards) - 1
    monkeypatch.setattr(interlocking, table, without)
    with pytest.raises(AssertionError):
        live(seed)
