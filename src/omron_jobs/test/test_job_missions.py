"""The missions that are made from jobs: their stops, their goals and the acts of their robots."""
from __future__ import annotations

import math
from typing import Optional

import pytest

from fleet_core.supervision.waits import WaitCode
from fleet_core.work.site_work import JobSteps, SiteWork
from fleet_core.work.stops import LoadEffect, StopKind, WorkStep, WorkStop
from omron_jobs.core.job_words import SegmentKind
from omron_jobs.core.jobs import DriveAct, JobSegment, QueuedJob
from omron_jobs.fleet.missions import act_of, goals_of, stops_of
from trajectory_graph import Vertex

JOB = QueuedJob('own', (JobSegment(7, SegmentKind.PICKUP, 'x', 1, 10),
                        JobSegment(8, SegmentKind.DROPOFF, 'y', 2, 20)), 1, 41)
ENGAGE = WorkStep('engage', 60.0, load=LoadEffect.TAKES)


def test_segments_become_stops_with_the_steps_of_the_site() -> None:
    work = SiteWork(job_steps=(JobSteps(StopKind.PICKUP, (ENGAGE,)),
                               JobSteps(StopKind.DROPOFF, (WorkStep('disengage', 60.0),), (7,))))
    assert stops_of(JOB, work) == (WorkStop(1, StopKind.PICKUP, (ENGAGE,)),
                                   WorkStop(2, StopKind.DROPOFF))


@pytest.mark.parametrize('label, name', [
    ('press', 'press'), ('twice', '1'), ('', '1'), ('12', '1'), ('a"b', '1'), (' a', '1'),
    ('a\nb', '1'), ('two words', 'two words')])
def test_a_goal_is_named_by_a_label_that_can_name_it(label: str, name: str) -> None:
    vertices = [Vertex(1, 0.0, 0.0, 0.0, label=label), Vertex(2, 1.0, 0.0, 0.0, label='twice'),
                Vertex(3, 2.0, 0.0, 0.0, label='d', dock=True)]
    assert goals_of(vertices) == {name: 1, '2' if label == 'twice' else 'twice': 2}


@pytest.mark.parametrize('is_busy, waits_for, to_destination, act', [
    (True, WaitCode.NOTHING, 5.0, DriveAct.DRIVES), (True, WaitCode.TRAFFIC, 5.0, None),
    (True, WaitCode.STEP, 5.0, DriveAct.WAITS), (True, WaitCode.STEP, 0.0, DriveAct.WORKS),
    (True, WaitCode.STEP, math.nan, None), (True, 99, 5.0, None),
    (False, WaitCode.NOTHING, 5.0, None)])
def test_what_a_robot_does_follows_from_what_it_waits_for(
        is_busy: bool, waits_for: int, to_destination: float, act: Optional[DriveAct]) -> None:
    assert act_of(is_busy, waits_for, to_destination) is act
