"""A supervisor, the real planner and simulated AGVs in one process, with all that can go wrong.

Messages are carried by this module: they may come late, twice, or not at all. Time is simulated.
"""
from __future__ import annotations

import math
import os
import tempfile
from dataclasses import replace
from random import Random
from typing import (
    Any,
    Callable,
    Dict,
    Iterable,
    List,
    Mapping,
    Optional,
    Protocol,
    Sequence,
    Tuple,
)

from fleet_simulation.plain_agv import Agv, LostLink
from graph_fleet_manager.fleet import Fleet, Robot, RobotType
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
    """Who looks at everything that happens to a fleet."""

    def sends(self, order: SendRoute) -> None:
        """An order goes out now."""

    def tells(self, status: Status) -> None:
        """A status is told now."""

    def stepped(self) -> None:
        """One step of time is over."""

    def restarted(self) -> None:
        """The supervisor has begun anew."""


class SupervisedFleet:
    """Robots {name: (type, vertex)} on a graph; `parking` ids of vertices, None: all of them."""

    def __init__(self, graph: Graph, robots: Mapping[str, Tuple[RobotType, int]],
                 clearance: float = 0.1, seed: int = 0, loss: float = 0.0, repeats: float = 0.0,
                 planning: float = 0.1, settings: Optional[RobotSettings] = None,
                 parking: Optional[Sequence[int]] = None) -> None:
        kinds = tuple(dict.fromkeys(kind for kind, _ in robots.values()))
        self.graph, self.clearance = graph, clearance
        self._told = (f'seed {seed}, loss {loss}, repeats {repeats}, planning {planning}, '
                      f'{settings}, ' + ', '.join(f'{n}: {k}' for n, (k, _) in robots.items()))
        self.fleet = Fleet(kinds, tuple(Robot(n, k, v) for n, (k, v) in robots.items()), clearance)
        self.agvs = {name: Agv(graph, kind, vertex) for name, (kind, vertex) in robots.items()}
        self.settings = {name: settings or RobotSettings(release_ahead=0.0) for name in robots}
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
        self.orders_late: Dict[str, float] = {}
        """s that orders to a robot are under way; none overtakes another."""
        self.lost: Dict[str, LostLink] = {}
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
        self._begin()

    def __repr__(self) -> str:
        return f'<a fleet: {self._told}>'

    def _begin(self) -> None:
        self.journal = _CountingJournal(os.path.join(self._folder.name, 'journal.sqlite'),
                                        lambda: 1e9 + self.now)
        self.journal._db.execute('PRAGMA synchronous=OFF')  # no test here cuts the power
        self.is_disk_full = False
        self.supervisor = Supervisor(self.graph, self.fleet, self.settings, self.journal, self.now)
        self.do(self.supervisor.close_edges(self.closed, self.now))

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

    def lose_link(self, name: str, commands_only: bool = False) -> None:
        """A robot's computer loses the link to it: it drives on as it was told, and nobody knows
        where. Its route fails; a stop is obeyed once the link is back."""
        if name not in self.lost:
            self.lost[name] = LostLink(self.agvs[name], self.now, commands_only)

    def find_link(self, name: str) -> None:
        """The link is there again."""
        link = self.lost.pop(name, None)
        if link is not None:
            link.end()

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
        """One step of everybody."""
        self.now += STEP
        self._deliver_orders()
        for agv in self.agvs.values():
            agv.drive(STEP)
        self._check_room()
        for name, agv in self.agvs.items():
            if self.silent.get(name, 0.0) <= self.now:
                at = self.now + self.late.get(name, 0.0)
                told = self.lost.get(name, agv).report(self.now)
                self._reports += [(at, name, told)] * self._copies()
        if not self.hangs:
            self._supervise()
        if self.watcher is not None:
            self.watcher.stepped()

    def _supervise(self) -> None:
        """The supervisor hears what has arrived by now, and looks at the clock."""
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
                self.do(self.supervisor.report(name, replace(report, age=self.now - report.stamp),
                                               self.now))
            else:
                self._reports.append((at, name, report))
        answers, self._answers = self._answers, []
        for at, number, outcome in answers:
            if at <= self.now:
                self.do(self.supervisor.plan_made(number, outcome, self.now))
            else:
                self._answers.append((at, number, outcome))
        self.do(self.supervisor.tick(self.now))

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
                self.refused[order.robot] += 1
                at = self.now + self.late.get(order.robot, 0.0)
                self._refusals += [(at, order.robot, refusal, self.now)] * self._copies()

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
        networks = question.closed, frozenset(question.edge_times.items())
        planner = self._planners.get(networks)
        if planner is None:
            planner = self._planners[networks] = FleetPlanner(
                self.supervisor.network.with_closed(question.closed, question.edge_times),
                self.clearance, self.fleet.types, self._parking)
        return planner.plan(question.tasks, question.obstacles, rounds=self.rounds,
                            seed=question.seed)

    def _check_room(self) -> None:
        places = [(name, agv.kind.radius, *agv.position) for name, agv in self.agvs.items()]
        for k, (name, radius, x, y) in enumerate(places):
            for other, other_radius, other_x, other_y in places[:k]:
                room = math.hypot(x - other_x, y - other_y) - radius - other_radius - self.clearance
                self.nearest = min(self.nearest, room)
                assert room > -1e-6, (f'{self.now:.1f} s: {name} and {other} are {-room:.3f} m too '
                                      f'near: {self.picture()}')

    def picture(self) -> str:
        """Everything that a failing test should show."""
        lines = [f'{self.now:.1f} s']
        for name, agv in self.agvs.items():
            robot = self.supervisor.robots[name]
            client, record = robot.client, robot.record
            lines.append(f'{name}: edge {agv.edge} at {agv.arc:.2f}, route {agv.route_id} '
                         f'{agv.edges} {agv.current} {agv.phase.value}; known: {robot.outage} '
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


def blocked(fleet: SupervisedFleet, name: str) -> Tuple[Tuple[int, ...], Tuple[int, ...]]:
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
