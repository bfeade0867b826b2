"""The virtual world: a supervisor, the real planner and simulated robots in one process.

This module delivers all messages, which may come late, twice, or not at all. Time is virtual: the
planner answers after a given latency, and a number of rounds limits its work. Therefore a run
depends only on its seed, not on the speed of the computer.
"""
from __future__ import annotations

import math
import time
from random import Random
from typing import (
    Callable,
    Dict,
    Generic,
    List,
    Mapping,
    NamedTuple,
    Optional,
    Protocol,
    Sequence,
    Tuple,
    TypeVar,
    Union,
)

import numpy as np

from fleet_core.fleet import DOCK_APPROACH, Fleet, Robot, RobotType
from fleet_core.interlocking.allocation import Allocation
from fleet_core.interlocking.claims import Claims
from fleet_core.interlocking.conformance import (
    Conformance,
    ObservedRobot,
    Violation,
)
from fleet_core.interlocking.reports import Report
from fleet_core.interlocking.resources import Resource
from fleet_core.interlocking.route_master import ME
from fleet_core.planning.tasks import PlanningOutcome
from fleet_core.supervision.actions import (
    Action,
    AskDevice,
    AskPlanner,
    Note,
    PublishStatus,
    SendRoute,
    SendStep,
)
from fleet_core.supervision.missions import Status
from fleet_core.supervision.settings import RobotSettings
from fleet_core.supervision.site_resources import resources_of
from fleet_core.supervision.supervisor import Supervisor
from fleet_core.supervision.switching import OrderSwitching
from fleet_core.work.site_work import SiteWork
from fleet_simulation.agv.steps import SimulatedSteps
from fleet_simulation.report_times import ReportingRobot, ReportTimes, Rhythm
from fleet_simulation.virtual_device import VirtualDevice
from fleet_simulation.virtual_disk import VirtualDisk
from fleet_simulation.virtual_network import VirtualNetwork
from fleet_simulation.virtual_planner import VirtualPlanner
from route_protocol.master import Order
from route_protocol.values import RouteOrder, RouteRefusal, RouteReport
from trajectory_graph import Graph

STEP = 0.1  # s


class Watcher(Protocol):
    """An observer of a fleet; the world calls it when something happens."""

    def sends(self, order: SendRoute) -> None:
        """Notes that the supervisor sends an order now."""

    def publishes(self, status: Status) -> None:
        """Notes that the supervisor publishes a mission status now."""

    def stepped(self) -> None:
        """Notes that one time step is over."""

    def restarted(self) -> None:
        """Notes that the supervisor has restarted."""


class VirtualRobot(ReportingRobot, Protocol):
    """The interface of a simulated robot to the world."""

    due: float
    """Virtual time (s) until which the report changes only in its place, unless an order comes."""

    @property
    def position(self) -> Tuple[float, float]:
        """The position x, y in m, in the frame of the graph."""

    def drive(self, seconds: float) -> None:
        """Advances the robot by the given virtual time, in s."""

    def receive(self, order: RouteOrder) -> Optional[RouteRefusal]:
        """Gives the robot an order; returns a refusal if the robot refuses it at once."""

    def late_refusals(self) -> List[RouteRefusal]:
        """Returns the refusals since the last call, except those that `receive` returned."""

    def report(self, stamp: float) -> RouteReport:
        """Returns the robot's report, with this stamp."""


class LinkedRobot(Protocol):
    """The receiver of orders for a robot: the robot itself, or its computer while their link is
    lost.
    """

    def receive(self, order: RouteOrder) -> Optional[RouteRefusal]:
        """Gives an order; returns a refusal if it is refused at once."""

    def report(self, now: float) -> RouteReport:
        """Returns the report about the robot, with the stamp `now`."""


class Crash(NamedTuple):
    """A crash of the supervisor.

    commit  -- number of the write to the journal at which it crashes
    actions -- number of actions that are still performed after this write
    """

    commit: int
    actions: int = 0


class Spent(NamedTuple):
    """The processor time (s) that each part of the program used."""

    world: float
    supervisor: float
    planner: float


Body = TypeVar('Body', bound=VirtualRobot)
_TOGETHER = 1e-6    # s; events with a smaller time difference happen at the same time


class VirtualFleet(Generic[Body]):
    """A fleet on a graph, with its supervisor and planner.

    The fleet has all parts of the virtual world (network, planner, disk, robots and their clocks),
    and records what happens. So a test can read and disturb everything at one place.

    robots   -- for each robot's name: its type, and the id of the vertex on which it begins
    make     -- creates a robot from its name, type and vertex
    loss     -- probability (0..1) that a message is lost
    repeats  -- probability (0..1) that a message comes twice if it is not lost
    planning -- s until the planner answers
    settings -- one value for all robots, or one for each robot by its name
    parking  -- ids of the vertices on which robots may be parked; None: all vertices
    switches -- whether the order of robots on shared places may change while robots are late
    check_every -- number of events between two checks of the allocations
    resources -- zones and other resources that `work` does not name; devices among these are
                 simulated
    work     -- the content of the work file; None: there is no work file
    wall     -- s since 1970 at the beginning, by the computer's clock
    """

    def __init__(self, graph: Graph, robots: Mapping[str, Tuple[RobotType, int]],
                 make: Callable[[str, RobotType, int], Body],
                 clearance: float = 0.1, seed: int = 0, loss: float = 0.0, repeats: float = 0.0,
                 planning: float = 0.1,
                 settings: Union[None, RobotSettings, Mapping[str, RobotSettings]] = None,
                 parking: Optional[Sequence[int]] = None, dock_approach: float = DOCK_APPROACH,
                 rhythm: Optional[Rhythm] = None, switches: bool = False,
                 check_every: int = 1, resources: Sequence[Resource] = (),
                 work: Optional[SiteWork] = None, wall: float = 1e9) -> None:
        kinds = tuple(dict.fromkeys(kind for kind, _ in robots.values()))
        self.graph, self.clearance = graph, clearance
        self._described = (f'seed {seed}, loss {loss}, repeats {repeats}, planning {planning}, '
                      f'{settings}, ' + ', '.join(f'{n}: {k}' for n, (k, _) in robots.items()))
        self.fleet = Fleet(kinds, tuple(Robot(n, k, v) for n, (k, v) in robots.items()), clearance,
                           dock_approach)
        self.agvs: Dict[str, Body] = {name: make(name, kind, vertex)
                                      for name, (kind, vertex) in robots.items()}
        self.settings: Dict[str, RobotSettings] = (
            dict(settings) if isinstance(settings, Mapping) else
            {name: settings or RobotSettings(release_ahead=0.0) for name in robots})
        self.rhythm = rhythm or Rhythm()
        self.now = 0.0
        self.random = Random(seed)
        self.network = VirtualNetwork(self.random, loss, repeats)
        self.planner = VirtualPlanner(self.fleet, planning, parking)
        self.wall = wall
        self.disk = VirtualDisk(lambda: self.wall + self.now, self._hang)
        self.clocks: Dict[str, float] = {}
        """For each robot: s by which its clock is ahead."""
        self.ages: Dict[str, float] = {}
        """For each robot: age (s) of its last report on arrival; negative if its clock is ahead."""
        self.lost: Dict[str, LinkedRobot] = {}
        """For each robot whose computer has lost the link to it: the computer."""
        self.loads: Dict[str, float] = {}
        """For each robot that carries a load: radius (m) of the disc around robot and load."""
        self.closed: Tuple[int, ...] = ()
        self.crash: Optional[Crash] = None
        """The next crash of the supervisor."""
        self.hangs = False
        """Whether the supervisor hangs. Messages to it wait until it continues."""
        self.watcher: Optional[Watcher] = None
        self.statuses: List[Status] = []
        self.notes: List[str] = []
        self.sent: List[SendRoute] = []
        self.steps: Dict[str, SimulatedSteps] = {}
        """For each robot that carries out steps: its steps."""
        self.step_devices: Dict[str, SimulatedSteps] = {
            name: SimulatedSteps(lambda: round(1000.0 * (self.wall + self.now)))
            for name in (work or SiteWork()).step_devices}
        """For each device: the steps that it carries out."""
        self.resources = resources
        self.devices: Dict[str, VirtualDevice] = {
            one.name: VirtualDevice(one.name)
            for one in (*resources_of(work or SiteWork()), *resources) if one.has_device}
        self._steps_told: Dict[str, Tuple[float, object]] = {}
        self.refused = dict.fromkeys(robots, 0)
        """For each robot: the number of orders that it refused."""
        self.nearest = math.inf
        """The smallest free space (m) between any two robots so far, minus the clearance."""
        self._supervising = self._stepping = 0.0
        self._driven = dict.fromkeys(robots, 0.0)
        """For each robot: the virtual time up to which its motion has been simulated."""
        self._reports = ReportTimes(self.rhythm)
        self._ticks_at = self._looks_at = 0.0
        self._switches, self._check_every = switches, check_every
        self.work = work
        self._begin()

    def __repr__(self) -> str:
        return f'<a fleet: {self._described}>'

    def _begin(self) -> None:
        # No time limit for switching: the computer's speed must not change the results.
        switching = OrderSwitching(self.clearance, math.inf) if self._switches else None
        self.supervisor = Supervisor(self.graph, self.fleet, self.settings, self.disk.journal,
                                     self.now, switching=switching,
                                     conformance=StrictConformance(self._check_every),
                                     resources=self.resources, work=self.work,
                                     clock=lambda: self.now)
        self.do(self.supervisor.close_edges(self.closed, self.now))

    def end(self) -> None:
        """Ends the world and deletes its journal."""
        self.disk.end()

    def restart(self, graph: Optional[Graph] = None) -> None:
        """Kills the supervisor, loses all messages to and from it, and starts it again.

        Delayed orders that are already on their way still reach the robots. A full disk becomes
        writable again, because no supervisor starts with a full disk.

        graph -- the graph that the supervisor uses from now on; the robots keep the old graph
        """
        if graph is not None:
            self.graph = graph
            self.planner.forget_graph()
        self.disk.reopen()
        self.network.lose_messages()
        self.planner.answers.lose()
        self.hangs = False
        self._begin()
        if self.watcher is not None:
            self.watcher.restarted()

    # -- time -------------------------------------------------------------------------------------

    def step(self) -> None:
        """Simulates one time step: robots, messages, supervisor and planner."""
        begun, before = time.thread_time(), self._supervising + self.planner.spent
        last = self.now
        self.now += STEP
        for order in self.network.arrived_orders(self.now):
            self._drive(order.robot, last)
            self._deliver(order)
            self._reports.touch(order.robot)
        for name, agv in self.agvs.items():
            if agv.due <= self.now:
                self._drive(name, self.now)
        if self.now >= self._looks_at:
            self._looks_at = self.now + self.rhythm.room - _TOGETHER
            self._check_room()
        for steps in (*self.steps.values(), *self.step_devices.values()):
            steps.advance(STEP)
        for device in self.devices.values():
            device.advance(STEP)
        for name, agv in self.agvs.items():
            if not self.network.is_silent(name, self.now) and (
                    self._reports.is_due(name, agv, self.now)):
                self._drive(name, self.now)
                self._reports.reported(name, agv, self.now)
                told = self.lost.get(name, agv).report(self.now + self.clocks.get(name, 0.0))
                self.network.carry_report(name, told, self.now)
        if not self.hangs:
            self._supervise()
        if self.watcher is not None:
            self.watcher.stepped()
        self._stepping += (time.thread_time() - begun) - (
            self._supervising + self.planner.spent - before)

    def drive_all(self) -> None:
        """Simulates the motion of all robots up to now, because the places of all robots matter."""
        for name in self.agvs:
            self._drive(name, self.now)

    def _drive(self, name: str, until: float) -> None:
        """Simulates a robot's motion up to this time, unless that has been done already."""
        seconds = until - self._driven[name]
        if seconds < _TOGETHER:
            return
        agv, self._driven[name] = self.agvs[name], until
        was_driving = agv.is_driving
        agv.drive(STEP if abs(seconds - STEP) < _TOGETHER else seconds)
        if was_driving and not agv.is_driving:
            self._reports.ask_all(self.now)
        self._reports.touch(name)
        for refusal in agv.late_refusals():
            self._refuse(name, refusal)

    @property
    def spent(self) -> Spent:
        """The processor time of the run so far."""
        return Spent(self._stepping, self._supervising, self.planner.spent)

    def _hang(self, seconds: float) -> None:
        """Lets the supervisor hang during an event for `seconds`, while the world goes on."""
        end, self.hangs = self.now + seconds, True
        while self.now < end - _TOGETHER:
            self.step()
        self.hangs = False

    def _supervise(self) -> None:
        """Gives the supervisor all messages that have arrived by now, and then calls its tick.

        Does nothing if no message has arrived and the next tick is not due.
        """
        if self.now < self._ticks_at and not (self.network.reports.has_arrived(self.now)
                                              or self.planner.answers.has_arrived(self.now)):
            return
        self._ticks_at = self.now + self.rhythm.supervisor - _TOGETHER
        begun, planning = time.thread_time(), self.planner.spent
        for name, report in self.network.reports.arrived(self.now):
            aged = Report(report, self.now - report.stamp / 1e9)
            self.ages[name] = aged.age
            self.do(self.supervisor.report(name, aged, self.now))
        self._report_steps()
        for device in self.devices.values():
            for said in device.reports(self.now):
                for _ in range(self.network.copies()):
                    self.do(self.supervisor.device_report(said, self.now))
        for number, outcome in self.planner.answers.arrived(self.now):
            self.do(self.supervisor.plan_made(number, outcome, self.now))
        self.do(self.supervisor.tick(self.now))
        self._supervising += time.thread_time() - begun - (self.planner.spent - planning)
        self._reports.follow(self.supervisor, self.agvs, self.now)

    def _report_steps(self) -> None:
        """Reports the steps of each robot and device when they change, and once a second."""
        for name, steps in self.steps.items():
            if not self.network.is_silent(name, self.now) and self._must_report(name, steps):
                for _ in range(self.network.copies()):
                    self.do(self.supervisor.step_report(name, steps.report(), self.now))
        for name, steps in self.step_devices.items():
            if self._must_report(f'device {name}', steps):
                for _ in range(self.network.copies()):
                    self.do(self.supervisor.device_steps(name, steps.report(), self.now))

    def _must_report(self, subject: str, steps: SimulatedSteps) -> bool:
        """Returns whether a report is due. If so, notes that the report is made now."""
        at, news = self._steps_told.get(subject, (-math.inf, None))
        if news == steps.news and self.now < at + 1.0 - _TOGETHER:
            return False
        self._steps_told[subject] = self.now, steps.news
        return True

    def _deliver(self, order: SendRoute) -> None:
        robot = self.lost.get(order.robot, self.agvs[order.robot])
        refusal = robot.receive(route_order(order.order, order.speed))
        if refusal is not None:
            self._refuse(order.robot, refusal)

    def _refuse(self, name: str, refusal: RouteRefusal) -> None:
        """Counts a refusal, which the supervisor sees in the next report."""
        self.refused[name] += 1

    def do(self, actions: Sequence[Action]) -> None:
        """Performs the supervisor's actions. If the supervisor is to crash now, performs only the
        first actions.
        """
        crash = self.crash
        if crash is not None and self.disk.commits >= crash.commit:
            self.crash = None
            self._perform(actions[:crash.actions])
            self.restart()
        else:
            self._perform(actions)

    def _perform(self, actions: Sequence[Action]) -> None:
        for action in actions:
            if isinstance(action, SendRoute):
                if self.watcher is not None:
                    self.watcher.sends(action)
                self.sent.append(action)
                self.network.to_robots.append(action)
            elif isinstance(action, SendStep):
                self._send_step(action)
            elif isinstance(action, AskDevice):
                for _ in range(self.network.copies()):
                    self.devices[action.request.device].receive(action.request)
            elif isinstance(action, PublishStatus):
                if self.watcher is not None:
                    self.watcher.publishes(action.status)
                self.statuses.append(action.status)
                self._reports.ask_all(self.now)
            elif isinstance(action, Note):
                self.notes.append(action.text)
            elif isinstance(action, AskPlanner):
                self.planner.answer(action.number, self._plan(action), self.now)

    def _send_step(self, action: SendStep) -> None:
        if not action.device and self.network.is_silent(action.robot, self.now):
            return
        actor = (self.step_devices[action.device] if action.device
                 else self.steps[action.robot])
        for _ in range(self.network.copies()):
            actor.receive(action.command)

    def _plan(self, question: AskPlanner) -> PlanningOutcome:
        return self.planner.plan(question, self.supervisor.network)

    def _check_room(self) -> None:
        self.drive_all()
        robots = list(self.agvs.items())
        at = np.array([agv.position for _, agv in robots])
        radii = np.array([max(agv.kind.radius, self.loads.get(name, 0.0)) for name, agv in robots])
        one, other = np.triu_indices(len(robots), 1)
        room = np.hypot(*(at[one] - at[other]).T) - radii[one] - radii[other] - self.clearance
        if not len(room):
            return
        least = int(room.argmin())
        self.nearest = min(self.nearest, float(room[least]))
        assert room[least] > -1e-6, (
            f'{self.now:.1f} s: {robots[one[least]][0]} and {robots[other[least]][0]} are '
            f'{-room[least]:.3f} m too near: {self.picture()}')

    def picture(self) -> str:
        """Returns the state of the fleet as text, for the message of a failing test."""
        lines = [f'{self.now:.1f} s']
        for name, agv in self.agvs.items():
            robot = self.supervisor.robots[name]
            master, record = robot.master, robot.record
            lines.append(f'{name}: {agv}; supervisor: outage {robot.outage} '
                         f'{robot.why} place {record.position} ahead {record.ahead} order '
                         f'{master.order} waits for '
                         f'{self.supervisor.plan_executor.waits_for.get(name)!r}')
        for mission in self.supervisor.book.open:
            lines.append(str(mission))
        if self.supervisor.plan_executor.plan:
            lines.append(f'unserved {self.supervisor.plan_executor.plan.unserved}')
            lines += [f'{name}: {[d.edge for d in plan.drives]} from {plan.base}'
                      for name, plan in self.supervisor.plan_executor.plan.plans.items()]
        lines.append(f'is planning: {self.supervisor.plan_executor.is_planning}; last notes: '
                     f'{self.notes[-5:]}')
        return '\n'.join(lines)


class StrictConformance(Conformance):
    """Raises AssertionError at the first event that is not a step of the model of allocations."""

    def event(self, robots: Mapping[str, ObservedRobot], known: Mapping[str, Allocation],
              excluding: Callable[[str], Sequence[str]], claims: Claims) -> List[Violation]:
        """Checks an event; returns an empty list."""
        found = super().event(robots, known, excluding, claims)
        assert not found, '; '.join(map(str, found))
        return found


def route_order(order: Order, speed: float = 0.0) -> RouteOrder:
    """Returns the supervisor's order as the robot receives it.

    speed -- speed limit of the robot's load, m/s; 0: no limit
    """
    return order.sent_by(ME, speed=speed)
