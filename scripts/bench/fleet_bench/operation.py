"""A fleet at work: missions one after the other, delays and stalls, with a time for each
replanning.
"""
from __future__ import annotations

import sys
from pathlib import Path
from random import Random
from typing import Dict, Sequence

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / 'src/graph_fleet_manager/test'))

from fleet_run import Delays, FleetRun  # noqa: E402

from graph_fleet_manager.fleet import RobotType  # noqa: E402
from graph_fleet_manager.planning.planner import FleetPlanner  # noqa: E402
from graph_fleet_manager.planning.road_network import RoadNetwork  # noqa: E402
from trajectory_graph import Graph, load_graph, split_edges  # noqa: E402

DOCK = 16
STATIONS = (6, 18, 27, 39, 52, DOCK)
PARKING = (8, 10, 14, 32, 33, 35, 41, 18, 27, 39, 52, 6, DOCK)  # the largest well-formed set
# The first vertices of `parking` are the starts of the robots. At edge speeds an AGV drives as fast
# as the edge allows.
AGV = RobotType('agv', 0.43, 10.0, docks=frozenset((DOCK,)))
LD90 = RobotType('ld90', 0.43, 1.35, 0.25, False, docks=frozenset((DOCK,)))
DELAYS = Delays()


def at_work(graph: Graph, kind: RobotType, starts: Sequence[int], goals: Sequence[int],
            parking: Sequence[int], clearance: float, seed: int, seconds: float,
            rounds: int, time_limit: float) -> FleetRun:
    """Runs the fleet for the given number of simulated seconds; each mission is one goal, drawn
    evenly.
    """
    planner = FleetPlanner(RoadNetwork(graph), clearance, [kind], parking, seed=seed)
    planner.prepare()
    robots: Dict[str, tuple] = {f'r{k}': (kind, start) for k, start in enumerate(starts)}

    def next_mission(random: Random, at: int) -> Sequence[int]:
        return (random.choice([goal for goal in goals if goal != at]),)
    run = FleetRun(planner, robots, next_mission, DELAYS, seed, rounds, time_limit)
    run.run(seconds)
    return run


def in_the_laboratory(robots: int, longest: float, kind: RobotType, seed: int,
                      seconds: float = 3600.0, rounds: int = 100) -> FleetRun:
    """An hour on the example laboratory's graph, with its edges cut at `longest` m."""
    graph = split_edges(load_graph(ROOT / 'maps/lab_graph.yaml'), longest)
    return at_work(graph, kind, PARKING[:robots], STATIONS, PARKING, 0.1, seed, seconds, rounds,
                   time_limit=2.0)
