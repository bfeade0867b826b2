"""The resources of a site follow from its devices and stations, and the docks of its fleet."""
from __future__ import annotations

from dataclasses import replace
from typing import Tuple

from fleet_builders import AGV, corridor, with_docks

from fleet_core.fleet import Fleet
from fleet_core.interlocking.resources import Resource, ResourceKind
from fleet_core.supervision.networks import Networks
from fleet_core.supervision.site_resources import chargers_of, resources_of
from fleet_core.work.chargers import Charger
from fleet_core.work.devices import Device, DeviceKind
from fleet_core.work.site_work import SiteWork
from fleet_core.work.stations import Station
from fleet_core.work.zones import Zone

DOORS = (DeviceKind.DOOR, DeviceKind.AIR_LOCK, DeviceKind.LIGHT)  # kinds through which edges lead
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


def test_a_zone_is_a_resource_of_edges_and_vertices_without_a_device() -> None:
    work = SiteWork(zones={'hall': Zone('hall', (1, 2), (4,), 2)})
    assert resources_of(work) == (
        Resource('hall', ResourceKind.ZONE, frozenset({1, 2}), frozenset({4}), 2),)


def test_the_planner_is_told_the_places_of_resources_for_one_robot_if_there_are_several() -> None:
    bay = Charger('bay', (7, 8))
    told = Networks(corridor(8), Fleet((), (), 0.1), resources=resources_of(WORK, (bay,))
                    ).network.geometry.alone
    assert [(set(one.edges), set(one.vertices)) for one in told] == [
        ({3, 4}, set())] * 3 + [(set(), {7, 8})]


# -- chargers --------------------------------------------------------------------------------------

SITE = with_docks(corridor(8), 1, 7, 8)


def chargers(work: SiteWork, *docks: int) -> Tuple[Charger, ...]:
    fleet = Fleet((replace(AGV, docks=frozenset(docks)), replace(AGV, name='other')), ())
    return tuple(chargers_of(work, fleet, SITE).values())


def test_a_charger_is_a_resource_for_as_many_robots_as_its_capacity_says() -> None:
    assert resources_of(SiteWork(), (Charger('bay', (7, 8), 2),)) == (
        Resource('bay', ResourceKind.CHARGER, vertices=frozenset({7, 8}), capacity=2),)


def test_each_dock_that_a_robot_type_lists_is_a_charger_for_one_robot() -> None:
    assert chargers(SiteWork(), 7, 8) == (Charger('dock_7', (7,)), Charger('dock_8', (8,)))


def test_a_listed_vertex_that_is_no_dock_of_the_graph_is_no_charger() -> None:
    assert chargers(SiteWork(), 1, 2, 99) == (Charger('dock_1', (1,)),)


def test_a_dock_of_a_charger_in_the_work_file_is_no_charger_of_its_own() -> None:
    bay = Charger('bay', (7, 8))
    assert chargers(SiteWork(chargers={'bay': bay}), 1, 7, 8) == (bay, Charger('dock_1', (1,)))


def test_a_station_may_have_any_name() -> None:
    work = SiteWork({'dock_7': Station('dock_7', (2,))})
    assert chargers(work, 7) == (Charger('charger_dock_7', (7,)),)
