"""The command `plan_fleet`: makes one plan, without a ROS master.

Exit status 0: solved; 2: not solved, the output gives the reason; 1: wrong input, with one sentence
on stderr.
"""
from __future__ import annotations

import argparse
import math
import sys
import time
from math import inf
from typing import Dict, Mapping, NoReturn, Optional, Sequence, Tuple

from fleet_core.files.errors import FileError
from fleet_core.files.fleet_file import load_fleet
from fleet_core.files.missions_file import load_missions
from fleet_core.files.plan_file import save_plan, solved_plan, unsolved_plan
from fleet_core.fleet import Fleet
from fleet_core.geometry.exclusions import OutOfTime
from fleet_core.planning.explanation import why_apart
from fleet_core.planning.layers import layered
from fleet_core.planning.planner import FleetPlanner
from fleet_core.planning.road_network import RoadNetwork
from fleet_core.planning.safe_intervals import find_path
from fleet_core.planning.tasks import Task
from trajectory_graph import GraphError, load_graph


class WrongInput(Exception):
    """The input cannot be planned. The text is one sentence that says why and what to do."""


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        self.exit(1, f'{self.prog}: {message}; see {self.prog} --help.\n')


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Runs the command; returns its exit status."""
    options = _parser().parse_args(arguments)
    try:
        network, fleet, missions = _read(options)
        begun = time.monotonic()
        plan = _plan(network, fleet, missions, begun, options)
        save_plan(plan, options.output)
    except (GraphError, FileError, WrongInput) as error:
        print(error, file=sys.stderr)
        return 1
    except OSError as error:
        print(f'{options.output} cannot be written: {error.strerror}.', file=sys.stderr)
        return 1
    if not plan['solved']:
        print(f'Not solved: {plan["reason"]}.', file=sys.stderr)
        return 2
    print(f'{options.output}: sum of costs {plan["sum_of_costs"]:.1f} s (lower bound '
          f'{plan["lower_bound"]:.1f} s), makespan {plan["makespan"]:.1f} s, planned in '
          f'{plan["planning_time"]:.3f} s.')
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(prog='plan_fleet',
                     description='Plans the paths of a fleet once, without conflicts even if '
                                 'robots are late, and writes them as JSON.')
    parser.add_argument('--graph', required=True, help='trajectory graph (YAML)')
    parser.add_argument('--fleet', required=True, help='robot types and robots (YAML)')
    parser.add_argument('--missions', required=True, help='vertices for each robot (YAML)')
    parser.add_argument('--time-limit', required=True, type=_seconds, metavar='S',
                        help='s for planning, after the files are read; all of it is used to '
                             'improve the plan, unless it cannot be improved')
    parser.add_argument('--output', required=True, help='plan (JSON)')
    parser.add_argument('--seed', type=int, default=0, help='seed of all random numbers (0)')
    parser.add_argument('--rounds', type=int, metavar='N',
                        help='number of attempts to improve the plan, so that it is the same on '
                             'every machine; without it: until the time limit')
    parser.add_argument('--search', choices=('safe_intervals', 'layers'), default='safe_intervals',
                        help='the search for the path of one robot (safe_intervals)')
    parser.add_argument('--layer-length', type=_seconds, default=1.0, metavar='S',
                        help='s between two layers (1)')
    return parser


def _seconds(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 < value < inf:
        raise argparse.ArgumentTypeError(f'{text!r} is not a time above 0 s')
    return value


def _read(options: argparse.Namespace) -> Tuple[RoadNetwork, Fleet, Dict[str, Tuple[int, ...]]]:
    graph = load_graph(options.graph)
    fleet, missions = load_fleet(options.fleet), load_missions(options.missions)
    robots = {robot.name: robot for robot in fleet.robots}
    for robot in fleet.robots:
        if robot.vertex not in graph.vertices:
            raise WrongInput(f'{options.fleet}: robot {robot.name} stands on vertex '
                             f'{robot.vertex}, which the graph does not have; choose another.')
    for name, vertices in missions.items():
        if name not in robots:
            raise WrongInput(f'{options.missions}: there is no robot {name}; name one of '
                             f'{options.fleet}.')
        for vertex in vertices:
            if vertex not in graph.vertices:
                raise WrongInput(f'{options.missions}: robot {name} is to visit vertex {vertex}, '
                                 'which the graph does not have; choose another.')
            if graph.vertices[vertex].dock and not robots[name].type.may_dock(vertex):
                raise WrongInput(f'{options.missions}: robots of type {robots[name].type.name} do '
                                 f'not use dock {vertex}; send {name} elsewhere.')
    return RoadNetwork(graph, (), fleet.dock_approach), fleet, missions


def _plan(network: RoadNetwork, fleet: Fleet, missions: Mapping[str, Tuple[int, ...]],
          begun: float, options: argparse.Namespace) -> Dict:
    deadline = begun + options.time_limit
    search = find_path if options.search == 'safe_intervals' else layered(options.layer_length)
    planner = FleetPlanner(network, fleet.clearance, [robot.type for robot in fleet.robots],
                           search=search, seed=options.seed)
    lower_bound = _check_reachable(network, fleet, missions)
    geometry = 0.0

    def unsolved(reason: str) -> Dict:
        return unsolved_plan(reason, lower_bound, [robot.name for robot in fleet.robots],
                             time.monotonic() - begun, geometry)

    network.exclusions.deadline = deadline
    before = time.monotonic()
    try:
        planner.prepare()
    except OutOfTime:
        geometry = time.monotonic() - before
        return unsolved(f'the conflict sets were not known within {options.time_limit} s')
    geometry = time.monotonic() - before
    _check_ends(planner, fleet, missions)
    tasks = [Task(robot.name, robot.type, robot.vertex, destinations=missions.get(robot.name, ()),
                  stays=True) for robot in fleet.robots]
    outcome = planner.plan(tasks, deadline=deadline, rounds=options.rounds)
    if outcome.unserved:
        name, why = next(iter(outcome.unserved.items()))
        return unsolved(f'{name}: {why}')
    return solved_plan(outcome, time.monotonic() - begun, geometry)


def _check_reachable(network: RoadNetwork, fleet: Fleet,
                     missions: Mapping[str, Tuple[int, ...]]) -> float:
    """Returns the sum of the times (s) that the robots need if each one is alone on the graph.

    Raises WrongInput if a vertex cannot be reached.
    """
    total = 0.0
    for robot in fleet.robots:
        at = robot.vertex
        for vertex in missions.get(robot.name, ()):
            times = network.paths_to(robot.type, (network.index[vertex],))[0]
            seconds = float(times[network.index[at]])
            if seconds == inf:
                why = why_apart(network, robot.type, (network.index[at],), network.index[vertex])
                raise WrongInput(f'Robot {robot.name}: vertex {vertex} cannot be reached from '
                                 f'vertex {at}{why}. Change the graph, or choose another vertex.')
            total += seconds
            at = vertex
    return total


def _check_ends(planner: FleetPlanner, fleet: Fleet,
                missions: Mapping[str, Tuple[int, ...]]) -> None:
    """Raises WrongInput if the start vertices, or the last vertices, are too near each other."""
    starts = [(robot.name, robot.type, robot.vertex) for robot in fleet.robots]
    ends = [(robot.name, robot.type, missions[robot.name][-1]) for robot in fleet.robots
            if missions.get(robot.name)]
    for places, verb, cure in ((starts, 'stand', 'place'), (ends, 'end', 'send')):
        pair = planner.too_near(places)
        if pair is not None:
            (one, _, vertex), (other, _, other_vertex) = pair
            where = (f'on vertex {vertex}' if vertex == other_vertex
                     else f'on vertices {vertex} and {other_vertex}, too near each other')
            raise WrongInput(f'Robots {one} and {other} cannot both {verb} {where}; '
                             f'{cure} one of them elsewhere.')
    if not planner.can_park(ends, [place for place in starts if not missions.get(place[0])]):
        raise WrongInput('There are more robots than can park on this graph; take some out, or '
                         'give it more vertices.')
