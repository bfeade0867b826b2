"""The virtual world: a supervisor, the real planner and simulated robots in one process.

This module delivers all messages; they may come late, twice, or not at all. Time is virtual: the
planner answers after a given latency, and its work is limited by a number of rounds. Therefore a
run depends only on its seed, not on the speed of the computer.
"""
from __future__ import annotations

import math
import os
import tempfile
import time
from itertools import chain
from random import Random
from typing import (
    Any,
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
from fleet_core.interlocking.conformance import (
    Conformance,
    ObservedRobot,
    Violation,
)
from fleet_core.interlocking.reports import Report
from fleet_core.interlocking.route_master import ME
from fleet_core.planning.planner import FleetPlanner
from fleet_core.planning.tasks import Outcome
from fleet_core.supervision.actions import (
    Action,
    AskPlanner,
    Note,
    SendRoute,
    SendStep,
    TellStatus,
)
from fleet_core.supervision.journal import Journal
from fleet_core.supervision.missions import Status
from fleet_core.supervision.settings import RobotSettings
from fleet_core.supervision.supervisor import Supervisor
from fleet_core.supervision.switching import OrderSwitching
from fleet_simulation.agv.steps import SimulatedSteps
from route_protocol.master import Order
from route_protocol.values import RouteOrder, RouteRefusal, RouteReport
from trajectory_graph import Graph

STEP = 0.1  # s


class _CountingJournal(Journal):
    """A journal that counts its completed writes."""

    commits = 0

    def store(self, *args: Any, **named: Any) -> None:
        super().store(*args, **named)
        self.commits += 1


class Watcher(Protocol):
    """An observer of a fleet; the world calls it when something happens."""

    def sends(self, order: SendRoute) -> None:
        """The supervisor sends an order now."""

    def tells(self, status: Status) -> None:
        """The supervisor publishes a mission status now."""

    def stepped(self) -> None:
        """One time step is over."""

    def restarted(self) -> None:
        """The supervisor has restarted."""


class VirtualRobot(Protocol):
    """The interface that each simulated robot has for the world."""

    graph: Graph
    kind: RobotType

    @property
    def position(self) -> Tuple[float, float]:
        """The position x, y in m, in the frame of the graph."""

    @property
    def is_driving(self) -> bool:
        """Whether the robot has a route that is not finished."""

    def drive(self, seconds: float) -> None:
        """Advances the robot by the given virtual time, in s."""

    def receive(self, order: RouteOrder) -> Optional[RouteRefusal]:
        """Gives the robot an order; returns a refusal if the robot refuses it at once."""

    def late_refusals(self) -> List[RouteRefusal]:
        """Returns the refusals since the last call that `receive` did not return."""

    def report(self, stamp: float) -> RouteReport:
        """Returns the robot's report, with this stamp."""

    @property
    def news(self) -> object:
        """The part of the report that is sent at once when it changes."""


class LinkedRobot(Protocol):
    """The end of the network at the robot: the robot, or its computer without a link to it."""

    def receive(self, order: RouteOrder) -> Optional[RouteRefusal]:
        """Gives an order; returns a refusal if it is refused at once."""

    def report(self, now: float) -> RouteReport:
        """Returns the report on the robot, with the stamp `now`."""


class Rhythm(NamedTuple):
    """Periods of repeated actions, in virtual s; 0: in every step.

    driving    -- between two reports of a driving robot if nothing changes
    standing   -- between two reports of a standing robot if nothing changes
    supervisor -- between two ticks of the supervisor if no message comes
    room       -- between two checks of the distances between robots
    """

    driving: float = 0.0
    standing: float = 0.0
    supervisor: float = 0.0
    room: float = 0.0


class Spent(NamedTuple):
    """Seconds of processor time, by the part that used them."""

    world: float
    supervisor: float
    planner: float


Body = TypeVar('Body', bound=VirtualRobot)
_PLANNERS_KEPT = 4  # one planner per set of closed edges and learned driving times is kept
_TOGETHER = 1e-6    # s; events with a smaller time difference happen at the same time


class VirtualFleet(Generic[Body]):
    """A fleet on a graph, with its supervisor and planner.

    robots   -- by name: type, and id of the vertex on which the robot begins
    make     -- creates a robot from its name, type and vertex
    loss     -- probability (0..1) that a message is lost
    repeats  -- probability (0..1) that a message that is not lost comes twice
    planning -- s until the planner answers
    settings -- of all robots, or of each robot by its name
    parking  -- ids of the vertices on which robots may be parked; None: all vertices
    switches -- whether the order of robots on shared places may change while robots are late
    check_every -- number of events from one check against the model of allocations to the next
    """

    def __init__(self, graph: Graph, robots: Mapping[str, Tuple[RobotType, int]],
                 make: Callable[[str, RobotType, int], Body],
                 clearance: float = 0.1, seed: int = 0, loss: float = 0.0, repeats: float = 0.0,
                 planning: float = 0.1,
                 settings: Union[None, RobotSettings, Mapping[str, RobotSettings]] = None,
                 parking: Optional[Sequence[int]] = None, dock_approach: float = DOCK_APPROACH,
                 rhythm: Optional[Rhythm] = None, switches: bool = False,
                 check_every: int = 1) -> None:
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
        self.random = Random(seed)
        self.loss, self.repeats, self.planning = loss, repeats, planning
        self.rounds = 0
        """Rounds in which the planner improves each plan."""
        self._parking = None if parking is None else tuple(parking)
        self._folder = tempfile.TemporaryDirectory()
        self.journal_path = os.path.join(self._folder.name, 'journal.sqlite')
        self.now = 0.0
        self.silent: Dict[str, float] = {}
        """By robot: time until which no report comes from it and no order reaches it."""
        self.deaf: Dict[str, float] = {}
        """By robot: time until which no order reaches it. It still reports."""
        self.late: Dict[str, float] = {}
        """By robot: s by which its reports and refusals are delayed."""
        self.clocks: Dict[str, float] = {}
        """By robot: s by which its clock is ahead."""
        self.ages: Dict[str, float] = {}
        """By robot: age of its last report on arrival, in s; negative if its clock is ahead."""
        self.orders_late: Dict[str, float] = {}
        """By robot: s by which orders to it are delayed. No order overtakes another."""
        self.lost: Dict[str, LinkedRobot] = {}
        """By robot: its computer, if this has lost the link to the robot."""
        self.closed: Tuple[int, ...] = ()
        self.crash_at: Optional[int] = None
        """Number of the commit at which the supervisor dies, before the actions that follow it."""
        self.dies_after = 0
        """Number of the actions after that commit that are performed before the supervisor dies."""
        self.hangs = False
        """Whether the supervisor hangs. Messages to it wait until it continues."""
        self.commits = 0
        self.watcher: Optional[Watcher] = None
        self.statuses: List[Status] = []
        self.notes: List[str] = []
        self.sent: List[SendRoute] = []
        self.steps: Dict[str, SimulatedSteps] = {}
        """By robot: the steps that it carries out. A robot that is not in it carries out none."""
        self._steps_told: Dict[str, Tuple[float, object]] = {}
        self.refused = dict.fromkeys(robots, 0)
        """By robot: number of orders that it refused."""
        self.nearest = math.inf
        """Smallest free space (m) between two robots so far, minus the clearance."""
        self.to_robots: List[SendRoute] = []
        """Orders that leave the supervisor's computer in the next step."""
        self._under_way: List[Tuple[float, SendRoute]] = []
        self._reports: List[Tuple[float, str, RouteReport]] = []
        self._answers: List[Tuple[float, int, Outcome]] = []
        self._planners: Dict[Tuple[frozenset, frozenset], FleetPlanner] = {}
        self.plans: List[float] = []
        """s of processor time that each plan took."""
        self._supervising = self._stepping = self._planning_time = 0.0
        self._told: Dict[str, Tuple[float, object]] = {}
        self._ticks_at = self._looks_at = 0.0
        self._switches, self._check_every = switches, check_every
        self._begin()

    def __repr__(self) -> str:
        return f'<a fleet: {self._described}>'

    def _begin(self) -> None:
        self.journal = _CountingJournal(self.journal_path, lambda: 1e9 + self.now)
        self.journal._db.execute('PRAGMA synchronous=OFF')  # no test here cuts the power
        self.is_disk_full = False
        # No time limit for switching: the speed of the computer must not change the results.
        switching = OrderSwitching(self.clearance, math.inf) if self._switches else None
        self.supervisor = Supervisor(self.graph, self.fleet, self.settings, self.journal, self.now,
                                     switching=switching,
                                     conformance=StrictConformance(self._check_every))
        self.do(self.supervisor.close_edges(self.closed, self.now))

    def end(self) -> None:
        """Ends the world and deletes its journal."""
        self.journal.close()
        self._folder.cleanup()

    def disk_fails(self, fails: bool = True) -> None:
        """Makes the journal read-only, as on a full disk; with `fails` False, writable again."""
        self.is_disk_full = fails
        self.journal._db.execute(f'PRAGMA query_only={int(fails)}')

    def restart(self, graph: Optional[Graph] = None) -> None:
        """Kills the supervisor, loses all messages to and from it, and starts it again.

        Delayed orders that are already under way still reach the robots. The disk can be written
        again, because no supervisor starts with a full disk.

        graph -- another graph that is in force from now on; the robots keep theirs
        """
        if graph is not None:
            self.graph = graph
            self._planners.clear()
        self.commits += self.journal.commits
        self.journal.close()
        self.to_robots, self._answers, self._reports = [], [], []
        self.hangs = False
        self._begin()
        if self.watcher is not None:
            self.watcher.restarted()

    def under_way(self, name: str) -> List[SendRoute]:
        """Returns the orders to a robot that have not arrived yet and may still arrive."""
        return [order for order in (*(late for _, late in self._under_way), *self.to_robots)
                if order.robot == name]

    # -- time -------------------------------------------------------------------------------------

    def step(self) -> None:
        """Simulates one time step: robots, messages, supervisor and planner."""
        begun, before = time.thread_time(), self._supervising + self._planning_time
        self.now += STEP
        self._deliver_orders()
        for name, agv in self.agvs.items():
            agv.drive(STEP)
            for refusal in agv.late_refusals():
                self._refuse(name, refusal)
        if self.now >= self._looks_at:
            self._looks_at = self.now + self.rhythm.room - _TOGETHER
            self._check_room()
        for steps in self.steps.values():
            steps.advance(STEP)
        for name, agv in self.agvs.items():
            if self.silent.get(name, 0.0) <= self.now and self._has_to_tell(name, agv):
                at = self.now + self.late.get(name, 0.0)
                told = self.lost.get(name, agv).report(self.now + self.clocks.get(name, 0.0))
                self._reports += [(at, name, told)] * self._copies()
        if not self.hangs:
            self._supervise()
        if self.watcher is not None:
            self.watcher.stepped()
        self._stepping += (time.thread_time() - begun) - (
            self._supervising + self._planning_time - before)

    @property
    def spent(self) -> Spent:
        """The processor time of the run so far."""
        return Spent(self._stepping, self._supervising, self._planning_time)

    def _has_to_tell(self, name: str, robot: Body) -> bool:
        """Returns whether a robot reports now: its report changed, or the period is over."""
        news = robot.news
        last, before = self._told.get(name, (-math.inf, None))
        pause = self.rhythm.driving if robot.is_driving else self.rhythm.standing
        if news == before and self.now < last + pause - _TOGETHER:
            return False
        self._told[name] = self.now, news
        return True

    def _supervise(self) -> None:
        """Gives the supervisor all messages that have arrived by now, then its tick.

        Does nothing if no message has arrived and the next tick is not due.
        """
        arrivals = chain((at for at, *_ in self._reports), (at for at, *_ in self._answers))
        if self.now < self._ticks_at and all(at > self.now for at in arrivals):
            return
        self._ticks_at = self.now + self.rhythm.supervisor - _TOGETHER
        begun, planning = time.thread_time(), self._planning_time
        reports, self._reports = self._reports, []
        for at, name, report in reports:
            if at <= self.now:
                aged = Report(report, self.now - report.stamp / 1e9)
                self.ages[name] = aged.age
                self.do(self.supervisor.report(name, aged, self.now))
            else:
                self._reports.append((at, name, report))
        self._report_steps()
        answers, self._answers = self._answers, []
        for at, number, outcome in answers:
            if at <= self.now:
                self.do(self.supervisor.plan_made(number, outcome, self.now))
            else:
                self._answers.append((at, number, outcome))
        self.do(self.supervisor.tick(self.now))
        self._supervising += time.thread_time() - begun - (self._planning_time - planning)

    def _report_steps(self) -> None:
        """Reports the steps of each robot when they change, and once a second."""
        for name, steps in self.steps.items():
            at, news = self._steps_told.get(name, (-math.inf, None))
            if self.silent.get(name, 0.0) > self.now or (
                    news == steps.news and self.now < at + 1.0 - _TOGETHER):
                continue
            self._steps_told[name] = self.now, steps.news
            for _ in range(self._copies()):
                self.do(self.supervisor.step_report(name, steps.report(), self.now))

    def _copies(self) -> int:
        if self.random.random() < self.loss:
            return 0
        return 2 if self.random.random() < self.repeats else 1

    def _deliver_orders(self) -> None:
        orders, self.to_robots = self.to_robots, []
        under_way, self._under_way = self._under_way, []
        last: Dict[str, float] = {}
        for at, order in [*under_way, *((self.now + self.orders_late.get(o.robot, 0.0), o)
                                        for o in orders)]:
            at = last[order.robot] = max(at, last.get(order.robot, 0.0))
            if at > self.now:
                self._under_way.append((at, order))
            else:
                self._deliver(order)

    def _deliver(self, order: SendRoute) -> None:
        if max(self.silent.get(order.robot, 0.0), self.deaf.get(order.robot, 0.0)) > self.now:
            return
        robot = self.lost.get(order.robot, self.agvs[order.robot])
        for _ in range(self._copies()):
            refusal = robot.receive(route_order(order.order))
            if refusal is not None:
                self._refuse(order.robot, refusal)

    def _refuse(self, name: str, refusal: RouteRefusal) -> None:
        """Counts a refusal. The supervisor learns of it by the next report."""
        self.refused[name] += 1

    def do(self, actions: Sequence[Action]) -> None:
        """Performs the supervisor's actions, unless the supervisor is to die at this commit."""
        if self.crash_at is not None and self.commits + self.journal.commits >= self.crash_at:
            self.crash_at = None
            self._perform(actions[:self.dies_after])
            self.restart()
        else:
            self._perform(actions)

    def _perform(self, actions: Sequence[Action]) -> None:
        for action in actions:
            if isinstance(action, SendRoute):
                if self.watcher is not None:
                    self.watcher.sends(action)
                self.sent.append(action)
                self.to_robots.append(action)
            elif isinstance(action, SendStep):
                if self.silent.get(action.robot, 0.0) <= self.now:
                    for _ in range(self._copies()):
                        self.steps[action.robot].receive(action.command)
            elif isinstance(action, TellStatus):
                if self.watcher is not None:
                    self.watcher.tells(action.status)
                self.statuses.append(action.status)
            elif isinstance(action, Note):
                self.notes.append(action.text)
            elif isinstance(action, AskPlanner):
                self._answers.append((self.now + self.planning, action.number, self._plan(action)))

    def _plan(self, question: AskPlanner) -> Outcome:
        begun = time.thread_time()
        networks = question.closed, frozenset(question.edge_times.items())
        planner = self._planners.pop(networks, None)
        if planner is None:
            planner = FleetPlanner(
                self.supervisor.network.with_closed(question.closed, question.edge_times),
                self.clearance, self.fleet.types,
                tuple(self.graph.vertices) if self._parking is None else self._parking)
            while len(self._planners) >= _PLANNERS_KEPT:
                del self._planners[next(iter(self._planners))]
        self._planners[networks] = planner
        outcome = planner.plan(question.tasks, question.obstacles, rounds=self.rounds,
                               seed=question.seed)
        self.plans.append(time.thread_time() - begun)
        self._planning_time += self.plans[-1]
        return outcome

    def _check_room(self) -> None:
        robots = list(self.agvs.items())
        at = np.array([agv.position for _, agv in robots])
        radii = np.array([agv.kind.radius for _, agv in robots])
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
              excluding: Callable[[str], Sequence[str]]) -> List[Violation]:
        """Checks an event; returns nothing."""
        found = super().event(robots, known, excluding)
        assert not found, '; '.join(map(str, found))
        return found


def route_order(order: Order) -> RouteOrder:
    """Returns the supervisor's order as the robot receives it."""
    return order.sent_by(ME)
