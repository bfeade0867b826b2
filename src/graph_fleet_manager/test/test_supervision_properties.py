"""Whatever happens to a fleet: nothing collides, nothing accepted is lost, nothing drives twice."""
from __future__ import annotations

import os
from random import Random
from typing import Dict, List, Sequence, Tuple

import pytest
from fleet_builders import AGV, graph_of
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from supervised_fleet import SupervisedFleet

from graph_fleet_manager.supervision.actions import SendRoute
from graph_fleet_manager.supervision.missions import Command, MissionState
from trajectory_graph import Graph

LONG = os.environ.get('LD90_LONG_TESTS') == '1'
ROBOTS = ('a', 'b', 'c')
FOUND = (23, 35, 58, 660, 764, 821, 1049, 1541)
"""Lives that ended badly while this was written."""


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


PARKING = (21, 22, 23, 24, 25)


class Life:
    """A fleet to which random things happen."""

    def __init__(self, seed: int) -> None:
        self.random = Random(seed)
        self.fleet = SupervisedFleet(
            yard(), {name: (AGV, 21 + k) for k, name in enumerate(ROBOTS)}, seed=seed,
            loss=self.random.choice((0.0, 0.05, 0.3)), repeats=self.random.choice((0.0, 0.2)),
            planning=self.random.choice((0.05, 0.3, 1.5)), parking=PARKING)
        self.ids: List[int] = []
        self.events: List[str] = []

    def happen(self) -> None:
        """Something happens."""
        what = self.random.choice((
            self.request, self.request, self.request, self.command, self.stall, self.silence,
            self.restart, self.stop_and_resume, self.out_and_in, self.emergency, self.close,
            self.take_over))
        self.events.append(f'{self.fleet.now:.1f} {what.__name__}')
        what()

    def request(self) -> None:
        id = len(self.ids) + 1
        count = self.random.randint(1, 3)
        vertices = [self.random.choice(list(self.fleet.graph.vertices)) for _ in range(count)]
        self.fleet.request(id, *vertices, robot=self.random.choice(('', '', *ROBOTS)),
                           priority=self.random.choice((0, 0, 5)),
                           dwells=self.random.choice(((), (0.0,) * count, (2.0,) * count)))
        self.ids.append(id)

    def command(self) -> None:
        if self.ids:
            command = self.random.choice((Command.CANCEL, Command.PAUSE, Command.RESUME))
            self.fleet.do(self.fleet.supervisor.command(self.random.choice(self.ids), command,
                                                        self.fleet.now))

    def _somebody(self) -> str:
        return self.random.choice(ROBOTS)

    def stall(self) -> None:
        self.fleet.agvs[self._somebody()].stalled = self.random.uniform(0.0, 20.0)

    def silence(self) -> None:
        self.fleet.silent[self._somebody()] = self.fleet.now + self.random.uniform(0.0, 15.0)

    def restart(self) -> None:
        self.fleet.restart()

    def stop_and_resume(self) -> None:
        supervisor, fleet = self.fleet.supervisor, self.fleet
        fleet.do(supervisor.stop_fleet(fleet.now))
        fleet.run(self.random.uniform(0.0, 5.0))
        fleet.do(supervisor.resume_fleet(fleet.now)[1])

    def out_and_in(self) -> None:
        name = self._somebody()
        self.fleet.do(self.fleet.supervisor.take_out(name, self.fleet.now))
        self.fleet.run(self.random.uniform(0.0, 8.0))
        self.bring_in(name)

    def bring_in(self, name: str) -> None:
        self.fleet.do(self.fleet.supervisor.bring_in(name, self.fleet.now)[1])

    def emergency(self) -> None:
        agv = self.fleet.agvs[self._somebody()]
        agv.emergency = True
        self.fleet.run(self.random.uniform(0.0, 5.0))
        agv.emergency = False

    def take_over(self) -> None:
        """Somebody stops a robot; no more than that, for what they drive into is not ours."""
        self.fleet.agvs[self._somebody()].fail('taken over')

    def close(self) -> None:
        edges = self.random.choice(((), (12,), (1, 12), (201,)))
        self.fleet.do(self.fleet.supervisor.close_edges(edges, self.fleet.now))

    def calm_down(self) -> None:
        """Everything that kept robots from working is over; people have done their part."""
        fleet = self.fleet
        fleet.silent.clear()
        fleet.loss = 0.0
        fleet.do(fleet.supervisor.close_edges((), fleet.now))
        for id in self.ids:
            mission = fleet.supervisor.book.find(id)
            if mission.state is MissionState.PAUSED:
                fleet.do(fleet.supervisor.command(id, Command.RESUME, fleet.now))
        fleet.run(8.0)
        for name in ROBOTS:
            robot = fleet.supervisor.robots[name]
            if robot.outage is not None and robot.outage.needs_person:
                self.bring_in(name)
        fleet.run(2.5)


@settings(max_examples=300 if LONG else 25, deadline=None,
          suppress_health_check=list(HealthCheck))
@given(st.integers(0, 10 ** 6))
def test_whatever_happens_nothing_collides_and_every_mission_ends(seed: int) -> None:
    live(seed)


@pytest.mark.parametrize('seed', FOUND)
def test_what_went_wrong_once_does_not_again(seed: int) -> None:
    live(seed)


def live(seed: int) -> None:
    """One life; room between robots is checked at every step."""
    life = Life(seed)
    try:
        for _ in range(life.random.randint(3, 25)):
            life.happen()
            life.fleet.run(life.random.uniform(0.0, 12.0))
        life.calm_down()
        life.fleet.run_until_done(*life.ids, limit=900.0)
        for id in life.ids:
            assert not life.fleet.state(id).is_open
        check_orders(life.fleet.sent)
    except AssertionError as error:
        raise AssertionError(f'seed {seed}: {life.events}\n{error}') from error


def check_orders(sent: Sequence[SendRoute]) -> None:
    """A route id is one robot's; under it, only what was sent just before is sent as a repeat."""
    owner: Dict[int, str] = {}
    last: Dict[str, Tuple[int, Tuple[int, ...]]] = {}
    for order in sent:
        assert owner.setdefault(order.route_id, order.robot) == order.robot
        if order.repeated:
            assert last[order.robot] == (order.route_id, order.edges), order
        last[order.robot] = order.route_id, order.edges
