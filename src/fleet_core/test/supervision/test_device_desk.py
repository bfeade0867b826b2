"""What the fleet manager believes of devices, and what it asks of them."""
from __future__ import annotations

from typing import List

import pytest
from fleet_builders import corridor

from fleet_core.geometry.site_geometry import SiteGeometry
from fleet_core.interlocking.claims import Claims
from fleet_core.interlocking.resources import (
    DeviceReading,
    Needs,
    Resource,
    ResourceKind,
)
from fleet_core.supervision.device_desk import FRESH, REPEAT, DeviceDesk
from route_protocol.devices import DeviceMode

DOOR = Resource('door', ResourceKind.DOOR, frozenset({2}), has_device=True)


class Desk(DeviceDesk):
    """The desk of one door, which robot `a` claims."""

    def __init__(self) -> None:
        self.claims = Claims(Needs([DOOR], SiteGeometry(corridor(4))))
        self.claims.want('a', [2])
        self.claims.stored()
        self.lost_robots: List[str] = []
        super().__init__(self.claims, lambda: self.lost_robots)

    @property
    def number(self) -> int:
        return self.claims.requests['door'].number

    def hear(self, now: float, mode: DeviceMode = DeviceMode.OPEN, age: float = 0.0) -> None:
        self.report(DeviceReading('door', mode, self.number, age), now)

    def is_open(self, now: float) -> bool:
        self.update_open(now)
        return self.claims.open_for == {'door': self.number}


def test_a_report_counts_while_it_is_fresh() -> None:
    desk = Desk()
    desk.hear(10.0)
    assert desk.is_open(10.0) and desk.is_open(10.0 + FRESH)
    assert not desk.is_open(10.1 + FRESH)


def test_a_report_that_was_old_when_it_arrived_is_old() -> None:
    desk = Desk()
    desk.hear(10.0, age=FRESH + 1.0)
    assert not desk.is_open(10.0)


def test_a_report_that_was_read_before_the_newest_changes_nothing() -> None:
    desk = Desk()
    desk.hear(10.0, DeviceMode.CLOSED)
    desk.hear(10.5, DeviceMode.OPEN, age=1.0)
    assert not desk.is_open(10.5)


@pytest.mark.parametrize('mode', sorted(set(DeviceMode) - {DeviceMode.OPEN}))
def test_only_an_open_device_is_open(mode: DeviceMode) -> None:
    desk = Desk()
    desk.hear(10.0, mode)
    assert not desk.is_open(10.0)


def test_a_request_is_repeated_until_a_fresh_report_shows_it() -> None:
    desk = Desk()
    assert [one.request.robots for one in desk.due(0.0)] == [('a',)]
    assert not desk.due(REPEAT / 2) and desk.due(REPEAT)
    desk.hear(2.0 * REPEAT, DeviceMode.MOVING)
    assert not desk.due(2.0 * REPEAT)
    assert desk.due(2.0 * REPEAT + FRESH + 0.1), 'it may have lost its memory'


def test_a_new_request_goes_out_at_once() -> None:
    desk = Desk()
    desk.due(0.0)
    desk.claims.want('a', ())
    desk.claims.stored()
    assert [one.request.robots for one in desk.due(0.1)] == [()]


def test_no_device_is_asked_for_anything_while_a_robot_may_be_anywhere() -> None:
    desk = Desk()
    desk.lost_robots.append('b')
    assert not desk.due(0.0)
    desk.lost_robots.clear()
    assert desk.due(0.0)
