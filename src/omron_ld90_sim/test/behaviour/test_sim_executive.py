"""The executive: scripts that run on the clock, and events that end them."""
from __future__ import annotations

from typing import List

import pytest
from sim_builders import Rig

from omron_ld90_sim.behaviour import tasks
from omron_ld90_sim.behaviour.states import STANDING, Script, ScriptedActivity


def test_a_script_waits_for_seconds_and_for_the_base() -> None:
    rig, seen = Rig(), []

    def script() -> Script:
        yield 1.5
        seen.append((rig.clock.now, rig.robot.base.still))
        rig.robot.executive.set_course(0.0, 2000.0, None)
        yield STANDING
        seen.append((rig.robot.true_pose.distance_to(0.0, 2000.0) < 1.0, rig.robot.base.still))

    rig.robot.start(ScriptedActivity('Testing', 'Testing', script()))
    rig.clock.advance(30.0)
    assert seen == [(1.5, True), (True, True)] and rig.robot.activity is None


def test_an_activity_that_another_replaces_can_clean_up() -> None:
    rig, seen = Rig(), []

    def script() -> Script:
        try:
            yield 10.0
        finally:
            seen.append(rig.clock.now)

    rig.robot.start(ScriptedActivity('Testing', 'Testing', script()))
    client = rig.client()
    rig.clock.advance(2.0)
    assert client.ask('goto 12') == ['Interrupted: Testing', 'Going to 12'] and seen == [2.0]


@pytest.mark.parametrize('first', ['applicationBlockDrivingSet mine', 'localizeAtGoal 12'])
def test_a_task_that_forbids_driving_ends_the_activity_it_belongs_to(first: str) -> None:
    rig = Rig()
    client = rig.client()
    steps = [tasks.parse(first), tasks.parse('goto West'), tasks.parse('goto 12')]
    rig.robot.start(tasks.task_list(rig.robot, steps))
    before = rig.robot.true_pose
    rig.clock.advance(5.0)
    lines: List[str] = client.lines()
    assert lines[-1] in ('Stopped', 'Error: Robot lost')
    assert rig.robot.activity is None and rig.robot.true_pose == before
