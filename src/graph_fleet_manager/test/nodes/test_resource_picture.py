"""RViz shows doors and stations by colour, with the robots that claim them."""
from __future__ import annotations

from typing import List

import pytest
from fleet_builders import corridor
from visualization_msgs.msg import Marker

from graph_fleet_manager.nodes.rviz.resource_picture import (
    ALARM,
    OPEN,
    SHUT,
    STATION,
    resource_markers,
)
from itrci_nav_msgs.msg import DeviceState, FleetResource, ResourceClaim

GRAPH = corridor(4)  # 2 m apart, on the x axis


def drawn(**fields: object) -> List[Marker]:
    return resource_markers(GRAPH, [FleetResource(name='gate', **fields)])


def door(mode: int, *claims: ResourceClaim) -> List[Marker]:
    return drawn(edges=[2, 99], has_device=True, device_mode=mode, claims=list(claims))


@pytest.mark.parametrize('mode, paint', [
    (DeviceState.OPEN, OPEN), (DeviceState.CLOSED, SHUT), (DeviceState.OFFLINE, SHUT)])
def test_a_door_is_a_band_on_its_edges(mode: int, paint: object) -> None:
    band, words = door(mode, ResourceClaim('agv_1', ResourceClaim.ASKED))
    xs = [point.x for point in band.points]
    assert (min(xs), max(xs), band.color) == (2.0, 4.0, paint)
    assert words.text.split('\n')[1] == 'agv_1 (asked)'


def test_a_door_that_is_not_open_for_a_robot_in_it_is_red() -> None:
    band, _ = door(DeviceState.OFFLINE, ResourceClaim('agv_1', ResourceClaim.LOST))
    assert band.color == ALARM


def test_a_station_is_a_ring_on_each_of_its_places() -> None:
    ring, words = drawn(kind=FleetResource.STATION, vertices=[1, 3])
    assert ring.color == STATION and words.text == 'gate'
    assert min(point.x for point in ring.points) < 0.0 < 4.0 < max(p.x for p in ring.points)
