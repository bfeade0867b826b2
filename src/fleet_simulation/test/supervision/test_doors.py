"""Doors and zones: no robot is in them without a claim, and no door closes on a robot."""
from __future__ import annotations

from random import Random
from typing import Any, List, Sequence

import pytest
from fleet_builders import AGV, corridor, graph_of

from fleet_core.interlocking.claims import ClaimState
from fleet_core.interlocking.resources import Resource, ResourceKind
from fleet_core.supervision.device_desk import FRESH
from fleet_core.supervision.missions import CommandKind, MissionState, Request
from fleet_core.supervision.resource_view import ClaimView, resource_views
from fleet_core.supervision.settings import RobotSettings
from fleet_core.supervision.waits import WaitCode
from fleet_core.supervision.why import mission_reason
from fleet_core.work.devices import Device, DeviceKind
from fleet_core.work.site_work import SiteWork
from fleet_core.work.stations import Station
from fleet_core.work.zones import Zone
from fleet_simulation.virtual_fleet import Crash
from route_protocol.devices import DeviceMode
from world.chaos import PARKING, ROBOTS, VERTICES, YARD
from world.supervised_fleet import SupervisedFleet

GATE = Resource('gate', ResourceKind.DOOR, frozenset({3}), has_device=True)


class FleetWithDoors(SupervisedFleet):
    """A fleet that checks, in each step, the robots on the edges of resources.

    A resource must not have more robots than its capacity, and its device must be open for each
    robot.
    """

    def __init__(self, *given: Any, resources: Sequence[Resource] = (GATE,), **more: Any) -> None:
        self.entered: List[str] = []
        super().__init__(*given, resources=resources, **more)

    def step(self) -> None:
        super().step()
        for resource in self.resources:
            inside = [name for name, agv in self.agvs.items() if abs(agv.edge) in resource.edges
                      and 0.0 < agv.arc < self.graph.curve(agv.edge).length]
            assert len(inside) <= resource.capacity, self.picture()
            for name in inside:
                if self.entered[-1:] != [name]:
                    self.entered.append(name)
                if resource.has_device:
                    device = self.devices[resource.name]
                    assert device.mode is DeviceMode.OPEN and device.is_held, self.picture()
                    assert resource.name in self.supervisor.interlocking.claims.stored_of(name), (
                        self.picture())


def fleet_at_a_door(**more: Any) -> FleetWithDoors:
    fleet = FleetWithDoors(corridor(6), {'a': (AGV, 1)}, settings=RobotSettings(release_ahead=3.0),
                           **more)
    fleet.run(2.0)
    return fleet


def state(fleet: SupervisedFleet, name: str = 'a', resource: str = 'gate') -> object:
    return fleet.supervisor.interlocking.claims.state(name, resource)


def test_a_robot_waits_for_a_door_drives_through_and_the_door_closes() -> None:
    fleet = fleet_at_a_door()
    fleet.request(1, 6)
    fleet.run_until_done(1)
    fleet.run(3.0)
    assert fleet.entered == ['a'] and state(fleet) is None
    assert fleet.devices['gate'].mode is DeviceMode.CLOSED


def test_a_door_opens_while_the_robot_comes_near() -> None:
    fleet = fleet_at_a_door()
    fleet.request(1, 6)
    fleet.run_until(lambda: state(fleet) is ClaimState.ASKED)
    assert fleet.agvs['a'].position[0] < 2.0
    fleet.run_until(lambda: state(fleet) is ClaimState.IN_USE)


def test_a_robot_that_waits_for_a_door_says_so() -> None:
    fleet = fleet_at_a_door()
    fleet.devices['gate'].is_silent = True
    fleet.request(1, 6)
    fleet.run(20.0)
    assert fleet.supervisor.plan_executor.waits_for['a'] == 'door gate'
    assert not fleet.entered and fleet.state(1) is MissionState.ACTIVE
    reason = mission_reason(fleet.supervisor.book.of_robot('a'), fleet.supervisor, fleet.now)
    assert reason.wait.code is WaitCode.RESOURCE
    assert reason.wait.text.startswith('door gate (OFFLINE: its reports are old')
    fleet.devices['gate'].is_silent = False
    fleet.run_until_done(1)


def test_a_claim_is_returned_when_the_mission_is_cancelled_before_the_door() -> None:
    fleet = fleet_at_a_door()
    fleet.devices['gate'].is_silent = True
    fleet.request(1, 6)
    fleet.run_until(lambda: state(fleet) is ClaimState.ASKED)
    fleet.do(fleet.supervisor.command(1, CommandKind.CANCEL, fleet.now))
    fleet.run_until(lambda: state(fleet) is None, limit=5.0)
    assert not fleet.devices['gate'].is_held


def fleet_in_a_silent_door() -> FleetWithDoors:
    """Returns a fleet in which a robot was stopped in the door, and then the door fell silent."""
    fleet = fleet_at_a_door()
    fleet.request(1, 6)
    fleet.run_until(lambda: bool(fleet.entered) and fleet.agvs['a'].arc > 0.8)
    fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    fleet.devices['gate'].is_silent = True
    fleet.run(FRESH + 2.0)
    return fleet


def alarms(fleet: SupervisedFleet) -> List[str]:
    return [note for note in fleet.notes if 'a is where it needs the door gate' in note]


def test_a_door_that_falls_silent_raises_an_alarm_for_the_robot_in_it() -> None:
    fleet = fleet_in_a_silent_door()
    assert state(fleet) is ClaimState.LOST and len(alarms(fleet)) == 1
    view, = resource_views(fleet.supervisor, fleet.now)
    assert view.claims == (ClaimView('a', ClaimState.LOST),)
    assert view.device is not None and view.device.mode is DeviceMode.OFFLINE
    assert view.alarms == [
        'a is where it needs the door gate, which does not report that it is open']


def test_a_robot_in_a_silent_door_may_leave_it() -> None:
    fleet = fleet_in_a_silent_door()
    fleet.do(fleet.supervisor.resume_fleet(fleet.now)[1])
    fleet.run_until_done(1)


def test_a_robot_in_a_silent_door_keeps_its_claim_whatever_time_passes() -> None:
    fleet = fleet_in_a_silent_door()
    fleet.run(30.0)
    fleet.restart()
    fleet.run(30.0)
    assert state(fleet) is ClaimState.LOST and fleet.devices['gate'].is_held


def fails(fleet: FleetWithDoors) -> None:
    """Lets the door close by itself and report nothing."""
    fleet.devices['gate'].is_silent, fleet.devices['gate'].request = True, None


def goes_on_when_the_door_works(fleet: FleetWithDoors) -> None:
    """Checks that the robot waits before the door until the door works again.

    The robot must have no outage.
    """
    fleet.run(20.0)
    assert not fleet.entered and state(fleet) is ClaimState.ASKED
    assert fleet.supervisor.robots['a'].outage is None
    assert fleet.supervisor.plan_executor.waits_for['a'] == 'door gate'
    fleet.devices['gate'].is_silent = False
    fleet.devices['gate'].restart()
    fleet.run_until_done(1)


def test_a_route_that_leads_into_a_door_ends_before_it_when_the_door_falls_silent() -> None:
    fleet = fleet_at_a_door()
    fleet.request(1, 6)
    fleet.run_until(lambda: state(fleet) is ClaimState.IN_USE)
    assert not fleet.entered
    fleet.agvs['a'].stalled = FRESH + 2.0
    fails(fleet)
    goes_on_when_the_door_works(fleet)


def fleet_that_waits_at_a_slow_door() -> FleetWithDoors:
    fleet = fleet_at_a_door()
    fleet.devices['gate'].seconds = 12.0
    fleet.request(1, 6)
    fleet.run_until(lambda: state(fleet) is ClaimState.ASKED)
    fleet.run(8.0)
    assert state(fleet) is ClaimState.ASKED and not fleet.agvs['a'].is_driving
    return fleet


def test_an_order_that_was_stored_before_a_restart_is_not_sent_into_a_door_that_has_closed(
        ) -> None:
    fleet = fleet_that_waits_at_a_slow_door()
    fleet.crash = Crash(fleet.disk.commits + 1)
    fleet.run_until(lambda: fleet.crash is None)
    assert fleet.supervisor.robots['a'].record.ahead, 'the order is stored'
    fails(fleet)
    goes_on_when_the_door_works(fleet)


def test_an_order_whose_commit_takes_long_does_not_leave_by_an_old_report() -> None:
    fleet = fleet_that_waits_at_a_slow_door()
    hang = fleet.disk._hang

    def fails_and_hangs(seconds: float) -> None:
        fails(fleet)
        hang(seconds)

    fleet.disk.seconds, fleet.disk._hang = FRESH + 1.0, fails_and_hangs
    fleet.run_until(lambda: fleet.devices['gate'].is_silent)
    goes_on_when_the_door_works(fleet)


def test_after_a_restart_a_door_is_asked_anew_before_a_robot_is_let_in() -> None:
    fleet = fleet_at_a_door()
    fleet.request(1, 6)
    fleet.run_until(lambda: state(fleet) is ClaimState.READY or bool(fleet.entered))
    asked = fleet.supervisor.interlocking.claims.number
    fleet.restart()
    assert fleet.supervisor.interlocking.claims.number > asked
    assert state(fleet) is not ClaimState.READY
    fleet.run_until_done(1)


def test_a_door_that_forgets_its_request_is_asked_again() -> None:
    fleet = fleet_at_a_door()
    fleet.request(1, 6)
    fleet.run_until(lambda: state(fleet) is ClaimState.ASKED)
    fleet.devices['gate'].restart()
    fleet.run_until_done(1)


def test_requests_and_reports_may_be_lost_and_come_twice() -> None:
    fleet = fleet_at_a_door(loss=0.4, repeats=0.3, seed=3)
    fleet.request(1, 6)
    if fleet.supervisor.book.find(1) is None:
        fleet.request(1, 6)
    fleet.run_until_done(1)
    assert fleet.entered == ['a']


JUNCTION = graph_of({1: (0, 0), 2: (2, 0), 3: (4, 0), 4: (4, 4), 5: (4, 6), 6: (4, 8), 7: (6, 0),
                     8: (8, 0), 9: (10, 0)},
                    {1: (1, 2), 2: (2, 3), 3: (3, 4), 4: (4, 5), 5: (5, 6), 6: (3, 7), 7: (7, 8),
                     8: (8, 9)})


def test_robots_do_not_wait_for_each_other_in_a_ring_although_a_zone_has_places_far_apart(
        ) -> None:
    """`b` is to pass the junction first. So `a`, which is nearer, must not wait in the zone."""
    zone = Resource('hall', ResourceKind.ZONE, vertices=frozenset({2, 4}))
    fleet = FleetWithDoors(JUNCTION, {'a': (AGV, 1), 'b': (AGV, 6)}, resources=(zone,),
                           settings=RobotSettings(release_ahead=3.0))
    fleet.run(2.0)
    fleet.do(fleet.supervisor.requests((Request(1, (9,), robot='b', priority=5),
                                        Request(2, (8,), robot='a')), fleet.now))
    fleet.run_until_done(1, 2)


def test_robots_share_zones_and_stations_and_all_missions_end() -> None:
    draw = Random(1)
    hall = Resource('hall', ResourceKind.ZONE, frozenset(draw.sample(sorted(YARD.edges), 4)))
    press = Resource('press', ResourceKind.STATION, vertices=frozenset({draw.choice(VERTICES)}))
    fleet = FleetWithDoors(YARD, {name: (AGV, 21 + k) for k, name in enumerate(ROBOTS)},
                           resources=(hall, press), parking=PARKING,
                           settings=RobotSettings(release_ahead=3.0))
    fleet.run(2.0)
    for id in range(1, 10):
        fleet.request(id, *draw.sample(VERTICES, 3))
    fleet.run_until_done(*range(1, 10))


@pytest.mark.parametrize('commit', range(1, 40, 3))
def test_the_supervisor_may_die_at_any_commit_and_no_door_closes_on_a_robot(commit: int) -> None:
    fleet = fleet_at_a_door()
    fleet.crash = Crash(fleet.disk.commits + commit)
    fleet.request(1, 6)
    if fleet.supervisor.book.find(1) is None:
        fleet.request(1, 6)
    fleet.run_until_done(1)
    assert fleet.entered == ['a']


def test_a_zone_of_a_work_file_is_for_one_robot_at_a_time() -> None:
    hall = Zone('hall', (3,), (4, 6))
    fleet = FleetWithDoors(corridor(8), {'a': (AGV, 1), 'b': (AGV, 8)}, resources=(), work=SiteWork(
        zones={'hall': hall}), settings=RobotSettings(release_ahead=3.0))
    fleet.run(2.0)
    fleet.request(1, 4, robot='a', dwells=(30.0,))
    fleet.run_until(lambda: state(fleet, 'a', 'hall') is ClaimState.IN_USE)
    fleet.request(2, 6, robot='b')
    fleet.run(20.0)
    assert state(fleet, 'b', 'hall') is not ClaimState.IN_USE
    assert fleet.agvs['b'].visited[-1] == 7
    fleet.run_until_done(1, 2)
    assert state(fleet, 'b', 'hall') is ClaimState.IN_USE


def test_the_devices_and_stations_of_a_work_file_are_claimed() -> None:
    work = SiteWork({'press': Station('press', (4,))},
                    {'door': Device('door', DeviceKind.DOOR, (2,), 10.0)})
    fleet = FleetWithDoors(corridor(6), {'a': (AGV, 1)}, resources=(), work=work)
    fleet.run(2.0)
    fleet.request(1, 4, dwells=(5.0,))
    fleet.run_until(lambda: state(fleet, 'a', 'door') is ClaimState.IN_USE)
    fleet.run_until(lambda: fleet.supervisor.robots['a'].record.position.vertex == 4)
    assert state(fleet, 'a', 'press') is ClaimState.IN_USE and state(fleet, 'a', 'door') is None
    fleet.run_until_done(1)
    fleet.request(2, 6)
    fleet.run_until_done(2)
    assert state(fleet, 'a', 'press') is None
