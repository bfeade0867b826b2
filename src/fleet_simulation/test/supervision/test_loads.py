"""Grants to robots with loads that need more room, a lower speed or other edges."""
from __future__ import annotations

from dataclasses import replace
from typing import Mapping, Set, Tuple

import pytest

from fleet_core.fleet import RobotType
from fleet_core.interlocking import interlocking
from fleet_core.interlocking.interlocking import Gate, Interlocking
from fleet_core.planning.road_network import RoadNetwork
from fleet_core.supervision import questions
from fleet_core.supervision.laden_types import LadenTypes
from fleet_core.supervision.load_room import LoadRoom
from fleet_core.supervision.missions import MissionState, Request
from fleet_core.supervision.plan_executor import PlanExecutor
from fleet_core.work.loads import LoadType
from fleet_core.work.site_work import SiteWork
from fleet_core.work.stops import LoadEffect, WorkStep, WorkStop, dwells_of
from fleet_core.work.tables import LoadState
from fleet_core.work.work import RobotLoad
from fleet_simulation.agv.steps import SimulatedSteps
from trajectory_graph import Edge, Graph, Vertex
from world.supervised_fleet import SupervisedFleet

AGV = RobotType('agv', 0.4, 1.0)
PALLET = LoadType('pallet', 1.3, 0.5)
TAKE = WorkStep('take', 60.0, load=LoadEffect.TAKES, load_type='pallet')
GIVE = WorkStep('give', 60.0, load=LoadEffect.GIVES)

# Two lanes, 1.5 m apart, joined by an edge at both ends, with more room at the right end:
#   11 -- 12 -- 13 -- 14 -- 15
#    |                 |
#    1 --- 2 --- 3 --- 4
PLACES = {**{k: (3.0 * k, 0.0) for k in (1, 2, 3, 4)},
          **{10 + k: (3.0 * k, 1.5) for k in (1, 2, 3, 4, 5)}}
ENDS = {1: (1, 2), 2: (2, 3), 3: (3, 4), 11: (11, 12), 12: (12, 13), 13: (13, 14), 14: (14, 15),
        21: (1, 11), 24: (4, 14)}
LANES = Graph([Vertex(id, *place, 0.0) for id, place in PLACES.items()],
              [Edge(id, *ends, velocity_forward=1.0, velocity_backwards=1.0)
               for id, ends in ENDS.items()])


class LoadedFleet(SupervisedFleet):
    """A fleet that carries pallets. The virtual world checks the free space around the pallets."""

    def __init__(self, robots: Mapping[str, int], pallet: LoadType = PALLET,
                 graph: Graph = LANES, **more: object) -> None:
        super().__init__(graph, {name: (AGV, vertex) for name, vertex in robots.items()},
                         work=SiteWork(loads={'pallet': pallet}), **more)
        self.steps = {name: SimulatedSteps(lambda: 1) for name in robots}
        self._radius = pallet.radius

    def step(self) -> None:
        super().step()
        self.loads = {name: self._radius for name, steps in self.steps.items()
                      if self._radius and steps.done.count('take') > steps.done.count('give')}

    def send(self, id: int, *stops: WorkStop, **more: object) -> None:
        self.do(self.supervisor.request(Request(
            id, tuple(stop.place for stop in stops), dwells=dwells_of(stops), stops=stops,
            **more), self.now))

    def load(self, name: str = 'a') -> LoadState:
        return self.supervisor.desk.load(name).state

    def kind(self, name: str = 'a') -> RobotType:
        return self.supervisor.robots[name].type

    def told_speeds(self, name: str = 'a') -> Set[float]:
        """Returns the speeds in the routes that were sent to the robot since the last call."""
        sent, self.sent = self.sent, []
        return {one.speed for one in sent if one.robot == name and one.edges}


def carry(at: int, to: int) -> Tuple[WorkStop, WorkStop]:
    return WorkStop(at, steps=(TAKE,)), WorkStop(to, steps=(GIVE,))


def test_a_robot_counts_with_its_load_until_it_has_given_it():
    fleet = LoadedFleet({'a': 1})
    fleet.send(1, *carry(2, 4))
    fleet.run(0.5)
    assert (fleet.kind().radius, fleet.kind().speed) == (1.3, 1.0), 'it makes room in time'
    fleet.run_until(lambda: fleet.load() is LoadState.LOADED)
    assert (fleet.kind().radius, fleet.kind().speed) == (1.3, 0.5)
    assert fleet.told_speeds() == {0.0}
    fleet.run_until_done(1)
    fleet.run(0.2)
    assert fleet.kind() == AGV
    assert fleet.told_speeds() == {0.5}


def test_robots_pass_each_other_empty_but_not_beside_a_load():
    fleet = LoadedFleet({'a': 1, 'b': 15})
    fleet.send(1, *carry(2, 4), robot='a')
    for id, place in ((2, 14), (3, 11), (4, 15)):
        fleet.request(id, place, robot='b')
    fleet.run_until_done(1, 2, 3, 4, limit=80.0)
    assert fleet.nearest > -1e-6


def test_the_planner_keeps_no_plan_of_a_robot_that_has_become_another_one():
    fleet = LoadedFleet({'a': 1, 'b': 15})
    fleet.send(1, *carry(2, 4), robot='a')
    fleet.run_until(lambda: fleet.load() is LoadState.LOADED)
    supervisor = fleet.supervisor
    plan = supervisor.plan_executor.plan
    supervisor.robots['a'].become(AGV)
    asked = questions.question_of(supervisor._world(), plan, 0, fleet.now)
    assert [task.kept is None for task in asked.tasks] == [True, False]


def test_an_idle_robot_beside_the_place_of_a_load_is_sent_away_first():
    fleet = LoadedFleet({'a': 2, 'b': 12})
    fleet.send(1, *carry(2, 4), robot='a')
    fleet.run(0.3)
    assert fleet.load() is LoadState.EMPTY and fleet.steps['a'].running == ()
    fleet.run_until_done(1, limit=100.0)
    assert len(fleet.agvs['b'].visited) > 1


def test_a_load_is_not_taken_while_a_robot_that_cannot_leave_is_too_near():
    fleet = LoadedFleet({'a': 2, 'b': 12})
    fleet.run(0.5)
    fleet.do(fleet.supervisor.take_out('b', fleet.now))
    fleet.send(1, *carry(2, 4), robot='a')
    fleet.run(30.0)
    assert fleet.load() is LoadState.EMPTY and not fleet.steps['a'].done
    assert 'too near for the load' in fleet.supervisor.book.find(1).reason


def test_a_robot_is_not_sent_onto_an_edge_that_is_closed_to_its_load():
    fleet = LoadedFleet({'a': 1}, LoadType('pallet', closed=frozenset({3})))
    fleet.send(1, *carry(3, 4))
    fleet.run_until_done(1, limit=100.0)
    assert fleet.agvs['a'].visited == [1, 2, 3, 2, 1, 11, 12, 13, 14, 4]


def test_the_interlocking_refuses_an_edge_that_is_closed_to_a_load():
    fleet = LoadedFleet({'a': 1}, LoadType('pallet', closed=frozenset({3})))
    fleet.send(1, WorkStop(3, steps=(TAKE, WorkStep('wait', 300.0, (('seconds', '200'),)))))
    fleet.run_until(lambda: fleet.load() is LoadState.LOADED)
    fleet.supervisor.interlocking.at_work = frozenset()
    given = fleet.supervisor.interlocking.grant(fleet.supervisor.robots['a'], [3])
    assert given.edges == ()
    assert given.refusal.gate is Gate.CLOSED_TO_LOAD


def test_a_robot_drives_slower_by_plan_with_a_load_that_allows_no_more():
    def seconds(pallet: LoadType) -> float:
        fleet = LoadedFleet({'a': 1}, pallet)
        fleet.send(1, *carry(1, 4))
        fleet.run_until(lambda: fleet.load() is LoadState.LOADED)
        fleet.run(1.0)
        plan = fleet.supervisor.plan_executor.plan.plans['a']
        return plan.drives[-1].end - plan.drives[0].start
    assert seconds(LoadType('pallet', speed=0.25)) > 3.0 * seconds(LoadType('pallet', speed=1.0))


def test_a_load_is_what_it_was_after_a_restart():
    fleet = LoadedFleet({'a': 1})
    fleet.send(1, *carry(2, 4))
    fleet.run_until(lambda: fleet.load() is LoadState.LOADED)
    before = fleet.kind()
    fleet.restart()
    assert fleet.kind() == before and before.radius == 1.3
    fleet.run_until_done(1)


def test_a_load_of_which_a_person_says_so_counts_at_once_and_stops_whoever_is_too_near():
    fleet = LoadedFleet({'a': 2, 'b': 12})
    fleet.send(1, WorkStop(4, steps=(WorkStep('wait', 300.0),)), WorkStop(2, steps=(TAKE,)),
               WorkStop(1, steps=(GIVE,)), robot='a', )
    fleet.run(0.1)
    problem, actions = fleet.supervisor.set_load('a', 1, fleet.now)
    fleet.do(actions)
    assert not problem and fleet.kind().radius == 1.3
    assert fleet.supervisor.interlocking.excluding('a') == ('b',)
    assert fleet.supervisor.desk.load('a').types == ('pallet',)


def test_a_robot_that_gives_what_it_does_not_carry_needs_no_room_for_it():
    fleet = LoadedFleet({'a': 2, 'b': 12})
    fleet.send(1, WorkStop(2, steps=(GIVE,)), robot='a')
    fleet.run_until(lambda: fleet.load() is LoadState.UNKNOWN)
    assert fleet.kind() == AGV
    fleet.run_until_done(1)


def test_a_step_that_takes_a_load_names_its_type_and_one_that_the_site_has():
    fleet = LoadedFleet({'a': 1})
    for id, kind in ((1, ''), (2, 'crate')):
        fleet.send(id, WorkStop(2, steps=(replace(TAKE, load_type=kind),)))
        assert fleet.statuses[-1].state is MissionState.REFUSED
        assert fleet.statuses[-1].reason.endswith('the loads of the work file are: pallet')


# -- types of robots with loads --------------------------------------------------------------------


def test_a_load_that_may_be_of_several_types_is_the_strictest_of_all():
    box = LoadType('box', 0.5, 0.8, frozenset({7}))
    laden = LadenTypes({'pallet': PALLET, 'box': box}, [AGV])
    for some in ({'pallet', 'box'}, {''}, {'a type that the file has lost'}):
        kind = laden.laden(AGV, some)
        assert (kind.radius, kind.speed, kind.closed) == (1.3, 0.5, {7})
        assert (kind.model, kind.fastest) == ('agv', 1.0)
    assert laden.laden(AGV, {'box'}).radius == 0.5
    assert laden.ready(AGV, {'box'}).closed == frozenset()


def test_a_site_without_types_of_load_has_no_types_of_robots_with_loads():
    laden = LadenTypes({}, [AGV])
    assert not laden and laden.types == () and laden.laden(AGV, {'pallet'}) is AGV


# -- planted ---------------------------------------------------------------------------------------


def _without(name: str) -> Tuple[interlocking.Condition, ...]:
    return tuple(one for one in interlocking.CONDITIONS if one.__name__ != name)


@pytest.mark.parametrize('owner, name, instead, found_by', [
    (LoadRoom, 'lacks_room', lambda *_: False,
     test_a_load_is_not_taken_while_a_robot_that_cannot_leave_is_too_near),
    (Interlocking, 'without_room', lambda *_: '',
     test_a_load_is_not_taken_while_a_robot_that_cannot_leave_is_too_near),
    (RobotLoad, 'may_be', property(lambda self: frozenset()),
     test_robots_pass_each_other_empty_but_not_beside_a_load),
    (interlocking, 'CONDITIONS', _without('_edge_is_open_to_load'),
     test_the_interlocking_refuses_an_edge_that_is_closed_to_a_load),
    (RoadNetwork, 'closed_to', lambda self, kind: self.closed,
     test_a_robot_is_not_sent_onto_an_edge_that_is_closed_to_its_load),
    (questions, '_plan_of', lambda robot, plan: plan and plan.plan_of(robot.name),
     test_the_planner_keeps_no_plan_of_a_robot_that_has_become_another_one),
    (PlanExecutor, 'make_room', lambda *_: None,
     test_an_idle_robot_beside_the_place_of_a_load_is_sent_away_first)])
def test_a_guard_that_is_left_out_is_found(monkeypatch, owner, name, instead, found_by):
    monkeypatch.setattr(owner, name, instead)
    with pytest.raises(AssertionError):
        found_by()
