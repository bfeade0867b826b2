#!/usr/bin/env python3
"""Makes a graph, a work file and a fleet file from a plant model of openTCS (XML, version 6 or 7).

    examples/graph_from_opentcs.py model.xml --into build/my_site

Points become vertices, paths edges, locations stations, and vehicles robots. The program prints
each thing that a person must do. It writes into a new folder only, and changes no file.
docs/how-to/from_opentcs.md explains the mapping. It needs no ROS.
"""
from __future__ import annotations

import argparse
import math
import re
import sys
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Dict, List, Optional, Set, Tuple

import yaml

from trajectory_graph import CurveType, Edge, Graph, GraphError, Vertex, save_graph

Position = Tuple[float, float]
SECTIONS = 4  # number of straight edges that replace a Bézier curve
CLEARANCE = 0.1  # m between any two robots
DEVICE_TIME = 20  # timeout of a device, s
CHARGE = 'charge'  # an operation whose name contains this word charges


class NoPlantModel(Exception):
    """The file is not a plant model that this program reads. The text says why."""


@dataclass(frozen=True)
class Site:
    """The plant in the form of this workspace's files, and the tasks that are left to a person."""

    graph: Graph
    work: Dict[str, List[object]]
    fleet: Dict[str, object]
    to_do: Tuple[str, ...]


def metres(element: ElementTree.Element, key: str) -> float:
    """Returns a length in m. The model has it in mm."""
    return float(element.get(key, '0')) / 1000.0


def ros_name(name: str) -> str:
    """Returns a name that ROS accepts."""
    return re.sub(r'\W', '_', name.lower(), flags=re.ASCII)


def drawn_through(path: ElementTree.Element, ends: Tuple[Position, Position],
                  scale: Position) -> List[Position]:
    """Returns the places through which the path is drawn, without its ends.

    The layout has pixels, with y downwards. `scale` is the size of a pixel, in mm.
    """
    layout = path.find('pathLayout')
    if layout is None or layout.get('connectionType') in ('DIRECT', 'ELBOW', 'SLANTED'):
        return []
    points = [(float(point.get('x', '0')) * scale[0] / 1000.0,
               -float(point.get('y', '0')) * scale[1] / 1000.0)
              for point in layout.findall('controlPoint')]
    if layout.get('connectionType') != 'BEZIER' or len(points) != 2:
        return points
    corners = (ends[0], *points, ends[1])
    return [on_curve(corners, step / SECTIONS) for step in range(1, SECTIONS)]


def on_curve(corners: Tuple[Position, ...], t: float) -> Position:
    """Returns the place at parameter t (0 to 1) on a cubic Bézier curve, rounded to a micrometre.

    The rounding gives the same places if the curve is driven in the opposite direction.
    """
    weights = [math.comb(3, i) * (1.0 - t) ** (3 - i) * t ** i for i in range(4)]
    return (round(sum(w * x for w, (x, _) in zip(weights, corners)), 6),
            round(sum(w * y for w, (_, y) in zip(weights, corners)), 6))


class Converter:
    """Collects vertices, edges, stations and robots of one model."""

    def __init__(self, model: ElementTree.Element) -> None:
        self._model = model
        self._vertices: Dict[str, Vertex] = {}
        self._edges: List[Edge] = []
        self._courses: Dict[Tuple[Position, ...], List[int]] = {}  # ids of the edges of each path
        self._devices: Dict[str, Set[int]] = {}  # ids of the edges through each device
        self._to_do: List[str] = []

    def convert(self) -> Site:
        """Returns the files of the plant."""
        for point in self._model.findall('point'):
            angle = float(point.get('vehicleOrientationAngle', 'nan'))
            self._add_vertex(point.get('name', ''), metres(point, 'positionX'),
                             metres(point, 'positionY'),
                             0.0 if math.isnan(angle) else math.radians(angle),
                             parking=True if point.get('type') == 'PARK_POSITION' else None)
        for path in self._model.findall('path'):
            self._add_path(path)
        work = {'stations': self._stations(), 'devices': self._simulated_devices()}
        for block in self._model.findall('block'):
            self._to_do.append(f'block {block.get("name")}: robots keep apart by their size. If '
                               'the block protects more than that, make a device of it')
        fleet = self._fleet()
        return Site(Graph(list(self._vertices.values()), self._edges), work, fleet,
                    tuple(self._to_do))

    def _add_vertex(self, name: str, x: float, y: float, theta: float = 0.0,
                    parking: Optional[bool] = None) -> Vertex:
        vertex = Vertex(len(self._vertices) + 1, x, y, theta, theta, name, parking=parking)
        self._vertices[name] = vertex
        return vertex

    def _add_path(self, path: ElementTree.Element) -> None:
        name = path.get('name', '')
        ends = [self._vertices[path.get(key, '')] for key in ('sourcePoint', 'destinationPoint')]
        forward, backwards = metres(path, 'maxVelocity'), metres(path, 'maxReverseVelocity')
        course = (ends[0].position, *drawn_through(path, (ends[0].position, ends[1].position),
                                                   self._scale()), ends[1].position)
        opposite = self._courses.get(course[::-1])
        if opposite is not None:
            edges = opposite
            for index in edges:  # one edge for both directions
                edge = self._edges[index - 1]
                self._edges[index - 1] = replace(
                    edge, velocity_forward=max(edge.velocity_forward, backwards),
                    velocity_backwards=max(edge.velocity_backwards, forward))
        else:
            edges = self._add_edges(name, ends, course, forward, backwards)
            self._courses[course] = edges
        if path.get('locked') == 'true':
            self._to_do.append(f'path {name} is locked: edge close {edges[0]}')
        for operation in path.findall('peripheralOperation'):
            self._devices.setdefault(ros_name(operation.get('locationName', '')), set()).update(
                edges)

    def _add_edges(self, name: str, ends: List[Vertex], course: Tuple[Position, ...],
                   forward: float, backwards: float) -> List[int]:
        """Adds the edges of a path, and a vertex between each two of them."""
        between = [self._add_vertex(f'{name} {number}', x, y, parking=False)
                   for number, (x, y) in enumerate(course[1:-1], 1)]
        stops = [ends[0], *between, ends[1]]
        first = len(self._edges) + 1
        for origin, destination in zip(stops, stops[1:]):
            self._edges.append(Edge(len(self._edges) + 1, origin.id, destination.id, CurveType.LINE,
                                    velocity_forward=forward, velocity_backwards=backwards))
        return list(range(first, len(self._edges) + 1))

    def _scale(self) -> Position:
        layout = self._model.find('visualLayout')
        if layout is None:
            return 50.0, 50.0  # the model editor's default
        return float(layout.get('scaleX', '50')), float(layout.get('scaleY', '50'))

    def _stations(self) -> List[object]:
        operations = {kind.get('name'): [operation.get('name', '').lower()
                                         for operation in kind.findall('allowedOperation')]
                      for kind in self._model.findall('locationType')}
        stations: List[object] = []
        taken: Dict[int, str] = {}
        for location in self._model.findall('location'):
            name = location.get('name', '')
            places = [self._vertices[link.get('point', '')] for link in location.findall('link')]
            if ros_name(name) in self._devices:
                continue
            if not places:
                self._to_do.append(f'location {name} has no link to a point: it is left out')
            elif any(CHARGE in operation for operation in operations.get(location.get('type'), ())):
                self._charge_at(name, places)
            elif any(place.id in taken for place in places):
                owner = next(taken[place.id] for place in places if place.id in taken)
                self._to_do.append(f'location {name} is left out: {owner} has its point')
            else:
                taken.update({place.id: name for place in places})
                stations.append({'name': name, 'places': [place.id for place in places]})
        return stations

    def _simulated_devices(self) -> List[object]:
        """Returns the devices of paths, each as a simulated door."""
        for name in self._devices:
            self._to_do.append(f'device {name} is simulated: write its kind and driver into '
                               'work.yaml')
        return [{'name': name, 'kind': 'door', 'edges': sorted(edges), 'timeout': DEVICE_TIME,
                 'driver': 'simulated'} for name, edges in self._devices.items()]

    def _charge_at(self, name: str, places: List[Vertex]) -> None:
        for place in places:
            neighbours = {end for edge in self._edges for end in (edge.origin, edge.destination)
                          if place.id in (edge.origin, edge.destination)} - {place.id}
            if len(neighbours) == 1:
                self._vertices[place.label] = replace(place, dock=True)
            else:
                self._to_do.append(f'location {name} charges at vertex {place.id}, but routes lead '
                                   'through it: add a dock beside it in the graph editor')

    def _fleet(self) -> Dict[str, object]:
        """Returns the fleet file. Each robot starts at a park position."""
        types: Dict[Tuple[float, float], Dict[str, object]] = {}
        robots: List[object] = []
        docks = [vertex.id for vertex in self._vertices.values() if vertex.dock]
        free = [vertex.id for vertex in self._vertices.values() if vertex.parking]
        for vehicle in self._model.findall('vehicle'):
            name = ros_name(vehicle.get('name', ''))
            box = vehicle.find('boundingBox')
            size = vehicle if box is None else box
            radius = math.hypot(metres(size, 'length'), metres(size, 'width')) / 2.0
            speed = metres(vehicle, 'maxVelocity')
            kind = types.setdefault((radius, speed), {
                'name': f'agv_{len(types) + 1}', 'radius': round(radius, 3), 'speed': speed,
                **({'docks': docks} if docks else {})})
            if free:
                robots.append({'name': name, 'type': kind['name'], 'vertex': free.pop(0),
                               'driver': 'agv'})
            else:
                self._to_do.append(f'vehicle {name} has no park position to start: add it to the '
                                   'fleet file, with the vertex on which it stands')
        return {'clearance': CLEARANCE, 'robot_types': list(types.values()), 'robots': robots}


def read(file: Path) -> Site:
    """Reads a plant model."""
    try:
        model = ElementTree.parse(file).getroot()
    except (OSError, ElementTree.ParseError) as error:
        raise NoPlantModel(f'{file} is not read: {error}') from error
    if model.tag != 'model' or not model.get('version', '').startswith(('6.', '7.')):
        raise NoPlantModel(f'{file} is no plant model of version 6 or 7: open it with the model '
                           'editor of openTCS, and save it')
    return Converter(model).convert()


def main() -> int:
    """Returns 0 if the files were written, 1 if not."""
    parser = argparse.ArgumentParser(description='Makes a graph from a plant model of openTCS.')
    parser.add_argument('model', type=Path)
    parser.add_argument('--into', type=Path, required=True, help='a folder, which is made')
    given = parser.parse_args()
    try:
        site = read(given.model)
        given.into.mkdir(parents=True)
        save_graph(site.graph, given.into / 'graph.yaml')
    except (NoPlantModel, GraphError, OSError) as error:
        print(error, file=sys.stderr)
        return 1
    for name, content in (('work.yaml', site.work), ('fleet.yaml', site.fleet)):
        (given.into / name).write_text(yaml.safe_dump(content, sort_keys=False, width=160,
                                                      default_flow_style=None), encoding='utf-8')
    print(f'{len(site.graph.vertices)} vertices, {len(site.graph.edges)} edges, '
          f'{len(site.work["stations"])} stations: {given.into}')
    for line in site.to_do:
        print(f'to do: {line}')
    return 0


if __name__ == '__main__':
    sys.exit(main())
