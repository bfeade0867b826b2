"""Whatever happens to a fleet: nothing collides, nothing accepted is lost, nothing drives twice."""
from __future__ import annotations

import math
import os
from itertools import groupby
from typing import Dict, List, Sequence, Set, Tuple

import pytest
from fleet_builders import AGV, corridor, graph_of
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule
from supervised_fleet import SupervisedFleet

from graph_fleet_manager.fleet import RobotType
from graph_fleet_manager.supervision.actions import SendRoute
from graph_fleet_manager.supervision.missions import Command, MissionState
from graph_fleet_manager.supervision.outbox import AGAIN
from graph_fleet_manager.supervision.settings import RobotSettings
from trajectory_graph import Graph

LONG = os.environ.get('LD90_LONG_TESTS') == '1'
ROBOTS = ('a', 'b', 'c')


def yard() -> Graph:
    """Two rows of vertices joined like a ladder, with a spur at each of the upper ones."""
    places: Dict[int, Tuple[float, float]] = {}
    ends: Dict[int, Tuple[int, int]] = {}
    for k in range(5):
        places[k + 1], places[k + 11], places[k + 21] = (2.0 * k, 0.0), (2.0 * k, 2.0), (2.0 * k,
                                                                                        4.0)
        ends[100 + k], ends[200 + k] = (k + 1, k + 11), (k + 11, k + 21)
        if k:
            ends[k], ends[k + 10] = (k, k + 1), (k + 10, k + 11)
    return graph_of(places, ends)


YARD = yard()
SLOW = RobotType('slow', 0.4, 0.3)
PARKING = (21, 22, 23, 24, 25)
robots = st.sampled_from(ROBOTS)
vertices = st.sampled_from(sorted(YARD.vertices))


def seconds(most: float) -> st.SearchStrategy[float]:
    """A time up to `most`, in tenths of a second."""
    return st.integers(0, round(10 * most)).map(lambda tenths: tenths / 10)


class FleetLife(RuleBasedStateMachine):
    """A fleet to which things happen; room between robots is checked at every step of time."""

    @initialize(loss=st.sampled_from((0.0, 0.05, 0.3)), repeats=st.sampled_from((0.0, 0.2)),
                planning=st.sampled_from((0.05, 0.3, 1.5)), ahead=st.sampled_from((0.0, 3.0, 8.0)),
                moment=st.sampled_from((0.3, 2.0, 6.0)), last=st.sampled_from((AGV, SLOW)),
                seed=st.integers(0, 1000))
    def begin(self, loss: float, repeats: float, planning: float, ahead: float, moment: float,
              last: RobotType, seed: int) -> None:
        """Messages are lost and repeated from now on, and the planner takes its time."""
        self.moment = moment
        self.fleet = SupervisedFleet(
            YARD, {name: (kind, 21 + k) for k, (name, kind) in enumerate(
                zip(ROBOTS, (AGV, AGV, last)))}, seed=seed, loss=loss,
            repeats=repeats, planning=planning, parking=PARKING,
            settings=RobotSettings(release_ahead=ahead))
        self.requests: Dict[int, Tuple[int, ...]] = {}
        self.visited_before: Dict[int, Dict[str, int]] = {}
        self.cancelled: Set[int] = set()
        self.shortened = False
        self.may_fail = False
        self.foreign = 10 ** 8

    @invariant()
    def a_moment_passes(self) -> None:
        """Between two events. Nobody who is left to a person, and stands, is sent on."""
        fleet = self.fleet
        under_way = {order.robot for _, order in fleet._under_way}
        under_way |= {order.robot for order in fleet._to_robots}
        left = {name: fleet.agvs[name].travelled for name, robot in fleet.supervisor.robots.items()
                if robot.outage is not None and robot.outage.needs_person
                and not fleet.agvs[name].is_driving and name not in under_way}
        fleet.run(self.moment)
        for name, travelled in left.items():
            assert fleet.agvs[name].travelled == travelled, fleet.picture()

    # -- missions ---------------------------------------------------------------------------------

    @rule(destinations=st.lists(vertices, min_size=1, max_size=3),
          robot=st.sampled_from(('', '', *ROBOTS)), priority=st.sampled_from((0, 0, 5)),
          dwell=st.sampled_from((None, 0.0, 2.0, -1.0)), twice=st.booleans())
    def request(self, destinations: List[int], robot: str, priority: int, dwell: float,
                twice: bool) -> None:
        id = len(self.requests) + 1
        self.visited_before[id] = {name: len(agv.visited) - 1
                                   for name, agv in self.fleet.agvs.items()}
        dwells = () if dwell is None else (dwell,) * len(destinations)
        for _ in range(1 + twice):
            self.fleet.request(id, *destinations, robot=robot, priority=priority, dwells=dwells)
        if self.fleet.supervisor.book.find(id) is None:  # it died before anything was on the disk
            self.fleet.request(id, *destinations, robot=robot, priority=priority, dwells=dwells)
        self.requests[id] = tuple(destinations)

    @precondition(lambda self: self.requests)
    @rule(data=st.data(), command=st.sampled_from(Command))
    def command(self, data: st.DataObject, command: Command) -> None:
        id = data.draw(st.sampled_from(sorted(self.requests)))
        if command is Command.CANCEL and self.fleet.state(id).is_open:
            self.cancelled.add(id)
        self.shortened |= command in (Command.CANCEL, Command.PAUSE)
        self.fleet.do(self.fleet.supervisor.command(id, command, self.fleet.now))

    @rule(command=st.sampled_from((Command.CANCEL, Command.PAUSE)), orders=seconds(1.0),
          reports=seconds(1.0))
    def command_amid_an_order(self, command: Command, orders: float, reports: float) -> None:
        """A mission is cancelled or paused just as its robot is let go on, and all is late."""
        fleet, until = self.fleet, self.fleet.now + 6.0
        while fleet.now < until and not fleet._to_robots:
            fleet.step()
        for name in {order.robot for order in fleet._to_robots}:
            fleet.orders_late[name], fleet.late[name] = orders, reports
            mission = fleet.supervisor.book.of_robot(name)
            if mission is not None:
                self.shortened = True
                if command is Command.CANCEL:
                    self.cancelled.add(mission.request.id)
                fleet.run(0.1)
                self._say(mission.request.id, command)

    # -- robots -----------------------------------------------------------------------------------

    @rule(robot=robots, pause=seconds(20.0))
    def stall(self, robot: str, pause: float) -> None:
        self.fleet.agvs[robot].stalled = pause

    @rule(robot=robots, pace=st.sampled_from((0.3, 1.0)))
    def slow_down(self, robot: str, pace: float) -> None:
        self.fleet.agvs[robot].pace = pace

    @rule(robot=robots, delay=st.sampled_from((0.0, 0.4, 1.5)))
    def reports_come_late(self, robot: str, delay: float) -> None:
        """When they come sooner again, the new ones overtake the old."""
        self.fleet.late[robot] = delay

    @rule(robot=robots, pause=seconds(15.0))
    def silence(self, robot: str, pause: float) -> None:
        self.fleet.silent[robot] = self.fleet.now + pause

    @rule(robot=robots, pause=seconds(15.0))
    def deafness(self, robot: str, pause: float) -> None:
        """It goes on reporting, and no order reaches it."""
        self.fleet.deaf[robot] = self.fleet.now + pause

    @rule(robot=robots, pause=seconds(15.0))
    def leave_and_join(self, robot: str, pause: float) -> None:
        """It is switched off, and on again without a memory."""
        self.may_fail = True
        self.fleet.agvs[robot].forget()
        self.fleet.silent[robot] = self.fleet.now + pause

    @rule(robot=robots, times=st.integers(1, 4))
    def refuse(self, robot: str, times: int) -> None:
        self.may_fail = True
        self.fleet.agvs[robot].refusing = times

    @rule(robot=robots, pause=seconds(5.0))
    def emergency_stop(self, robot: str, pause: float) -> None:
        self.fleet.agvs[robot].emergency = True
        self.fleet.run(pause)
        self.fleet.agvs[robot].emergency = False

    @rule(robot=robots)
    def take_over(self, robot: str) -> None:
        """Somebody stops a robot; no more than that, for what they drive into is not ours."""
        self.may_fail = True
        self.fleet.agvs[robot].fail('taken over')

    @rule(robot=robots, delay=st.sampled_from((0.0, 0.2, 0.4, 1.5)))
    def orders_come_late(self, robot: str, delay: float) -> None:
        self.fleet.orders_late[robot] = delay

    @rule(robot=robots)
    def lose_link(self, robot: str) -> None:
        """It drives on, and nobody knows where."""
        self.may_fail = True
        self.fleet.lose_link(robot)

    @rule(robot=robots)
    def find_link(self, robot: str) -> None:
        self.fleet.find_link(robot)

    @rule(robot=robots)
    def give_a_foreign_route(self, robot: str) -> None:
        """Somebody else lets it drive to the end of its edge."""
        self.may_fail = True
        self.foreign += 1
        agv = self.fleet.agvs[robot]
        if agv.is_driving and robot not in self.fleet.lost:
            agv.order(self.foreign, (agv.edges[agv.current],))

    @rule(robot=robots, edge=st.sampled_from(sorted(YARD.edges)), share=st.sampled_from((0.0, 0.4)))
    def carry(self, robot: str, edge: int, share: float) -> None:
        """Somebody carries a robot that is left to a person to where there is room, while the
        planner works if it soon does."""
        fleet, agv, until = self.fleet, self.fleet.agvs[robot], self.fleet.now + 2.0
        outage = fleet.supervisor.robots[robot].outage
        if outage is None or not outage.needs_person or robot in fleet.lost:
            return
        while fleet.now < until and not fleet.supervisor.dispatcher.is_planning:
            fleet.step()
        if agv.is_driving or edge not in fleet.graph.edges:
            return
        x, y = YARD.curve(edge).point_at(share * YARD.curve(edge).length)
        for name, other in fleet.supervisor.robots.items():
            if name != robot and (
                    math.dist((x, y), fleet.agvs[name].position) < 1.5
                    or any(YARD.curve(e).project(x, y).distance < 1.5 for e in other.track.held)):
                return
        agv.forget()
        agv.edge, agv.arc = edge, share * YARD.curve(edge).length

    # -- the fleet --------------------------------------------------------------------------------

    @rule(pause=seconds(12.0))
    def time_passes(self, pause: float) -> None:
        self.fleet.run(pause)

    @rule(edges=st.sampled_from(((), (12,), (1, 12), (201,))))
    def close(self, edges: Tuple[int, ...]) -> None:
        self.fleet.close(*edges)

    @rule(edge=st.sampled_from((0, *(e for e in sorted(YARD.edges) if e < 200))))
    def reload(self, edge: int) -> None:
        """A graph without one edge, or with all, comes into force, where that breaks no route."""
        agvs = self.fleet.agvs.values()
        used = {abs(e) for agv in agvs for e in (agv.edge, *agv.edges[agv.current:],
                                                 agv.report(0.0).pose.edge)}
        if edge not in used:
            self._use(Graph(YARD.vertices.values(),
                            [e for e in YARD.edges.values() if e.id != edge]))

    def _use(self, graph: Graph) -> None:
        self.fleet.graph = graph
        for agv in self.fleet.agvs.values():
            agv.graph = graph
        self.fleet._planners.clear()
        self.fleet.restart()

    @rule(pause=seconds(5.0))
    def stop_and_resume(self, pause: float) -> None:
        self.fleet.do(self.fleet.supervisor.stop_fleet(self.fleet.now))
        self.fleet.run(2.0)
        stood = [agv.travelled for agv in self.fleet.agvs.values()]
        heard = not self.fleet.loss and not any(
            until > self.fleet.now - 2.5
            for until in (*self.fleet.silent.values(), *self.fleet.deaf.values()))
        self.fleet.run(pause)
        if heard and self.fleet.supervisor.is_stopped:
            assert stood == [agv.travelled for agv in self.fleet.agvs.values()]
        self.fleet.do(self.fleet.supervisor.resume_fleet(self.fleet.now)[1])

    @rule(pause=seconds(8.0), stops=st.booleans())
    def disk_fails(self, pause: float, stops: bool) -> None:
        """Nothing can be stored for a while, unless the supervisor dies and its disk is mended."""
        fleet, journal, before = self.fleet, self.fleet.journal, len(self.fleet.sent)
        fleet.disk_fails()
        fleet.run(pause)
        if stops:
            self.stop_and_resume(pause)
        if fleet.journal is journal:
            assert all(order.repeated or not order.edges or self.shortened
                       for order in fleet.sent[before:]), fleet.sent[before:]
            fleet.disk_fails(False)
        fleet.run(2.0 + AGAIN)  # until then requests are refused
        assert not fleet.supervisor.trouble

    @rule(robot=robots)
    def take_out(self, robot: str) -> None:
        self.may_fail = True
        self.fleet.do(self.fleet.supervisor.take_out(robot, self.fleet.now))

    @rule(robot=robots)
    def bring_in(self, robot: str) -> None:
        self.fleet.do(self.fleet.supervisor.bring_in(robot, self.fleet.now)[1])

    @rule(commits=st.integers(0, 12))
    def die(self, commits: int) -> None:
        """The supervisor is killed at one of its next commits, before it acts on it."""
        self.fleet.crash_at = self.fleet.commits + self.fleet.journal.commits + commits

    # -- the end ----------------------------------------------------------------------------------

    def teardown(self) -> None:
        """All trouble is over; people have done their part. Now every mission ends, and truly."""
        if not hasattr(self, 'fleet'):
            return
        fleet = self.fleet
        fleet.silent.clear()
        fleet.deaf.clear()
        for name in ROBOTS:
            fleet.find_link(name)
        fleet.late.clear()
        fleet.orders_late.clear()
        fleet.loss, fleet.crash_at = 0.0, None
        self._use(YARD)
        fleet.close()
        for agv in fleet.agvs.values():
            agv.pace, agv.refusing = 1.0, 0
        fleet.do(fleet.supervisor.resume_fleet(fleet.now)[1])
        for _ in range(3):
            fleet.run(8.0)
            for name, robot in fleet.supervisor.robots.items():
                if robot.outage is not None and robot.outage.needs_person:
                    self.bring_in(name)
        fleet.run_until(self._all_are_done, limit=900.0)
        for id, destinations in self.requests.items():
            self._check_end(id, destinations)
        check_orders(fleet.sent, self.shortened)

    def _all_are_done(self) -> bool:
        for mission in self.fleet.supervisor.book.open:
            if mission.state is MissionState.PAUSED:
                self._say(mission.request.id, Command.RESUME)
            elif mission.dwell_until == math.inf:
                self._say(mission.request.id, Command.RELEASE)
        return not self.fleet.supervisor.book.open

    def _say(self, id: int, command: Command) -> None:
        self.fleet.do(self.fleet.supervisor.command(id, command, self.fleet.now))

    def _check_end(self, id: int, destinations: Sequence[int]) -> None:
        """Is the state in which a mission ended true?"""
        mission = self.fleet.supervisor.book.find(id)
        assert mission is not None, f'mission {id} is lost'
        if mission.state is MissionState.SUCCEEDED:
            before = self.visited_before[id][mission.robot]
            visited = iter(self.fleet.agvs[mission.robot].visited[before:])
            assert all(vertex in visited for vertex, _ in groupby(destinations)), (
                mission, self.fleet.picture())
        elif mission.state is MissionState.CANCELLED:
            assert id in self.cancelled
        else:
            assert mission.state is MissionState.FAILED and self.may_fail and mission.reason


def check_orders(sent: Sequence[SendRoute], shortened: bool) -> None:
    """What is released stays released.

    A route id is one robot's; under it a route only gets longer, or shorter where a mission was
    cancelled or paused; only what was sent just before is sent as a repeat.
    """
    owner: Dict[int, str] = {}
    last: Dict[str, SendRoute] = {}
    for order in sent:
        assert owner.setdefault(order.route_id, order.robot) == order.robot
        before = last.get(order.robot)
        if order.repeated:
            assert before is not None
            assert (before.route_id, before.edges) == (order.route_id, order.edges), order
        elif before is not None and before.route_id == order.route_id:
            common = min(len(order.edges), len(before.edges))
            assert order.edges[:common] == before.edges[:common], (before, order)
            assert len(order.edges) >= len(before.edges) or shortened, (before, order)
        last[order.robot] = order


TestFleetLife = FleetLife.TestCase
TestFleetLife.settings = settings(max_examples=300 if LONG else settings.default.max_examples // 4,
                                  stateful_step_count=25, derandomize=not LONG, deadline=None,
                                  suppress_health_check=list(HealthCheck))


def swap(crash_at: int) -> SupervisedFleet:
    """Two robots swap their places in a corridor while the supervisor dies at one commit."""
    fleet = SupervisedFleet(corridor(5, siding_at=3), {'a': (AGV, 1), 'b': (AGV, 5)},
                            settings=RobotSettings(release_ahead=3.0))
    fleet.crash_at = crash_at
    for id, (vertex, robot) in enumerate(((5, 'a'), (1, 'b')), 1):
        fleet.request(id, vertex, robot=robot)
        if fleet.supervisor.book.find(id) is None:
            fleet.request(id, vertex, robot=robot)
    fleet.run_until_done(1, 2)
    assert [fleet.state(id) for id in (1, 2)] == [MissionState.SUCCEEDED] * 2
    check_orders(fleet.sent, shortened=False)
    return fleet


def test_the_supervisor_may_die_at_every_single_commit() -> None:
    whole = swap(crash_at=10 ** 6)
    for commit in range(1, whole.journal.commits + 1, 1 if LONG else 3):
        fleet = swap(commit)
        for name, agv in fleet.agvs.items():
            assert agv.visited[-1] == whole.agvs[name].visited[-1], f'death at commit {commit}'
            assert agv.travelled == pytest.approx(whole.agvs[name].travelled), (
                f'death at commit {commit}: {name} drove other ways')
