"""RViz shows doors, stations, queues and machines by colour, with the robots that use them."""
from __future__ import annotations

from itertools import combinations
from typing import List

import pytest
from fleet_builders import corridor, graph_of
from visualization_msgs.msg import Marker

from fleet_core.supervision.looks import ResourceLook
from graph_fleet_manager.nodes.rviz.paints import PAINTS
from graph_fleet_manager.nodes.rviz.resource_picture import draw_resources
from itrci_nav_msgs.msg import (
    DeviceState,
    FleetMachine,
    FleetResource,
    QueuePlace,
    ResourceClaim,
)
from trajectory_graph.placing import Places, middle_of, shared

GRAPH = corridor(4)  # 2 m apart, on the x axis


def visible(markers: List[Marker]) -> List[Marker]:
    return [one for one in markers if one.action == Marker.ADD]


def drawn(**fields: object) -> List[Marker]:
    return visible(draw_resources(GRAPH, [FleetResource(name='gate', **fields)]).markers)


def door(mode: int, *claims: ResourceClaim) -> List[Marker]:
    return drawn(edges=[2, 99], has_device=True, device_mode=mode, claims=list(claims))


@pytest.mark.parametrize('mode, look, shows', [
    (DeviceState.OPEN, ResourceLook.OPEN, 'open'),
    (DeviceState.CLOSED, ResourceLook.SHUT, 'closed'),
    (DeviceState.OFFLINE, ResourceLook.TROUBLE, 'offline')])
def test_a_door_is_a_band_on_its_edges(mode: int, look: ResourceLook, shows: str) -> None:
    band, words = door(mode, ResourceClaim('agv_1', ResourceClaim.ASKED))
    xs = [point.x for point in band.points]
    assert (min(xs), max(xs), band.color) == (2.0, 4.0, PAINTS[look])
    assert words.text == f'door gate: {shows}\nagv_1 (asked)'


def test_a_door_that_is_not_open_for_a_robot_in_it_is_in_the_colour_of_trouble() -> None:
    band, _ = door(DeviceState.CLOSED, ResourceClaim('agv_1', ResourceClaim.LOST))
    assert band.color == PAINTS[ResourceLook.TROUBLE]


def test_words_cover_an_edge_only_if_no_side_is_clear_of_it() -> None:
    """A station at the lower end of an upward edge has its words below, not on the edge."""
    station = FleetResource(name='gate', kind=FleetResource.STATION, vertices=[1])
    above, everywhere = Places(), Places()
    above.cover((-1.0, 0.0, 1.0, 2.0), is_soft=True)
    everywhere.cover((-9.0, -9.0, 9.0, 9.0), is_soft=True)
    _, words = visible(draw_resources(GRAPH, [station], beneath=above).markers)
    assert words.pose.position.y < 0.0
    _, words = visible(draw_resources(GRAPH, [station], beneath=everywhere).markers)
    assert words.text == 'station gate'


def test_a_station_is_a_ring_on_each_of_its_places() -> None:
    ring, words = drawn(kind=FleetResource.STATION, vertices=[1, 3])
    assert ring.color == PAINTS[ResourceLook.PLACE] and words.text == 'station gate'
    assert min(point.x for point in ring.points) < 0.0 < 4.0 < max(p.x for p in ring.points)


def test_queue_places_have_their_order_and_their_robots() -> None:
    markers = drawn(kind=FleetResource.STATION, vertices=[4], queue=[
        QueuePlace(3, 'a', True), QueuePlace(2, 'b', False), QueuePlace(1, '', False)])
    assert [one.text for one in markers if one.type == Marker.TEXT_VIEW_FACING][1:] == [
        'gate 1: a', 'gate 2: b is on its way', 'gate 3']
    thin, = (one for one in markers if one.ns == 'queues')
    thick, = (one for one in markers if one.ns == 'queues_taken')
    assert max(point.x for point in thin.points) < 3.0 < min(point.x for point in thick.points)
    assert thin.scale.x < thick.scale.x


@pytest.mark.parametrize('state, look, words', [
    (FleetMachine.FREE, ResourceLook.PLACE, 'machine oven: free'),
    (FleetMachine.WORKING, ResourceLook.OPEN, 'machine oven: working\na'),
    (FleetMachine.SILENT, ResourceLook.TROUBLE, 'machine oven: offline')])
def test_a_machine_is_a_square_around_its_place(state: int, look: ResourceLook, words: str) -> None:
    machine = FleetMachine(name='oven', state=state, vertices=[2, 99],
                           robot='a' if state == FleetMachine.WORKING else '')
    square, text = visible(draw_resources(GRAPH, (), [machine]).markers)
    assert (square.color, text.text) == (PAINTS[look], words)
    assert min(p.x for p in square.points) < 2.0 < max(p.x for p in square.points)


def test_a_machine_of_which_the_place_is_not_known_is_not_drawn() -> None:
    assert visible(draw_resources(GRAPH, (), [FleetMachine(name='oven')]).markers) == []


def test_the_words_of_a_door_do_not_lie_on_its_band() -> None:
    graph = graph_of({1: (0.0, 0.0), 2: (4.0, 4.0)}, {1: (1, 2)})
    door = FleetResource(name='gate', edges=[1], has_device=True)
    box, = draw_resources(graph, [door]).boxes
    assert not any(box[0] < x < box[2] and box[1] < y < box[3]
                   for x, y in graph.curve(1).sample(0.05))


def test_no_words_cover_each_other_or_lie_outside_of_what_is_seen() -> None:
    places = [QueuePlace(id, f'robot_{id}', False) for id in (1, 2, 3)]
    window = (-2.0, -2.0, 8.0, 2.0)
    boxes = draw_resources(GRAPH, [
        FleetResource(name='press', kind=FleetResource.STATION, vertices=[4], queue=places),
        FleetResource(name='gate', edges=[3], has_device=True)], [
            FleetMachine(name='press_1', vertices=[4])], window).boxes
    assert len(boxes) > 3
    assert not any(shared(one, other) for one, other in combinations(boxes, 2))
    assert all(shared(box, window) == pytest.approx((box[2] - box[0]) * (box[3] - box[1]))
               for box in boxes)


def test_labels_of_robots_know_the_rings_of_stations_and_queue_places() -> None:
    rings = draw_resources(GRAPH, [FleetResource(
        name='press', kind=FleetResource.STATION, vertices=[4],
        queue=[QueuePlace(2, '', False), QueuePlace(99, '', False)])]).rings
    assert [middle_of(ring) for ring in rings] == [
        pytest.approx(GRAPH.vertices[id].position) for id in (4, 2)]
