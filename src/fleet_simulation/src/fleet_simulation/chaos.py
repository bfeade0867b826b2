"""All that can happen to a fleet, by name: to robots, to messages, by people, to the disk."""
from __future__ import annotations

import math
from itertools import groupby
from typing import Callable, Dict, Iterator, List, NamedTuple, Sequence, Set, Tuple

from fleet_simulation.promises import Promises
from fleet_simulation.supervised_fleet import STEP, SupervisedFleet
from graph_fleet_manager.nodes.early_stop import EarlyStop
from graph_fleet_manager.supervision.missions import Command, Mission, MissionState, Request
from graph_fleet_manager.supervision.outbox import AGAIN
from trajectory_graph import Edge, Graph, Vertex
from trajectory_graph.route_protocol import TAKEN_OVER, Reason, ReasonCode

ROBOTS = ('a', 'b', 'c')
PARKING = (21, 22, 23, 24, 25)
DOCKS = (24, 25)
SAME = 3  # instead of a robot's rank: the one of the event before
_SECONDS = (0.3, 1.0, 2.5, 6.0, 12.0)
_DELAYS = (0.0, 0.2, 0.4, 1.5)
_CLOCK = 3.0  # s, more than a report is ever under way
_CHARGES = (0.05, 0.2, 0.5, 0.9)
_CHARGING = 0.05  # of the battery, in a second in the dock


def yard() -> Graph:
    """Two rows of vertices joined like a ladder, with a spur at each of the upper ones; at the ends
    of two of them robots charge."""
    places: Dict[int, Tuple[float, float]] = {}
    ends: Dict[int, Tuple[int, int]] = {}
    for k in range(5):
        places[k + 1], places[k + 11], places[k + 21] = (2.0 * k, 0.0), (2.0 * k, 2.0), (2.0 * k,
                                                                                        4.0)
        ends[100 + k], ends[200 + k] = (k + 1, k + 11), (k + 11, k + 21)
        if k:
            ends[k], ends[k + 10] = (k, k + 1), (k + 10, k + 11)
    return Graph([Vertex(id, *place, 0.0, dock=id in DOCKS) for id, place in places.items()],
                 [Edge(id, *pair, velocity_forward=1.0, velocity_backwards=1.0)
                  for id, pair in ends.items()])


YARD = yard()
VERTICES = sorted(YARD.vertices)


Act = Callable[['Chaos', str, int], None]


class Event(NamedTuple):
    """Something happens to a robot, when that moment has come.

    robot  -- its rank: 0 to 2, those that drive come first; or SAME
    number -- how much or which one, as the act has it
    pause  -- s before the next event
    """

    act: str
    moment: str = 'now'
    robot: int = 0
    number: int = 0
    pause: float = 0.0


class Chaos:
    """A fleet in the yard to which things happen; the promises are checked all the time."""

    def __init__(self, fleet: SupervisedFleet) -> None:
        self.fleet = fleet
        self.promises = Promises(fleet, YARD)
        self.requests: List[Request] = []
        self._charges: Dict[str, float] = {}
        self._passed: Dict[float, Dict[str, int]] = {}
        self._cancelled: List[float] = []
        self._ends: List[Tuple[float, Callable[[], None]]] = []
        self._robot = ROBOTS[0]
        self._foreign = 10 ** 8

    def hide(self, robot: str, number: int) -> None:
        """Before anything was heard of a robot: it is switched off, and not where it is to begin.
        """
        agv = self.fleet.agvs[robot]
        taken = {one.visited[-1] for one in self.fleet.agvs.values()}
        vertex = [one for one in VERTICES if one not in taken][number % (len(VERTICES) - 3)]
        agv.edge, agv.arc, agv.visited = YARD.edges_from(vertex)[0], 0.0, [vertex]
        self.silence(robot, number)

    def run(self, seconds: float) -> None:
        """Lets time pass, in which what was to last for a while ends."""
        self._until(lambda: False, seconds)

    def _until(self, condition: Callable[[], bool], seconds: float) -> None:
        end = self.fleet.now + seconds - 1e-6
        while self.fleet.now < end and not condition():
            self.fleet.step()
            self._tell_charges()
            due = [what for at, what in self._ends if at <= self.fleet.now]
            self._ends = [(at, what) for at, what in self._ends if at > self.fleet.now]
            for what in due:
                what()

    def _tell_charges(self) -> None:
        fleet = self.fleet
        for name, charge in self._charges.items():
            agv = fleet.agvs[name]
            if not agv.is_driving and agv.visited[-1] in DOCKS:
                charge = self._charges[name] = min(charge + _CHARGING * STEP, 1.0)
            if not fleet.hangs and fleet.silent.get(name, 0.0) <= fleet.now:
                fleet.do(fleet.supervisor.battery(name, charge, fleet.now))

    def _later(self, number: int, what: Callable[[], None]) -> None:
        self._ends.append((self.fleet.now + _seconds(number), what))

    def happen(self, event: Event) -> None:
        """Waits for the moment, at most a few seconds, and lets it happen."""
        fleet = self.fleet
        if event.robot != SAME:
            self._robot = sorted(ROBOTS, key=lambda r: not fleet.agvs[r].is_driving)[event.robot]
        if event.moment == 'order':
            self._until(lambda: bool(fleet._to_robots), 3.0)
            self._robot = next((order.robot for order in fleet._to_robots), self._robot)
        elif event.moment == 'plan':
            self._until(lambda: fleet.supervisor.plan_executor.is_planning, 1.5)
        ACTS[event.act](self, self._robot, event.number)
        self.run(event.pause)

    # -- missions ---------------------------------------------------------------------------------

    def request(self, robot: str, number: int) -> None:
        """A mission: every third one for this robot, some with stays; ids come again."""
        vertices = [VERTICES[(number * k + k) % len(VERTICES)] for k in range(1, 2 + number % 3)]
        dwell = (None, None, 0.0, 2.0, -1.0)[number % 5]
        request = Request(
            1 + len(self.requests) % 4, tuple(vertices), robot='' if number % 4 else robot,
            priority=5 * (number % 7 == 0), stamp=1.0 + len(self.requests),
            dwells=() if dwell is None else (dwell,) * len(vertices))
        self.requests.append(request)
        self._passed[request.stamp] = {name: len(agv.visited) - 1
                                       for name, agv in self.fleet.agvs.items()}
        self._send(request)

    def repeat(self, _: str, number: int) -> None:
        """A request of before comes again, as one that was under way for long: one whose id was
        given to another since, if there is one."""
        requests = self.requests[:-4] or self.requests
        if requests:
            self._send(requests[-1 - number % len(requests)])

    def _send(self, request: Request) -> None:
        fleet = self.fleet
        before = self.promises.accepted(request.id, request.stamp)
        fleet.do(fleet.supervisor.request(request, fleet.now))
        after = self.promises.accepted(request.id, request.stamp)
        assert after <= 1, f'{request} became {after} missions'
        assert before == after or not fleet.is_disk_full

    def cancel(self, robot: str, number: int) -> None:
        """A robot's mission, or another one, is cancelled."""
        self._command(Command.CANCEL, robot, number)

    def pause(self, robot: str, number: int) -> None:
        """A robot's mission, or another one, is paused."""
        self._command(Command.PAUSE, robot, number)

    def resume(self, robot: str, number: int) -> None:
        """A robot's mission, or another one, is to go on."""
        self._command(Command.RESUME, robot, number)

    def release(self, robot: str, number: int) -> None:
        """A robot's mission, or another one, is to end its stay."""
        self._command(Command.RELEASE, robot, number)

    def _command(self, command: Command, robot: str, number: int) -> None:
        book = self.fleet.supervisor.book
        mission = book.of_robot(robot)
        if mission is None and book.open:
            mission = book.open[number % len(book.open)]
        if mission is not None:
            self._say(mission, command)

    def _say(self, mission: Mission, command: Command) -> None:
        fleet, robot = self.fleet, mission.robot
        supervisor = fleet.supervisor
        if command is Command.CANCEL:
            self._cancelled.append(mission.request.stamp)
        actions = supervisor.command(mission.request.id, command, fleet.now)
        if robot and command in (Command.CANCEL, Command.PAUSE):
            self.promises.rest(robot)
        elif robot and command is Command.RESUME:
            self.promises.resting.pop(robot, None)
        fleet.do(actions)

    # -- robots -----------------------------------------------------------------------------------

    def stall(self, robot: str, number: int) -> None:
        """It stands for a while."""
        self.fleet.agvs[robot].stalled = _seconds(number)

    def slow_down(self, robot: str, number: int) -> None:
        """It is slower, or as fast as ever."""
        self.fleet.agvs[robot].pace = (0.3, 1.0)[number % 2]

    def brake_late(self, robot: str, number: int) -> None:
        """It needs room to stop."""
        self.fleet.agvs[robot].braking = (1.0, 0.0)[number % 2]

    def switch_off(self, robot: str, number: int) -> None:
        """It is switched off, and on again without a memory."""
        self.promises.blamed.add(robot)
        self.fleet.agvs[robot].forget()
        self.silence(robot, number)

    def refuse(self, robot: str, number: int) -> None:
        """It refuses the next orders."""
        self.promises.blamed.add(robot)
        self.fleet.agvs[robot].refusing = 1 + number % 4

    def emergency_stop(self, robot: str, number: int) -> None:
        """Its emergency stop is pressed for a while."""
        self.fleet.agvs[robot].emergency = True
        self._later(number, lambda: setattr(self.fleet.agvs[robot], 'emergency', False))

    def change_battery(self, robot: str, number: int) -> None:
        """It finds its battery fuller or emptier than before."""
        self._charges[robot] = _CHARGES[number % 4]

    def leave_graph(self, robot: str, number: int) -> None:
        """It cannot tell for a while where it is."""
        self.promises.blamed.add(robot)
        agv = self.fleet.agvs[robot]
        agv.fail(Reason(ReasonCode.OFF_GRAPH, 'off the graph'))
        agv.off_graph = True
        self._later(number, lambda: setattr(agv, 'off_graph', False))

    def take_over(self, robot: str, _: int) -> None:
        """A person stops it; no more than that, for what they drive into is not ours."""
        self.promises.blamed.add(robot)
        self.fleet.agvs[robot].fail(TAKEN_OVER)

    def fail(self, robot: str, _: int) -> None:
        """It cannot drive on."""
        self.promises.blamed.add(robot)
        self.fleet.agvs[robot].fail(Reason(ReasonCode.OTHER, 'something lies in its way'))

    def drive_by_hand(self, robot: str, _: int) -> None:
        """Another program gives it a route to the end of its edge."""
        agv = self.fleet.agvs[robot]
        if agv.is_driving and robot not in self.fleet.lost:
            self.promises.driven_by_hand(robot, agv.edges[agv.current])
            self._foreign += 1
            agv.order(self._foreign, (agv.edges[agv.current],))

    def carry(self, robot: str, number: int) -> None:
        """A person carries a robot that is out of service to where there is room.

        The robot tells at once where it is: the fleet manager cannot know of one that does not.
        """
        fleet, agv = self.fleet, self.fleet.agvs[robot]
        edges = sorted(fleet.graph.edges)
        edge, share = edges[number % len(edges)], (0.0, 0.4)[number % 2]
        outage = fleet.supervisor.robots[robot].outage
        is_quiet = (agv.off_graph or robot in fleet.lost or fleet.late.get(robot, 0.0) > 0.0
                    or fleet.silent.get(robot, 0.0) > fleet.now)
        if outage is None or not outage.needs_person or is_quiet or agv.is_driving:
            return
        x, y = YARD.curve(edge).point_at(share * YARD.curve(edge).length)
        for name, other in fleet.supervisor.robots.items():
            if name != robot and (
                    math.dist((x, y), fleet.agvs[name].position) < 1.5
                    or any(YARD.curve(e).project(x, y).distance < 1.5 for e in other.record.held)):
                return
        agv.forget()
        agv.edge, agv.arc = edge, share * YARD.curve(edge).length
        self.promises.carried.add(robot)

    # -- messages ---------------------------------------------------------------------------------

    def reports_come_late(self, robot: str, number: int) -> None:
        """When they come sooner again, the new ones overtake the old."""
        self.fleet.late[robot] = _DELAYS[number % 4]

    def orders_come_late(self, robot: str, number: int) -> None:
        """They are under way for a while."""
        self.fleet.orders_late[robot] = _DELAYS[number % 4]

    def set_clock(self, robot: str, number: int) -> None:
        """The clock of its computer is ahead for a while."""
        self.fleet.clocks[robot] = _CLOCK
        self._later(number, lambda: self.fleet.clocks.update({robot: 0.0}))

    def silence(self, robot: str, number: int) -> None:
        """Nothing goes to it or comes from it."""
        self.fleet.silent[robot] = self.fleet.now + _seconds(number)

    def deafness(self, robot: str, number: int) -> None:
        """It goes on reporting, and no order reaches it."""
        self.fleet.deaf[robot] = self.fleet.now + _seconds(number)

    def lose_link(self, robot: str, number: int) -> None:
        """It drives on, and its computer does not know where, for a while."""
        self.promises.blamed.add(robot)
        self.fleet.lose_link(robot)
        self._later(number, lambda: self.fleet.find_link(robot))

    # -- the fleet --------------------------------------------------------------------------------

    def close(self, _: str, number: int) -> None:
        """Some edges are closed, or none."""
        self.promises.closed()
        self.fleet.close(*((), (12,), (1, 12), (201,))[number % 4])

    def change_graph(self, robot: str, number: int) -> None:
        """A graph without the edge behind a robot, or without another one, or with all edges."""
        agv = self.fleet.agvs[robot]
        edge = 0
        if number % 3 == 0 and agv.current:
            edge = abs(agv.edges[agv.current - 1])
        elif number % 3:
            edge = [e for e in sorted(YARD.edges) if e < 200][number % 13]
        if edge < 200 and edge not in self._used():
            self.use(Graph(YARD.vertices.values(),
                           [e for e in YARD.edges.values() if e.id != edge]))

    def _used(self) -> Set[int]:
        """Edges that no graph may lack, as robots are on them, or may drive there yet."""
        fleet = self.fleet
        used: Set[int] = set()
        for name, agv in fleet.agvs.items():
            used.update((agv.edge, agv.report(0.0).pose.edge, *agv.edges[agv.current:],
                         *fleet.supervisor.robots[name].record.ahead))
            used.update(edge for order in fleet.under_way(name) for edge in order.edges)
        return set(map(abs, used))

    def use(self, graph: Graph) -> None:
        """A graph comes into force. The supervisor then begins as after a restart."""
        self.fleet.graph = graph
        for agv in self.fleet.agvs.values():
            agv.graph = graph
        self.fleet._planners.clear()
        self.fleet.restart()

    def stop_all(self, _: str, __: int) -> None:
        """A person stops the fleet."""
        supervisor = self.fleet.supervisor
        actions = supervisor.stop_fleet(self.fleet.now)
        self.promises.stop()
        self.fleet.do(actions)

    def resume_all(self, _: str, __: int) -> None:
        """A person lets the fleet go on."""
        self.promises.stopped = None
        self.fleet.do(self.fleet.supervisor.resume_fleet(self.fleet.now)[1])

    def take_out(self, robot: str, _: int) -> None:
        """A person takes a robot out of service."""
        self.promises.blamed.add(robot)
        actions = self.fleet.supervisor.take_out(robot, self.fleet.now)
        self.promises.take_out(robot)
        self.fleet.do(actions)

    def bring_in(self, robot: str, _: int) -> None:
        """A person puts a robot back into service, one that cannot work if there is one."""
        robots = self.fleet.supervisor.robots
        if robots[robot].works:
            robot = next((name for name in ROBOTS if not robots[name].works), robot)
        problem, actions = self.fleet.supervisor.bring_in(robot, self.fleet.now)
        if not problem:
            self.promises.out.pop(robot, None)
        self.fleet.do(actions)

    def die(self, _: str, number: int) -> None:
        """The supervisor dies at one of its next commits, in the midst of acting on it."""
        self.fleet.dies_after = number // 6 % 3
        self.fleet.crash_at = self.fleet.commits + self.fleet.journal.commits + number % 6

    def restart(self, _: str, __: int) -> None:
        """The supervisor dies now."""
        self.fleet.restart()

    def hang(self, _: str, number: int) -> None:
        """The supervisor hangs for a while; maybe a person stops the fleet past it, and then it is
        killed or goes on."""
        fleet, is_stopped, is_killed = self.fleet, number % 4 > 0, number % 4 > 1
        hears = not fleet.loss and not any(
            until > fleet.now for until in (*fleet.deaf.values(), *fleet.silent.values())
        ) and not fleet.lost
        fleet.hangs = True
        if is_stopped:
            fleet._to_robots += EarlyStop(ROBOTS).stop(fleet.now)
        self.run(2.0)
        fleet.hangs = False
        if is_killed:
            if hears:
                self.promises.stop(is_past=True)
            fleet.restart()
        elif is_stopped:
            self.stop_all('', 0)

    def fill_disk(self, _: str, number: int) -> None:
        """Nothing can be stored for a while, unless the supervisor dies and its disk is mended."""
        self.fleet.disk_fails()
        self._later(number, lambda: self.fleet.disk_fails(False))

    # -- the end ----------------------------------------------------------------------------------

    def end(self) -> None:
        """All trouble is over; people have done their part. Now every mission ends, and truly."""
        fleet, limit = self.fleet, self.fleet.now + 100.0
        fleet.disk_fails(False)
        for at_end in (fleet.silent, fleet.deaf, fleet.late, fleet.orders_late, fleet.clocks):
            at_end.clear()
        for name, agv in fleet.agvs.items():
            fleet.find_link(name)
            agv.pace, agv.refusing, agv.emergency, agv.braking = 1.0, 0, False, 0.0
            agv.off_graph = False
        self._ends.clear()
        fleet.loss, fleet.crash_at = 0.0, None
        if len(fleet.graph.edges) < len(YARD.edges):
            self.use(YARD)
        fleet.close()
        self.run(2.0 + AGAIN)
        self.resume_all('', 0)
        for mission in fleet.supervisor.book.open[2:]:
            self._say(mission, Command.CANCEL)
        while any(robot.outage is not None for robot in fleet.supervisor.robots.values()):
            assert fleet.now < limit, fleet.picture()
            self.run(1.0)
            self._resume_what_was_stopped_past_it()
            for name, robot in fleet.supervisor.robots.items():
                if robot.outage is not None and robot.outage.needs_person:
                    self.bring_in(name, 0)
        self._until(self._all_are_done, 300.0)
        assert not fleet.supervisor.book.open, fleet.picture()
        for request in self.requests:
            self._check_end(request)

    def _resume_what_was_stopped_past_it(self) -> None:
        """A stop past the supervisor may have been under way for long."""
        if self.fleet.supervisor.is_stopped:
            self.resume_all('', 0)

    def _all_are_done(self) -> bool:
        self._resume_what_was_stopped_past_it()
        for mission in self.fleet.supervisor.book.open:
            if mission.state is MissionState.PAUSED:
                self._say(mission, Command.RESUME)
            elif mission.dwell_until == math.inf:
                self._say(mission, Command.RELEASE)
        return not self.fleet.supervisor.book.open

    def _check_end(self, request: Request) -> None:
        """Is the state in which a mission ended true?"""
        stored = self.promises.stored(request.id, request.stamp)
        told = self.promises.told(request)
        assert stored is not None or told in (None, MissionState.REFUSED), f'{request} is lost'
        if stored is None:
            return
        state, robot, reached = stored
        if state is MissionState.SUCCEEDED:
            visited = iter(self.fleet.agvs[robot].visited[self._passed[request.stamp][robot]:])
            assert _all_in(request.destinations, visited), (request, robot, self.fleet.picture())
        elif state is MissionState.CANCELLED:
            assert request.stamp in self._cancelled, request
        else:
            assert state is MissionState.FAILED and robot in self.promises.blamed, (request, stored)


def _all_in(vertices: Sequence[int], visited: Iterator[int]) -> bool:
    return all(vertex in visited for vertex, _ in groupby(vertices))


def _seconds(number: int) -> float:
    return _SECONDS[number % len(_SECONDS)]


def _named(*acts: Act) -> Dict[str, Act]:
    return {act.__name__: act for act in acts}


PEOPLE = _named(
    Chaos.repeat, Chaos.cancel, Chaos.pause, Chaos.resume, Chaos.release, Chaos.stop_all,
    Chaos.resume_all, Chaos.take_out, Chaos.bring_in, Chaos.carry)
"""What people do, by its name."""
TROUBLE = _named(
    Chaos.stall, Chaos.slow_down, Chaos.brake_late, Chaos.switch_off, Chaos.refuse,
    Chaos.emergency_stop, Chaos.change_battery, Chaos.leave_graph, Chaos.take_over, Chaos.fail,
    Chaos.drive_by_hand, Chaos.reports_come_late, Chaos.orders_come_late, Chaos.silence,
    Chaos.deafness, Chaos.lose_link, Chaos.set_clock, Chaos.close, Chaos.change_graph, Chaos.die,
    Chaos.restart, Chaos.hang, Chaos.fill_disk)
"""What goes wrong, by its name."""
ACTS = {**_named(Chaos.request), **PEOPLE, **TROUBLE}
"""What an event names."""
