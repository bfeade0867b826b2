"""All events that can happen to a fleet, by name: of robots, messages, people and the disk."""
from __future__ import annotations

import math
from itertools import groupby
from typing import Callable, Dict, Iterator, List, NamedTuple, Sequence, Set, Tuple

from fleet_core.supervision.early_stop import EarlyStop
from fleet_core.supervision.fleet_stop import FleetStop, StopCause
from fleet_core.supervision.missions import CommandKind, Mission, MissionState, Request
from fleet_core.supervision.outbox import AGAIN
from fleet_simulation.virtual_fleet import STEP, Crash
from route_protocol.values import TAKEN_OVER, Reason, ReasonCode
from trajectory_graph import Edge, Graph, Vertex
from world.promises import Promises
from world.supervised_fleet import SupervisedFleet

ROBOTS = ('a', 'b', 'c')
PARKING = (21, 22, 23, 24, 25)
DOCKS = (24, 25)
SAME = 3  # instead of a robot's rank: the robot of the previous event
_SECONDS = (0.3, 1.0, 2.5, 6.0, 12.0)
_DELAYS = (0.0, 0.2, 0.4, 1.5)
_CLOCK = 3.0  # s; a wrong clock is ahead by this time, which exceeds each delay of a report
_FAR = 1.5  # m; a robot farther away from another robot and its route is not in its way
_CHARGES = (0.05, 0.2, 0.5, 0.9)
_CHARGING = 0.05  # charge (0..1) that a battery gains per second in the dock


def yard() -> Graph:
    """Returns a graph like a ladder: two rows of vertices, with a spur at each upper vertex.

    The ends of two spurs are docks.
    """
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
    """One event of a run.

    act    -- name of the method of `Chaos` that makes the event happen
    moment -- `now`, `order` (when an order is sent) or `plan` (while the planner works)
    robot  -- rank of the robot, 0 to 2, driving robots first; or SAME
    number -- parameter of the act, for example which edge or how long
    pause  -- s before the next event
    """

    act: str
    moment: str = 'now'
    robot: int = 0
    number: int = 0
    pause: float = 0.0


class Chaos:
    """Lets events happen to a fleet in the yard, while `Promises` checks the fleet all the time."""

    def __init__(self, fleet: SupervisedFleet) -> None:
        self.fleet = fleet
        self.promises = Promises(fleet, YARD)
        self.requests: List[Request] = []
        self._charges: Dict[str, float] = {}
        self._passed: Dict[float, Dict[str, int]] = {}
        self._cancelled: List[float] = []
        self._ends: List[Tuple[float, Callable[[], None]]] = []
        self._robot = ROBOTS[0]

    def hide(self, robot: str, number: int) -> None:
        """Switches a robot off before its first report, and puts it onto an unexpected vertex."""
        agv = self.fleet.agvs[robot]
        taken = {one.visited[-1] for one in self.fleet.agvs.values()}
        vertex = [one for one in VERTICES if one not in taken][number % (len(VERTICES) - 3)]
        agv.edge, agv.arc, agv.visited = YARD.edges_from(vertex)[0], 0.0, [vertex]
        self.silence(robot, number)

    def run(self, seconds: float) -> None:
        """Simulates the given virtual seconds; temporary faults end when their time is over."""
        self.run_until(lambda: False, seconds)

    def run_until(self, condition: Callable[[], bool], seconds: float) -> None:
        """Simulates until the condition holds, at most the given virtual seconds."""
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
            if not fleet.hangs and fleet.network.silent.get(name, 0.0) <= fleet.now:
                fleet.do(fleet.supervisor.battery(name, charge, fleet.now))

    def later(self, number: int, what: Callable[[], None]) -> None:
        """Lets something happen after a time that the number determines."""
        self._ends.append((self.fleet.now + _seconds(number), what))

    def happen(self, event: Event) -> None:
        """Waits at most 3 s for the event's moment, then lets the event happen."""
        fleet = self.fleet
        if event.robot != SAME:
            self._robot = sorted(ROBOTS, key=lambda r: not fleet.agvs[r].is_driving)[event.robot]
        if event.moment == 'order':
            self.run_until(lambda: bool(fleet.network.to_robots), 3.0)
            self._robot = next((order.robot for order in fleet.network.to_robots), self._robot)
        elif event.moment == 'plan':
            self.run_until(lambda: fleet.supervisor.plan_executor.is_planning, 1.5)
        getattr(self, event.act)(self._robot, event.number)
        self.run(event.pause)

    # -- missions ---------------------------------------------------------------------------------

    def request(self, robot: str, number: int) -> None:
        """Requests a mission. Some missions are for this robot, some have dwells, and ids are used
        again.
        """
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
        """Sends an earlier request again, like a message with a long delay.

        A request is preferred if a later request used its id again.
        """
        requests = self.requests[:-4] or self.requests
        if requests:
            self._send(requests[-1 - number % len(requests)])

    def _send(self, request: Request) -> None:
        fleet = self.fleet
        before = self.promises.accepted(request.id, request.stamp)
        fleet.do(fleet.supervisor.request(request, fleet.now))
        after = self.promises.accepted(request.id, request.stamp)
        assert after <= 1, f'{request} became {after} missions'
        assert before == after or not fleet.disk.is_full

    def cancel(self, robot: str, number: int) -> None:
        """Cancels the robot's mission, or an open mission if the robot has none."""
        self._command(CommandKind.CANCEL, robot, number)

    def pause(self, robot: str, number: int) -> None:
        """Pauses the robot's mission, or an open mission if the robot has none."""
        self._command(CommandKind.PAUSE, robot, number)

    def resume(self, robot: str, number: int) -> None:
        """Resumes the robot's mission, or an open mission if the robot has none."""
        self._command(CommandKind.RESUME, robot, number)

    def release(self, robot: str, number: int) -> None:
        """Ends the dwell of the robot's mission, or of an open mission if the robot has none."""
        self._command(CommandKind.RELEASE, robot, number)

    def _command(self, command: CommandKind, robot: str, number: int) -> None:
        book = self.fleet.supervisor.book
        mission = book.of_robot(robot)
        if mission is None and book.open:
            mission = book.open[number % len(book.open)]
        if mission is not None:
            self._say(mission, command)

    def _say(self, mission: Mission, command: CommandKind) -> None:
        fleet, robot = self.fleet, mission.robot
        supervisor = fleet.supervisor
        if command is CommandKind.CANCEL:
            self._cancelled.append(mission.request.stamp)
        actions = supervisor.command(mission.request.id, command, fleet.now)
        if robot and command in (CommandKind.CANCEL, CommandKind.PAUSE):
            self.promises.rest(robot)
        elif robot and command is CommandKind.RESUME:
            self.promises.resting.pop(robot, None)
        fleet.do(actions)

    # -- robots -----------------------------------------------------------------------------------

    def stall(self, robot: str, number: int) -> None:
        """Makes the robot stand still for a while."""
        self.fleet.agvs[robot].stalled = _seconds(number)

    def slow_down(self, robot: str, number: int) -> None:
        """Sets the robot's speed to 30 % or back to 100 %."""
        self.fleet.agvs[robot].pace = (0.3, 1.0)[number % 2]

    def brake_late(self, robot: str, number: int) -> None:
        """Sets the robot's braking distance to 1 m or 0 m."""
        self.fleet.agvs[robot].braking = (1.0, 0.0)[number % 2]

    def switch_off(self, robot: str, number: int) -> None:
        """Switches the robot off, and on again without a memory of its route."""
        self.promises.blamed.add(robot)
        self.fleet.agvs[robot].forget()
        self.silence(robot, number)

    def refuse(self, robot: str, number: int) -> None:
        """Makes the robot refuse its next 1 to 4 orders."""
        self.promises.blamed.add(robot)
        self.fleet.agvs[robot].refusing = 1 + number % 4

    def emergency_stop(self, robot: str, number: int) -> None:
        """Presses the robot's emergency stop for a while."""
        self.fleet.agvs[robot].emergency = True
        self.later(number, lambda: setattr(self.fleet.agvs[robot], 'emergency', False))

    def change_battery(self, robot: str, number: int) -> None:
        """Sets the charge of the robot's battery."""
        self._charges[robot] = _CHARGES[number % 4]

    def leave_graph(self, robot: str, number: int) -> None:
        """Makes the robot lose its position for a while: it is off the graph."""
        self.promises.blamed.add(robot)
        agv = self.fleet.agvs[robot]
        agv.fail(Reason(ReasonCode.OFF_GRAPH, 'off the graph'))
        agv.off_graph = True
        self.later(number, lambda: setattr(agv, 'off_graph', False))

    def take_over(self, robot: str, _: int) -> None:
        """Lets a person take over the robot.

        The person stops it and does not drive it: the fleet manager cannot prevent that a person
        drives one robot into another.
        """
        self.promises.blamed.add(robot)
        self.fleet.agvs[robot].fail(TAKEN_OVER)

    def fail(self, robot: str, _: int) -> None:
        """Lets the robot's route fail."""
        self.promises.blamed.add(robot)
        self.fleet.agvs[robot].fail(Reason(ReasonCode.OTHER, 'an object blocks the path'))

    def drive_by_hand(self, robot: str, _: int) -> None:
        """Lets another program order the robot to the end of its current edge."""
        agv = self.fleet.agvs[robot]
        if agv.is_driving and robot not in self.fleet.lost:
            self.promises.blamed.add(robot)
            agv.obey_another(agv.ahead[:1])

    def carry(self, robot: str, number: int) -> None:
        """Lets a person carry a robot that is out of service to a place far from all others.

        The robot reports its new place at once: the fleet manager cannot know of a robot that
        is carried while it does not report.
        """
        fleet, agv = self.fleet, self.fleet.agvs[robot]
        edges = sorted(fleet.graph.edges)
        edge, share = edges[number % len(edges)], (0.0, 0.4)[number % 2]
        if self.can_be_carried(robot) and self.is_far(robot, edge, share):
            agv.be_carried(edge, share * YARD.curve(edge).length)
            self.promises.carried.add(robot)

    def tells(self, robot: str) -> bool:
        """Returns whether the robot's reports show its place, without delay."""
        fleet = self.fleet
        return not (fleet.agvs[robot].off_graph or robot in fleet.lost
                    or fleet.network.late.get(robot, 0.0) > 0.0
                    or fleet.network.is_silent(robot, fleet.now))

    def can_be_carried(self, robot: str) -> bool:
        """Returns whether the robot stands, and is out of service."""
        return (self.fleet.supervisor.robots[robot].needs_person and self.tells(robot)
                and not self.fleet.agvs[robot].is_driving)

    def is_far(self, robot: str, edge: int, share: float) -> bool:
        """Returns whether a place is far from all other robots, and from their routes."""
        fleet = self.fleet
        x, y = YARD.curve(edge).point_at(share * YARD.curve(edge).length)
        return not any(
            math.dist((x, y), fleet.agvs[name].position) < _FAR
            or any(YARD.curve(e).project(x, y).distance < _FAR for e in other.record.held)
            for name, other in fleet.supervisor.robots.items() if name != robot)

    # -- messages ---------------------------------------------------------------------------------

    def reports_come_late(self, robot: str, number: int) -> None:
        """Sets the delay of the robot's reports. If the delay becomes shorter, new reports overtake
        old ones.
        """
        self.fleet.network.late[robot] = _DELAYS[number % 4]

    def orders_come_late(self, robot: str, number: int) -> None:
        """Sets the delay of orders to the robot."""
        self.fleet.network.orders_late[robot] = _DELAYS[number % 4]

    def set_clock(self, robot: str, number: int) -> None:
        """Sets the clock of the robot's computer ahead for a while."""
        self.fleet.clocks[robot] = _CLOCK
        self.later(number, lambda: self.fleet.clocks.update({robot: 0.0}))

    def silence(self, robot: str, number: int) -> None:
        """Cuts all messages to and from the robot for a while."""
        self.fleet.network.silent[robot] = self.fleet.now + _seconds(number)

    def deafness(self, robot: str, number: int) -> None:
        """Loses all orders to the robot for a while; its reports still arrive."""
        self.fleet.network.deaf[robot] = self.fleet.now + _seconds(number)

    def lose_link(self, robot: str, number: int) -> None:
        """Cuts the link between the robot and its computer for a while; the robot drives on."""
        self.promises.blamed.add(robot)
        self.fleet.lose_link(robot)
        self.later(number, lambda: self.fleet.find_link(robot))

    # -- the fleet --------------------------------------------------------------------------------

    def close(self, _: str, number: int) -> None:
        """Closes some edges, or opens all of them."""
        self.promises.closed()
        self.fleet.close(*((), (12,), (1, 12), (201,))[number % 4])

    def change_graph(self, robot: str, number: int) -> None:
        """Uses a graph without the edge behind a robot, a graph without some other edge, or the
        whole graph.
        """
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
        """Returns the edges that each graph must have, because a robot is on them, or may
        still drive on them.
        """
        fleet = self.fleet
        used: Set[int] = set()
        for name, agv in fleet.agvs.items():
            used.update((agv.edge, agv.report(0.0).pose.edge, *agv.edges[agv.current:],
                         *fleet.supervisor.robots[name].record.ahead))
            used.update(edge for order in fleet.network.under_way(name) for edge in order.edges)
        return set(map(abs, used))

    def use(self, graph: Graph) -> None:
        """Puts a graph into force. The supervisor then begins as after a restart."""
        for agv in self.fleet.agvs.values():
            agv.graph = graph
        self.fleet.restart(graph)

    def stop_all(self, _: str, __: int) -> None:
        """Lets a person stop the fleet."""
        supervisor = self.fleet.supervisor
        actions = supervisor.stop_fleet(self.fleet.now)
        self.promises.stop()
        self.fleet.do(actions)

    def resume_all(self, _: str, __: int) -> None:
        """Lets a person release the fleet stop."""
        self.promises.stopped = None
        self.fleet.do(self.fleet.supervisor.resume_fleet(self.fleet.now)[1])

    def take_out(self, robot: str, _: int) -> None:
        """Lets a person take a robot out of service."""
        self.promises.blamed.add(robot)
        actions = self.fleet.supervisor.take_out(robot, self.fleet.now)
        self.promises.take_out(robot)
        self.fleet.do(actions)

    def bring_in(self, robot: str, _: int) -> None:
        """Lets a person bring this robot into service, or another robot if this one is in service.
        """
        robots = self.fleet.supervisor.robots
        if robots[robot].works:
            robot = next((name for name in ROBOTS if not robots[name].works), robot)
        problem, actions = self.fleet.supervisor.bring_in(robot, self.fleet.now)
        if not problem:
            self.promises.out.pop(robot, None)
        self.fleet.do(actions)

    def die(self, _: str, number: int) -> None:
        """Lets the supervisor crash at one of its next commits, after 0 to 2 of its actions."""
        self.fleet.crash = Crash(self.fleet.disk.commits + number % 6, number // 6 % 3)

    def restart(self, _: str, __: int) -> None:
        """Lets the supervisor crash and start again now."""
        self.fleet.restart()

    def hang(self, _: str, number: int) -> None:
        """Lets the supervisor hang for 2 s.

        Depending on `number`, a person meanwhile stops the fleet with stop orders that bypass the
        supervisor. Afterwards the supervisor is killed, or it continues.
        """
        fleet, is_stopped, is_killed = self.fleet, number % 4 > 0, number % 4 > 1
        hears = not fleet.network.loss and not fleet.lost and all(
            # Without an epoch in the journal, an old stop cannot be distinguished from a new one.
            fleet.network.hears(name, fleet.now) and robot.master.protocol.epoch
            for name, robot in fleet.supervisor.robots.items())
        fleet.hangs = True
        if is_stopped:
            fleet.network.to_robots += EarlyStop(ROBOTS).stop(
                fleet.now, FleetStop(StopCause.PERSON))
        self.run(2.0)
        fleet.hangs = False
        if is_killed:
            if hears:
                self.promises.stop(is_past=True)
            fleet.restart()
        elif is_stopped:
            self.stop_all('', 0)

    def fill_disk(self, _: str, number: int) -> None:
        """Lets all writes to the disk fail for a while, or until the supervisor is restarted."""
        self.fleet.disk.fails()
        self.later(number, lambda: self.fleet.disk.fails(False))

    # -- the end ----------------------------------------------------------------------------------

    def end(self) -> None:
        """Ends all faults, brings all robots into service, and checks that each mission ends.

        It also checks for each mission that its final state agrees with what happened. For example,
        a mission that SUCCEEDED must have visited all its destinations.
        """
        fleet, limit = self.fleet, self.fleet.now + 100.0
        fleet.disk.fails(False)
        fleet.network.end_faults()
        fleet.clocks.clear()
        for name, agv in fleet.agvs.items():
            fleet.find_link(name)
            agv.pace, agv.refusing, agv.emergency, agv.braking = 1.0, 0, False, 0.0
            agv.off_graph = False
        self._ends.clear()
        fleet.crash = None
        if len(fleet.graph.edges) < len(YARD.edges):
            self.use(YARD)
        fleet.close()
        self.run(2.0 + AGAIN)
        self.resume_all('', 0)
        for mission in fleet.supervisor.book.open[2:]:
            self._say(mission, CommandKind.CANCEL)
        while any(robot.outage is not None for robot in fleet.supervisor.robots.values()):
            assert fleet.now < limit, fleet.picture()
            self.run(1.0)
            self._resume_what_was_stopped_past_it()
            for name, robot in fleet.supervisor.robots.items():
                if robot.outage is not None and robot.outage.needs_person:
                    self.bring_in(name, 0)
        self.run_until(self._all_are_done, 300.0)
        assert not fleet.supervisor.book.open, fleet.picture()
        for request in self.requests:
            self._check_end(request)

    def _resume_what_was_stopped_past_it(self) -> None:
        """Releases a fleet stop, if there is one: a stop that bypassed the supervisor may come
        late.
        """
        if self.fleet.supervisor.is_stopped:
            self.resume_all('', 0)

    def _all_are_done(self) -> bool:
        self._resume_what_was_stopped_past_it()
        for mission in self.fleet.supervisor.book.open:
            if mission.state is MissionState.PAUSED:
                self._say(mission, CommandKind.RESUME)
            elif mission.dwell_until == math.inf:
                self._say(mission, CommandKind.RELEASE)
        return not self.fleet.supervisor.book.open

    def _check_end(self, request: Request) -> None:
        """Checks that the final state of a mission agrees with what happened."""
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
"""The actions of people, by name."""
TROUBLE = _named(
    Chaos.stall, Chaos.slow_down, Chaos.brake_late, Chaos.switch_off, Chaos.refuse,
    Chaos.emergency_stop, Chaos.change_battery, Chaos.leave_graph, Chaos.take_over, Chaos.fail,
    Chaos.drive_by_hand, Chaos.reports_come_late, Chaos.orders_come_late, Chaos.silence,
    Chaos.deafness, Chaos.lose_link, Chaos.set_clock, Chaos.close, Chaos.change_graph, Chaos.die,
    Chaos.restart, Chaos.hang, Chaos.fill_disk)
"""The faults of robots, messages and programs, by name."""
