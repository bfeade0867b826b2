"""The command `station` lists claims of stations and devices, and the faults of devices."""
from __future__ import annotations

from typing import Any, Optional

import pytest

from fleet_core.interlocking.claims import ClaimState
from fleet_core.interlocking.resources import Resource, ResourceKind
from fleet_core.supervision.device_desk import DeviceView
from fleet_core.supervision.resource_view import ClaimView, ResourceView
from graph_fleet_manager.commands import station
from graph_fleet_manager.messages.resources import (
    CLAIM_OF_CODE,
    KIND_OF_CODE,
    device_of,
    resource_messages,
)
from route_protocol.devices import DeviceMode

GATE = Resource('gate', ResourceKind.DOOR, frozenset({17, 18}), has_device=True)
PRESS = Resource('press', ResourceKind.STATION, vertices=frozenset({18}), capacity=2)


def listed(resource: Resource, device: Optional[DeviceView] = None, **claims: ClaimState) -> Any:
    views = [ResourceView(resource, device, tuple(
        ClaimView(robot, state) for robot, state in claims.items()))]
    return resource_messages(views)


def test_each_kind_and_each_state_of_a_claim_has_a_code() -> None:
    assert set(KIND_OF_CODE.values()) == set(ResourceKind)
    assert set(CLAIM_OF_CODE.values()) == set(ClaimState)


def test_a_station_shows_who_claims_it_and_how_many_may() -> None:
    _, line = station._listed(listed(PRESS, agv_1=ClaimState.IN_USE)).splitlines()
    assert line.split() == ['press', 'station', '-', '1', 'of', '2', 'agv_1', '(in', 'use)']


def test_a_charger_shows_who_charges_there() -> None:
    bay = Resource('bay', ResourceKind.CHARGER, vertices=frozenset({16, 24}))
    _, line = station._listed(listed(bay, ld90_1=ClaimState.IN_USE)).splitlines()
    assert line.split() == ['bay', 'charger', '-', '1', 'of', '1', 'ld90_1', '(in', 'use)']


@pytest.mark.parametrize('mode', DeviceMode)
def test_a_device_shows_its_mode_and_what_is_wrong(mode: DeviceMode) -> None:
    view = DeviceView(mode, 'the PLC does not answer')
    messages = listed(GATE, view)
    assert device_of(messages[0]) == view
    _, line, note = station._listed(messages).splitlines()
    assert mode.name in line and note.strip() == view.why
    assert station._values(messages[0])['shows'] == mode.name


def test_a_robot_in_a_door_that_is_not_open_is_an_alarm() -> None:
    text = station._listed(listed(GATE, DeviceView(DeviceMode.OFFLINE), agv_2=ClaimState.LOST))
    assert 'ALARM: agv_2 is there, but it does not report that it is open' in text
    assert 'ALARM' not in station._listed(listed(GATE, DeviceView(DeviceMode.OPEN),
                                                 agv_2=ClaimState.IN_USE))


def test_programs_get_all_fields() -> None:
    assert station._values(listed(PRESS, agv_1=ClaimState.ASKED)[0]) == {
        'name': 'press', 'kind': 'STATION', 'capacity': 2, 'edges': [], 'vertices': [18],
        'shows': None, 'reason': None, 'claims': [{'robot': 'agv_1', 'state': 'ASKED'}]}


def test_a_site_without_resources_is_said_to_have_none() -> None:
    assert 'no work file' in station._listed([])
