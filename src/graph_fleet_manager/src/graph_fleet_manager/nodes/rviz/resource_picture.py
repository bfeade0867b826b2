"""Doors, stations and chargers in RViz: what they show, and the robots that claim them."""
from __future__ import annotations

from typing import Iterable, List

from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker

from fleet_core.interlocking.claims import ClaimState
from graph_fleet_manager.messages.resources import CLAIM_OF_CODE, device_of
from itrci_nav_msgs.msg import FleetResource
from route_protocol.devices import DeviceMode
from rviz_drawing import drawing
from trajectory_graph import Graph

OPEN, SHUT = drawing.colour(0.25, 0.85, 0.4), drawing.colour(0.95, 0.7, 0.2)
ALARM, STATION = drawing.colour(1.0, 0.25, 0.2), drawing.colour(0.35, 0.75, 0.95)
BAND, RING, RING_RADIUS = 0.22, 0.1, 0.45  # m
TEXT_HEIGHT, TEXT_ABOVE = 0.36, 0.75       # m
_Z = 0.01


def resource_markers(graph: Graph, resources: Iterable[FleetResource]) -> List[Marker]:
    """The markers of doors and other devices, along their edges, of stations and of chargers."""
    markers: List[Marker] = []
    for number, one in enumerate(resources):
        curves = [graph.curve(edge) for edge in one.edges if edge in graph.edges]
        places = [graph.vertices[id].position for id in one.vertices if id in graph.vertices]
        paint = _paint(one)
        lines = [*(curve.sample(drawing.STEP) for curve in curves),
                 *(drawing.ring(place, RING_RADIUS) for place in places)]
        markers.append(drawing.lines('resources', number, paint, BAND if curves else RING, lines,
                                     _Z))
        middles = [*(curve.point_at(curve.length / 2.0) for curve in curves), *places]
        for x, y in middles[:1]:
            markers.append(drawing.text('resource_names', number, words_of(one),
                                        (x, y + TEXT_ABOVE), TEXT_HEIGHT, paint, z=0.3))
    return markers


def words_of(one: FleetResource) -> str:
    """Its name, what it shows, and the robots that claim it."""
    device = device_of(one)
    shows = '' if device is None else f' {device.mode.name}'
    return '\n'.join([f'{one.name}{shows}', *(
        f'{claim.robot} ({CLAIM_OF_CODE[claim.state].value})' for claim in one.claims)])


def _paint(one: FleetResource) -> ColorRGBA:
    device, states = device_of(one), {CLAIM_OF_CODE[claim.state] for claim in one.claims}
    if device is None:
        return STATION
    if ClaimState.LOST in states:
        return ALARM
    return OPEN if device.mode is DeviceMode.OPEN else SHUT

