"""After any wrong answer of the planner, robots drive on as soon as the planner answers correctly.
"""
from __future__ import annotations

from dataclasses import replace
from random import Random

import pytest
from fleet_builders import AGV, ladder

from fleet_core.planning.precedence import Constraint
from fleet_core.planning.tasks import PlannedDrive, PlanningOutcome, Task
from fleet_core.supervision.actions import AskPlanner
from fleet_core.supervision.plan_check import fault_of
from world.supervised_fleet import SupervisedFleet
from world.wrong_plans import WRONG, without_drives

SPOILT = 2  # answers


class MisledFleet(SupervisedFleet):
    """A fleet whose first plans are wrong."""

    spoil = staticmethod(without_drives)
    answers = 0

    def _plan(self, question: AskPlanner) -> PlanningOutcome:
        self.answers += 1
        outcome = super()._plan(question)
        return self.spoil(outcome, self.random) if self.answers <= SPOILT else outcome


@pytest.mark.parametrize('seed', range(3))
@pytest.mark.parametrize('name', WRONG)
def test_missions_end_though_the_first_plans_were_wrong(name, seed, monkeypatch):
    monkeypatch.setattr(MisledFleet, 'spoil', staticmethod(WRONG[name]))
    fleet = MisledFleet(ladder(5), {'a': (AGV, 1), 'b': (AGV, 5)}, parking=(1, 5), seed=seed)
    fleet.request(1, 5, robot='a')
    fleet.request(2, 1, robot='b')
    fleet.run_until_done(1, 2, limit=120.0)
    assert fleet.answers > SPOILT


def test_after_a_wrong_answer_the_planner_is_not_asked_to_keep_the_plan_in_force():
    """The plan in force may be the cause: its times may be wrong, and no check finds wrong times.
    """
    asked = []

    class Fleet(SupervisedFleet):
        def _plan(self, question):
            asked.append(question)
            outcome = super()._plan(question)
            return without_drives(outcome, self.random) if len(asked) == 2 else outcome

    fleet = Fleet(ladder(5), {'a': (AGV, 1), 'b': (AGV, 5)}, parking=(1, 5))
    fleet.request(1, 5, robot='a')
    fleet.run(1.0)
    fleet.request(2, 1, robot='b')
    fleet.run_until_done(1, 2, limit=120.0)
    assert any(task.kept for task in asked[1].tasks), 'this plan was to be kept'
    assert not any(task.kept for task in asked[2].tasks)


def test_a_plan_that_leads_a_robot_past_its_destination_is_told():
    fleet = MisledFleet(ladder(5), {'a': (AGV, 1)}, parking=(1,))
    fleet.request(1, 5, robot='a')
    fleet.run_until_done(1, limit=120.0)
    assert any('does not lead a to its destinations' in note for note in fleet.notes)


GRAPH = ladder(5)
TASKS = (Task('a', AGV, vertex=1, destinations=(3,)), Task('b', AGV, vertex=5))
RIGHT = PlanningOutcome({'a': (PlannedDrive(1, 0.0, 2.0), PlannedDrive(2, 2.0, 4.0)),
                         'b': (PlannedDrive(-4, 0.0, 2.0), PlannedDrive(4, 3.0, 5.0))},
                        (Constraint('a', 1, 0.5, 'b', 1),))


def drives(*edges):
    return tuple(PlannedDrive(edge, float(k), k + 1.0) for k, edge in enumerate(edges))


def with_drives(name, *edges):
    return replace(RIGHT, drives={**RIGHT.drives, name: drives(*edges)})


def in_order(*constraints):
    return replace(RIGHT, precedence=constraints)


def test_a_right_plan_has_no_fault():
    assert fault_of(RIGHT, TASKS, GRAPH) == ''


@pytest.mark.parametrize(('outcome', 'words'), [
    (with_drives('c'), "names robot 'c', which the question does not have"),
    (replace(RIGHT, unserved={'c': 'no way'}), "names robot 'c', which the question does not have"),
    (with_drives('a', 1, 99), 'leads a over edge 99, which the graph does not have'),
    (with_drives('a', 1, 3), 'leads a from edge 1 to edge 3, which do not meet'),
    (with_drives('a', 2, 3), 'leads a over edge 2 first, but a is elsewhere'),
    (with_drives('a', 1), 'does not lead a to its destinations'),
    (in_order(Constraint('c', 0, 0.5, 'b', 0)),
     "drive 0 of 'b' waits for fraction 0.5 of drive 0 of 'c'"),
    (in_order(Constraint('a', 2, 0.5, 'b', 0)),
     "drive 0 of 'b' waits for fraction 0.5 of drive 2 of 'a'"),
    (in_order(Constraint('a', 0, 0.5, 'b', -1)),
     "drive -1 of 'b' waits for fraction 0.5 of drive 0 of 'a'"),
    (in_order(Constraint('a', 0, float('nan'), 'b', 0)),
     "drive 0 of 'b' waits for fraction nan of drive 0 of 'a'"),
    (in_order(Constraint('a', 1, 0.5, 'b', 0), Constraint('b', 1, 1.0, 'a', 0)),
     'lets a wait for itself'),
])
def test_a_plan_for_another_question_is_refused_with_the_reason(outcome, words):
    assert words in fault_of(outcome, TASKS, GRAPH)


def test_robots_that_follow_each_other_around_do_not_wait_in_a_ring():
    """A robot counts as having reached fraction 0 of a drive before the drive begins."""
    outcome = in_order(Constraint('a', 1, 0.0, 'b', 1), Constraint('b', 1, 0.0, 'a', 1))
    assert fault_of(outcome, TASKS, GRAPH) == ''


@pytest.mark.parametrize('task', [
    Task('a', AGV, released=(1, 2), begun=0.5), Task('a', AGV, mid_edge=(1, 0.5)),
    Task('a', AGV, mid_edge=(-1, 0.5)), Task('a', AGV, vertex=1)])
def test_a_plan_may_begin_where_the_robot_is(task):
    assert fault_of(with_drives('a', 1, 2, 3), (task, TASKS[1]), GRAPH) == ''


@pytest.mark.parametrize('task', [
    Task('a', AGV, released=(1, 201)), Task('a', AGV, mid_edge=(2, 0.5)), Task('a', AGV, vertex=2)])
def test_a_plan_that_begins_elsewhere_is_refused(task):
    assert 'but a is elsewhere' in fault_of(with_drives('a', 1, 2, 3), (task, TASKS[1]), GRAPH)


def test_an_answer_that_is_spoilt_twice_never_ends_the_supervisor():
    """Each spoilt answer is refused or used; none causes an exception."""
    for seed in range(40):
        fleet = MisledFleet(ladder(4), {'a': (AGV, 1), 'b': (AGV, 4)}, parking=(1, 4), seed=seed)
        chance = Random(seed)
        fleet.spoil = lambda outcome, _, chance=chance: chance.choice(
            list(WRONG.values()))(chance.choice(list(WRONG.values()))(outcome, chance), chance)
        fleet.request(1, 4, robot='a')
        fleet.request(2, 1, robot='b')
        fleet.run_until_done(1, 2, limit=120.0)
