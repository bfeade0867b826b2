"""Makes a fleet for a number N: N LD-90s and N AGVs, each on a parking vertex of its own."""
from __future__ import annotations

from typing import List, Sequence

from fleet_bringup.errors import CannotStart
from fleet_core.fleet import Fleet, Robot, RobotType
from fleet_core.planning.parking import WellFormedSets
from fleet_core.planning.road_network import RoadNetwork
from trajectory_graph import Graph

CLEARANCE = 0.1  # m
#: For each type of robot: length (m) of the route that is released ahead of it. This is enough to
#: drive until the next order comes, and then to brake.
RELEASE_AHEAD = {'ld90': 8.0, 'agv': 2.0}


def made_fleet(count: int, graph: Graph) -> Fleet:
    """Returns `count` LD-90s and as many AGVs. Raises CannotStart if they cannot all park."""
    docks = frozenset(vertex.id for vertex in graph.vertices.values() if vertex.dock)
    ld90 = RobotType('ld90', 0.43, 1.35, 0.25, False, docks)
    agv = RobotType('agv', 0.35, 1.0, 0.0, False)
    starts = parking_places(graph, [ld90, agv], CLEARANCE, 2 * count)
    if 2 * count > len(starts):
        raise CannotStart(
            f'fleet:={count} gives {2 * count} robots, but the graph has places for {len(starts)} '
            f'to park without cutting any robot off: choose fleet:={len(starts) // 2} or less, or '
            'another graph.')
    names = [f'{kind}_{number + 1}' for number in range(count) for kind in ('ld90', 'agv')]
    step = len(starts) / len(names)
    robots = [Robot(name, ld90 if name.startswith('ld90') else agv, starts[int(place * step)],
                    name.rpartition('_')[0]) for place, name in enumerate(names)]
    return Fleet((ld90, agv), tuple(sorted(robots, key=lambda r: (r.driver != 'ld90', r.name))),
                 CLEARANCE)


def parking_places(graph: Graph, types: Sequence[RobotType], clearance: float,
                   enough: int) -> List[int]:
    """Returns vertices, but no docks, on which robots of the largest type may all stand for ever.

    The search ends when it has found `enough` vertices. The result has fewer vertices if the graph
    has no more.
    """
    largest = max(types, key=lambda kind: kind.reach)
    network = RoadNetwork(graph)
    kind = RobotType('any', largest.radius, largest.speed, largest.play, False)
    found = WellFormedSets(network, kind, clearance).largest(enough=enough)
    return sorted(network.vertex_ids[vertex] for vertex in found)


def fleet_text(fleet: Fleet) -> str:
    """Returns the content of the fleet file."""
    lines = [f'clearance: {fleet.clearance}', 'robot_types:']
    for kind in fleet.types:
        docks = f', docks: {sorted(kind.docks)}' if kind.docks else ''
        lines.append(f'- {{name: {kind.name}, radius: {kind.radius}, speed: {kind.speed}, '
                     f'play: {kind.play}, '
                     f'obeys_edge_speed: {str(kind.obeys_edge_speed).lower()}, '
                     f'release_ahead: {RELEASE_AHEAD[kind.name]}{docks}}}')
    lines.append('robots:')
    lines += [f'- {{name: {robot.name}, type: {robot.type.name}, vertex: {robot.vertex}, '
              f'driver: {robot.driver}}}' for robot in fleet.robots]
    return '\n'.join(lines) + '\n'
