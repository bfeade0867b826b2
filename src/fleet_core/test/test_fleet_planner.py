"""The planner as a fleet manager uses it: released drives, kept plans, obstacles, closed edges.

A robot between two vertices blocks the point where it is, not its whole edge. It is planned like
all other robots, even if its edge was closed after the robot had entered it.
"""
from __future__ import annotations

import time
from pathlib import Path
from random import Random

import pytest
from fleet_builders import AGV, corridor, graph_of, ladder

from fleet_core.fleet import RobotType
from fleet_core.geometry.areas import Area
from fleet_core.geometry.site_geometry import Alone, SiteGeometry
from fleet_core.planning.lacam import search_lacam
from fleet_core.planning.parking import WellFormedSets
from fleet_core.planning.planner import FleetPlanner
from fleet_core.planning.plans import Drive
from fleet_core.planning.precedence import Conflicting, precedence
from fleet_core.planning.problem import Problem
from fleet_core.planning.reservation_table import ReservationTable
from fleet_core.planning.road_network import RoadNetwork
from fleet_core.planning.safe_intervals import find_path
from fleet_core.planning.tasks import CannotPlan, Obstacle, PlannedDrive, Task
from trajectory_graph import load_graph


def _planner(graph, parking=(), closed=(), kinds=(AGV,)):
    return FleetPlanner(RoadNetwork(graph, closed), 0.1, kinds, parking or tuple(graph.vertices))


def _plan(planner, *tasks, obstacles=(), rounds=0, seconds=1.0):
    return planner.plan(tasks, obstacles, time.monotonic() + seconds, rounds)


def _edges(outcome, name):
    return [drive.edge for drive in outcome.drives[name]]


def test_a_robot_goes_on_from_what_was_released_to_it():
    task = Task('a', AGV, 1, released=(1, 2), begun=0.5, destinations=(5,), stays=True)
    outcome = _plan(_planner(corridor(5)), task)
    assert outcome.drives['a'] == (PlannedDrive(1, 0.0, 1.0), PlannedDrive(2, 1.0, 3.0),
                                   PlannedDrive(3, 3.0, 5.0), PlannedDrive(4, 5.0, 7.0))


@pytest.mark.parametrize('rounds', [0, 2])
def test_no_robot_passes_ahead_of_a_slow_robot_whose_drive_is_released(rounds):
    """A released drive stays released: another robot waits for it, even if there is time to pass.
    """
    crossing = graph_of({1: (0.0, 0.0), 2: (2.0, 0.0), 3: (4.0, 0.0), 4: (6.0, 0.0), 5: (8.0, 0.0),
                         6: (6.0, 2.0), 7: (6.0, -2.0)},
                        {1: (1, 2), 2: (2, 3), 3: (3, 4), 4: (4, 5), 5: (6, 4), 6: (4, 7)})
    slow = RobotType('slow', 0.4, 0.2)
    outcome = _plan(_planner(crossing, kinds=(AGV, slow)),
                    Task('a', slow, 1, released=(1, 2, 3, 4), destinations=(5,), stays=True),
                    Task('b', AGV, 6, destinations=(7,), stays=True), rounds=rounds)
    assert _edges(outcome, 'b') == [5, 6]
    cleared = outcome.drives['a'][3].start + 0.9 / slow.speed  # both radii and the clearance
    assert outcome.drives['b'][0].start == pytest.approx(cleared)
    assert [c for c in outcome.precedence if c.then == 'a'] == []


@pytest.mark.parametrize('seed', range(20))
def test_whatever_was_released_plans_for_new_destinations_keep_it(seed):
    """First all drives that wait for no other robot are released. Then all robots get new
    destinations.
    """
    random = Random(seed)
    graph, slow = ladder(8), RobotType('slow', 0.4, 0.2)
    planner = _planner(graph, kinds=(AGV, slow))
    at = dict(zip('abcd', random.sample(sorted(graph.vertices), 4)))
    kinds = {'a': slow, 'b': slow, 'c': AGV, 'd': AGV}

    def tasks(released):
        return [Task(name, kinds[name], at[name], released.get(name, ()),
                     destinations=(goal,), stays=True)
                for name, goal in zip('abcd', random.sample(sorted(graph.vertices), 4))]

    first = _plan(planner, *tasks({}))
    free = {name: min((c.drive for c in first.precedence if c.then == name), default=len(plan))
            for name, plan in first.drives.items()}
    released = {name: tuple(_edges(first, name)[:free[name]]) for name in 'ab'}
    then = _plan(planner, *tasks(released))
    assert not then.unserved
    for name, edges in released.items():
        assert tuple(_edges(then, name)[:len(edges)]) == edges
        assert all(c.drive >= len(edges) for c in then.precedence if c.then == name)


def test_a_robot_between_two_vertices_may_go_either_way():
    planner = _planner(corridor(5))
    for goal, first, seconds in ((1, -2, 2.5), (5, 2, 5.5)):
        outcome = _plan(planner, Task('a', AGV, mid_edge=(2, 0.25), destinations=(goal,),
                                      stays=True))
        assert _edges(outcome, 'a')[0] == first
        assert outcome.drives['a'][-1].end == pytest.approx(seconds)


def _planner_with_a_zone():
    """A planner for two corridors far from each other; edges 2 and 4 form a zone for one robot."""
    graph = graph_of({1: (0.0, 0.0), 2: (2.0, 0.0), 3: (4.0, 0.0),
                      4: (0.0, 9.0), 5: (2.0, 9.0), 6: (4.0, 9.0)},
                     {1: (1, 2), 2: (2, 3), 3: (4, 5), 4: (5, 6)})
    zone = SiteGeometry(graph, alone=[Alone(frozenset({2, 4}))])
    return FleetPlanner(RoadNetwork(graph, geometry=zone), 0.1, (AGV,), tuple(graph.vertices))


@pytest.mark.parametrize('rounds', [0, 2])
def test_a_robot_between_two_vertices_leaves_its_zone_before_another_one_enters(rounds):
    outcome = _plan(_planner_with_a_zone(),
                    Task('a', AGV, mid_edge=(2, 0.25), destinations=(1,), stays=True),
                    Task('b', AGV, 5, destinations=(6,), stays=True, priority=5), rounds=rounds)
    assert not outcome.unserved
    assert outcome.drives['b'][0].start >= outcome.drives['a'][0].end
    assert any((c.first, c.then) == ('a', 'b') for c in outcome.precedence)


def test_nobody_is_planned_into_a_zone_in_which_a_robot_stands_for_ever():
    obstacle = Obstacle('a', AGV, areas=(Area(((2.5, 0.0),)),))
    outcome = _plan(_planner_with_a_zone(), Task('b', AGV, 5, destinations=(6,), stays=True),
                    obstacles=[obstacle])
    assert set(outcome.unserved) == {'b'}


def test_several_destinations_with_dwells_are_one_search():
    task = Task('a', AGV, 1, destinations=(3, 2, 3), dwells=(4.0, 0.0, 1.0), stays=True)
    outcome = _plan(_planner(corridor(4)), task)
    assert _edges(outcome, 'a') == [1, 2, -2, 2]
    assert [d.start for d in outcome.drives['a']] == [0.0, 2.0, 8.0, 10.0]
    assert outcome.cost == pytest.approx(13.0)
    assert outcome.lower_bound == pytest.approx(13.0)


def test_who_is_not_to_stay_goes_on_to_parking():
    outcome = _plan(_planner(corridor(5), parking=(5,)), Task('a', AGV, 1, destinations=(3,)))
    assert _edges(outcome, 'a') == [1, 2, 3, 4]
    assert outcome.cost == pytest.approx(4.0, abs=0.01), 'the other paths hardly add to the cost'


def test_who_got_a_way_when_it_made_room_for_another_is_not_planned_once_more():
    """Robot a finds no path. Then b is planned together with a, so that both have a path."""
    calls = []

    def search(query, *others):
        calls.append(query)
        return None if len(calls) <= 4 else find_path(query, *others)

    graph = ladder(5)
    planner = FleetPlanner(RoadNetwork(graph), 0.1, (AGV,), tuple(graph.vertices), search)
    outcome = _plan(planner, Task('a', AGV, 1, destinations=(5,), kept=()),
                    Task('b', AGV, 5, destinations=(1,), kept=()))
    assert not outcome.unserved
    assert len(calls) == 4 + 2


def test_an_idle_robot_gives_way_and_comes_to_rest_on_parking():
    outcome = _plan(_planner(corridor(5, siding_at=3), parking=(1, 5, 100)),
                    Task('a', AGV, 1, destinations=(5,)), Task('idle', AGV, 3, kept=()))
    assert not outcome.unserved
    assert _edges(outcome, 'idle') == [100]


def test_two_kept_plans_stay_when_a_third_robot_gets_a_mission():
    planner = _planner(ladder(5))
    first = _plan(planner, Task('a', AGV, 1, destinations=(5,)),
                  Task('b', AGV, 105, destinations=(101,)), Task('c', AGV, 103))
    kept = [Task(name, AGV, vertex, destinations=goal, kept=first.drives[name])
            for name, vertex, goal in (('a', 1, (5,)), ('b', 105, (101,)))]
    again = _plan(planner, *kept, Task('c', AGV, 103, destinations=(3,), kept=()))
    assert not again.unserved
    assert {n: _edges(again, n) for n in 'ab'} == {n: _edges(first, n) for n in 'ab'}


def test_who_gets_no_way_keeps_its_old_plan_and_it_is_said_who_is_in_its_way():
    planner = _planner(corridor(5))
    old = (PlannedDrive(1, 0.0, 2.0),)
    outcome = _plan(planner, Task('a', AGV, 1, destinations=(5,), kept=old),
                    obstacles=(Obstacle('broken', AGV, vertices=(4,)),))
    assert _edges(outcome, 'a') == [1]
    assert outcome.unserved == {
        'a': 'on the way to vertex 5 it is blocked by broken, which cannot move'}


def test_robots_that_stand_too_near_each_other_stay_and_everybody_else_goes_round_them():
    graph = graph_of({1: (0, 0), 2: (2, 0), 3: (4, 0), 4: (2, 2), 5: (2.3, 0)},
                     {1: (1, 2), 2: (2, 3), 3: (1, 4), 4: (4, 3), 5: (2, 5)})
    outcome = _plan(_planner(graph), Task('a', AGV, 2, destinations=(3,)),
                    Task('b', AGV, 5, destinations=(3,)), Task('c', AGV, 1, destinations=(3,)))
    assert 'nearer to b than is allowed' in outcome.unserved['a']
    assert outcome.drives['a'] == outcome.drives['b'] == ()
    assert _edges(outcome, 'c')[:2] == [3, 4]


def test_closed_edges_are_not_driven_and_named_where_they_cut_off():
    ring = {1: (1, 2), 2: (2, 3), 3: (3, 4), 4: (4, 1)}
    graph = graph_of({1: (0, 0), 2: (3, 0), 3: (3, 3), 4: (0, 3)}, ring)
    task = Task('a', AGV, 1, destinations=(2,))
    assert _edges(_plan(_planner(graph, closed=(1,)), task), 'a')[:3] == [-4, -3, -2]
    why = _plan(_planner(graph, closed=(1, 3)), task).unserved['a']
    assert why == 'vertex 2 cannot be reached from vertex 1 while edges 1, 3 are closed'


def test_a_large_robot_and_a_small_one_keep_their_own_distances():
    small, large = RobotType('small', 0.2, 1.0), RobotType('large', 0.9, 1.0)
    graph = graph_of({1: (0, 0), 2: (6, 0), 3: (0, 1), 4: (6, 1)},
                     {1: (1, 2), 2: (3, 4), 3: (1, 3)})
    for kinds, at_once in (((small, small), True), ((small, large), False)):
        outcome = _plan(_planner(graph, kinds=(small, large)),
                        Task('a', kinds[0], 2, destinations=(1,), stays=True),
                        Task('b', kinds[1], 3, destinations=(4,), stays=True))
        assert (not outcome.unserved) is at_once


def test_priorities_decide_who_waits():
    """Two robots arrive at the crossing at the same time."""
    graph = graph_of({1: (-4, 0), 2: (0, 0), 3: (4, 0), 4: (0, -4), 5: (0, 4)},
                     {1: (1, 2), 2: (2, 3), 3: (4, 2), 4: (2, 5)})
    for urgent in 'ab':
        outcome = _plan(_planner(graph), *(
            Task(name, AGV, start, destinations=(end,), stays=True, priority=name == urgent)
            for name, start, end in (('a', 1, 3), ('b', 4, 5))))
        assert outcome.drives[urgent][-1].end == 8.0


def test_where_not_all_can_be_served_somebody_is():
    """Each robot is in the way of another robot, and only one of them has room to step aside."""
    graph = corridor(6, siding_at=3)
    tasks = [Task(name, AGV, vertex, destinations=(goal,), kept=())
             for name, vertex, goal in (('a', 1, 6), ('b', 6, 1), ('c', 4, 2))]
    outcome = _plan(_planner(graph, parking=(1, 2, 4, 6, 100)), *tasks, seconds=2.0)
    assert len(outcome.unserved) < 3


@pytest.mark.parametrize('task, sentence', [
    (Task('a', AGV), 'must stand on one vertex'),
    (Task('a', AGV, 1, mid_edge=(1, 0.5)), 'must stand on one vertex'),
    (Task('a', AGV, 9), 'the graph has no vertex 9'),
    (Task('a', AGV, 1, destinations=(8,)), 'the graph has no vertex 8'),
    (Task('a', AGV, released=(7,)), 'the graph has no edge 7'),
    (Task('a', AGV, released=(1, 3)), 'edge 3 does not begin where edge 1 ends'),
    (Task('a', AGV, released=(1,), begun=1.0), 'fractions must be below 1'),
    (Task('a', AGV, 1, ready=float('nan')), 'numbers, 0 or more'),
    (Task('a', AGV, 1, destinations=(2, 3), dwells=(1.0,)), '2 destinations but 1 dwells'),
])
def test_tasks_that_make_no_sense_are_refused(task, sentence):
    with pytest.raises(CannotPlan, match=sentence):
        _plan(_planner(corridor(5)), task)


def test_the_same_question_gets_the_same_answer():
    tasks = [Task(f'r{k}', AGV, k, destinations=(6 - k,)) for k in range(1, 6)]
    first, second = (_plan(_planner(ladder(5)), *tasks, rounds=40, seconds=60.0) for _ in 'ab')
    assert first == second
    planner = _planner(ladder(5))
    _plan(planner, *tasks[:3], rounds=5)
    assert _plan(planner, *tasks, rounds=40, seconds=60.0) == first, (
        'nothing is kept from the previous call')


def test_improvement_makes_no_plan_worse():
    tasks = [Task(f'r{k}', AGV, k, destinations=(7 - k,), stays=True) for k in range(1, 7)]
    costs = [_plan(_planner(ladder(6)), *tasks, rounds=rounds, seconds=60.0).cost
             for rounds in (0, 20, 100)]
    assert costs == sorted(costs, reverse=True)
    assert costs[-1] < costs[0]


def test_robots_whose_ends_are_in_each_others_only_way_change_places_in_a_siding():
    """If the robots are planned one after the other, the second robot drives a detour of 45 m."""
    row = {k: (3.0 * k, 0.0) for k in range(1, 6)}
    graph = graph_of({**row, 9: (6.0, 3.0), 10: (3.0, -15.0), 11: (15.0, -15.0)},
                     {**{k: (k, k + 1) for k in range(1, 5)}, 9: (2, 9), 10: (1, 10), 11: (10, 11),
                      12: (11, 5)})
    tasks = [Task('one', AGV, 1, destinations=(4,), stays=True),
             Task('other', AGV, 5, destinations=(2,), stays=True)]
    assert _plan(_planner(graph), *tasks).cost == pytest.approx(54.0)
    assert _plan(_planner(graph), *tasks, rounds=100, seconds=60.0).cost < 36.0


def rows(table):
    """The bookings of all slots for an AGV."""
    slots = table.slots[AGV]
    return [slots.row(slot) for slot in range(len(slots.merged))]


def test_cancelling_leaves_nothing_booked():
    network = RoadNetwork(ladder(4))
    table = ReservationTable(network, 0.1, [AGV])
    planner = FleetPlanner(network, 0.1, [AGV])
    outcome = _plan(planner, Task('a', AGV, 1, destinations=(4,), stays=True))
    problem = Problem(table, [Task('a', AGV, 1)], ())
    drives = [problem.with_rests(t, frozenset()).query for t in problem.agents.values()]
    assert drives[0].vertex == network.index[1]
    planner.reservations.cancel('a')
    assert planner.reservations.is_empty and not any(rows(planner.reservations)), outcome


def test_robots_that_are_put_back_are_booked_as_before():
    network = RoadNetwork(ladder(4))
    table = ReservationTable(network, 0.1, [AGV])
    slots = table.slots[AGV]
    out, back = network.drive(network.edge_ids[0]), network.drive(-network.edge_ids[0])
    robots = {'a': (network.origin[out], [Drive(out, 5.0, 7.0), Drive(back, 9.0, 11.0)]),
              'b': (network.vertices - 1, [])}

    def seen():
        return ([sorted(map(tuple, bookings)) for bookings in rows(table)],
                [slots.busy(slot) for slot in range(len(slots.merged))], dict(table.booked))
    for name, (vertex, plan) in robots.items():
        table.book(name, AGV, vertex, plan)
    before = seen()
    taken = table.take_out(['a', 'b'])
    assert not any(rows(table)) and table.is_empty
    table.book('a', AGV, network.vertices - 2, [])
    assert seen() != before
    table.put_back(taken)
    assert seen() == before
    for name in robots:
        table.cancel(name)
    assert not any(rows(table)) and table.is_empty


def test_the_search_over_configurations_swaps_robots_in_a_siding():
    network = RoadNetwork(corridor(5, siding_at=3))
    table = ReservationTable(network, 0.1, [AGV])
    agents = list(Problem(table, [
        Task('a', AGV, 1, destinations=(5,), stays=True),
        Task('b', AGV, 5, destinations=(1,), stays=True)], ()).agents.values())
    moves = search_lacam(table, agents, time.monotonic() + 5.0, Random(0))
    assert moves is not None
    at = {'a': network.index[1], 'b': network.index[5]}
    for name, drive in moves:
        assert network.origin[drive] == at[name]
        at[name] = network.destination(drive)
        assert at['a'] != at['b']
    assert at == {'a': network.index[5], 'b': network.index[1]}


def test_no_order_of_use_is_made_of_drives_that_go_back_in_time():
    """If the times of a robot's drives increase, all constraints lead forward in time. Only drives
    that go back in time could make robots wait in a ring.
    """
    network = RoadNetwork(corridor(4))
    table = ReservationTable(network, 0.1, [AGV])
    first, second = (network.drive(edge) for edge in network.edge_ids[:2])
    with pytest.raises(Conflicting, match='a would begin its drive 1 before'):
        precedence(table, {'a': [Drive(first, 5.0, 7.0), Drive(second, 1.0, 3.0)]}, {'a': AGV})


def test_what_was_released_needs_no_precedence_any_more():
    planner = _planner(corridor(5))
    outcome = _plan(planner, Task('a', AGV, 3, destinations=(5,), stays=True),
                    Task('b', AGV, 1, destinations=(3,), stays=True))
    assert {c.then for c in outcome.precedence} == {'b'}
    assert precedence(planner.reservations, {}, {}) == []


# -- parking --------------------------------------------------------------------------------------

def test_a_parked_robot_in_a_corridor_cuts_it_and_one_at_its_end_does_not():
    network = RoadNetwork(corridor(5))
    parking = WellFormedSets(network, AGV, 0.1)
    assert parking.is_well_formed([network.index[1]])
    assert not parking.is_well_formed([network.index[3]])
    assert not parking.is_well_formed([network.index[1], network.index[5], network.index[2]])


def test_the_laboratory_has_room_for_thirteen_and_not_for_one_more(lab_graph):
    """The set `best` comes from an exhaustive search."""
    network = RoadNetwork(lab_graph)
    parking = WellFormedSets(network, RobotType('agv', 0.43, 1.0, docks=frozenset((16,))), 0.1)
    best = {network.index[v] for v in (8, 10, 14, 32, 33, 35, 6, 16, 18, 27, 41, 39, 52)}
    assert parking.is_well_formed(best)
    assert not any(parking.is_well_formed(best | {v}) for v in range(network.vertices)
                   if v not in best)


def test_the_largest_set_of_a_ladder_with_dead_ends_is_found():
    """Each rung leads to a dead end; robots that are parked in dead ends block no other robot."""
    graph = graph_of({**{k: (3.0 * k, 0.0) for k in range(1, 6)},
                      **{10 + k: (3.0 * k, 2.0) for k in range(1, 6)}},
                     {**{k: (k, k + 1) for k in range(1, 5)},
                      **{10 + k: (k, 10 + k) for k in range(1, 6)}})
    network = RoadNetwork(graph)
    found = WellFormedSets(network, AGV, 0.1).largest()
    assert {network.vertex_ids[v] for v in found} == {11, 12, 13, 14, 15}


def _grid(size, spacing=3.0):
    """Square grid of size x size vertices."""
    places = {1 + k: (spacing * (k % size), spacing * (k // size)) for k in range(size ** 2)}
    edges = [(id, id + 1) for id in places if id % size]
    edges += [(id, id + size) for id in places if id + size in places]
    return graph_of(places, dict(enumerate(edges, 1)))


@pytest.mark.parametrize('size', [5, 15])
def test_a_search_for_parking_ends_after_a_fixed_amount_of_work(size, monkeypatch):
    """Without the limit, a search on a grid of 225 vertices did not end within minutes."""
    work = []
    network = RoadNetwork(_grid(size))
    parking = WellFormedSets(network, AGV, 0.1)
    places = network.vertices + len(network.edge_ids)
    is_well_formed = parking.is_well_formed

    def check(parked):
        work.append(places)
        return is_well_formed(parked)
    monkeypatch.setattr(parking, 'is_well_formed', check)
    monkeypatch.setattr('fleet_core.planning.parking._WORK', 500_000)
    found = parking.largest()
    one_set = 2 * network.vertices * places  # upper bound of the work for one set
    assert sum(work) <= 500_000 + 2 * one_set
    assert len(found) > network.vertices / 2 and is_well_formed(found)


@pytest.fixture
def lab_graph():
    return load_graph(Path(__file__).parents[3] / 'maps/lab_graph.yaml')


# -- robots between two vertices -------------------------------------------------------------------

@pytest.mark.parametrize('names', [('a', 'b'), ('b', 'a')])
def test_a_robot_far_enough_from_one_between_vertices_is_planned(names):
    outcome = _planner(corridor(4)).plan(
        [Task(names[0], AGV, 2, destinations=(1,)),
         Task(names[1], AGV, mid_edge=(2, 0.5), destinations=(4,))], rounds=0)
    assert outcome.unserved == {}


@pytest.mark.parametrize('names', [('a', 'b'), ('b', 'a')])
def test_a_robot_too_near_to_one_between_vertices_is_told_so(names):
    outcome = _planner(corridor(4)).plan(
        [Task(names[0], AGV, 2, destinations=(1,)),
         Task(names[1], AGV, mid_edge=(2, 0.4), destinations=(4,))], rounds=0)
    assert set(outcome.unserved) == {'a', 'b'}


def test_a_robot_between_vertices_may_go_on_while_another_comes_to_the_vertex_behind_it():
    outcome = _planner(corridor(4)).plan([Task('a', AGV, mid_edge=(2, 0.55), destinations=(4,)),
                                         Task('b', AGV, released=(1,), destinations=(2,))],
                                        rounds=0)
    assert outcome.unserved == {}
    assert outcome.drives['a'][0].start == 0.0, 'the robot must not block places behind it'


@pytest.mark.parametrize('gap, too_near', [(0.4, False), (0.1, True)])
def test_two_robots_on_one_edge_leave_it_apart_if_their_points_are_far_enough_apart(gap, too_near):
    outcome = _planner(corridor(4, spacing=5.0)).plan(
        [Task('a', AGV, mid_edge=(2, 0.5 - gap / 2), destinations=(1,), stays=True),
         Task('b', AGV, mid_edge=(2, 0.5 + gap / 2), destinations=(4,), stays=True)], rounds=0)
    assert set(outcome.unserved) == ({'a', 'b'} if too_near else set())
    if not too_near:
        assert (_edges(outcome, 'a'), _edges(outcome, 'b')) == ([-2, -1], [2, 3])


@pytest.mark.parametrize('goal, way', [(1, [-2, -1]), (4, [2, 3])])
def test_a_robot_leaves_a_closed_edge_to_either_side(goal, way):
    outcome = _planner(corridor(4), closed=(2,)).plan(
        [Task('a', AGV, mid_edge=(2, 0.25), destinations=(goal,), stays=True)], rounds=0)
    assert outcome.unserved == {}
    assert _edges(outcome, 'a') == way


def test_a_robot_leaves_a_closed_edge_only_in_the_direction_that_the_edge_allows():
    graph = graph_of({1: (0, 0), 2: (4, 0), 3: (4, 4)}, {1: (1, 2), 2: (2, 3), 3: (3, 1)},
                     one_way=(1,))
    task = Task('a', AGV, mid_edge=(1, 0.1), destinations=(1,), stays=True)
    assert _edges(_planner(graph, closed=(1,)).plan([task], rounds=0), 'a') == [1, 2, 3]


def test_a_robot_does_not_come_back_to_a_closed_edge_that_it_has_left():
    outcome = _planner(corridor(4), closed=(2,)).plan(
        [Task('a', AGV, mid_edge=(2, 0.25), destinations=(1, 4), stays=True)], rounds=0)
    assert 'vertex 4 cannot be reached from vertex 1 while edges 2 are closed' in \
        outcome.unserved['a']


def test_a_robot_keeps_its_plan_out_of_an_edge_that_was_closed():
    kept = (PlannedDrive(-2, 0.0, 0.5), PlannedDrive(-1, 0.5, 2.5))
    outcome = _planner(corridor(4), closed=(2,)).plan(
        [Task('a', AGV, mid_edge=(2, 0.25), destinations=(1,), stays=True, kept=kept)], rounds=0)
    assert _edges(outcome, 'a') == [-2, -1]


def test_an_obstacle_blocks_the_rest_of_an_edge_but_not_the_part_behind():
    graph = corridor(3, spacing=8.0)
    for centre, is_blocked in ((4.0, False), (12.0, True)):
        beside = Obstacle('dead', AGV, areas=(Area(((centre, 0.5),), 0.1),))
        outcome = _planner(graph).plan(
            [Task('a', AGV, mid_edge=(2, 0.1), destinations=(3,), stays=True)], [beside], rounds=0)
        assert ('a' in outcome.unserved) is is_blocked
        assert not is_blocked or 'dead, which cannot move' in outcome.unserved['a']
