"""The missions of jobs: their stops and goals, and what their robots do."""
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
    """Returns what a robot does; None: it cannot be told, or is nothing that concerns a segment.

    waits_for      -- number of a WaitCode, which may be unknown
    to_destination -- s
    """
    if not is_busy:
        return None
    if waits_for == WaitCode.NOTHING:
        return DriveAct.DRIVES
    if waits_for != WaitCode.STEP or math.isnan(to_destination):
        return None
    return DriveAct.WAITS if to_destination > 0.0 else DriveAct.WORKS


def goals_of(vertices: Collection[Vertex]) -> Dict[str, int]:
    """Returns the goals among these vertices: each by its label, or by its id.

    A label names no goal if it is empty, is that of another vertex too, or looks like an id, or if
    a line could not contain it. Docks are no goals.
    """
    labels = Counter(vertex.label for vertex in vertices)
    return {vertex.label if is_name(vertex.label) and labels[vertex.label] == 1
            else str(vertex.id): vertex.id
            for vertex in vertices if not vertex.dock}


def is_name(label: str) -> bool:
    """Returns whether a label can be the name of a goal in a line."""
    return (label.isprintable() and '"' not in label and label == label.strip()
            and bool(label) and not label.isdecimal())
