"""Checks whether an answer of the planner is a plan for the question.

An answer is a message that any program can send. It is used only if

- each robot, edge and drive in it exists,
- the drives of a robot follow each other and begin at its place, and
- no robots wait for each other for ever.

The interlocking decides whether two robots may be at the places of the plan.
"""
from __future__ import annotations

from typing import Dict, List, Optional, Sequence

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from fleet_core.planning.precedence import Constraint
from fleet_core.planning.tasks import PlanningOutcome, Task
from trajectory_graph import Graph
from trajectory_graph.drawn_names import edge_name

_SHOWN = 40  # maximum number of characters that are shown of an unknown name


def fault_of(outcome: PlanningOutcome, tasks: Sequence[Task], graph: Graph) -> str:
    """Returns the first fault, as the end of a sentence about the plan; empty: there is none."""
    asked = {task.name for task in tasks}
    for name in (*outcome.drives, *outcome.unserved):
        if name not in asked:
            return f'names robot {name[:_SHOWN]!r}, which the question does not have'
    for task in tasks:
        edges = [drive.edge for drive in outcome.drives.get(task.name, ())]
        fault = _fault_of_drives(task, edges, graph)
        if fault:
            return fault
        if task.name not in outcome.unserved and not _leads_over(task, edges, graph):
            return f'does not lead {task.name} to its destinations'
    for constraint in outcome.precedence:
        if not _is_possible(constraint, outcome):
            return (f'has an impossible order: drive {constraint.drive} of '
                    f'{constraint.then[:_SHOWN]!r} waits for fraction {constraint.fraction:g} of '
                    f'drive {constraint.before} of {constraint.first[:_SHOWN]!r}')
    waiting = _ring(outcome)
    return f'lets {waiting[0]} wait for itself' if waiting else ''


def _fault_of_drives(task: Task, edges: Sequence[int], graph: Graph) -> str:
    """Returns a fault unless each edge exists and begins where the previous edge ends."""
    name, known = task.name, graph.edges
    place: Optional[int] = None
    for number, edge in enumerate(edges):
        found = known.get(abs(edge))
        if found is None:
            return f'leads {name} over edge {abs(edge)}, which the graph does not have'
        start, end = (found.origin, found.destination)[::1 if edge > 0 else -1]
        if start != place and place is not None:
            return (f'leads {name} from {edge_name(graph, edges[number - 1])} to '
                    f'{edge_name(graph, edge)}, which do not meet')
        place = end
    if not edges or not all(abs(edge) in known for edge in task.released):
        return ''
    if task.released:
        begins_right = tuple(edges[:len(task.released)]) == task.released
    elif task.mid_edge is not None:
        begins_right = abs(edges[0]) == abs(task.mid_edge[0])
    else:
        begins_right = graph.start_vertex(edges[0]).id == task.vertex
    return ('' if begins_right else
            f'leads {name} over {edge_name(graph, edges[0])} first, but {name} is elsewhere')


def _leads_over(task: Task, edges: Sequence[int], graph: Graph) -> bool:
    """Returns whether the drives visit all destinations in order.

    The robot may have completed some released drives already.
    """
    left, known = list(task.destinations), graph.edges
    vertices = [known[abs(edge)].destination if edge > 0 else known[-edge].origin
                for edge in edges] if left else []
    for vertex in ((task.vertex,) if task.vertex is not None else ()) + tuple(vertices):
        while left and left[0] == vertex:
            del left[0]
    return not left


def _is_possible(constraint: Constraint, outcome: PlanningOutcome) -> bool:
    """Returns whether both drives exist, and the fraction is a number from 0 to 1."""
    return (0 <= constraint.before < len(outcome.drives.get(constraint.first, ()))
            and 0 <= constraint.drive < len(outcome.drives.get(constraint.then, ()))
            and 0.0 <= constraint.fraction <= 1.0)


def _ring(outcome: PlanningOutcome) -> List[str]:
    """Returns robots that would wait for each other for ever.

    A drive may begin when the drive before it, and all drives for which it waits, have begun. A
    wait for fraction 0 of a drive is a wait for the previous drive.
    """
    first_node: Dict[str, int] = {}
    robots: List[str] = []
    for name, drives in outcome.drives.items():
        first_node[name] = len(robots)
        robots += [name] * len(drives)
    before, behind = [], []
    for first, number, fraction, then, drive in outcome.precedence:
        begun = number if fraction > 0.0 else number - 1
        if begun >= 0:
            before.append(first_node[first] + begun)
            behind.append(first_node[then] + drive)
    for name, drives in outcome.drives.items():
        nodes = range(first_node[name], first_node[name] + len(drives))
        before += nodes[:-1]
        behind += nodes[1:]
    if not before:
        return []
    # a ring is a strongly connected part of more than one node, or a node that precedes itself
    count = len(robots)
    arcs = coo_matrix((np.ones(len(before)), (before, behind)), shape=(count, count))
    _, part = connected_components(arcs, connection='strong')
    is_in_ring = np.bincount(part, minlength=1)[part] > 1
    alone = [node for node, later in zip(before, behind) if node == later]
    return sorted({robots[node] for node in (*np.flatnonzero(is_in_ring), *alone)})
