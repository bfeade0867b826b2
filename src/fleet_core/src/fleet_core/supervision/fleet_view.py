"""The state of each robot, and its plan with the released part, as published for the fleet."""
from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import Collection, List, Mapping, NamedTuple, Optional, Sequence, Tuple

from fleet_core.interlocking.allocation import Knowledge
from fleet_core.interlocking.reports import Pose
from fleet_core.supervision.duties import Duty, Errand
from fleet_core.supervision.fleet_stop import FleetStop
from fleet_core.supervision.machine_view import MachineView
from fleet_core.supervision.outages import Outage
from fleet_core.supervision.plan_in_force import PlanInForce
from fleet_core.supervision.resource_view import ResourceView, resource_views
from fleet_core.supervision.restoring import RemovedRobot
from fleet_core.supervision.robots import ManagedRobot
from fleet_core.supervision.supervisor import Supervisor
from fleet_core.supervision.time_to_go import UNKNOWN, TimeToGo, time_to_go
from fleet_core.supervision.waits import NO_WAIT, Wait, WaitCode
from fleet_core.supervision.why import robot_wait
from fleet_core.work.tables import LoadState
from fleet_core.work.work import RobotLoad


class RobotState(IntEnum):
    """The state of a robot, as in itrci_nav_msgs/FleetRobot."""

    IDLE = 0
    BUSY = 1
    CHARGING = 2
    OFFLINE = 3
    STOPPED = 4
    TAKEN_OVER = 5
    FAILED = 6
    OFF_GRAPH = 7
    OUT_OF_SERVICE = 8
    ABSENT = 9
    UNKNOWN = 10

    @property
    def words(self) -> str:
        """The state as people read it, on the page, in RViz and in `fleet list`."""
        return _WORDS.get(self, self.name.lower().replace('_', ' '))

    def words_with(self, waits_for: int) -> str:
        """Returns `words`, with two exceptions: `working` for a busy robot that waits for a step,
        and `needs a person` for a robot that waits for an answer, or to be unloaded.

        waits_for -- a WaitCode
        """
        if self in (self.IDLE, self.BUSY) and waits_for == WaitCode.PERSON:
            return ASKS
        return WORKING if self is self.BUSY and waits_for == WaitCode.STEP else self.words


WORKING, ASKS = 'working', 'needs a person'
LOAD_WORDS: Mapping[LoadState, str] = {
    LoadState.LOADED: 'load of {mission}', LoadState.UNKNOWN: 'load unknown'}
"""What a robot carries, in words for people; `mission`: the short name of the load's mission."""
LOAD_MOVES = 'load is being moved'
"""The words while a step takes or gives the load: no person has to look at the robot then."""
_WORDS = {RobotState.BUSY: 'driving', RobotState.STOPPED: 'emergency stop',
          RobotState.OFF_GRAPH: 'off the graph', RobotState.UNKNOWN: 'place unknown'}
_OF_OUTAGE = {
    Outage.UNSEEN: RobotState.OFFLINE, Outage.SILENT: RobotState.OFFLINE,
    Outage.LOST_LINK: RobotState.OFFLINE, Outage.DEAF: RobotState.OFFLINE,
    Outage.CLOCK: RobotState.OFFLINE, Outage.ABSENT: RobotState.ABSENT,
    Outage.STOPPED: RobotState.STOPPED, Outage.TOO_NEAR: RobotState.TAKEN_OVER,
    Outage.TAKEN_OVER: RobotState.TAKEN_OVER, Outage.FAILED: RobotState.FAILED,
    Outage.OFF_GRAPH: RobotState.OFF_GRAPH, Outage.OUT_OF_SERVICE: RobotState.OUT_OF_SERVICE}


@dataclass(frozen=True)
class RobotView:
    """The published state of one robot.

    seen        -- the supervisor's time of its last report; minus infinity: never
    battery     -- state of charge; NaN: unknown
    mission     -- request id of the mission that it serves
    destination -- vertex to which it drives; None: none
    to_go       -- the time until it is at its destination, and until its mission ends
    load        -- what it carries

    Each attribute is a field of the published state.
    """

    name: str
    type: str
    state: RobotState
    outage: Optional[Outage]
    pose: Pose
    seen: float
    battery: float
    mission: Optional[int]
    destination: Optional[int]
    waits_for: Wait = NO_WAIT
    to_go: TimeToGo = UNKNOWN
    load: RobotLoad = RobotLoad()


@dataclass(frozen=True)
class FleetView:
    """The state of the fleet at one moment, for displays and diagnoses.

    trouble  -- why nothing can be stored, as a clause; empty: everything can be stored
    stop     -- the stop of the fleet; if it is not in force, the fleet is not stopped
    no_plan  -- why there is no plan, as a clause; empty: there is a plan, or none is needed yet
    unserved -- the robots for which the plan has no path
    """

    robots: Sequence[RobotView]
    resources: Sequence[ResourceView]
    machines: Sequence[MachineView]
    trouble: str
    stop: FleetStop
    no_plan: str
    unserved: Collection[str]


class DriveView(NamedTuple):
    """One planned edge. Times are those of the supervisor's clock."""

    edge: int
    start: float
    end: float
    released: bool


def fleet_view(supervisor: Supervisor, now: float) -> FleetView:
    """Returns the state of the fleet at the supervisor's time `now`."""
    executor = supervisor.plan_executor
    return FleetView(
        robot_views(supervisor, now), resource_views(supervisor, now),
        supervisor.desk.machines(now), supervisor.trouble, supervisor.stop, executor.trouble,
        () if executor.plan is None else tuple(executor.plan.unserved))


def robot_views(supervisor: Supervisor, now: float) -> List[RobotView]:
    """Returns all robots of the fleet, and the robots that have left the fleet file but still block
    places.
    """
    errands = supervisor.errands()
    return [*(_view(robot, errands[name], supervisor, now)
              for name, robot in supervisor.robots.items()),
            *(_removed_view(robot, supervisor) for robot in supervisor.removed.values())]


def _view(robot: ManagedRobot, errand: Errand, supervisor: Supervisor, now: float) -> RobotView:
    mission = errand.mission
    if robot.knowledge is Knowledge.UNKNOWN:
        state = RobotState.UNKNOWN
    elif robot.outage is not None:
        state = _OF_OUTAGE[robot.outage]
    elif errand.duty is Duty.CHARGE:
        state = RobotState.CHARGING
    else:
        state = RobotState.IDLE if errand.duty is Duty.IDLE else RobotState.BUSY
    destination = errand.place
    if destination is None and mission is not None and mission.left:
        destination = mission.left[0]
    charge = math.nan if robot.battery.is_mute(robot.liveness, now) else robot.battery.charge
    return RobotView(robot.name, robot.type.model, state, robot.outage, robot.record.pose,
                     robot.liveness.seen, charge,
                     None if mission is None else mission.request.id, destination,
                     robot_wait(robot, errand, supervisor, now),
                     _to_go(robot, errand, supervisor, now), supervisor.desk.load(robot.name))


def _to_go(robot: ManagedRobot, errand: Errand, supervisor: Supervisor, now: float) -> TimeToGo:
    if errand.duty is Duty.IDLE:
        return UNKNOWN
    return time_to_go(robot, errand, supervisor.plan_executor.plan,
                      supervisor.networks.edge_times, now)


def _removed_view(robot: RemovedRobot, supervisor: Supervisor) -> RobotView:
    record = robot.master.record
    position, pose = record.position, Pose()
    if position is not None:
        pose = Pose(position.edge, position.fraction) if position.vertex is None else (
            Pose(record.graph.edges_from(position.vertex)[0]))
    wait = Wait(WaitCode.OUTAGE, 'it is not in the fleet file any more; its places stay blocked '
                                 f'until `fleet absent {robot.name}`')
    return RobotView(robot.name, robot.type.name, RobotState.OUT_OF_SERVICE, None, pose, -math.inf,
                     math.nan, None, None, wait, load=supervisor.desk.load(robot.name))


class PlanProgress(NamedTuple):
    """A plan and its progress. Both stay unchanged while other threads read them.

    robots -- by name, the numbers of the robot's present edge and of the edge after its last
              granted one
    """

    plan: PlanInForce
    robots: Mapping[str, Tuple[int, int]]


def plan_progress(supervisor: Supervisor) -> Optional[PlanProgress]:
    """Returns the progress of the plan in force; None: there is none."""
    plan = supervisor.plan_executor.plan
    if plan is None:
        return None
    records = {name: supervisor.robots[name].record for name in plan.plans}
    return PlanProgress(plan, {name: (record.done, record.end)
                               for name, record in records.items()})


def plan_views(progress: Optional[PlanProgress]) -> List[Tuple[str, List[DriveView]]]:
    """Returns the plan of each robot, beginning with its present edge."""
    if progress is None:
        return []
    plan, found = progress.plan, []
    for name, own in plan.plans.items():
        done, end = progress.robots[name]
        first = max(done - own.base, 0)
        found.append((name, [
            DriveView(drive.edge, plan.made_at + drive.start, plan.made_at + drive.end, k < end)
            for k, drive in enumerate(own.drives[first:], own.base + first)]))
    return found
