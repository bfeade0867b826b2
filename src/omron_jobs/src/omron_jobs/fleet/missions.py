"""The missions of jobs: their stops, their goals and the acts of their robots."""
from __future__ import annotations

import math
from collections import Counter
from typing import Collection, Dict, Optional, Tuple

from fleet_core.supervision.waits import WaitCode
from fleet_core.work.site_work import SiteWork
from fleet_core.work.stops import StopKind, WorkStop
from omron_jobs.core.job_words import SegmentKind
from omron_jobs.core.jobs import DriveAct, QueuedJob
from trajectory_graph import Vertex

_KINDS = {SegmentKind.PICKUP: StopKind.PICKUP, SegmentKind.DROPOFF: StopKind.DROPOFF}


def stops_of(job: QueuedJob, work: SiteWork) -> Tuple[WorkStop, ...]:
    """Returns the stops of the mission of a job, with the steps that a site has for them."""
    return tuple(WorkStop(one.vertex, _KINDS[one.kind],
                          work.steps_of_job(one.vertex, _KINDS[one.kind]))
                 for one in job.segments)


def act_of(is_busy: bool, waits_for: int, to_destination: float) -> Optional[DriveAct]:
    """Returns what a robot does; None: this is not known, or does not concern a segment.

    waits_for      -- number of a WaitCode, which may be unknown
    to_destination -- s left until the robot is there; NaN: not known
    """
    if not is_busy:
        return None
    if waits_for == WaitCode.NOTHING:
        return DriveAct.DRIVES
    if waits_for != WaitCode.STEP or math.isnan(to_destination):
        return None
    return DriveAct.WAITS if to_destination > 0.0 else DriveAct.WORKS


def goals_of(vertices: Collection[Vertex]) -> Dict[str, int]:
    """Returns the goals among these vertices, each by its label or its id.

    A goal is named by its id if its label is empty, is also the label of another vertex, looks like
    an id, or does not fit into a line. Docks are no goals.
    """
    labels = Counter(vertex.label for vertex in vertices)
    return {vertex.label if is_name(vertex.label) and labels[vertex.label] == 1
            else str(vertex.id): vertex.id
            for vertex in vertices if not vertex.dock}


def is_name(label: str) -> bool:
    """Returns whether a label can be the name of a goal in a line."""
    return (label.isprintable() and '"' not in label and label == label.strip()
            and bool(label) and not label.isdecimal())
