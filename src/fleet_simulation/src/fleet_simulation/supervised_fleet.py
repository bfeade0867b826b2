"""The virtual world: a supervisor, the real planner and simulated robots in one process.

Messages are carried by this module: they may come late, twice, or not at all. Time is virtual: the
planner answers after a stated latency and is bounded by rounds, so a run depends on its seed only.
"""
from __future__ import annotations

import math
import os
import tempfile
import time
from dataclasses import replace
from itertools import chain
from random import Random
from typing import (
    Any,
    Callable,
    Dict,
    Generic,
    Iterable,
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

from fleet_simulation.plain_agv import Agv, LostLink
from graph_fleet_manager.fleet import DOCK_APPROACH, Fleet, Robot, RobotType
from graph_fleet_manager.interlocking.reports import Report
from graph_fleet_manager.planning.planner import FleetPlanner
from graph_fleet_manager.planning.tasks import Outcome
from graph_fleet_manager.supervision.actions import (
    Action,
    AskPlanner,
    Note,
    SendRoute,
    TellStatus,
)
from graph_fleet_manager.supervision.journal import Journal, RobotMemory
from graph_fleet_manager.supervision.missions import Mission, MissionState, Request, Status
from graph_fleet_manager.supervision.settings import RobotSettings
from graph_fleet_manager.supervision.supervisor import Supervisor
from graph_fleet_manager.supervision.switching import OrderSwitching
from trajectory_graph import Graph
from trajectory_graph.route_protocol import RouteRefusal

STEP = 0.1  # s


class _CountingJournal(Journal):
    """Counts how often something was really written."""

    commits = 0

    def store(self, missions: Iterable[Mission] = (),
              robots: Optional[Mapping[str, Optional[RobotMemory]]] = None,
              values: Optional[Mapping[str, int]] = None, graph: Optional[Graph] = None,
              stays: Optional[Mapping[int, float]] = None) -> None:
        super().store(missions, robots, values, graph, stays)
        self.commits += 1


class Watcher(Protocol):
    """An observer of all that happens to a fleet."""

    def sends(self, order: SendRoute) -> None:
        """An order goes out now."""

    def tells(self, status: Status) -> None:
        """A status is told now."""

    def stepped(self) -> None:
        """One step of time is over."""

    def restarted(self) -> None:
        """The supervisor has begun anew."""


class VirtualRobot(Protocol):
    """What the world asks of a robot, whichever it is."""

    graph: Graph
    kind: RobotType

    @property
    def position(self) -> Tuple[float, float]:
        """x, y in m."""

    @property
    def is_driving(self) -> bool:
        """Has it anything to drive?"""

    def drive(self, seconds: float) -> None:
        """Lets time pass."""

    def order(self, route_id: int, edges: Tuple[int, ...]) -> Optional[RouteRefusal]:
        """Takes up a route, or refuses it at once."""

    def late_refusals(self) -> List[RouteRefusal]:
        """The orders that it refused since the last call, after some thought."""

    def report(self, stamp: float) -> Report:
        """What it tells."""

    @property
    def news(self) -> object:
        """What of its report is told at once where it changes."""


class LinkedRobot(Protocol):
    """What reaches the robot, or its computer, through the network."""

    def order(self, route_id: int, edges: Tuple[int, ...]) -> Optional[RouteRefusal]:
        """Takes up a route, or refuses it at once."""

    def report(self, now: float) -> Report:
        """What is told of the robot."""


class Rhythm(NamedTuple):
    """How often things happen, in virtual s; 0: in every step.

    driving, standing -- between two reports of a robot without news
    supervisor        -- between two looks at the clock while nothing comes
    room              -- between two looks at how near robots are to each other
    """

    driving: float = 0.0
    standing: float = 0.0
    supervisor: float = 0.0
    room: float = 0.0


class Spent(NamedTuple):
    """Seconds of this computer's time, by what they were used for."""

    world: float
    supervisor: float
    planner: float


Body = TypeVar('Body', bound=VirtualRobot)
_PLANNERS_KEPT = 4  # closures and learned times come and go
_TOGETHER = 1e-6    # s: what is nearer than that in time happens at once


class VirtualFleet(Generic[Body]):
    """Robots {name: (type, vertex)} on a graph; `parking` ids of vertices, None: all of them.

    make     -- a robot of a name, a type and a vertex
    settings -- of all robots, or of each by its name
    switches -- the order of use is changed while robots are late
    """

    def __init__(self, graph: Graph, robots: Mapping[str, Tuple[RobotType, int]],
                 make: Callable[[str, RobotType, int], Body],
                 clearance: float = 0.1, seed: int = 0, loss: float = 0.0, repeats: float = 0.0,
                 planning: float = 0.1,
                 settings: Union[None, RobotSettings, Mapping[str, RobotSettings]] = None,
                 parking: Optional[Sequence[int]] = None, dock_approach: float = DOCK_APPROACH,
                 rhythm: Optional[Rhythm] = None, switches: bool = False) -> None:
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
        """In which plans are improved."""
        self._parking = tuple(graph.vertices) if parking is None else tuple(parking)
        self._folder = tempfile.TemporaryDirectory()
        self.now = 0.0
        self.silent: Dict[str, float] = {}
        self.deaf: Dict[str, float] = {}
        """Until when no order reaches a robot, which goes on reporting."""
        self.late: Dict[str, float] = {}
        """s that reports of a robot are under way."""
        self.clocks: Dict[str, float] = {}
        """s by which a robot's clock is ahead."""
        self.ages: Dict[str, float] = {}
        """How old the last report of each robot seemed when it came, s."""
        self.orders_late: Dict[str, float] = {}
        """s that orders to a robot are under way; none overtakes another."""
        self.lost: Dict[str, LinkedRobot] = {}
        """Robots to which their computers have lost the link."""
        self.closed: Tuple[int, ...] = ()
        self.crash_at: Optional[int] = None
        """With this commit the supervisor dies, before anything is done that relies on it."""
        self.dies_after = 0
        """So many of the actions that follow that commit are done nevertheless."""
        self.hangs = False
        """The supervisor does nothing; what comes in waits for it."""
        self.commits = 0
        self.watcher: Optional[Watcher] = None
        self.statuses: List[Status] = []
        self.notes: List[str] = []
        self.sent: List[SendRoute] = []
        self.refused = dict.fromkeys(robots, 0)
        """How many orders each robot did not take up."""
        self.nearest = math.inf
        """The least room (m) that any two robots left each other beyond the clearance."""
        self._to_robots: List[SendRoute] = []
        self._under_way: List[Tuple[float, SendRoute]] = []
        self._reports: List[Tuple[float, str, Report]] = []
        self._refusals: List[Tuple[float, str, RouteRefusal, float]] = []
        self._answers: List[Tuple[float, int, Outcome]] = []
        self._planners: Dict[Tuple[frozenset, frozenset], FleetPlanner] = {}
        self.plans: List[float] = []
        """s of this computer's time that each plan took."""
        self._supervising = self._stepping = self._planning_time = 0.0
        self._told: Dict[str, Tuple[float, object]] = {}
        self._ticks_at = self._looks_at = 0.0
        self._switches = switches
        self._begin()

    def __repr__(self) -> str:
        return f'<a fleet: {self._described}>'

    def _begin(self) -> None:
        self.journal = _CountingJournal(os.path.join(self._folder.name, 'journal.sqlite'),
                                        lambda: 1e9 + self.now)
        self.journal._db.execute('PRAGMA synchronous=OFF')  # no test here cuts the power
        self.is_disk_full = False
        # How fast this computer is must not decide what happens.
        switching = OrderSwitching(self.clearance, math.inf) if self._switches else None
        self.supervisor = Supervisor(self.graph, self.fleet, self.settings, self.journal, self.now,
                                     switching=switching)
        self.do(self.supervisor.close_edges(self.closed, self.now))

    def end(self) -> None:
        """Ends the world; its journal goes with it."""
        self.journal.close()
        self._folder.cleanup()

    def disk_fails(self, fails: bool = True) -> None:
        """From now on nothing can be written, or everything again."""
        self.is_disk_full = fails
        self.journal._db.execute(f'PRAGMA query_only={int(fails)}')

    def restart(self) -> None:
        """The supervisor dies, with all messages to and from it, and comes back.

        What is under way to robots longer than a step still reaches them. A full disk has room
        again, for without one no supervisor begins.
        """
        self.commits += self.journal.commits
        self.journal.close()
        self._to_robots, self._answers, self._reports, self._refusals = [], [], [], []
        self.hangs = False
        self._begin()
        if self.watcher is not None:
            self.watcher.restarted()

    # -- what users do ----------------------------------------------------------------------------

    def request(self, id: int, *destinations: int, **more: Any) -> None:
        """Sends a mission."""
        self.do(self.supervisor.request(Request(id, destinations, **more), self.now))

    def close(self, *edges: int) -> None:
        """Closes these edges only."""
        self.closed = edges
        self.do(self.supervisor.close_edges(edges, self.now))

    def bring_in(self, name: str) -> str:
        """A person brings a robot in, once more where it is to stop first; why not, or nothing."""
        for _ in range(2):
            problem, actions = self.supervisor.bring_in(name, self.now)
            self.do(actions)
            if 'told to stop first' not in problem:
                break
            self.run(3.0)
        return problem

    def state(self, id: int) -> MissionState:
        """The state of a mission."""
        mission = self.supervisor.book.find(id)
        assert mission is not None, f'mission {id} is lost'
        return mission.state

    def told(self, id: int) -> List[MissionState]:
        """The states of a request that were told, each once."""
        states = [status.state for status in self.statuses if status.request_id == id]
        return [s for k, s in enumerate(states) if k == 0 or states[k - 1] != s]

    def robot_of(self, id: int) -> str:
        """The robot that a mission was last with."""
        mission = self.supervisor.book.find(id)
        assert mission is not None
        return mission.robot

    def reached(self, id: int) -> int:
        """How many destinations of a mission are visited."""
        mission = self.supervisor.book.find(id)
        assert mission is not None
        return mission.reached

    def under_way(self, name: str) -> List[SendRoute]:
        """Orders that have not reached a robot yet, and still may."""
        return [order for order in (*(late for _, late in self._under_way), *self._to_robots)
                if order.robot == name]

    # -- time -------------------------------------------------------------------------------------

    def run(self, seconds: float) -> None:
        """Lets so much time pass."""
        for _ in range(round(seconds / STEP)):
            self.step()

    def run_until(self, condition: Callable[[], bool], limit: float = 300.0) -> None:
        """Until something is so."""
        begun = self.now
        while not condition():
            assert self.now - begun < limit, self.picture()
            self.step()

    def run_until_done(self, *ids: int, limit: float = 600.0) -> float:
        """Until these missions are at an end; the time that it took."""
        begun = self.now
        while any(self.state(id).is_open for id in ids):
            assert self.now - begun < limit, self.picture()
            self.step()
        return self.now - begun

    def step(self) -> None:
        """One step of all robots."""
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
        """What the run took so far of this computer's time."""
        return Spent(self._stepping, self._supervising, self._planning_time)

    def _has_to_tell(self, name: str, robot: Body) -> bool:
        """Has a robot news, or has it told nothing for long?"""
        news = robot.news
        last, before = self._told.get(name, (-math.inf, None))
        pause = self.rhythm.driving if robot.is_driving else self.rhythm.standing
        if news == before and self.now < last + pause - _TOGETHER:
            return False
        self._told[name] = self.now, news
        return True

    def _supervise(self) -> None:
        """The supervisor hears what has arrived by now, and looks at the clock."""
        arrivals = chain((at for at, *_ in self._refusals), (at for at, *_ in self._reports),
                         (at for at, *_ in self._answers))
        if self.now < self._ticks_at and all(at > self.now for at in arrivals):
            return
        self._ticks_at = self.now + self.rhythm.supervisor - _TOGETHER
        refusals, self._refusals = self._refusals, []
        for refused in refusals:
            at, name, refusal, stamp = refused
            if at <= self.now:
                self.do(self.supervisor.refusal(name, refusal, self.now, stamp))
            else:
                self._refusals.append(refused)
        reports, self._reports = self._reports, []
        for at, name, report in reports:
            if at <= self.now:
                aged = replace(report, age=self.now - report.stamp)
                self.ages[name] = aged.age
                self.do(self._timed(self.supervisor.report, name, aged, self.now))
            else:
                self._reports.append((at, name, report))
        answers, self._answers = self._answers, []
        for at, number, outcome in answers:
            if at <= self.now:
                self.do(self._timed(self.supervisor.plan_made, number, outcome, self.now))
            else:
                self._answers.append((at, number, outcome))
        self.do(self._timed(self.supervisor.tick, self.now))

    def _timed(self, act: Callable[..., List[Action]], *arguments: Any) -> List[Action]:
        """What the supervisor answers; the time that it takes is counted."""
        begun = time.thread_time()
        actions = act(*arguments)
        self._supervising += time.thread_time() - begun
        return actions

    def _copies(self) -> int:
        if self.random.random() < self.loss:
            return 0
        return 2 if self.random.random() < self.repeats else 1

    def _deliver_orders(self) -> None:
        orders, self._to_robots = self._to_robots, []
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
            refusal = robot.order(order.route_id, order.edges)
            if refusal is not None:
                self._refuse(order.robot, refusal)

    def _refuse(self, name: str, refusal: RouteRefusal) -> None:
        self.refused[name] += 1
        at = self.now + self.late.get(name, 0.0)
        stamp = self.now + self.clocks.get(name, 0.0)
        self._refusals += [(at, name, refusal, stamp)] * self._copies()

    def do(self, actions: Sequence[Action]) -> None:
        """Does what the supervisor wants done, unless it dies first."""
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
                self._to_robots.append(action)
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
                self.clearance, self.fleet.types, self._parking)
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
        """Everything that a failing test should show."""
        lines = [f'{self.now:.1f} s']
        for name, agv in self.agvs.items():
            robot = self.supervisor.robots[name]
            client, record = robot.client, robot.record
            lines.append(f'{name}: {agv}; known: {robot.outage} '
                         f'{robot.why} place {record.position} ahead {record.ahead} order '
                         f'{client.order} waits '
                         f'{self.supervisor.plan_executor.waits_for.get(name)!r}')
        for mission in self.supervisor.book.open:
            lines.append(str(mission))
        if self.supervisor.plan_executor.plan:
            lines.append(f'unserved {self.supervisor.plan_executor.plan.unserved}')
            lines += [f'{name}: {[d.edge for d in plan.drives]} from {plan.base}'
                      for name, plan in self.supervisor.plan_executor.plan.plans.items()]
        lines.append(f'asked {self.supervisor.plan_executor.is_planning}; {self.notes[-5:]}')
        return '\n'.join(lines)


class SupervisedFleet(VirtualFleet[Agv]):
    """The world of the tests: plain AGVs, and what can be done to them."""

    def __init__(self, graph: Graph, robots: Mapping[str, Tuple[RobotType, int]],
                 **more: Any) -> None:
        super().__init__(graph, robots, lambda _, kind, vertex: Agv(graph, kind, vertex), **more)

    def lose_link(self, name: str, commands_only: bool = False) -> None:
        """A robot's computer loses the link to it: it drives on as it was told, and no node knows
        where. Its route fails; a stop is obeyed once the link is back."""
        if name not in self.lost:
            self.lost[name] = LostLink(self.agvs[name], self.now, commands_only)

    def find_link(self, name: str) -> None:
        """The link is there again."""
        link = self.lost.pop(name, None)
        if isinstance(link, LostLink):
            link.end()


def blocked(fleet: VirtualFleet, name: str) -> Tuple[Tuple[int, ...], Tuple[int, ...]]:
    """Ids of the vertices and edges on which a robot may be, by its allocation."""
    allocation = fleet.supervisor.robots[name].client.allocation
    vertices = {vertex for vertex in (allocation.vertex,) if vertex is not None}
    edges = {abs(hold.edge) for hold in allocation.holds}
    for area in allocation.areas:
        for x, y in area.line:
            near = [vertex.id for vertex in fleet.graph.vertices.values()
                    if math.hypot(vertex.x - x, vertex.y - y) < 1e-6]
            nearest = fleet.graph.nearest_edge(x, y)
            assert nearest is not None
            vertices.update(near)
            edges.update(() if near else nearest[:1])
    return tuple(sorted(vertices)), tuple(sorted(edges))
