"""Learned edge times: which drives count, and when learned times replace the nominal time."""
from __future__ import annotations

import pytest
from fleet_builders import AGV, complete, corridor, grant

from fleet_core.interlocking.reports import GraphPosition
from fleet_core.interlocking.route_record import RouteRecord
from fleet_core.supervision.edge_times import ENOUGH, PERIOD, Driven, EdgeTimer, EdgeTimes
from world.supervised_fleet import SupervisedFleet

NOMINAL = 2.0  # s; time for each edge


@pytest.fixture
def record():
    record = RouteRecord(corridor(5), AGV)
    record.position = GraphPosition(vertex=1)
    return record


def nominal(kind, edge):
    return NOMINAL


def learned(*seconds, table=None):
    """Returns the learned times after these drives of edge 1 and one tick of the clock."""
    times = table or EdgeTimes(nominal)
    for edge in (2, 3):
        for _ in range(ENOUGH):
            times.learn('agv', Driven(edge, NOMINAL))
    for each in seconds:
        times.learn('agv', Driven(1, each))
    times.renew(PERIOD)
    return times


def test_an_edge_is_timed_from_its_order_to_its_completion(record):
    timer = EdgeTimer()
    assert timer.follow(record, 0.0) is None
    grant(record, [1, 2])
    assert timer.follow(record, 10.0) is None
    complete(record, 1)
    assert timer.follow(record, 13.0) == Driven(1, 3.0)
    complete(record, 2)
    assert timer.follow(record, 15.5) == Driven(2, 2.5)


def test_waiting_at_a_vertex_is_not_driving(record):
    timer = EdgeTimer()
    grant(record, [1])
    timer.follow(record, 0.0)
    complete(record, 1)
    timer.follow(record, 2.0)
    timer.follow(record, 100.0)
    grant(record, [2])
    timer.follow(record, 101.0)
    complete(record, 2)
    assert timer.follow(record, 103.0) == Driven(2, 2.0)


def test_what_was_not_seen_from_end_to_end_does_not_count(record):
    timer = EdgeTimer()
    grant(record, [1, 2, 3, 4])
    timer.follow(record, 0.0)  # the robot already drives when it is first seen, as after a restart
    complete(record, 1)
    assert timer.follow(record, 1.0) is None
    complete(record, 3)
    assert timer.follow(record, 5.0) is None, 'both edges ended in one report'
    timer.stop()
    complete(record, 4)
    assert timer.follow(record, 6.0) is None, 'the robot was stopped on the way'


def test_a_drive_from_the_middle_of_an_edge_does_not_count(record):
    timer = EdgeTimer()
    record.position = GraphPosition(edge=1, fraction=0.5)
    timer.follow(record, 0.0)
    grant(record, [1])
    timer.follow(record, 1.0)
    complete(record, 1)
    assert timer.follow(record, 2.0) is None


def test_the_median_of_enough_drives_replaces_the_nominal_time():
    assert learned(*[4.0] * (ENOUGH - 1)).table == {}
    assert learned(4.0, 90.0, 4.0, 4.0).table['agv', 1] == 4.0, 'one long wait does not count'


def test_small_changes_are_not_worth_a_new_table():
    assert learned(2.1, 2.2, 2.1).table == {}
    times = learned(4.0, 4.0, 4.0)
    before = times.table
    for _ in range(9):
        times.learn('agv', Driven(1, 4.1))
    assert not times.renew(3.0 * PERIOD) and times.table is before


def test_tables_come_seldom():
    times = learned(4.0, 4.0, 4.0)
    for _ in range(9):
        times.learn('agv', Driven(1, 9.0))
    assert not times.renew(1.5 * PERIOD)
    assert times.renew(2.0 * PERIOD) and times.table['agv', 1] == 9.0


def test_what_is_slow_everywhere_makes_no_unknown_edge_look_fast():
    fleet = SupervisedFleet(corridor(3), {'a': (AGV, 1)})
    fleet.agvs['a'].pace = 0.5
    for id in range(1, 9):
        fleet.request(id, 3 if id % 2 else 1)
        fleet.run_until_done(id)
    fleet.run(PERIOD)
    assert fleet.supervisor.networks.edge_times.table == {}


def test_the_fleet_plans_by_learned_times():
    fleet = SupervisedFleet(corridor(3), {'a': (AGV, 1)})
    for edge, seconds in ((1, 6.0), (2, 2.0), (-1, 2.0)):
        for _ in range(ENOUGH):
            fleet.supervisor.networks.edge_times.learn(AGV.name, Driven(edge, seconds))
    fleet.step()
    fleet.request(1, 3)
    fleet.run(1.0)
    drive = fleet.supervisor.plan_executor.plan.plan_of('a').drives[0]
    assert drive.end - drive.start == pytest.approx(6.0)
