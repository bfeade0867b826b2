"""One simulation run: a fleet of a given size on a site, with missions drawn from a seed."""
from __future__ import annotations

from dataclasses import replace
from random import Random
from typing import Dict, Optional, Set

from fleet_core.supervision.actions import SendRoute
from fleet_core.supervision.missions import MissionState, Request, Status
from fleet_core.supervision.robots import ManagedRobot
from fleet_core.supervision.timetable_runs import giver_of
from fleet_simulation.demand import HOUR, RequestSource
from fleet_simulation.driven_robot import DrivenRobot
from fleet_simulation.figures import Figures, TimetableUse, Use, WaitingCause
from fleet_simulation.hold_ups import HoldUp, ResourceUse, WaitFor, held_up
from fleet_simulation.site import OrderPolicy, StudiedSite
from fleet_simulation.studied_fleet import MakeRobot, StudiedFleet
from fleet_simulation.virtual_fleet import STEP

WARM_UP = 600.0     # s at the start of a run that do not count; in a short run, a tenth of the run
_SAMPLE = 10        # number of steps between two samples of what the robots do
_REPLANNING = 50    # number of steps between two complete new plans, with OrderPolicy.REPLANNING


def simulate(site: StudiedSite, robots: int, seed: int, hours: float) -> Figures:
    """Returns the figures of one run; if the run failed, `Figures.trouble` is the reason."""
    return Run(site, robots, seed).run(hours)


class Run:
    """One run. It observes a fleet in virtual time, and adds up the figures.

    make -- makes the robots; see StudiedFleet
    """

    def __init__(self, site: StudiedSite, robots: int, seed: int,
                 make: Optional[MakeRobot] = None) -> None:
        self._site = site
        self._random = Random(f'run {seed}')
        self._fleet = StudiedFleet(site, robots, seed, self._random, make)
        self.world = self._fleet.world
        self.figures = Figures(robots, seed)
        resources = self.world.supervisor.interlocking.claims.needs.resources
        self.figures.resources = {name: ResourceUse(one) for name, one in resources.items()}
        self.figures.timetables = {name: TimetableUse() for name in site.work.timetables}
        self._givers = {giver_of(name): name for name in site.work.timetables}
        self._timetables: Dict[int, str] = {}
        """For each open mission of a timetable: the timetable's name."""
        self._warm_up = 0.0
        self._steps = 0
        self._requests = RequestSource(site.demand, [], self._random)
        self._requested: Dict[int, float] = {}
        self._begun: Set[int] = set()
        self._deadlines: Dict[int, float] = {}
        """For each open mission: its deadline in s since 1970."""
        self.world.watcher = self

    def run(self, hours: float) -> Figures:
        """Simulates the given number of virtual hours; returns the figures."""
        world, figures, end = self.world, self.figures, hours * HOUR
        self._warm_up = min(WARM_UP, 0.1 * end)
        demand = self._site.demand
        self._requests = RequestSource(demand, demand.draw(figures.seed, hours), self._random)
        try:
            self._fleet.begin()
            while world.now < end - STEP / 2:
                self._request()
                world.step()
        except AssertionError as failure:
            figures.trouble = str(failure).splitlines()[0]
        for id, deadline in self._deadlines.items():
            self._count_deadline(id, deadline, False)
        figures.seconds = max(world.now - self._warm_up, 0.0)
        figures.open_at_end = len(world.supervisor.book.open)
        world.drive_all()
        figures.travelled = sum(robot.travelled for robot in world.agvs.values())
        figures.planning = world.planner.plans
        figures.spent, figures.simulated = world.spent, world.now
        world.end()
        return figures

    # -- demand -----------------------------------------------------------------------------------

    def _request(self) -> None:
        for request in self._requests.due(self.world.now, len(self.world.agvs), STEP):
            self._ask(request)

    def _ask(self, request: Request) -> None:
        if request.deadline:
            request = replace(request, deadline=request.deadline + self.world.wall)
            self._deadlines[request.id] = request.deadline
        self._requested[request.id] = self.world.now
        if self.world.now >= self._warm_up:
            self.figures.requested += 1
        self.world.do(self.world.supervisor.request(request, self.world.now))

    def _note_timetable(self, id: int) -> None:
        """Notes a mission that the supervisor has requested because of a timetable."""
        mission = self.world.supervisor.book.find(id)
        name = '' if mission is None else self._givers.get(mission.request.requested_by, '')
        if mission is None or not name:
            return
        self._requested[id], self._timetables[id] = self.world.now, name
        if mission.request.deadline:
            self._deadlines[id] = mission.request.deadline
        if self.world.now >= self._warm_up:
            self.figures.requested += 1
            self.figures.timetables[name].requested += 1

    def _count_deadline(self, id: int, deadline: float, is_done: bool) -> None:
        """Counts the deadline of a mission when the mission ends, or when the run ends before it.
        """
        moment = self.world.wall + self.world.now
        if not is_done and moment <= deadline or self.world.now < self._warm_up:
            return
        of_timetable = self.figures.timetables.get(self._timetables.get(id, ''))
        for counted in (self.figures, *(() if of_timetable is None else (of_timetable,))):
            counted.deadlines += 1
            counted.missed += not is_done or moment > deadline

    # -- observation of the virtual world ---------------------------------------------------------

    def sends(self, order: SendRoute) -> None:
        """Ignores that the supervisor sends an order."""

    def restarted(self) -> None:
        """Ignores a restart of the supervisor, which does not happen here."""

    def publishes(self, status: Status) -> None:
        """Records the start and the end of each mission."""
        id, now, figures = status.request_id, self.world.now, self.figures
        counts = now >= self._warm_up
        if id not in self._requested and status.state.is_open:
            self._note_timetable(id)
        if id not in self._requested:
            return
        assert status.state is not MissionState.NEEDS_PERSON, (
            f'Mission {id} needs a person: {status.reason}.')
        if status.state is MissionState.ACTIVE and id not in self._begun:
            self._begun.add(id)
            if counts:
                figures.waits.append(now - self._requested[id])
        elif not status.state.is_open:
            if counts and status.state is MissionState.SUCCEEDED:
                figures.succeeded += 1
                figures.leads.append(now - self._requested[id])
                if id in self._timetables:
                    of_timetable = figures.timetables[self._timetables[id]]
                    of_timetable.succeeded += 1
                    of_timetable.leads.append(figures.leads[-1])
            elif counts:
                why = status.reason or status.state.name
                figures.failures[why] = figures.failures.get(why, 0) + 1
            if id in self._deadlines:
                is_done = status.state is MissionState.SUCCEEDED
                self._count_deadline(id, self._deadlines.pop(id), is_done)
            self._timetables.pop(id, None)
            del self._requested[id]
            self._begun.discard(id)
            self._requests.ended(id)

    def stepped(self) -> None:
        """Does what is due after one time step: new plans, battery reports, samples."""
        self._steps += 1
        self._fleet.stepped()
        if self._site.order is OrderPolicy.REPLANNING and self._steps % _REPLANNING == 0:
            self.world.supervisor.plan_executor.plan_anew()
        if self._steps % _SAMPLE == 0 and self.world.now >= self._warm_up:
            self._sample()

    def _sample(self) -> None:
        seconds, figures = _SAMPLE * STEP, self.figures
        self.world.drive_all()
        docks = parked = 0
        held_up = self._sample_resources(seconds)
        for name, body in self.world.agvs.items():
            robot = self.world.supervisor.robots[name]
            use = self._use(name, body, robot)
            figures.use[use] += seconds
            docks += use is Use.CHARGING
            parked += use is Use.IDLE
            if use is Use.WAITING:
                what = self._wanted_edge(name, robot), (
                    WaitingCause.RESOURCE if name in held_up else self._cause(name))
                if name in held_up:
                    wait = held_up[name]
                    figures.resources[wait.resource].waiting[wait.why] += seconds
                figures.waiting[what] = figures.waiting.get(what, 0.0) + seconds
        figures.docks, figures.parked = max(figures.docks, docks), max(figures.parked, parked)

    def _sample_resources(self, seconds: float) -> Dict[str, WaitFor]:
        """Adds `seconds` to the time of each claim. Returns the resource for which each robot
        waits.
        """
        figures, supervisor = self.figures, self.world.supervisor
        if not figures.resources:
            return {}
        for name, use in figures.resources.items():
            use.claimed += seconds * len(supervisor.interlocking.claims.holders(name))
        direct: Dict[str, WaitFor] = {}
        for name in self.world.agvs:
            wait = self._waits_for_resource(name)
            if wait is not None:
                direct[name] = wait
        waits_for = supervisor.plan_executor.waits_for
        return held_up(direct, {name: other for name, other in waits_for.items()
                                if other in self.world.agvs})

    def _waits_for_resource(self, name: str) -> Optional[WaitFor]:
        supervisor = self.world.supervisor
        standing = supervisor.stations.standing_of(name)
        if standing is not None:
            return WaitFor(standing.station.name, HoldUp.TURN)
        resource = supervisor.plan_executor.lacks.get(name)
        if resource is None:
            return None
        others = [one for one in supervisor.interlocking.claims.holders(resource.name)
                  if one != name]
        is_full = len(others) >= resource.capacity
        return WaitFor(resource.name, HoldUp.CLAIM if is_full else HoldUp.OPENING)

    def _use(self, name: str, body: DrivenRobot, robot: ManagedRobot) -> Use:
        mission = self.world.supervisor.book.of_robot(name)
        if not robot.works:
            return Use.OUT
        if body.is_held:
            return Use.HELD
        if body.is_driving and not body.vehicle.drive.at_rest:
            return Use.LOADED if mission is not None else Use.EMPTY
        if mission is not None:
            is_at_work = mission.stays_since is not None or (
                self.world.supervisor.desk.waits_for(name, mission).code)
            return Use.STAY if is_at_work else Use.WAITING
        if robot.dock is not None:
            return Use.CHARGING if body.vehicle.battery.charging else Use.WAITING
        return Use.CHARGING if body.vehicle.battery.charging else Use.IDLE

    def _cause(self, name: str) -> WaitingCause:
        executor = self.world.supervisor.plan_executor
        waits_for = executor.waits_for.get(name, '')
        if executor.plan is not None and name in executor.plan.unserved:
            return WaitingCause.NO_PLAN
        if waits_for in self.world.agvs:
            return WaitingCause.ROBOT
        if waits_for.startswith('edge '):
            return WaitingCause.CLOSED
        return WaitingCause.PLANNER if executor.is_planning else WaitingCause.OWN

    def _wanted_edge(self, name: str, robot: ManagedRobot) -> int:
        """Returns the id of the robot's next edge in the plan, or of its present edge."""
        plan = self.world.supervisor.plan_executor.plan
        if plan is not None and name in plan.plans:
            ahead = plan.plans[name].behind(robot.record.end)
            if ahead:
                return abs(ahead[0].edge)
        return abs(self.world.agvs[name].report(0.0).pose.edge)
