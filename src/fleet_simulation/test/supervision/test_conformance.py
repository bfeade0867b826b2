"""Each event of the supervisor must be a step of the model of allocations. The check finds all
other events.

All tests of virtual fleets run with this check after each event (`StrictConformance`).
"""
from __future__ import annotations

import math
from typing import Callable

import pytest
from fleet_builders import AGV, corridor, graph_of

from fleet_core.interlocking import interlocking
from fleet_core.interlocking.claims import Claims
from fleet_core.interlocking.conformance import Conformance, Invariant
from fleet_core.interlocking.interlocking import Interlocking
from fleet_core.interlocking.resources import Resource, ResourceKind
from fleet_core.interlocking.route_master import RouteMaster
from fleet_core.interlocking.route_record import RouteRecord
from fleet_core.supervision import supervisor
from fleet_core.supervision.fleet_stop import StopCause
from fleet_core.supervision.networks import Networks
from fleet_core.supervision.outbox import Outbox
from fleet_core.supervision.settings import RobotSettings
from fleet_core.supervision.supervisor import Supervisor
from fleet_simulation.report_times import Rhythm
from world.supervised_fleet import SupervisedFleet


def fleet_that_drives() -> SupervisedFleet:
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)},
                            settings=RobotSettings(release_ahead=5.0))
    fleet.run(2.0)
    fleet.request(1, 8)
    return fleet


def test_a_fleet_that_works_breaks_nothing() -> None:
    fleet = fleet_that_drives()
    fleet.run_until_done(1)


def test_an_edge_that_was_not_granted_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Conformance, 'granted', lambda *_: None)
    with pytest.raises(AssertionError, match=Invariant.CHECKED.value):
        fleet_that_drives().run(5.0)


def test_an_order_that_is_sent_before_it_is_stored_is_found(
        monkeypatch: pytest.MonkeyPatch) -> None:
    fleet = fleet_that_drives()
    monkeypatch.setattr(Outbox, '_store', lambda *_: None)
    with pytest.raises(AssertionError, match=Invariant.STORED.value):
        fleet.run(5.0)


def test_an_edge_that_an_allocation_forgets_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    holds = RouteRecord.holds
    monkeypatch.setattr(RouteRecord, 'holds', lambda record: holds(record)[:1])
    with pytest.raises(AssertionError, match=Invariant.CONTAINED.value):
        fleet_that_drives().run(5.0)


def test_robots_that_exclude_each_other_and_are_not_stopped_are_found(
        monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Interlocking, 'separate', lambda *_: [])
    graph = graph_of({1: (0, 0), 2: (12, 0), 3: (0, 5), 4: (12, 5)}, {1: (1, 2), 2: (3, 4)})
    fleet = SupervisedFleet(graph, {'a': (AGV, 1), 'b': (AGV, 3)}, planning=0.05,
                            rhythm=Rhythm(room=math.inf))  # a person pushes robot b into a's way
    fleet.run(2.0)
    fleet.request(1, 2, robot='a')
    fleet.run(2.0)
    pushed = fleet.agvs['b']
    pushed.edge, pushed.arc = 1, 8.0
    with pytest.raises(AssertionError, match=Invariant.APART.value):
        fleet.run(5.0)


def test_a_change_that_the_interlocking_does_not_read_is_found(
        monkeypatch: pytest.MonkeyPatch) -> None:
    fleet = fleet_that_drives()
    fleet.run(0.5)
    for robot in fleet.supervisor.robots.values():
        monkeypatch.setattr(robot.master, '_tell', lambda: None)
    with pytest.raises(AssertionError, match=Invariant.READ.value):
        fleet.run(5.0)


def fleet_at_a_zone() -> SupervisedFleet:
    """Returns two robots that are to drive through the same zone from opposite sides."""
    zone = Resource('hall', ResourceKind.ZONE, frozenset({3, 6}))
    fleet = SupervisedFleet(corridor(9), {'a': (AGV, 1), 'b': (AGV, 9)},
                            settings=RobotSettings(release_ahead=5.0), resources=(zone,))
    fleet.run(2.0)
    fleet.request(1, 5, robot='a')
    fleet.request(2, 6, robot='b')
    return fleet


def left_out(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(interlocking, 'CONDITIONS', interlocking.WITHOUT_CLAIMS)


def ended_while_needed(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Claims, '_kept', lambda claims, name: claims._wanted.get(name, frozenset()))


def more_than_there_is(patch: pytest.MonkeyPatch) -> None:
    """Lets robots claim a full zone, and lets the planner ignore zones."""
    patch.setattr(Claims, '_is_free', lambda *_: True)
    patch.setattr(supervisor, 'Networks', lambda *of: Networks(*of[:3]))


def not_stored(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Claims, 'stored_of', lambda *_: frozenset())
    patch.setattr(Claims, 'keeping_out', lambda *_: '')


@pytest.mark.parametrize(('plant', 'invariant'), [
    (left_out, Invariant.GRANTED), (ended_while_needed, Invariant.CLAIMED),
    (more_than_there_is, Invariant.CAPACITY), (not_stored, Invariant.GRANTED)])
def test_a_fault_of_claims_is_found(plant: Callable[[pytest.MonkeyPatch], None],
                                    invariant: Invariant,
                                    monkeypatch: pytest.MonkeyPatch) -> None:
    plant(monkeypatch)
    with pytest.raises(AssertionError, match=invariant.value):
        fleet_at_a_zone().run(20.0)


def test_a_site_that_checks_itself_stops_the_fleet(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Interlocking, 'violations', lambda _: [])
    fleet = fleet_that_drives()
    fleet.run(1.0)
    monkeypatch.undo()
    supervisor: Supervisor = fleet.supervisor
    supervisor.interlocking._conformance = Conformance()
    fleet.run(0.2)
    master: RouteMaster = supervisor.robots['a'].master
    master.extend([7])
    fleet.run(0.5)
    assert supervisor.is_stopped and supervisor.stop.cause is StopCause.DEFECT
    assert any('An error of the fleet manager: a: ' in note for note in fleet.notes)
