"""An AGV stays where it is, and obeys the route protocol, when its graph is replaced."""
from __future__ import annotations

import math
from dataclasses import replace
from random import Random

from agv_builders import GRAPH, Conversation
from hypothesis import given
from hypothesis import strategies as st

from route_protocol.values import Phase, ReasonCode
from trajectory_graph import Graph


def with_speed(edge: int, speed: float) -> Graph:
    return Graph(GRAPH.vertices.values(), [
        replace(one, velocity_forward=speed, velocity_backwards=speed) if one.id == edge else one
        for one in GRAPH.edges.values()])


def without(edge: int) -> Graph:
    """Returns the graph without this edge and without the vertices that no other edge reaches.

    Without edge 2, edge 3 would be a separate part, so it is also left out.
    """
    kept = [one for one in GRAPH.edges.values() if one.id not in {edge, 3 if edge == 2 else edge}]
    used = {vertex for one in kept for vertex in (one.origin, one.destination)}
    return Graph([v for v in GRAPH.vertices.values() if v.id in used], kept)


def test_a_complete_route_goes_on_from_its_end_after_a_speed_was_changed() -> None:
    agv = Conversation()
    agv.order(7, 1, 2)
    agv.wait(30.0)
    assert agv.vehicle.state.phase is Phase.COMPLETE
    agv.vehicle.use_graph(with_speed(1, 0.3))
    agv.order(7, 1, 2, 3)
    assert agv.vehicle.pose[0] == 8.0, 'the AGV must stand at vertex 3'
    agv.wait(30.0)
    assert agv.vehicle.pose[0] == 12.0 and agv.reason is None


def test_a_complete_route_whose_last_edge_is_gone_is_not_extended() -> None:
    agv = Conversation()
    agv.order(9, 1, 2)
    agv.wait(60.0)
    agv.vehicle.use_graph(without(2))
    agv.vehicle.use_graph(GRAPH)
    before = agv.vehicle.pose
    agv.order(9, 1, 2, 3)
    assert agv.refusals[-1].reason.code in (ReasonCode.GRAPH_CHANGED, ReasonCode.OFF_GRAPH)
    assert agv.vehicle.pose == before


def test_a_vehicle_between_vertices_keeps_its_place_and_its_route_when_a_speed_changes() -> None:
    agv = Conversation()
    agv.order(7, 1, 2)
    agv.drive_to(2.0)
    agv.vehicle.use_graph(with_speed(2, 0.2))
    assert agv.last.pose.edge == 1 and agv.vehicle.running
    agv.wait(60.0)
    assert agv.vehicle.state.phase is Phase.COMPLETE


def test_a_route_fails_where_an_edge_ahead_is_gone_but_the_vehicle_stays_on_its_edge() -> None:
    agv = Conversation()
    agv.order(7, 1, 4)
    agv.drive_to(2.0)
    agv.vehicle.use_graph(without(4))
    assert agv.last.reason.code is ReasonCode.GRAPH_CHANGED and agv.last.pose.edge == 1
    agv.wait(10.0)
    agv.order(8, 1, 2)
    agv.wait(60.0)
    assert agv.vehicle.state.phase is Phase.COMPLETE and agv.vehicle.pose[0] == 8.0


@given(st.integers(0, 10_000))
def test_whatever_graphs_come_a_vehicle_never_jumps(seed: int) -> None:
    random = Random(seed)
    agv, route_id = Conversation(), 0
    for _ in range(30):
        before = agv.vehicle.pose
        act = random.randrange(4)
        if act == 0:
            route_id += random.randrange(2)
            agv.order(route_id or 1, *random.choice(((1, 2), (1, 2, 3), (1, 4), (-2, -1), (3,))))
        elif act == 1:
            agv.vehicle.use_graph(random.choice((
                GRAPH, without(3), without(4), with_speed(1, 0.5), with_speed(2, 0.1))))
        assert math.dist(before[:2], agv.vehicle.pose[:2]) < 1e-6, (
            'an order or a graph moved the AGV')
        agv.wait(1.0)
        assert math.dist(before[:2], agv.vehicle.pose[:2]) <= 1.0 + 1e-6, (
            'the AGV drove faster than its speed')
