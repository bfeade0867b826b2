"""Judges plans from their files alone, without any code of the planner.

The checker computes everything itself: curves from the files of the fleet, lengths by fine
sampling, distances with Shapely. It assumes that each robot can be arbitrarily late, and compares
all places that two robots can occupy at the same time if they obey the precedence. For each drive
of a robot it computes how far the other robots must have come when the drive begins. Then it checks
the distance to all places that the other robots may still occupy.
"""
from __future__ import annotations

import math
from typing import Dict, List, NamedTuple, Sequence, Tuple

import numpy as np
import yaml
from shapely.geometry import LineString, Point

SAMPLES = 400  # points on a spline: at a radius of 0.3 m, chords are within 0.01 mm of the curve
TOLERANCE = 1e-4  # m by which a distance may be short
SLACK = 1e-6  # s by which a time may be early


class World:
    """Graph, fleet and missions as plain data; each edge is a fine polyline."""

    def __init__(self, graph: dict, fleet: dict, missions: dict) -> None:
        self.vertices = {v['Id']: v for v in graph['Vertices']}
        self.edges = {e['Id']: e for e in graph['Edges']}
        self.clearance = float(fleet.get('clearance', 0.0))
        self.types = {t['name']: t for t in fleet['robot_types']}
        self.robots = {r['name']: r for r in fleet['robots']}
        self.missions = {m['robot']: m['vertices'] for m in missions['missions']}
        self.lines: Dict[int, LineString] = {}
        self._arcs: Dict[int, Tuple[np.ndarray, np.ndarray]] = {}

    @classmethod
    def load(cls, graph: str, fleet: str, missions: str) -> World:
        """Reads the three files."""
        return cls(*(yaml.safe_load(open(path)) for path in (graph, fleet, missions)))

    def line(self, signed: int) -> LineString:
        """The edge's curve in driving direction."""
        if signed not in self.lines:
            if signed < 0:
                self.lines[signed] = LineString(list(self.line(-signed).coords)[::-1])
            else:
                self.lines[signed] = LineString(self._points(self.edges[signed]))
        return self.lines[signed]

    def along(self, signed: int, share: np.ndarray) -> np.ndarray:
        """Points (N,2) at fractions (N,) of an edge's arc length."""
        if signed not in self._arcs:
            xy = np.array(self.line(signed).coords)
            self._arcs[signed] = xy, np.concatenate(
                ([0.0], np.cumsum(np.hypot(*np.diff(xy, axis=0).T))))
        xy, arc = self._arcs[signed]
        s = share * arc[-1]
        return np.column_stack((np.interp(s, arc, xy[:, 0]), np.interp(s, arc, xy[:, 1])))

    def _points(self, edge: dict) -> List[Tuple[float, float]]:
        a, b = self.vertices[edge['Origin_ID']], self.vertices[edge['Destination_ID']]
        p, s = complex(a['X'], a['Y']), complex(b['X'], b['Y'])
        if edge['CurveType'] == 'line':
            return [(p.real, p.imag), (s.real, s.imag)]
        q = p + edge['ParamF'] * complex(math.cos(a['Theta']), math.sin(a['Theta']))
        r = s - edge['ParamB'] * complex(math.cos(b['Theta']), math.sin(b['Theta']))
        points = []
        for k in range(SAMPLES + 1):
            t = k / SAMPLES
            one, two, three = p + t * (q - p), q + t * (r - q), r + t * (s - r)
            one, two = one + t * (two - one), two + t * (three - two)
            z = one + t * (two - one)
            points.append((z.real, z.imag))
        return points

    def ends(self, signed: int) -> Tuple[int, int]:
        """The first and last vertex in driving direction."""
        edge = self.edges[abs(signed)]
        ends = edge['Origin_ID'], edge['Destination_ID']
        return ends if signed > 0 else ends[::-1]

    def speed(self, robot: str, signed: int) -> float:
        """The speed in m/s; 0 if the edge may not be driven in this direction."""
        edge, kind = self.edges[abs(signed)], self.types[self.robots[robot]['type']]
        own = edge['VelocityForward'] if signed > 0 else edge['VelocityBackwards']
        if own == 0:
            return 0.0
        return min(own, kind['speed']) if kind.get('obeys_edge_speed', True) else kind['speed']

    def apart(self, a: str, b: str) -> float:
        """The distance (m) that the curves of two robots must keep."""
        kinds = [self.types[self.robots[name]['type']] for name in (a, b)]
        return self.clearance + sum(k['radius'] + k.get('play', 0.0) for k in kinds)

    def start(self, robot: str) -> Point:
        """The first place of a robot: a vertex, or a fraction of a signed edge."""
        given = self.robots[robot]
        if 'edge' in given:
            return Point(self.along(given['edge'], np.array([given['fraction']]))[0])
        return self.at(given['vertex'])

    def at(self, vertex: int) -> Point:
        """A vertex as a point."""
        return Point(self.vertices[vertex]['X'], self.vertices[vertex]['Y'])

    def begun(self, robot: str, number: int, signed: int) -> float:
        """The fraction of the edge that lies behind the robot before it begins this drive."""
        given = self.robots[robot]
        if number or 'edge' not in given:
            return 0.0
        return given['fraction'] if signed == given['edge'] else 1.0 - given['fraction']


class Held(NamedTuple):
    """The places that a robot may occupy during drive `index`; -1: before its first drive."""

    index: int
    shape: object


def faults(world: World, plan: dict) -> List[str]:
    """All faults of a solved plan; an empty list if there is none."""
    found = structure_faults(world, plan)
    if found:
        return found
    found += time_faults(world, plan)
    order = Order(plan)
    if order.cyclic:
        return [*found, 'the precedence has a cycle']
    return found + held_faults(world, plan, order) + nominal_faults(world, plan)


def structure_faults(world: World, plan: dict) -> List[str]:
    """Broken routes, forbidden directions, unvisited destinations, wrong sums."""
    found: List[str] = []
    if set(plan['robots']) != set(world.robots):
        return [f'robots are {sorted(plan["robots"])}']
    ends = []
    for name, drives in plan['robots'].items():
        at = world.robots[name].get('vertex')
        wanted = list(world.missions.get(name, ()))
        while wanted and wanted[0] == at:
            wanted.pop(0)
        for k, drive in enumerate(drives):
            if abs(drive['edge']) not in world.edges:
                return [f'{name} drives edge {drive["edge"]}, which does not exist']
            begin, end = world.ends(drive['edge'])
            if k == 0 and at is None:
                if abs(drive['edge']) != abs(world.robots[name]['edge']):
                    found.append(f'{name} is not on edge {drive["edge"]}')
            elif begin != at:
                found.append(f'{name} is at vertex {at}, but drive {k} begins at {begin}')
            at = end
            while wanted and wanted[0] == at:
                wanted.pop(0)
        if wanted:
            found.append(f'{name} does not visit {wanted}')
        if world.missions.get(name) and at != world.missions[name][-1]:
            found.append(f'{name} ends at vertex {at}')
        ends.append(drives[-1]['end'] if drives else 0.0)
    found += sum_faults(plan, ends)
    for a, i, f, b, j in plan['precedence']:
        if a == b or not 0.0 <= f <= 1.0 or not 0 <= i < len(plan['robots'][a]) \
                or not 0 <= j < len(plan['robots'][b]):
            found.append(f'precedence {[a, i, f, b, j]} makes no sense')
    return found


def sum_faults(plan: dict, ends: Sequence[float]) -> List[str]:
    """Sums in a plan that do not agree with the times at which its robots finish."""
    found: List[str] = []
    if abs(plan['sum_of_costs'] - sum(ends)) > 1e-6 * (1 + sum(ends)):
        found.append(f'sum_of_costs is {plan["sum_of_costs"]}, not {sum(ends)}')
    if abs(plan['makespan'] - max(ends, default=0.0)) > 1e-6 * (1 + max(ends, default=0.0)):
        found.append(f'makespan is {plan["makespan"]}')
    if plan['lower_bound'] > plan['sum_of_costs'] * (1 + 1e-9) + 1e-9:
        found.append('the lower bound is above the cost')
    return found


def time_faults(world: World, plan: dict) -> List[str]:
    """Drives that are too fast or overlap, and times that break the precedence."""
    found: List[str] = []
    for name, drives in plan['robots'].items():
        now = 0.0
        for k, drive in enumerate(drives):
            speed = world.speed(name, drive['edge'])
            if speed == 0.0:
                found.append(f'{name} drives edge {drive["edge"]}, which is forbidden')
                continue
            seconds = (world.line(drive['edge']).length / speed
                       * (1.0 - world.begun(name, k, drive['edge'])))
            if drive['end'] - drive['start'] < seconds * (1 - 1e-9) - SLACK:
                found.append(f'{name} drives {k} in {drive["end"] - drive["start"]} s, '
                             f'not {seconds} s')
            if drive['start'] < now - SLACK:
                found.append(f'{name} begins drive {k} before it has arrived')
            now = drive['end']
    for a, i, f, b, j in plan['precedence']:
        before, after = plan['robots'][a][i], plan['robots'][b][j]
        begun = world.begun(a, i, before['edge'])
        share = max(f - begun, 0.0) / (1.0 - begun)
        if after['start'] < before['start'] + share * (before['end'] - before['start']) - SLACK:
            found.append(f'{b} begins drive {j} at {after["start"]} s, before {a} is through '
                         f'{f} of drive {i}')
    return found


class Order:
    """For each drive: how far the other robots must have come when the drive begins."""

    def __init__(self, plan: dict) -> None:
        self.names = list(plan['robots'])
        self.index = {name: k for k, name in enumerate(self.names)}
        self.cyclic = False
        needs: Dict[Tuple[str, int], List[Tuple[str, int, float]]] = {}
        for a, i, f, b, j in plan['precedence']:
            needs.setdefault((b, j), []).append((a, i, f))
        self._needs = needs
        self._lengths = {name: len(drives) for name, drives in plan['robots'].items()}
        self.reached: Dict[Tuple[str, int], Dict[str, Tuple[int, float]]] = {}
        state: Dict[Tuple[str, int], int] = {}
        for name in self.names:
            for j in range(self._lengths[name]):
                self._work_out((name, j), state)

    def _work_out(self, root: Tuple[str, int], state: Dict[Tuple[str, int], int]) -> None:
        """Computes `reached` by a depth-first search; `state` of a drive: 1: begun, 2: done."""
        stack = [root]
        while stack:
            node = stack[-1]
            if state.get(node) == 2:
                stack.pop()
                continue
            before = [(a, i) for a, i, _ in self._needs.get(node, ())]
            if node[1]:
                before.append((node[0], node[1] - 1))
            if state.get(node) is None:
                state[node] = 1
                open_ones = [n for n in before if state.get(n) != 2]
                if any(state.get(n) == 1 for n in open_ones):
                    self.cyclic = True
                    state[node] = 2
                    self.reached[node] = {}
                    stack.pop()
                    continue
                if open_ones:
                    stack += open_ones
                    continue
            state[node] = 2
            stack.pop()
            reached: Dict[str, Tuple[int, float]] = {}
            for n in before:
                for name, progress in self.reached.get(n, {}).items():
                    reached[name] = max(reached.get(name, (-1, 1.0)), progress)
            for a, i, f in self._needs.get(node, ()):
                reached[a] = max(reached.get(a, (-1, 1.0)), (i, f))
            self.reached[node] = reached

    def at_least(self, other: str, name: str, drive: int) -> Tuple[int, float]:
        """How far (drive, fraction) robot `other` must have come when `name` begins `drive`."""
        if drive < 0:
            return (-1, 0.0)
        return self.reached[name, drive].get(other, (-1, 0.0))


def held_faults(world: World, plan: dict, order: Order) -> List[str]:
    """Pairs of places that are too near to each other, but may be occupied at the same time."""
    found: List[str] = []
    names = order.names
    boxes = {name: np.array([_shape(world, plan, name, k).bounds
                             for k in range(-1, len(plan['robots'][name]))]) for name in names}
    for x, a in enumerate(names):
        for b in names[x + 1:]:
            apart = world.apart(a, b)
            gaps = np.maximum(boxes[a][:, None, :2] - boxes[b][None, :, 2:],
                              boxes[b][None, :, :2] - boxes[a][:, None, 2:]).max(axis=2)
            for i, j in (np.argwhere(gaps <= apart) - 1).tolist():
                # When b is at drive j, a has reached at least `least_a`, and vice versa.
                least_a, least_b = order.at_least(a, b, j), order.at_least(b, a, i)
                if least_a[0] > i or least_b[0] > j:
                    continue
                rest_a = _shape(world, plan, a, i, least_a[1] if least_a[0] == i else 0.0)
                rest_b = _shape(world, plan, b, j, least_b[1] if least_b[0] == j else 0.0)
                distance = rest_a.distance(rest_b)
                if distance < apart - TOLERANCE:
                    found.append(f'{a} at drive {i} and {b} at drive {j} may come within '
                                 f'{distance:.4f} m of each other, not {apart:.4f}')
    return found


def _shape(world: World, plan: dict, name: str, k: int, fraction: float = 0.0):
    """The part of a drive that a robot may occupy when it has passed at least this fraction."""
    if k < 0:
        return world.start(name)
    edge = plan['robots'][name][k]['edge']
    shape, fraction = world.line(edge), max(fraction, world.begun(name, k, edge))
    if fraction <= 0.0:
        return shape
    xy = np.array(shape.coords)
    arc = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(xy, axis=0).T))))
    s = fraction * arc[-1]
    if s >= arc[-1]:
        return Point(xy[-1])
    return LineString([[np.interp(s, arc, xy[:, 0]), np.interp(s, arc, xy[:, 1])], *xy[arc > s]])


def nominal_faults(world: World, plan: dict, step: float = 0.1) -> List[str]:
    """Robots that come too near to each other although all are on time; checked every `step` s."""
    names = list(plan['robots'])
    if not names:
        return []
    times = np.arange(0.0, plan['makespan'] + step, step)
    records = np.array([_trajectory(world, plan, name, times) for name in names])
    found = []
    for x, a in enumerate(names):
        for y in range(x + 1, len(names)):
            gaps = np.hypot(*(records[x] - records[y]).T)
            if gaps.min() < world.apart(a, names[y]) - TOLERANCE:
                at = times[int(gaps.argmin())]
                found.append(f'{a} and {names[y]} are {gaps.min():.4f} m apart at {at:.1f} s')
    return found


def _trajectory(world: World, plan: dict, name: str, times: np.ndarray) -> np.ndarray:
    """The position of a robot at each time (T,2), in m."""
    point = world.start(name)
    places = np.tile((point.x, point.y), (len(times), 1))
    for k, drive in enumerate(plan['robots'][name]):
        begun = world.begun(name, k, drive['edge'])
        later = times >= drive['start']
        share = (times[later] - drive['start']) / (drive['end'] - drive['start'])
        places[later] = world.along(drive['edge'],
                                    begun + (1.0 - begun) * np.clip(share, 0.0, 1.0))
    return places
