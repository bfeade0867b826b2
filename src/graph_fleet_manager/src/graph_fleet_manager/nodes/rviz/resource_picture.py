"""Doors, stations, queues, chargers and machines in RViz, and the robots that use them."""
from __future__ import annotations

import math
from typing import Container, Iterable, Iterator, List, NamedTuple, Optional, Sequence, Tuple

from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker

from fleet_core.supervision.looks import LOOK_OF_MACHINE, ResourceLook, queue_words
from graph_fleet_manager.messages.resources import (
    CLAIM_OF_CODE,
    look_of,
    machine_of,
    words_of,
)
from graph_fleet_manager.nodes.rviz.paints import PAINTS
from itrci_nav_msgs.msg import FleetMachine, FleetResource
from rviz_drawing import drawing
from rviz_drawing.text_places import text_size
from trajectory_graph import Graph
from trajectory_graph.placing import (
    ABOVE_FIRST,
    Box,
    MayCover,
    Places,
    box_around,
    box_beside,
    middle_of,
)

BAND, RING, THIN = 0.22, 0.1, 0.04                      # m, widths of lines
STATION_RADIUS, QUEUE_RADIUS, MACHINE = 0.45, 0.32, 0.58  # m; MACHINE is half of a square's side
TEXT_HEIGHT, TEXT_AWAY = 0.36, 0.2                      # m
_Z = 0.01


class Words(NamedTuple):
    """A text beside a point, at the distance `away` (m)."""

    text: str
    paint: ColorRGBA
    point: Tuple[float, float]
    away: float


class DrawnResources(NamedTuple):
    """The markers of all resources, the boxes of their words, and the boxes within their rings."""

    markers: List[Marker]
    boxes: Sequence[Box] = ()
    rings: Sequence[Box] = ()


def draw_resources(graph: Graph, resources: Sequence[FleetResource],
                   machines: Sequence[FleetMachine] = (), window: Optional[Box] = None,
                   covered: Iterable[Box] = (), beneath: Optional[Places] = None
                   ) -> DrawnResources:
    """Draws doors and other devices along their edges, and stations and machines at their places.

    window  -- the area that people see; None: it is not known
    covered -- boxes that no words may cover
    beneath -- the edges, as soft boxes: words cover them only if there is no other place
    """
    markers: List[Marker] = []
    words: List[Words] = []
    squares = {vertex for machine in machines for vertex in machine.vertices}
    for number, one in enumerate(resources):
        markers.append(_resource(graph, number, one, words, squares))
    for number, machine in enumerate(machines):
        markers.append(_machine(graph, number, machine, words))
    for number, one in enumerate(resources):
        markers += _queue(graph, number, one, words)
    bands = [box_around((x, y), (BAND, BAND)) for one in resources for edge in one.edges
             if edge in graph.edges for x, y in graph.curve(edge).sample(BAND)]
    texts, boxes = _placed(words, Places(window, beneath=beneath), (*covered, *bands))
    return DrawnResources([*markers, *texts], boxes, list(_rings(graph, resources, machines)))


def _rings(graph: Graph, resources: Iterable[FleetResource],
           machines: Iterable[FleetMachine]) -> Iterator[Box]:
    """Yields the squares within the rings of stations and queue places, and around machines."""
    for radius, ids in (
            *((STATION_RADIUS * math.sqrt(0.5), one.vertices) for one in resources),
            *((QUEUE_RADIUS * math.sqrt(0.5), [place.vertex for place in one.queue])
              for one in resources),
            *((MACHINE, machine.vertices) for machine in machines)):
        for id in ids:
            if id in graph.vertices:
                yield box_around(graph.vertices[id].position, (2.0 * radius,) * 2)


def _resource(graph: Graph, number: int, one: FleetResource, words: List[Words],
              squares: Container[int]) -> Marker:
    """Draws a resource. Words avoid the square of a machine around each vertex in `squares`."""
    paint = PAINTS[look_of(one)]
    curves = [graph.curve(edge) for edge in one.edges if edge in graph.edges]
    places = [graph.vertices[id].position for id in one.vertices if id in graph.vertices]
    middles = [*(curve.point_at(curve.length / 2.0) for curve in curves), *places]
    if middles:
        words.append(Words(words_with_claims(one), paint, middles[0],
                           BAND if curves else
                           MACHINE if one.vertices[0] in squares else STATION_RADIUS))
    return drawing.lines('resources', number, paint, BAND if curves else RING, [
        *(curve.sample(drawing.STEP) for curve in curves),
        *(drawing.ring(place, STATION_RADIUS) for place in places)], _Z)


def words_with_claims(one: FleetResource) -> str:
    """Returns the kind, name and state of a resource, and the robots that claim it."""
    return '\n'.join([words_of(one), *(
        f'{claim.robot} ({CLAIM_OF_CODE[claim.state].value})' for claim in one.claims)])


def _queue(graph: Graph, number: int, one: FleetResource, words: List[Words]) -> List[Marker]:
    """Returns the queue places of a station: thick rings where a robot stands, else thin rings."""
    paint = PAINTS[ResourceLook.PLACE]
    rings = {is_there: [drawing.ring(graph.vertices[place.vertex].position, QUEUE_RADIUS)
                        for place in one.queue
                        if place.is_there is is_there and place.vertex in graph.vertices]
             for is_there in (False, True)}
    words += [Words(queue_words(one.name, k, place.robot, place.is_there), paint,
                    graph.vertices[place.vertex].position, QUEUE_RADIUS)
              for k, place in enumerate(one.queue, 1) if place.vertex in graph.vertices]
    return [drawing.lines('queues', number, paint, THIN, rings[False], _Z),
            drawing.lines('queues_taken', number, paint, RING, rings[True], _Z)]


def _machine(graph: Graph, number: int, message: FleetMachine, words: List[Words]) -> Marker:
    machine = machine_of(message)
    paint = PAINTS[LOOK_OF_MACHINE[machine.state]]
    places = [graph.vertices[id].position for id in machine.places if id in graph.vertices]
    text = f'machine {machine.name}: {machine.state.words}'
    if places:
        words.append(Words(f'{text}\n{machine.robot}' if machine.robot else text, paint, places[0],
                           MACHINE))
    return drawing.lines('machines', number, paint, RING,
                         [drawing.square(place, MACHINE) for place in places], _Z)


def _placed(words: Iterable[Words], places: Places,
            covered: Iterable[Box]) -> Tuple[List[Marker], List[Box]]:
    """Returns the texts for which there is room, and their boxes. Earlier texts are placed first.
    """
    for box in covered:
        places.cover(box)
    markers: List[Marker] = []
    boxes: List[Box] = []
    for number, one in enumerate(words):
        size = text_size(one.text, TEXT_HEIGHT)
        beside = [box_beside(one.point, one.away + TEXT_AWAY, size, side) for side in ABOVE_FIRST]
        side = places.place(beside, may=MayCover.SOFT)
        if side >= 0:
            boxes.append(beside[side])
            markers.append(drawing.text('resource_names', number, one.text,
                                        middle_of(beside[side]), TEXT_HEIGHT, one.paint, z=0.3))
    return markers, boxes
