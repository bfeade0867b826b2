"""The fleet manager and its robots in virtual time, as the job server uses them.

It calls the `Supervisor` as the node `path_supervisor` does when a message arrives. It makes the
values that the node `job_server` gives to its `JobBook`.
A person comes to each robot that needs help. If a step asks, the person answers `done`. If not, the
person unloads the robot: its mission was cancelled, has failed, or was only a pickup.
"""
from __future__ import annotations

from collections import defaultdict
from typing import Dict, List, NamedTuple, Optional, Set

from fleet_core.supervision.actions import SendRoute
from fleet_core.supervision.fleet_view import RobotState, robot_views
from fleet_core.supervision.missions import (
    CommandCode,
    CommandKind,
    MissionChange,
    MissionState,
    Request,
    Status,
    StepAnswer,
)
from fleet_core.work.rules import StepDecision
from fleet_core.work.site_work import SiteWork
from fleet_core.work.stops import dwells_of
from fleet_core.work.tables import LoadState
from fleet_simulation.driven_robot import DrivenRobot
from fleet_simulation.studied_fleet import StudiedFleet
from fleet_simulation.virtual_fleet import VirtualFleet
from omron_jobs.core.job_book import FleetAct, FleetMessage
from omron_jobs.core.jobs import JobDrive, JobMission, JobMissionState, QueuedJob
from omron_jobs.fleet.missions import act_of, stops_of

PERSON_COMES = 120.0    # s until a person helps a robot


class ToldMission(NamedTuple):
    """News of a mission for the job server. `shown` is None if the mission is unknown."""

    mission: int
    stamp: int
    shown: Optional[JobMission]


class FleetDesk:
    """Watches the virtual fleet, and carries out the job server's messages to the fleet manager.

    news    -- statuses that the job server has not heard yet
    last    -- the last status of each mission, by the id of its request
    serials -- the numbers of all missions that were accepted, by the id of their request
    """

    def __init__(self, fleet: StudiedFleet, work: SiteWork) -> None:
        self.world: VirtualFleet[DrivenRobot] = fleet.world
        self.news: List[ToldMission] = []
        self.last: Dict[int, Status] = {}
        self.serials: Dict[int, Set[int]] = defaultdict(set)
        self._fleet, self._work = fleet, work
        self._persons: Dict[str, float] = {}
        """When a person comes to each robot that needs help (s)."""
        self.world.watcher = self

    # -- the virtual world -------------------------------------------------------------------------

    def sends(self, order: SendRoute) -> None:
        """Does nothing when the supervisor sends an order."""

    def restarted(self) -> None:
        """Does nothing when the supervisor has restarted: the job server asks for its missions."""

    def publishes(self, status: Status) -> None:
        """Records a status, for the job server and the judge."""
        self.last[status.request_id] = status
        if status.serial:
            self.serials[status.request_id].add(status.serial)
        self.news.append(_news_of(status))

    def stepped(self) -> None:
        """Does the work that is due after a time step."""
        self._fleet.stepped()
        for name in self.world.agvs:
            if not self._needs_person(name):
                self._persons.pop(name, None)
            elif self.world.now >= self._persons.setdefault(name, self.world.now + PERSON_COMES):
                del self._persons[name]
                self._help(name)

    def _needs_person(self, name: str) -> bool:
        mission = self.world.supervisor.book.of_robot(name)
        return (mission.state is MissionState.NEEDS_PERSON if mission is not None
                else self.world.supervisor.desk.load(name).state is not LoadState.EMPTY)

    def _help(self, name: str) -> None:
        """Helps a robot as a person would."""
        world = self.world
        mission = world.supervisor.book.of_robot(name)
        if mission is not None and mission.asks:
            world.do(world.supervisor.command(mission.request.id, CommandKind.ANSWER, world.now,
                                              StepAnswer(StepDecision.DONE, mission.asks)))
        else:
            world.do(world.supervisor.set_load(name, None, world.now)[1])

    # -- the job server ----------------------------------------------------------------------------

    def handle(self, message: FleetMessage) -> None:
        """Carries out a message of the job server."""
        act, job, first = message
        supervisor, now = self.world.supervisor, self.world.now
        if act is FleetAct.REQUEST:
            self.world.do(supervisor.request(self._request_of(job), now))
        elif act is FleetAct.CANCEL:
            self.world.do(supervisor.command(job.mission, CommandKind.CANCEL, now))
        elif act is FleetAct.CHANGE:
            stops = stops_of(job, self._work)[first - 1:] if first else ()
            self.world.do(supervisor.command(
                job.mission, CommandKind.MODIFY, now,
                MissionChange(job.segments[0].priority, stops=stops, first_stop=first)))
        else:
            stored = supervisor.stored_status(job.mission, job.queued / 1000.0)
            self.news.append(ToldMission(job.mission, job.queued, None) if stored is None
                             else _news_of(stored))

    def _request_of(self, job: QueuedJob) -> Request:
        stops = stops_of(job, self._work)
        return Request(job.mission, tuple(stop.place for stop in stops), robot=job.robot,
                       priority=job.segments[0].priority, dwells=dwells_of(stops),
                       stamp=job.queued / 1000.0, requested_by='job_server', stops=stops)

    def drives(self) -> Dict[int, JobDrive]:
        """Returns what robots do on their missions, by the id of the mission's request."""
        found = {}
        for view in robot_views(self.world.supervisor, self.world.now):
            act = act_of(view.state is RobotState.BUSY, view.waits_for.code,
                         view.to_go.destination)
            if act is not None and view.mission is not None and view.destination is not None:
                found[view.mission] = JobDrive(view.name, view.destination, act)
        return found


def _news_of(status: Status) -> ToldMission:
    is_refusal = (status.command is CommandKind.MODIFY
                  and status.command_code is CommandCode.NOT_DONE)
    return ToldMission(status.request_id, round(1000.0 * status.stamp), JobMission(
        JobMissionState(status.state), status.robot, max(status.reached, 0), status.priority,
        status.destinations, is_refusal))
