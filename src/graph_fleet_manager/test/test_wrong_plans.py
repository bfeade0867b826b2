"""After every answer of the planner, robots drive on as soon as it answers rightly again."""
from __future__ import annotations

from dataclasses import replace
from typing import Callable

import pytest
from fleet_builders import AGV, ladder

from fleet_simulation.supervised_fleet import SupervisedFleet
from graph_fleet_manager.planning.tasks import Outcome
from graph_fleet_manager.supervision.actions import AskPlanner

WRONG = 2  # answers


class MisledFleet(SupervisedFleet):
    """Its first plans are wrong."""

    spoil: Callable[[Outcome], Outcome]
    answers = 0

    def _plan(self, question: AskPlanner) -> Outcome:
        self.answers += 1
        outcome = super()._plan(question)
        return type(self).spoil(outcome) if self.answers <= WRONG else outcome


def without_drives(outcome: Outcome) -> Outcome:
    """All robots stay where they are, and are said to be served."""
    return replace(outcome, drives=dict.fromkeys(outcome.drives, ()))


def exchanged(outcome: Outcome) -> Outcome:
    """Each robot has the drives of another one."""
    names = list(outcome.drives)
    return replace(outcome, precedence=(), drives={
        name: outcome.drives[other] for name, other in zip(names, names[1:] + names[:1])})


def with_holes(outcome: Outcome) -> Outcome:
    """The second drive of each robot is left out."""
    return replace(outcome, precedence=(), drives={
        name: drives[:1] + drives[2:] for name, drives in outcome.drives.items()})


def without_order(outcome: Outcome) -> Outcome:
    """No robot waits for another one."""
    return replace(outcome, precedence=())


@pytest.mark.parametrize('spoil', [without_drives, exchanged, with_holes, without_order])
def test_missions_end_though_the_first_plans_were_wrong(spoil, monkeypatch):
    monkeypatch.setattr(MisledFleet, 'spoil', staticmethod(spoil), raising=False)
    fleet = MisledFleet(ladder(5), {'a': (AGV, 1), 'b': (AGV, 5)}, parking=(1, 5))
    fleet.request(1, 5, robot='a')
    fleet.request(2, 1, robot='b')
    fleet.run_until_done(1, 2, limit=120.0)
    assert fleet.answers > WRONG


def test_a_plan_that_leads_a_robot_past_its_destination_is_told(monkeypatch):
    monkeypatch.setattr(MisledFleet, 'spoil', staticmethod(without_drives), raising=False)
    fleet = MisledFleet(ladder(5), {'a': (AGV, 1)}, parking=(1,))
    fleet.request(1, 5, robot='a')
    fleet.run_until_done(1, limit=120.0)
    assert any('does not lead a to its destinations' in note for note in fleet.notes)
