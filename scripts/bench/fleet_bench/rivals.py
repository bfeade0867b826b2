"""Runs other planners on the same instances, and checks whether robots can drive their plans.

The rivals use vertices, edges, and steps of equal length. None of them accepts conflict sets,
durations, sizes or delays. So this module puts their moves into an order: at each step a robot
leaves a vertex before another robot enters the vertex. If robots follow each other in a ring, there
is no such order. Then the module computes the times according to our own rules, and the checker
decides whether the result is safe.
"""
from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Dict, List, NamedTuple, Optional, Sequence, Tuple

from fleet_builders import as_files
from plan_checker import World, faults

from fleet_bench.instances import AGV, CLEARANCE, Instance
from fleet_core.planning.plans import makespan, sum_of_costs
from fleet_core.planning.precedence import Conflicting, precedence
from fleet_core.planning.problem import Problem
from fleet_core.planning.reservation_table import ReservationTable
from fleet_core.planning.road_network import RoadNetwork
from fleet_core.planning.schedule import schedule
from trajectory_graph import Graph

ROOT = Path(__file__).resolve().parents[3]
PACKAGES = {'pymapf': 'pymapf==0.9.0', 'w9': 'w9-pathfinding==0.1.3'}
SOLVERS = ('pymapf/lacam', 'pymapf/pibt', 'w9/hca', 'w9/cbs')


class Judged(NamedTuple):
    """The result for one instance."""

    seconds: float
    solved: bool
    """Whether a plan was found in time."""
    ratio: Optional[float]
    """The plan's cost, with true durations, divided by the lower bound; None: the plan is not safe.
    """


def environment(package: str) -> Tuple[Optional[Path], str]:
    """Returns the Python of a virtual environment with a rival, or the reason why there is none."""
    folder = ROOT / 'build/rivals' / package
    python = folder / 'bin/python'
    if sys.version_info < (3, 10):
        return None, 'it needs Python 3.10'
    try:
        if not python.exists():
            subprocess.run([sys.executable, '-m', 'venv', str(folder)], check=True,
                           capture_output=True)
        subprocess.run([str(python), '-m', 'pip', 'install', '-q', PACKAGES[package]], check=True,
                       capture_output=True, timeout=600)
    except subprocess.TimeoutExpired:
        return None, 'its installation took more than 10 minutes'
    except subprocess.CalledProcessError as error:
        said = error.stderr.decode(errors='replace').strip().splitlines()
        return None, f'it could not be installed ({said[-1][:90] if said else "offline?"})'
    return python, ''


def run(solver: str, python: Path, graph: Graph, instances: Sequence[Instance],
        limit: float) -> List[Judged]:
    """Runs a rival on all instances."""
    asked = {'solver': solver, 'limit': limit,
             'edges': [[e.origin, e.destination] for e in graph.edges.values()],
             'instances': [{'starts': list(i.starts.values()), 'goals': list(i.goals.values())}
                           for i in instances]}
    worker = Path(__file__).with_name('rival_worker.py')
    answer = json.loads(subprocess.run([str(python), str(worker)], input=json.dumps(asked),
                                       stdout=subprocess.PIPE, text=True, check=True).stdout)
    return [Judged(seconds, paths is not None, paths and driven(graph, instance, paths))
            for instance, (seconds, paths) in zip(instances, answer)]


def driven(graph: Graph, instance: Instance, paths: Sequence[Sequence[int]]) -> Optional[float]:
    """Returns the cost of these moves, with true sizes, curves and durations, divided by the lower
    bound; None if no order makes them safe.
    """
    order = _in_order(graph, instance, paths)
    if order is None:
        return None
    network = RoadNetwork(graph)
    reservations = ReservationTable(network, CLEARANCE, [AGV])
    agents = Problem(reservations, instance.tasks(), ()).agents
    plans = schedule(reservations, agents, order)
    try:
        constraints = precedence(reservations, plans, dict.fromkeys(plans, AGV))
    except Conflicting:
        return None
    bound = sum(agent.query.lower_bound for agent in agents.values())
    costs = sum_of_costs(plans)
    plan = {'sum_of_costs': costs, 'makespan': makespan(plans), 'lower_bound': bound,
            'robots': {name: [{'edge': network.signed_id(d.drive), 'start': d.start, 'end': d.end}
                              for d in drives] for name, drives in plans.items()},
            'precedence': [list(constraint) for constraint in constraints]}
    return None if faults(world_of(graph, instance), plan) else costs / bound


def _in_order(graph: Graph, instance: Instance,
              paths: Sequence[Sequence[int]]) -> Optional[List[Tuple[str, int]]]:
    """Returns pairs (robot, drive) in a possible order; None if robots follow each other in a ring.
    """
    drives: Dict[Tuple[int, int], int] = {}
    for k, edge in enumerate(graph.edges.values()):
        drives[edge.origin, edge.destination] = 2 * k
        drives[edge.destination, edge.origin] = 2 * k + 1
    names = list(instance.starts)
    order = []
    for step in range(max(map(len, paths)) - 1):
        moves = {name: (path[step], path[step + 1]) for name, path in zip(names, paths)
                 if step + 1 < len(path) and path[step] != path[step + 1]}
        while moves:
            leaving = {move[0] for move in moves.values()}
            free = [name for name, move in moves.items() if move[1] not in leaving]
            if not free:
                return None
            for name in free:
                order.append((name, drives[moves.pop(name)]))
    return order


def world_of(graph: Graph, instance: Instance) -> World:
    """Returns an instance in the form that the checker uses."""
    return World(*as_files(graph, [AGV], {name: (AGV.name, vertex)
                                          for name, vertex in instance.starts.items()},
                           {name: [goal] for name, goal in instance.goals.items()}, CLEARANCE))
