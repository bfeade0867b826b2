"""The planner as a service: its answer depends only on the request, and arrives in time.

The searches look at the clock. The time for the work after the searches grows no faster than the
plan. The tests measure CPU time, with a generous factor, because machines can be busy.
"""
from __future__ import annotations

import time
from random import Random

import pytest
from fleet_builders import AGV, corridor, graph_of, ladder

from fleet_core.fleet import Fleet, RobotType
from fleet_core.geometry.areas import Area
from fleet_core.geometry.site_geometry import Alone
from fleet_core.planning import planner as planner_module
from fleet_core.planning.layers import layered
from fleet_core.planning.plan_requests import PlanRequest
from fleet_core.planning.plan_service import PlanService
from fleet_core.planning.planner import FleetPlanner
from fleet_core.planning.road_network import RoadNetwork
from fleet_core.planning.safe_intervals import find_path
from fleet_core.planning.tasks import CannotPlan, Obstacle, Task
from fleet_core.planning.tea_star import TeaStar

TRUCK = RobotType('truck', 0.6, 1.0)


def square():
    """Vertices 1 to 4 on a square of 4 m; edge 1 joins 1 and 2, edges 2 to 4 lead round the square.
    """
    return graph_of({1: (0, 0), 2: (4, 0), 3: (4, 4), 4: (0, 4)},
                    {1: (1, 2), 2: (1, 4), 3: (4, 3), 4: (3, 2)})


def service(graph):
    return PlanService(graph, Fleet((AGV, TRUCK), (), 0.1))


def edges(outcome, robot):
    return [drive.edge for drive in outcome.drives[robot]]


def test_a_closed_edge_is_driven_round_and_open_again_used():
    planner = service(square())
    task = Task('r', AGV, 1, destinations=(2,), stays=True)
    paths = [edges(planner.answer(PlanRequest((task,), closed=frozenset(closed))), 'r')
             for closed in ((), (1,), ())]
    assert paths == [[1], [2, 3, 4], [1]]


def test_learned_times_replace_those_of_the_graph():
    planner = service(square())
    request = PlanRequest((Task('r', AGV, 1, destinations=(2,), stays=True),),
                          edge_times={('agv', 1): 20.0})
    assert edges(planner.answer(request), 'r') == [2, 3, 4]
    slow_truck = PlanRequest(request.tasks, edge_times={('truck', 1): 20.0})
    assert edges(planner.answer(slow_truck), 'r') == [1], 'the times of another type must not count'


def test_places_for_one_robot_because_of_a_resource_are_used_one_after_the_other():
    apart = graph_of({1: (0, 0), 2: (4, 0), 3: (0, 20), 4: (4, 20)}, {1: (1, 2), 2: (3, 4)})
    planner = service(apart)
    tasks = (Task('a', AGV, 1, destinations=(2,), stays=True),
             Task('b', AGV, 3, destinations=(4,), stays=True))
    hall = Alone(frozenset((1, 2)))
    orders = [planner.answer(PlanRequest(tasks, alone=alone)).precedence
              for alone in ((), (hall,), ())]
    assert [len(order) for order in orders] == [0, 1, 0]
    with pytest.raises(CannotPlan, match='A resource: the graph has no edge 9'):
        planner.answer(PlanRequest(tasks, alone=(Alone(frozenset((9,))),)))


def test_no_robot_is_parked_at_a_reserved_vertex():
    request = PlanRequest((Task('r', AGV, 1),), parking=frozenset({1, 2}), reserved=frozenset({1}))
    assert edges(service(square()).answer(request), 'r') == [1]


def test_reserved_vertices_are_used_if_there_is_no_other_parking():
    request = PlanRequest((Task('r', AGV, 1),), parking=frozenset({1}), reserved=frozenset({1}))
    assert edges(service(square()).answer(request), 'r') == []


def test_robots_are_parked_where_the_request_says():
    planner = service(square())
    task = Task('r', AGV, 1, destinations=(2,))
    ends = []
    for parking in ((3,), (1,)):
        last = planner.answer(PlanRequest((task,), parking=frozenset(parking))).drives['r'][-1]
        ends.append(planner.graph.end_vertex(last.edge).id)
    assert ends == [3, 1]


def test_an_obstacle_is_passed_by_and_named_where_it_cannot_be():
    planner = service(square())
    task = Task('r', AGV, 1, destinations=(3,), stays=True)
    out = Obstacle('dead', TRUCK, vertices=(2,))
    assert edges(planner.answer(PlanRequest((task,), (out,))), 'r') == [2, 3]
    both = PlanRequest((task,), (Obstacle('dead', TRUCK, vertices=(2,), edges=(3,)),))
    assert 'dead, which cannot move' in planner.answer(both).unserved['r']


def test_an_obstacle_blocks_what_is_near_its_areas():
    planner = service(square())
    task = Task('r', AGV, 1, destinations=(3,), stays=True)
    beside = Obstacle('dead', TRUCK, areas=(Area(((4.0, -0.5), (4.5, -0.5)), 0.1),))
    far = Obstacle('dead', TRUCK, areas=(Area(((9.0, -5.0),), 0.1),))
    assert edges(planner.answer(PlanRequest((task,), (beside,))), 'r') == [2, 3]
    near_by = Task('r', AGV, 1, destinations=(2,), stays=True)
    assert edges(planner.answer(PlanRequest((near_by,), (far,))), 'r') == [1]
    assert 'dead' in planner.answer(PlanRequest((near_by,), (beside,))).unserved['r']


def test_the_answer_does_not_depend_on_what_was_asked_before():
    request = PlanRequest((Task('a', AGV, 1, destinations=(5,), stays=True),
                           Task('b', AGV, 5, destinations=(1,), stays=True)), closed=frozenset())
    fresh = service(corridor(5, siding_at=3)).answer(request)
    used = service(corridor(5, siding_at=3))
    for closed in range(1, 5):
        used.answer(PlanRequest(request.tasks[:1], closed=frozenset((closed,))))
    assert used.answer(request) == fresh
    assert not fresh.unserved, 'they must swap places through the siding'


@pytest.mark.parametrize('seed, used', [(0, 5), (7, 7)])
def test_the_seed_is_that_of_the_request_and_without_one_the_services_own(
        monkeypatch, seed, used):
    seeds = []
    monkeypatch.setattr(planner_module, 'Random', lambda seed: seeds.append(seed) or Random(seed))
    planner = PlanService(square(), Fleet((AGV,), (), 0.1), seed=5)
    planner.answer(PlanRequest((Task('r', AGV, 1, destinations=(3,), stays=True),), seed=seed))
    assert seeds == [used]


def test_robots_are_planned_in_another_order_with_another_seed(monkeypatch):
    orders = []
    plan = TeaStar.plan
    monkeypatch.setattr(TeaStar, 'plan', lambda self, agents, *limits: (
        orders.append([agent.name for agent in agents]) or plan(self, agents, *limits)))
    planner = service(square())
    for seed in (0, 0, *range(1, 9)):
        planner.answer(PlanRequest(tuple(Task(f'r{k}', AGV, k, destinations=(k % 4 + 1,))
                                         for k in range(1, 4)), seed=seed))
    assert orders[0] == orders[1]
    assert len(set(map(tuple, orders))) > 3


def test_time_is_only_spent_on_improvement_that_is_asked_for():
    planner = service(corridor(7, siding_at=4))
    swap = (Task('a', AGV, 1, destinations=(7,), stays=True),
            Task('b', AGV, 7, destinations=(1,), stays=True))
    assert planner.answer(PlanRequest(swap)).rounds == 0
    assert planner.answer(PlanRequest(swap, improvement=0.2)).rounds > 0


@pytest.mark.parametrize('request_, words', [
    (PlanRequest((Task('r', AGV, 1), Task('r', AGV, 2))), 'Robot r stands in the request twice'),
    (PlanRequest((Task('r', AGV, 1),), (Obstacle('r', AGV, (2,)),)), 'twice'),
    (PlanRequest((Task('r', RobotType('boat', 1.0, 1.0), 1),)), 'no robot type boat'),
    (PlanRequest((Task('r', AGV, 99),)), 'no vertex 99'),
    (PlanRequest((), (Obstacle('r', AGV, (99,)),)), 'no vertex 99'),
    (PlanRequest((), (Obstacle('r', AGV, (), (-99,)),)), 'no edge -99'),
    (PlanRequest((), parking=frozenset((99,))), 'no vertex 99'),
    (PlanRequest((), edge_times={('agv', 1): float('nan')}), 'learned time of agv on edge 1'),
])
def test_what_makes_no_sense_is_refused_in_a_sentence(request_, words):
    with pytest.raises(CannotPlan) as refused:
        service(square()).answer(request_)
    assert words in str(refused.value)


def test_closed_edges_that_the_graph_does_not_have_change_nothing():
    planner = service(square())
    task = Task('r', AGV, 1, destinations=(2,), stays=True)
    assert edges(planner.answer(PlanRequest((task,), closed=frozenset((99,)))), 'r') == [1]


# -- the time limit of a request is respected ------------------------------------------------------

def rows(count, length=20):
    """Returns a row of vertices for each robot. The rows are joined at their far ends.

    Row r (from 0) has the vertices 100 r + 1 to 100 r + length.
    """
    places = {100 * row + k: (2.0 * k, 10.0 * row)
              for row in range(count) for k in range(1, length + 1)}
    ends = {100 * row + k: (100 * row + k, 100 * row + k + 1)
            for row in range(count) for k in range(1, length)}
    joints = {100 * row + length: (100 * row + length, 100 * (row + 1) + length)
              for row in range(count - 1)}
    return graph_of(places, {**ends, **joints})


def timed(service, request):
    begun = time.process_time()
    outcome = service.answer(request)
    return outcome, time.process_time() - begun


@pytest.mark.parametrize('search', [find_path, layered(1.0)], ids=['safe_intervals', 'layers'])
@pytest.mark.parametrize('owned', [False, True], ids=['anew', 'with plans'])
def test_robots_with_hundreds_of_destinations_are_answered_in_time(search, owned):
    random, graph = Random(1), ladder(40)
    service = PlanService(graph, Fleet((AGV,), (), 0.1), search)
    service.prepare()
    vertices = sorted(graph.vertices)
    tasks = tuple(Task(f'r{k}', AGV, vertex, destinations=tuple(random.choices(vertices, k=400)),
                       kept=() if owned else None)
                  for k, vertex in enumerate(random.sample(vertices, 6)))
    parking = service.parking_by_name()
    outcome, seconds = timed(service, PlanRequest(tasks, parking=parking, time_limit=0.3))
    assert seconds < 1.0
    assert outcome.unserved, 'otherwise the test measures nothing'
    assert set(outcome.drives) == {task.name for task in tasks}
    assert all(outcome.unserved.values())


def test_the_time_for_an_answer_grows_with_its_drives_and_not_with_their_square():
    def drives_and_seconds(count):
        random, service = Random(1), PlanService(rows(6, 40), Fleet((AGV,), (), 0.1))
        service.prepare()
        tasks = tuple(Task(f'r{k}', AGV, 100 * k + 1, stays=True, destinations=tuple(
            100 * k + random.randint(1, 39) for _ in range(count))) for k in range(6))
        outcome, seconds = timed(service, PlanRequest(tasks, time_limit=60.0))
        assert outcome.unserved == {}
        return sum(map(len, outcome.drives.values())), seconds
    few, seconds_of_few = drives_and_seconds(250)
    many, seconds_of_many = drives_and_seconds(1000)
    assert many > 70000
    growth = (seconds_of_many / seconds_of_few) / (many / few)
    assert growth < 2.0, f'{growth:.1f} times as much time for each drive'  # the square gives 4


@pytest.fixture
def plan_until(monkeypatch):
    """Returns a function that plans for robots, each in its own row of vertices.

    The time limit passes during search number `last`, so this search finds nothing.
    """
    def plan(count, last, *tasks):
        late, planned, now = [0.0], [], time.monotonic

        def search(errand, *others):
            planned.append(errand.vertex)
            if len(planned) == last:
                late[0] = 1000.0
                return None
            return find_path(errand, *others)
        planner = FleetPlanner(RoadNetwork(rows(count)), 0.1, [AGV], search=search)
        monkeypatch.setattr(time, 'monotonic', lambda: now() + late[0])
        return planner.plan(tasks, deadline=now() + 100.0, rounds=0)
    return plan


def test_robots_that_have_a_path_when_time_is_over_keep_it(plan_until):
    outcome = plan_until(3, 3, *(
        Task(f'r{k}', AGV, 100 * k + 1, destinations=(100 * k + 5,), stays=True)
        for k in range(3)))
    assert outcome.unserved == {'r2': 'no path to vertex 205 was found in the given time'}
    assert [len(outcome.drives[name]) for name in ('r0', 'r1', 'r2')] == [4, 4, 0]


def test_a_path_that_leads_past_a_robot_without_one_is_not_kept(plan_until):
    outcome = plan_until(1, 2, Task('a', AGV, 1, destinations=(8,), stays=True),
                         Task('b', AGV, 5, destinations=(18,), stays=True))
    assert set(outcome.unserved) == {'a', 'b'}
    assert [len(outcome.drives[name]) for name in 'ab'] == [0, 0]
