"""The requests of the fleet manager to devices, and the reports of devices that it accepts."""
from __future__ import annotations

from typing import List, Optional, Tuple

import pytest
from fleet_builders import corridor

from fleet_core.geometry.site_geometry import SiteGeometry
from fleet_core.interlocking.claims import Claims, ClaimState
from fleet_core.interlocking.resources import Needs, Resource, ResourceKind
from fleet_core.interlocking.route_master import ME
from fleet_core.supervision.device_desk import AHEAD, FRESH, REPEAT, DeviceDesk
from route_protocol.devices import DeviceFault, DeviceMode, DeviceReport, DeviceRequest, DeviceUse

DOOR = Resource('door', ResourceKind.DOOR, frozenset({2}), has_device=True)
OPEN, CLOSED = DeviceMode.OPEN, DeviceMode.CLOSED


class Desk(DeviceDesk):
    """The desk of one door, which robot `a` claims."""

    def __init__(self) -> None:
        self.claims = Claims(Needs([DOOR], SiteGeometry(corridor(4))))
        self.claims.want('a', [2])
        self.claims.stored()
        self.lost_robots: List[str] = []
        self.count = 0
        super().__init__(self.claims, lambda: self.lost_robots)

    @property
    def request(self) -> DeviceRequest:
        return self.claims.requests['door']

    def hear(self, now: float, mode: DeviceMode = OPEN, age: float = 0.0,
             obeyed: Optional[DeviceUse] = None, **fields: object) -> None:
        self.count += 1
        use = obeyed or DeviceUse(ME, self.request.mode, self.request.number, 0.0)
        self.report(DeviceReport('door', mode, 0.0, now - age, (use,),
                                 **{'count': self.count, **fields}), now)

    def is_open(self, now: float) -> bool:
        self.update_open(now)
        return self.claims.open_for == {'door': self.request.number}

    def asks(self, now: float) -> List[Tuple[str, DeviceMode]]:
        return [(one.request.device, one.request.mode) for one in self.due(now)]


def test_a_report_counts_while_it_is_fresh() -> None:
    desk = Desk()
    desk.hear(10.0)
    assert desk.is_open(10.0) and desk.is_open(10.0 + FRESH)
    assert not desk.is_open(10.1 + FRESH)


def test_a_report_that_was_old_when_it_arrived_is_old() -> None:
    desk = Desk()
    desk.hear(10.0, age=FRESH + 1.0)
    assert not desk.is_open(10.0)


def test_a_device_that_was_never_read_is_not_open() -> None:
    desk = Desk()
    desk.report(DeviceReport('door', OPEN, 0.0, None, (
        DeviceUse(ME, OPEN, desk.request.number, 0.0),), count=1), 10.0)
    assert not desk.is_open(10.0)


def test_a_reading_from_the_future_never_becomes_fresh() -> None:
    desk = Desk()
    desk.hear(10.0, age=-5.0)
    assert not any(desk.is_open(10.0 + later) for later in (0.0, 4.9, 5.0, 6.0))
    desk.hear(20.0, age=-AHEAD / 2)
    assert desk.is_open(20.0) and not desk.is_open(20.0 + FRESH + AHEAD / 4)


@pytest.mark.parametrize('before', [{'count': 1}, {'run': 0, 'count': 99}])
def test_a_report_that_was_made_before_the_newest_changes_nothing(before: dict) -> None:
    desk = Desk()
    desk.hear(10.0, CLOSED, run=1, count=2)
    desk.hear(10.5, OPEN, **{'run': 1, **before})
    assert not desk.is_open(10.5)


@pytest.mark.parametrize('mode', sorted(set(DeviceMode) - {OPEN}))
def test_only_an_open_device_is_open(mode: DeviceMode) -> None:
    desk = Desk()
    desk.hear(10.0, mode)
    assert not desk.is_open(10.0)


@pytest.mark.parametrize('use', [DeviceUse('anna', OPEN, 10 ** 9, 0.0), DeviceUse(
    ME, CLOSED, 10 ** 9, 0.0), DeviceUse(ME, OPEN, 0, 0.0)])
def test_a_device_that_is_open_for_another_reason_is_not_open(use: DeviceUse) -> None:
    desk = Desk()
    desk.hear(10.0, obeyed=use)
    desk.update_open(10.0)
    assert desk.claims.state('a', 'door') is ClaimState.ASKED


def test_a_report_of_what_is_no_device_changes_nothing() -> None:
    desk = Desk()
    desk.report(DeviceReport('gate', OPEN, 0.0, 10.0, count=1), 10.0)
    desk.update_open(10.0)
    assert desk.claims.open_for == {}


def test_a_device_that_obeys_a_later_request_than_the_journal_knows_is_asked_anew() -> None:
    desk = Desk()
    former = DeviceUse(ME, OPEN, desk.request.number + 1000, 0.0)
    desk.hear(10.0, obeyed=former)
    assert not desk.is_open(10.0) and desk.claims.is_changed
    desk.claims.stored()
    assert desk.request.number > former.number
    assert desk.asks(10.1) == [('door', OPEN)]
    desk.hear(10.2, obeyed=former)
    assert not desk.is_open(10.2)
    desk.hear(10.3)
    assert desk.is_open(10.3)


def test_a_request_is_repeated_until_a_fresh_report_shows_it() -> None:
    desk = Desk()
    assert desk.asks(0.0) == [('door', OPEN)]
    assert not desk.due(REPEAT / 2) and desk.due(REPEAT)
    desk.hear(2.0 * REPEAT, DeviceMode.MOVING)
    assert not desk.due(2.0 * REPEAT)
    assert desk.due(2.0 * REPEAT + FRESH + 0.1), 'it may have lost its memory'


def test_a_new_request_goes_out_at_once() -> None:
    desk = Desk()
    desk.due(0.0)
    desk.claims.want('a', ())
    desk.claims.stored()
    assert desk.asks(0.1) == [('door', CLOSED)]


def test_no_device_is_asked_for_anything_while_a_robot_may_be_anywhere() -> None:
    desk = Desk()
    desk.lost_robots.append('b')
    assert not desk.due(0.0)
    desk.lost_robots.clear()
    assert desk.due(0.0)


def test_people_read_what_a_device_shows_and_why_it_cannot_be_used() -> None:
    desk = Desk()
    mode, why = desk.view('door', 0.0)
    assert mode is DeviceMode.UNKNOWN and 'is fleet_devices running?' in why
    desk.hear(1.0)
    assert desk.view('door', 1.0) == (OPEN, '')
    assert desk.view('door', 1.1 + FRESH).mode is DeviceMode.OFFLINE
    desk.hear(5.0, DeviceMode.OFFLINE, FRESH + 1.0, fault=DeviceFault.NOT_READ, reason='no answer')
    assert desk.view('door', 5.0) == (DeviceMode.OFFLINE, 'no answer')
