"""The searches find the best solution: they agree with each other and with exhaustive search.

The grid has edges exactly as long as the distance that robots must keep. On this grid every plan
can be made of steps of one edge in which no two robots hold the same vertex. So an exhaustive
search is easy to write, and shares no code with the planner.
"""
from __future__ import annotations

import heapq
import itertools
import time
from math import inf
from random import Random
from typing import Dict, List, Optional, Sequence, Tuple

import networkx as nx
import pytest
from fleet_builders import AGV, graph_of
from fleet_cases import Case
from hypothesis import given, settings
from hypothesis import strategies as st

from fleet_core.fleet import RobotType
from fleet_core.planning.layers import layered
from fleet_core.planning.planner import FleetPlanner
from fleet_core.planning.problem import Problem
from fleet_core.planning.reservation_table import ReservationTable
from fleet_core.planning.road_network import RoadNetwork
from fleet_core.planning.safe_intervals import find_path
from fleet_core.planning.shortest_paths import ShortestPaths
from fleet_core.planning.tasks import Task
from fleet_core.planning.tea_star import TeaStar
from trajectory_graph import Graph, GraphError

# A robot drives an edge of 1 m in 1 s, and blocks both ends of the edge for this time.
UNIT = RobotType('unit', 0.5, 1.0)
SEARCHES = {'safe_intervals': find_path, 'layers': layered(1.0)}


def _grid(random: Random, columns: int, rows: int) -> Graph:
    """A connected grid; some edges are missing, and some are one-way."""
    places = {row * columns + column + 1: (float(column), float(row))
              for row in range(rows) for column in range(columns)}
    pairs = [(a, b) for a in places for b in places if a < b and sum(
        abs(p - q) for p, q in zip(places[a], places[b])) == 1.0]
    while True:
        kept = [pair for pair in pairs if random.random() < 0.8]
        if _connected(places, kept):
            break
    one_way = [k for k in range(1, len(kept) + 1) if random.random() < 0.15]
    return graph_of(places, dict(enumerate(kept, 1)), one_way=one_way)


def _connected(places, pairs) -> bool:
    reached = {1}
    for _ in places:
        reached |= {v for pair in pairs if reached & set(pair) for v in pair}
    return len(reached) == len(places)


def _neighbours(graph: Graph) -> Dict[int, List[int]]:
    neighbours: Dict[int, List[int]] = {vertex: [vertex] for vertex in graph.vertices}
    for edge in graph.edges.values():
        neighbours[edge.origin].append(edge.destination)
        if edge.velocity_backwards > 0.0:
            neighbours[edge.destination].append(edge.origin)
    return neighbours


def _best_sum(graph: Graph, starts: Sequence[int], goals: Sequence[int]) -> Optional[int]:
    """The lowest sum of the times at which robots have reached their goals for good."""
    neighbours = _neighbours(graph)
    first = tuple(starts), (False,) * len(starts)
    best = {first: 0}
    heap: List[Tuple[int, tuple]] = [(0, first)]
    while heap:
        cost, state = heapq.heappop(heap)
        if cost > best[state]:
            continue
        at, done = state
        if all(done):
            return cost
        for k, vertex in enumerate(at):  # a robot at its goal can stay there for good
            if not done[k] and vertex == goals[k]:
                _offer(best, heap, cost, (at, (*done[:k], True, *done[k + 1:])))
        options = [[vertex] if finished else neighbours[vertex]
                   for vertex, finished in zip(at, done)]
        for step in itertools.product(*options):
            held = [v for a, b in zip(at, step) for v in {a, b}]
            if len(held) == len(set(held)):
                _offer(best, heap, cost + done.count(False), (step, done))
    return None


def _offer(best, heap, cost, state):
    if cost < best.get(state, cost + 1):
        best[state] = cost
        heapq.heappush(heap, (cost, state))


def _best_alone(graph: Graph, start: int, goal: int, horizon: int,
                others: Sequence[Sequence[int]]) -> Optional[int]:
    """The earliest time from which a robot can stay at its goal.

    others -- the other robots: robot k is at `others[k][t]` at time t
    """
    neighbours = _neighbours(graph)

    def held(t):
        return {v for other in others for v in other[min(t, len(other) - 1):][:2]}
    reached = {start}
    arrived: Dict[int, bool] = {}
    for t in range(horizon):
        arrived[t] = goal in reached
        reached = {b for a in reached for b in neighbours[a] if not {a, b} & held(t)}
    stays = horizon
    while stays and goal not in held(stays - 1):
        stays -= 1
    return next((t for t in range(stays, horizon) if arrived[t]), None)


def _tasks(starts, goals):
    return [Task(f'r{k}', UNIT, start, destinations=(goal,), stays=True)
            for k, (start, goal) in enumerate(zip(starts, goals))]


@pytest.mark.parametrize('search', SEARCHES)
@given(st.integers(0, 2 ** 32 - 1))
@settings(max_examples=settings.default.max_examples // 2)
def test_one_robot_past_the_plan_of_another_takes_no_longer_than_it_must(search, seed):
    random = Random(seed)
    graph = _grid(random, 4, 3)
    (start, other), (goal, other_goal) = (random.sample(list(graph.vertices), 2) for _ in 'ab')
    network = RoadNetwork(graph)
    planner = FleetPlanner(network, 0.0, [UNIT], search=SEARCHES[search])
    first = planner.plan(_tasks([other], [other_goal]), (), time.monotonic() + 5.0, 0)
    if first.unserved:  # the goal is behind one-way edges
        return
    record = [other]
    for drive in first.drives['r0']:
        record += [record[-1]] * (round(drive.start) - len(record) + 1)
        record.append(graph.end_vertex(drive.edge).id)
    # The first robot keeps its path, because it has the higher priority.
    tasks = _tasks([other, start], [other_goal, goal])
    tasks[0] = Task('r0', UNIT, other, destinations=(other_goal,), stays=True, priority=1)
    both = planner.plan(tasks, (), time.monotonic() + 5.0, 0)
    least = _best_alone(graph, start, goal, 40, [record])
    if least is None or both.unserved or both.drives['r0'] != first.drives['r0']:
        return  # the other robot had to give way; `test_small_fleets...` tests that case
    ends = both.drives['r1'][-1].end if both.drives['r1'] else 0.0
    assert ends == pytest.approx(least)


@given(st.integers(0, 2 ** 32 - 1))
@settings(max_examples=settings.default.max_examples * 2 // 5)
def test_small_fleets_get_a_plan_whenever_there_is_one(seed):
    best, outcome = _small_fleet(seed)
    if best is None:
        assert outcome.unserved
        return
    assert not outcome.unserved
    assert best <= _sum_of_ends(outcome) + 1e-6


def test_plans_of_small_fleets_are_near_the_best_there_are():
    """The planner guarantees no bound: one plan in about 1,600 exceeds the bound of this test. The
    first such plan has the seed 3254.
    """
    for seed in range(200):
        best, outcome = _small_fleet(seed)
        if best is not None:
            assert _sum_of_ends(outcome) <= 2.0 * best + 2.0, f'seed {seed}'


def _small_fleet(seed):
    """The least possible sum of arrival times (None: there is no solution), and the plan."""
    random = Random(seed)
    graph = _grid(random, 3, 3)
    robots = random.choice((2, 2, 3))
    starts, goals = (random.sample(list(graph.vertices), robots) for _ in 'ab')
    planner = FleetPlanner(RoadNetwork(graph), 0.0, [UNIT])
    return (_best_sum(graph, starts, goals),
            planner.plan(_tasks(starts, goals), (), time.monotonic() + 5.0, 30))


def _sum_of_ends(outcome):
    return sum(drives[-1].end for drives in outcome.drives.values() if drives)


def test_plans_of_small_fleets_are_mostly_the_best_there_are():
    met, solved, costs, least = 0, 0, 0.0, 0.0
    for seed in range(30):
        random = Random(seed)
        graph = _grid(random, 3, 3)
        starts, goals = (random.sample(list(graph.vertices), 2) for _ in 'ab')
        best = _best_sum(graph, starts, goals)
        if best is None:
            continue
        outcome = FleetPlanner(RoadNetwork(graph), 0.0, [UNIT]).plan(
            _tasks(starts, goals), (), time.monotonic() + 5.0, 30)
        solved += 1
        met += outcome.cost <= best + 1e-6
        costs, least = costs + outcome.cost, least + best
    assert solved > 15
    assert met >= 0.8 * solved, f'{met} of {solved}'
    assert costs <= 1.1 * least, f'{costs} s instead of {least} s'


@given(st.integers(0, 2 ** 32 - 1))
@settings(max_examples=settings.default.max_examples // 5)
def test_fine_layers_and_safe_intervals_agree(seed):
    """On any graph, a path found with layers costs at most one layer more for each vertex."""
    try:
        case = Case(Random(seed))
    except GraphError:
        return
    first = next(iter(case.robots.values()))
    destinations = case.missions.get(first.name, ())
    layer = 0.02
    costs = []
    for search in (find_path, layered(layer)):
        planner = FleetPlanner(case.network, case.clearance, case.types, search=search)
        others = [Task(t.name, t.type, t.vertex, stays=True) for t in case.robots.values()
                  if t is not first]
        task = Task(first.name, first.type, first.vertex, destinations=destinations, stays=True,
                    priority=-1)
        costs.append(planner.plan([task, *others], (), time.monotonic() + 5.0, 0))
    drives = max(len(outcome.drives[first.name]) for outcome in costs)
    # If another robot also drives, the path that is found first determines all other paths.
    alone = not any(outcome.drives[task.name] for outcome in costs for task in others)
    if alone and not any(outcome.unserved for outcome in costs):
        assert costs[0].cost <= costs[1].cost + 1e-6
        assert costs[1].cost <= costs[0].cost + layer * (drives + 1)


# -- the loop of TEA*: another order if a robot finds no path --------------------------------------

def test_who_is_not_in_the_way_of_who_is_put_first_keeps_its_way():
    """Robot a would end in the corridor that b has to pass. Robot d meets neither a nor b."""
    graph = graph_of({1: (0, 0), 2: (2, 0), 3: (4, 0), 4: (6, 0), 5: (4, 2), 6: (9, 9), 7: (9, 7)},
                     {1: (1, 2), 2: (2, 3), 3: (3, 4), 4: (3, 5), 5: (6, 7), 6: (4, 7)})
    table = ReservationTable(RoadNetwork(graph), 0.1, [AGV])
    looked = []

    def search(query, *others):
        looked.append(graph_id(query.vertex))
        return find_path(query, *others)

    def graph_id(vertex):
        return table.network.vertex_ids[vertex]
    order = list(Problem(table, [
        Task('d', AGV, 6, destinations=(7,), stays=True),
        Task('a', AGV, 5, destinations=(2,), stays=True),
        Task('b', AGV, 1, destinations=(4,), stays=True)], ()).agents.values())
    paths = TeaStar(table, search).plan(order, inf, 2)
    assert looked == [6, 5, 1, 1, 5], 'd is planned once, b again as the first, a again after it'
    assert {name: graph_id(table.network.destination(path.plan[-1].drive))
            for name, path in paths.items()} == {'a': 2, 'b': 4, 'd': 7}
    assert paths['b'].cost == 6.0 < paths['a'].cost


# -- shortest paths with the graph reduced to its crossings ----------------------------------------

def _expected(vertices, roads, target):
    graph = nx.MultiDiGraph()
    graph.add_nodes_from(range(vertices))
    graph.add_weighted_edges_from((end, begin, seconds) for begin, end, seconds in roads)
    seconds = nx.single_source_dijkstra_path_length(graph, target)
    return [seconds.get(vertex, inf) for vertex in range(vertices)]


@given(st.integers(0, 2 ** 32 - 1))
def test_all_ways_to_all_vertices_are_the_shortest(seed):
    """The graphs have several parts; each is a tree with further links, some one-way or double."""
    random = Random(seed)
    vertices = random.randint(1, 25)
    ends = [(random.randrange(max(k - 3, 0), k), k) for k in range(1, vertices)
            if random.random() < 0.95]
    ends += [(random.randrange(vertices), random.randrange(vertices))
             for _ in range(random.randint(0, 8))]
    roads = [(*ends_of_road, random.uniform(0.1, 5.0)) for end in ends
             for ends_of_road in (end, end[::-1]) if random.random() < 0.9]
    paths = ShortestPaths(vertices, roads)
    targets = random.sample(range(vertices), random.randint(1, vertices))
    for target, row in zip(targets, paths.to(targets)):
        assert row.tolist() == pytest.approx(_expected(vertices, roads, target)), target
    nearest = paths.to(targets).min(axis=0)
    assert paths.to_nearest(targets).tolist() == pytest.approx(nearest.tolist())


def test_a_lane_of_many_sections_is_one_link():
    """Two crossings of four lanes, joined by a long lane."""
    lane = [(k, k + 1, 2.0) for k in range(100)]
    around = [(a, b, 1.0) for first, hub in ((101, 0), (104, 100))
              for a, b in ((hub, first), (hub, first + 1), (hub, first + 2),
                           (first, first + 1), (first + 1, first + 2), (first + 2, first))]
    both = [road for a, b, s in lane + around for road in ((a, b, s), (b, a, s))]
    paths = ShortestPaths(107, both)
    assert paths.left <= 8, 'only vertices of the crossings may remain'
    assert paths.to([50])[0][:101].tolist() == [2.0 * abs(50 - k) for k in range(101)]
