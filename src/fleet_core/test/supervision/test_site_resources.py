"""The resources of a site follow from its devices and stations."""
from __future__ import annotations

from fleet_builders import corridor

from fleet_core.fleet import Fleet
from fleet_core.interlocking.resources import Resource, ResourceKind
from fleet_core.supervision.networks import Networks
from fleet_core.supervision.site_resources import resources_of
from fleet_core.work.devices import Device, DeviceKind
from fleet_core.work.site_work import SiteWork
from fleet_core.work.stations import Station

DOORS = (DeviceKind.DOOR, DeviceKind.AIR_LOCK, DeviceKind.LIGHT)  # edges lead through them
WORK = SiteWork(
    stations={'press': Station('press', (2,)), 'shelves': Station('shelves', (5, 6), capacity=2)},
    devices={kind.value: Device(kind.value, kind, (3, 4), 10.0) for kind in DOORS})


def test_a_device_is_a_resource_for_one_robot_that_must_report_that_it_is_open() -> None:
    door = resources_of(WORK)[0]
    assert door == Resource('door', ResourceKind.DOOR, frozenset({3, 4}), has_device=True)
    assert [one.kind.name for one in resources_of(WORK)[:3]] == [kind.name for kind in DOORS]


def test_a_station_is_a_resource_for_as_many_robots_as_its_capacity_says() -> None:
    assert resources_of(WORK)[3:] == (
        Resource('press', ResourceKind.STATION, vertices=frozenset({2})),
        Resource('shelves', ResourceKind.STATION, vertices=frozenset({5, 6}), capacity=2))


def test_the_planner_is_told_the_places_of_resources_for_one_robot() -> None:
    told = Networks(corridor(8), Fleet((), (), 0.1), resources=resources_of(WORK)
                    ).network.geometry.alone
    assert [(set(one.edges), set(one.vertices)) for one in told] == [
        ({3, 4}, set())] * 3 + [(set(), {2})]
