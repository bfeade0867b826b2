"""Runs a rival in its own virtual environment: instances as JSON on stdin, paths on stdout.

Input: {"edges": [[a, b], ...], "instances": [{"starts": [...], "goals": [...]}], "solver": name,
"limit": seconds}. Output: for each instance [seconds, paths or null], a path being the vertex of
one robot at each step.
"""
import json
import signal
import sys
import time


class TooLong(Exception):
    """The time for an instance is over."""


def pymapf_solver(name, edges):
    """LaCAM and PIBT of pymapf, pure Python."""
    import pymapf
    graph = pymapf.ExplicitGraph.undirected([tuple(edge) for edge in edges])

    def solve(starts, goals):
        agents = [pymapf.Agent(str(k), *ends) for k, ends in enumerate(zip(starts, goals))]
        solution = pymapf.solve(pymapf.MAPFProblem(graph, agents), name)
        return solution and [solution.paths[str(k)] for k in range(len(agents))]
    return solve


def w9_solver(name, edges):
    """HCA* and CBS of w9-pathfinding, C++."""
    from w9_pathfinding.envs import Graph
    from w9_pathfinding.mapf import CBS, HCAStar
    vertices = max(map(max, edges)) + 1
    graph = Graph(vertices, [[a, b, 1.0] for a, b in edges] + [[b, a, 1.0] for a, b in edges])
    finder = {'hca': HCAStar, 'cbs': CBS}[name](graph)

    def solve(starts, goals):
        paths = finder.mapf(starts, goals)
        return paths if paths and all(paths) else None
    return solve


def main():
    """Solves what stdin asks for."""
    asked = json.load(sys.stdin)
    package, name = asked['solver'].split('/')
    solve = {'pymapf': pymapf_solver, 'w9': w9_solver}[package](name, asked['edges'])

    def stop(*_):
        raise TooLong
    signal.signal(signal.SIGALRM, stop)
    results = []
    for instance in asked['instances']:
        begun = time.perf_counter()
        signal.setitimer(signal.ITIMER_REAL, asked['limit'])
        try:
            paths = solve(instance['starts'], instance['goals'])
        except TooLong:
            paths = None
        except Exception as error:  # a rival's own way to say that it found nothing
            print(f'{asked["solver"]}: {type(error).__name__}: {error}', file=sys.stderr)
            paths = None
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        results.append([time.perf_counter() - begun, paths])
    json.dump(results, sys.stdout)


if __name__ == '__main__':
    main()
