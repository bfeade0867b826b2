"""Finds problems of one edge or vertex, and of the floor under it.

The findings depend only on the arguments of these functions. So the findings about an unchanged
element can be cached.
"""
from __future__ import annotations

import math
from typing import List, NamedTuple, Optional, Tuple

import numpy as np
from scipy import ndimage

from graph_editor.checking.findings import Finding, Severity
from graph_editor.checking.rules import CheckRules
from graph_editor.floor import Floor
from graph_editor.robot import NEARLY_STRAIGHT
from trajectory_graph import CurveType, Edge, Graph, GraphError, Vertex

STEP = 0.05  # m; distance between the checked points of a curve
GRAIN = 0.01  # m, accuracy of the floor; a corridor may be too narrow by this much


class Tightest(NamedTuple):
    """The smallest clearance along an edge (m), and its place (x, y)."""

    clearance: float
    place: Tuple[float, float]


def tightest(floor: Floor, points: np.ndarray) -> Tightest:
    """Returns the point of `points` (N,2) with the smallest clearance."""
    clearances = floor.clearance_at(points)
    worst = int(np.argmin(clearances))
    return Tightest(float(clearances[worst]), (float(points[worst][0]), float(points[worst][1])))


def check_edge(origin: Vertex, destination: Vertex, edge: Edge, floor: Optional[Floor],
               rules: CheckRules) -> List[Finding]:
    """Returns the findings about an edge."""
    middle = ((origin.x + destination.x) / 2.0, (origin.y + destination.y) / 2.0)
    try:
        graph = Graph((origin, destination), (edge,))
        points = graph.curve(edge.id).sample(STEP)
    except GraphError as error:
        return [Finding(Severity.ERROR, error.problem, 'edge', edge.id, middle)]
    findings = []
    if edge.velocity_forward == 0.0 and edge.velocity_backwards == 0.0:
        findings.append(Finding(Severity.ERROR, 'both its velocities are 0, so no robot can '
                                'drive on it', 'edge', edge.id, middle))
    if edge.curve_type is CurveType.SPLINE:
        findings += _sharp(graph, edge.id, rules)
    if floor is not None:
        findings += _narrow(floor, points, edge.id, rules)
        findings += _bent(floor, points, edge.id, rules)
    return findings


def check_vertex(vertex: Vertex, floor: Optional[Floor], rules: CheckRules) -> List[Finding]:
    """Returns the findings about the position of a vertex."""
    if floor is None:
        return []
    clearance = floor.clearance_of(vertex.position)
    if clearance < rules.robot_width / 2.0:
        return [Finding(Severity.ERROR, _too_near(clearance, rules), 'vertex', vertex.id,
                        vertex.position)]
    if clearance < rules.turning and vertex.parking:
        return [Finding(Severity.WARNING, f'a robot that parks here cannot turn: it has '
                        f'{clearance:.2f} m around it, but needs {rules.turning:.2f} m',
                        'vertex', vertex.id, vertex.position)]
    return []


def _too_near(clearance: float, rules: CheckRules) -> str:
    if clearance <= 0.0:
        return 'it is in a wall, in a forbidden area, or outside the part of the map that is used'
    return (f'an obstacle is {clearance:.2f} m from it, but half the robot is '
            f'{rules.robot_width / 2.0:.2f} m wide')


def _narrow(floor: Floor, points: np.ndarray, id: int, rules: CheckRules) -> List[Finding]:
    clearance, place = tightest(floor, points)
    if clearance < rules.robot_width / 2.0:
        return [Finding(Severity.ERROR, _too_near(clearance, rules), 'edge', id, place)]
    if clearance < rules.corridor / 2.0 - GRAIN:
        return [Finding(Severity.WARNING, f'its corridor of {rules.corridor:g} m is in a wall: '
                        f'there is room for {2.0 * clearance:.2f} m', 'edge', id, place)]
    return []


def _bent(floor: Floor, points: np.ndarray, id: int, rules: CheckRules) -> List[Finding]:
    """Returns a finding for the first part of an edge on which robots must turn but have no space
    to turn.
    """
    clearances = floor.clearance_at(points)
    narrow = clearances < rules.turning - GRAIN
    headings = np.unwrap(np.arctan2(*np.diff(points, axis=0).T[::-1]))
    stretches, count = ndimage.label(narrow[1:] & narrow[:-1])
    for stretch in range(1, count + 1):
        here = np.flatnonzero(stretches == stretch)
        turn = float(np.ptp(headings[here]))
        if turn > NEARLY_STRAIGHT and clearances[here].min() >= rules.robot_width / 2.0:
            tightest = here[int(np.argmin(clearances[here]))]
            return [Finding(Severity.WARNING, f'robots must turn by {math.degrees(turn):.0f} '
                            f'degrees along it, but have only {clearances[tightest]:.2f} m '
                            f'around them and need {rules.turning:.2f} m', 'edge', id,
                            (float(points[tightest][0]), float(points[tightest][1])))]
    return []


def _sharp(graph: Graph, id: int, rules: CheckRules) -> List[Finding]:
    """Returns a finding for the sharpest bend of a spline if a robot cannot follow it."""
    control = graph.control_points(id)
    t = np.linspace(0.0, 1.0, 65)[:, None]
    u = 1.0 - t
    first, second = 3.0 * np.diff(control, axis=0), 6.0 * np.diff(control, 2, axis=0)
    velocity = u ** 2 * first[0] + 2.0 * u * t * first[1] + t ** 2 * first[2]
    acceleration = u * second[0] + t * second[1]
    speed = np.hypot(*velocity.T)
    turning = np.abs(velocity[:, 0] * acceleration[:, 1] - velocity[:, 1] * acceleration[:, 0])
    with np.errstate(divide='ignore', invalid='ignore'):
        radii = np.where(turning > 1e-12, speed ** 3 / turning, np.inf)
    radii[speed < 1e-9] = np.inf  # an end without a handle
    backwards = (velocity[1:] * velocity[:-1]).sum(axis=1) < 0.0
    radii[1:][backwards] = 0.0
    worst = int(np.argmin(radii))
    if radii[worst] >= rules.least_radius:
        return []
    points = u ** 3 * control[0] + 3 * u ** 2 * t * control[1] + 3 * u * t ** 2 * control[2] \
        + t ** 3 * control[3]
    place = (float(points[worst][0]), float(points[worst][1]))
    return [Finding(Severity.ERROR, f'it bends with a radius of {int(100 * radii[worst]) / 100} m, '
                    f'too sharp for a robot that needs {rules.least_radius:.2f} m: make it a line, '
                    'or move its handles', 'edge', id, place)]
