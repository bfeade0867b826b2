"""Runs a rival in its own virtual environment: instances as JSON on stdin, paths on stdout.

A rival in C++ cannot be stopped. So a result that it finds after the time limit does not count.

Input: {"edges": [[a, b], ...], "instances": [{"starts": [...], "goals": [...]}], "solver": name,
"limit": seconds}. Output: for each instance [seconds, paths or null]; a path lists the vertex of
one robot at each step.
"""
from __future__ import annotations

import json
import signal
import sys
import time
from typing import Any, Callable, List, Sequence, Tuple

Edges = Sequence[Tuple[int, int]]
Paths = Any
"""The vertices of each robot, step by step; empty: no paths were found."""
Solver = Callable[[List[int], List[int]], Paths]
"""A function that gets starts and goals, and returns paths."""


class TooLong(Exception):
    """The time for an instance is over."""


def pymapf_solver(name: str, edges: Edges, limit: float) -> Solver:
    """Returns LaCAM or PIBT of pymapf, in pure Python: it allows one robot on a vertex, and no two
    robots may swap vertices.
    """
    import pymapf
    graph = pymapf.ExplicitGraph.undirected([tuple(edge) for edge in edges])

    def solve(starts: List[int], goals: List[int]) -> Paths:
        agents = [pymapf.Agent(str(k), *ends) for k, ends in enumerate(zip(starts, goals))]
        solution = pymapf.solve(pymapf.MAPFProblem(graph, agents), name, time_limit=limit)
        return solution and [solution.paths[str(k)] for k in range(len(agents))]
    return solve


def w9_solver(name: str, edges: Edges, limit: float) -> Solver:
    """Returns HCA* or CBS of w9-pathfinding, in C++: a vertex or an edge holds one robot."""
    from w9_pathfinding.envs import Graph
    from w9_pathfinding.mapf import CBS, HCAStar
    # on an undirected graph w9 would let robots swap, so each edge becomes two directed edges
    both_ways = [*edges, *(edge[::-1] for edge in edges)]
    graph = Graph(max(map(max, edges)) + 1, edges=both_ways, edge_collision=True)
    longest = {'max_length': float(len(edges))}
    if name == 'cbs':
        finder, longest['max_time'] = CBS(graph, seed=0), limit
    else:
        finder = HCAStar(graph)

    def solve(starts: List[int], goals: List[int]) -> Paths:
        return finder.mapf(starts, goals, **longest) or None
    return solve


def stopped_after(limit: float, solve: Solver, *instance: List[int]) -> Paths:
    """Runs Python code for at most `limit` s; raises TooLong after this time."""
    def stop(*_: object) -> None:
        raise TooLong
    signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, limit)
    try:
        return solve(*instance)
    finally:
        signal.signal(signal.SIGALRM, signal.SIG_IGN)
        signal.setitimer(signal.ITIMER_REAL, 0.0)


def main() -> None:
    """Solves the instances on stdin."""
    asked = json.load(sys.stdin)
    package, name = asked['solver'].split('/')
    solve = {'pymapf': pymapf_solver, 'w9': w9_solver}[package](
        name, [tuple(edge) for edge in asked['edges']], asked['limit'])

    results = []
    for instance in asked['instances']:
        begun = time.perf_counter()
        try:
            paths = stopped_after(asked['limit'], solve, instance['starts'], instance['goals'])
        except (TooLong, RuntimeError):  # if w9 finds nothing, it returns an empty list
            paths = None
        seconds = time.perf_counter() - begun
        results.append([seconds, paths if seconds <= asked['limit'] else None])
    json.dump(results, sys.stdout)


if __name__ == '__main__':
    main()
