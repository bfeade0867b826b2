"""Computes how many missions the laboratory allows if robots meet only at the stations.

Each station is at the end of an edge and has no other exit. So the robots drive in and out one
after the other, in the order of arrival. Everywhere else, a robot drives as if it were alone. No
planner can do much better if each robot gets its next mission only when its previous mission has
ended.
"""
from __future__ import annotations

from heapq import heappop, heappush
from random import Random
from typing import Dict, List, NamedTuple, Tuple

from fleet_bench import operation
from fleet_core.planning.road_network import RoadNetwork
from trajectory_graph import load_graph


class _Spur(NamedTuple):
    """The one edge to a station."""

    junction: int
    drive_in: float   # s
    drive_out: float  # s


def missions(robots: int, seed: int, seconds: float = 3600.0) -> int:
    """Returns the number of missions done in `seconds` simulated seconds, with the delays and
    stalls of `operation`.
    """
    network = RoadNetwork(load_graph(operation.ROOT / 'maps/lab_graph.yaml'))
    graph, times = network.graph, network.times(operation.AGV)
    random = Random(seed)
    spurs: Dict[int, _Spur] = {}
    for station in operation.STATIONS:
        (way_out,) = graph.edges_from(station)
        spurs[station] = _Spur(graph.end_vertex(way_out).id, times[network.drive(-way_out)],
                               times[network.drive(way_out)])

    def late(planned: float) -> float:
        driven = planned * random.uniform(1.0, operation.DELAYS.slower)
        stalls = random.random() < driven / operation.STALLS.every
        return driven + (operation.STALLS.seconds if stalls else 0.0)

    def other_than(vertex: int) -> int:
        return random.choice([station for station in operation.STATIONS if station != vertex])

    def between(begin: int, junction: int) -> float:
        times = network.paths_to(operation.AGV, (network.index[junction],))[0]
        return late(float(times[network.index[begin]]))

    # heap of (time of arrival at the junction of a station, robot, station)
    arrivals: List[Tuple[float, int, int]] = []
    for robot, start in enumerate(operation.PARKING[:robots]):
        station, begun = other_than(start), 0.0
        if start in spurs:
            begun, start = late(spurs[start].drive_out), spurs[start].junction
        heappush(arrivals, (begun + between(start, spurs[station].junction), robot, station))
    free_from = dict.fromkeys(spurs, 0.0)
    done = 0
    while arrivals[0][0] <= seconds:
        now, robot, station = heappop(arrivals)
        spur = spurs[station]
        served = max(now, free_from[station]) + late(spur.drive_in)
        left = free_from[station] = served + late(spur.drive_out)
        done += served <= seconds
        following = other_than(station)
        heappush(arrivals, (left + between(spur.junction, spurs[following].junction), robot,
                            following))
    return done
