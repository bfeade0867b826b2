"""The loop of TEA*: one robot after the other, and another order if a robot finds no path."""
from __future__ import annotations

from math import inf

from fleet_builders import AGV, graph_of

from fleet_core.planning.problem import Problem
from fleet_core.planning.reservation_table import ReservationTable
from fleet_core.planning.road_network import RoadNetwork
from fleet_core.planning.safe_intervals import find_path
from fleet_core.planning.tasks import Task
from fleet_core.planning.tea_star import TeaStar


def test_who_is_not_in_the_way_of_who_is_put_first_keeps_its_way():
    """Robot a would end in the corridor that b has to pass; d does not meet them."""
    graph = graph_of({1: (0, 0), 2: (2, 0), 3: (4, 0), 4: (6, 0), 5: (4, 2), 6: (9, 9), 7: (9, 7)},
                     {1: (1, 2), 2: (2, 3), 3: (3, 4), 4: (3, 5), 5: (6, 7), 6: (4, 7)})
    table = ReservationTable(RoadNetwork(graph), 0.1, [AGV])
    looked = []

    def search(errand, *others):
        looked.append(graph_id(errand.vertex))
        return find_path(errand, *others)

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
