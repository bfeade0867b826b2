"""Translates the messages of the fleet manager about missions and robots."""
from __future__ import annotations

from typing import Callable, Dict, Mapping, Optional

from itrci_nav_msgs import msg
from omron_jobs.core.job_words import DRIVING, RobotStatus
from omron_jobs.core.jobs import JobDrive, JobMission, JobMissionState
from omron_jobs.core.robots import RobotNews
from omron_jobs.fleet.missions import act_of

_ROBOT = msg.FleetRobot
_UNAVAILABLE: Mapping[int, str] = {
    _ROBOT.OFFLINE: 'OutgoingARCLConnLost', _ROBOT.UNKNOWN: 'OutgoingARCLConnLost',
    _ROBOT.STOPPED: 'EStopPressed', _ROBOT.TAKEN_OVER: 'Interrupted',
    _ROBOT.FAILED: 'Fault_Driving_Application_failed', _ROBOT.OFF_GRAPH: 'Lost',
    _ROBOT.OUT_OF_SERVICE: 'NotUsingEnterpriseManager', _ROBOT.ABSENT: 'NotUsingEnterpriseManager'}

SubstatusOf = Callable[[int], Optional[str]]
"""Returns the substatus of the segment that a mission serves; None: the mission is no job."""


class WrongStatus(ValueError):
    """A status of a mission that has no meaning. The text is a clause."""


def mission_of(status: msg.MissionStatus) -> JobMission:
    """Returns the mission of a status. Raises WrongStatus."""
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
    """Returns the stamp of the request of a mission, rounded to ms to remove errors of floats."""
    return round(status.request_stamp.to_nsec() / 1e6)


def robots_of(state: msg.FleetState, substatus_of: SubstatusOf) -> Dict[str, RobotNews]:
    """Returns the state to show for each robot."""
    return {robot.name: _robot_of(robot, substatus_of) for robot in state.robots}


def drives_of(state: msg.FleetState) -> Dict[int, JobDrive]:
    """Returns what robots do on their missions, by the id of the mission's request."""
    found = {}
    for robot in state.robots:
        act = act_of(robot.state == _ROBOT.BUSY, robot.waits_for_code, robot.to_destination)
        if act is not None and robot.has_mission and robot.destination:
            found[robot.request_id] = JobDrive(robot.name, robot.destination, act)
    return found


def _robot_of(robot: msg.FleetRobot, substatus_of: SubstatusOf) -> RobotNews:
    if robot.state in _UNAVAILABLE:
        return RobotNews(RobotStatus.UNAVAILABLE, _UNAVAILABLE[robot.state])
    if robot.state == _ROBOT.CHARGING:
        return RobotNews(RobotStatus.AVAILABLE, 'DockParked')
    if robot.has_mission:
        return RobotNews(RobotStatus.IN_PROGRESS, substatus_of(robot.request_id) or DRIVING)
    return RobotNews(RobotStatus.AVAILABLE, 'Parking' if robot.destination else 'Available')
