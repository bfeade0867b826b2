"""What the messages of the fleet manager say about missions, goals and robots."""
from __future__ import annotations

import math
from collections import Counter
from typing import Callable, Collection, Dict, List, Mapping, Optional

from fleet_core.work.site_work import SiteWork
from fleet_core.work.stops import StopKind, WorkStop
from graph_fleet_manager.messages.stops import stop_messages
from itrci_nav_msgs import msg, srv
from omron_jobs.core.job_commands import RobotNews
from omron_jobs.core.job_words import DRIVING, RobotStatus, SegmentKind
from omron_jobs.core.jobs import (
    DriveAct,
    JobDrive,
    JobMission,
    JobMissionState,
    JobSegment,
    QueuedJob,
)
from trajectory_graph import Vertex

_KINDS = {SegmentKind.PICKUP: StopKind.PICKUP, SegmentKind.DROPOFF: StopKind.DROPOFF}
_ROBOT = msg.FleetRobot
_UNAVAILABLE: Mapping[int, str] = {
    _ROBOT.OFFLINE: 'OutgoingARCLConnLost', _ROBOT.UNKNOWN: 'OutgoingARCLConnLost',
    _ROBOT.STOPPED: 'EStopPressed', _ROBOT.TAKEN_OVER: 'Interrupted',
    _ROBOT.FAILED: 'Fault_Driving_Application_failed', _ROBOT.OFF_GRAPH: 'Lost',
    _ROBOT.OUT_OF_SERVICE: 'NotUsingEnterpriseManager', _ROBOT.ABSENT: 'NotUsingEnterpriseManager'}

SubstatusOf = Callable[[int], Optional[str]]
"""Returns the substatus of the segment that a mission serves; None: it is no job."""


class WrongStatus(ValueError):
    """A status of a mission that means nothing. The text is a clause."""


def mission_of(status: msg.MissionStatus) -> JobMission:
    """What a status says. Raises WrongStatus."""
    try:
        state = JobMissionState(status.state)
    except ValueError:
        raise WrongStatus(f'mission {status.request_id} has the unknown state {status.state}'
                          ) from None
    is_refusal = (status.command == msg.MissionCommand.MODIFY
                  and status.command_code == msg.MissionStatus.COMMAND_NOT_DONE)
    return JobMission(state, status.robot, max(status.destinations_reached, 0), status.priority,
                      tuple(status.destinations), is_refusal)


def stamp_of(status: msg.MissionStatus) -> int:
    """The stamp of the request of a mission, in ms: the fleet manager rounds less than that."""
    return round(status.request_stamp.to_nsec() / 1e6)


def stops_of(job: QueuedJob, work: SiteWork) -> List[msg.MissionStop]:
    """The stops of the mission of a job, with the steps that a site has for them."""
    def stop(one: JobSegment) -> WorkStop:
        kind = _KINDS[one.kind]
        return WorkStop(one.vertex, kind, work.steps_of_job(one.vertex, kind))
    return stop_messages([stop(one) for one in job.segments])


def goals_of(vertices: Collection[Vertex]) -> Dict[str, int]:
    """The goals among these vertices: each by its label, or by its id.

    A label names no goal if it is empty, is that of another vertex too, or looks like an id, or if
    a line could not contain it. Docks are no goals.
    """
    labels = Counter(vertex.label for vertex in vertices)
    return {vertex.label if is_name(vertex.label) and labels[vertex.label] == 1
            else str(vertex.id): vertex.id
            for vertex in vertices if not vertex.dock}


def is_name(label: str) -> bool:
    """Whether a label can be the name of a goal in a line."""
    return (label.isprintable() and '"' not in label and label == label.strip()
            and bool(label) and not label.isdecimal())


def robots_of(state: msg.FleetState, substatus_of: SubstatusOf) -> Dict[str, RobotNews]:
    """What is shown of each robot."""
    return {robot.name: _robot_of(robot, substatus_of) for robot in state.robots}


def drives_of(state: msg.FleetState) -> Dict[int, JobDrive]:
    """What robots do on their missions, by the mission that each one serves."""
    found = {}
    for robot in state.robots:
        act = _act_of(robot)
        if act is not None and robot.has_mission and robot.destination:
            found[robot.request_id] = JobDrive(robot.name, robot.destination, act)
    return found


def _act_of(robot: msg.FleetRobot) -> Optional[DriveAct]:
    """What a robot does; None: it cannot be told, or is nothing that concerns a segment."""
    if robot.state != _ROBOT.BUSY:
        return None
    if robot.waits_for_code == srv.ExplainMissionResponse.NOTHING:
        return DriveAct.DRIVES
    if robot.waits_for_code != srv.ExplainMissionResponse.STEP or math.isnan(robot.to_destination):
        return None
    return DriveAct.WAITS if robot.to_destination > 0.0 else DriveAct.WORKS


def _robot_of(robot: msg.FleetRobot, substatus_of: SubstatusOf) -> RobotNews:
    if robot.state in _UNAVAILABLE:
        return RobotNews(RobotStatus.UNAVAILABLE, _UNAVAILABLE[robot.state])
    if robot.state == _ROBOT.CHARGING:
        return RobotNews(RobotStatus.AVAILABLE, 'DockParked')
    if robot.has_mission:
        return RobotNews(RobotStatus.IN_PROGRESS, substatus_of(robot.request_id) or DRIVING)
    return RobotNews(RobotStatus.AVAILABLE, 'Parking' if robot.destination else 'Available')
