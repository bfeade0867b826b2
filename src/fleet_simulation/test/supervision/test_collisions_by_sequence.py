"""Sequences of events, without special timing, after which robots were once too near to each other.

In each step, the virtual world checks the distances between all robots, and fails if two are too
near.
"""
from __future__ import annotations

import math
from dataclasses import replace
from typing import List

import pytest
from fleet_builders import AGV, corridor, graph_of, ladder

from fleet_core.supervision.actions import Action, AskPlanner
from fleet_core.supervision.missions import MissionState
from fleet_core.supervision.outages import Outage
from fleet_core.supervision.settings import RobotSettings
from fleet_core.supervision.supervisor import Supervisor
from fleet_simulation.report_times import Rhythm
from route_protocol.values import TAKEN_OVER
from world.supervised_fleet import SupervisedFleet

FAR = RobotSettings(release_ahead=100.0)
NEAR = RobotSettings(release_ahead=3.0)


def outages(fleet):
    """Returns the outage of each robot by its name."""
    return {name: robot.outage for name, robot in fleet.supervisor.robots.items()}


def beyond(fleet, name):
    """Returns the distance (m) of a robot's centre from its allocation; 0: the centre is inside."""
    allocation, here = fleet.supervisor.robots[name].master.allocation, fleet.agvs[name].position
    ways = [max(min(math.dist(here, point) for point in area.line) - area.radius, 0.0)
            for area in allocation.areas]
    if allocation.vertex is not None:
        vertex = fleet.graph.vertices[allocation.vertex]
        ways.append(math.dist(here, (vertex.x, vertex.y)))
    for hold in allocation.holds:
        curve = fleet.graph.curve(hold.edge)
        found = curve.project(*here)
        left = hold.cleared * curve.length - found.arc_length
        ways.append(math.hypot(found.distance, max(left, 0.0)))
    return min(ways, default=math.inf)


# -- robots that exclude each other ----------------------------------------------------------------

TWO_ROWS = graph_of({1: (0, 5), 2: (4, 5), 3: (0, 0), 4: (12, 0), 5: (0, 1.0), 6: (12, 1.0)},
                    {1: (1, 2), 3: (3, 4), 5: (5, 6)})


@pytest.mark.parametrize(('lower', 'upper'), [('b', 'c'), ('c', 'b')])
@pytest.mark.parametrize('waiting', ['lower', 'upper'])
def test_all_robots_in_whose_way_a_robot_was_pushed_stop(lower, upper, waiting):
    fleet = SupervisedFleet(TWO_ROWS, {'a': (AGV, 1), lower: (AGV, 3), upper: (AGV, 5)},
                            settings=NEAR, planning=0.05)
    fleet.run(2.0)
    fleet.request(1, 4, robot=lower)
    fleet.request(2, 6, robot=upper)
    fleet.run(1.0)
    fleet.agvs[lower if waiting == 'lower' else upper].stalled = 100.0
    fleet.run(1.0)
    pushed = fleet.agvs['a']
    pushed.edge, pushed.arc, pushed.aside = 3, 7.0, (0.0, 0.5)
    fleet.run(15.0)
    assert outages(fleet) == dict.fromkeys('abc', Outage.TOO_NEAR)
    assert not any(agv.is_driving for agv in fleet.agvs.values())


def test_a_person_is_told_of_all_robots_that_a_robot_is_too_near_to():
    graph = graph_of({1: (0, 5), 2: (4, 5), 3: (0, 0), 4: (1.6, 0)}, {1: (1, 2), 3: (3, 4)})
    fleet = SupervisedFleet(graph, {'a': (AGV, 1), 'b': (AGV, 3), 'c': (AGV, 4)}, planning=0.05,
                            rhythm=Rhythm(room=math.inf))  # a person puts robot a between b and c
    fleet.run(2.0)
    fleet.do(fleet.supervisor.take_out('a', fleet.now))
    fleet.agvs['a'].edge, fleet.agvs['a'].arc = 3, 0.8
    fleet.run(5.0)
    problem = fleet.bring_in('a')
    assert 'b' in problem and 'c' in problem, problem


@pytest.mark.parametrize('beside', [(0.08, 0.12), (0.0, 0.16), (0.0, 0.0)])
def test_a_grant_to_a_robot_beside_its_edge_stops_no_robot_that_it_is_not_too_near_to(beside):
    """The location of `a` was not on its route. This location excluded `b` only while `a`
    had the route.

    So both robots were stopped, no person could see why, and each `fleet in` stopped them again.
    """
    graph = graph_of({1: (0, 0), 2: (2, 0), 3: (2, 1.2), 4: (2.9, 1.1), 5: (6, 1.1)},
                     {1: (1, 2), 2: (2, 3), 3: (4, 5)})
    fleet = SupervisedFleet(graph, {'a': (replace(AGV, play=0.1), 1),
                                    'b': (replace(AGV, play=0.1), 4)}, planning=0.05)
    fleet.run(2.0)
    fleet.do(fleet.supervisor.take_out('a', fleet.now))
    a = fleet.agvs['a']
    a.edge, a.arc, a.aside = 2, 0.4, beside  # a person pushes it there
    fleet.run(4.0)
    assert not fleet.bring_in('a')
    if outages(fleet)['b'] is not None:  # while robot a was moved, it could be nearer
        assert not fleet.bring_in('b')
    fleet.request(1, 1, robot='a')
    fleet.run_until_done(1)
    assert outages(fleet) == {'a': None, 'b': None}


@pytest.mark.parametrize('beside', [0.3, 0.45])
def test_a_person_is_told_that_a_robot_is_too_far_beside_the_graph_to_come_back(beside):
    fleet = SupervisedFleet(corridor(4), {'a': (replace(AGV, play=0.1), 1)}, planning=0.05)
    fleet.run(2.0)
    a = fleet.agvs['a']
    a.arc, a.aside = 1.0, (0.0, beside)
    fleet.run(4.0)
    problem = fleet.bring_in('a')
    assert bool(problem) is (beside == 0.45), problem
    fleet.run(4.0)
    if problem:
        assert '0.45 m beside' in problem
        a.aside = 0.0, 0.0
        fleet.run(4.0)
        assert not fleet.bring_in('a')
        fleet.run(4.0)
    assert outages(fleet) == {'a': None}


# -- places of robots that go on -------------------------------------------------------------------

CROSSING = graph_of({1: (0, 0), 2: (20, 0), 5: (14, -3), 6: (14, 3)}, {1: (1, 2), 5: (5, 6)})


@pytest.mark.parametrize('late', [0.0, 0.4])
@pytest.mark.parametrize('stall', [1.0, 2.0, 3.0, 3.5, 4.0, 9.0])
def test_a_robot_pushed_back_in_an_emergency_stop_is_not_sent_through_places_of_others(late, stall):
    fleet = SupervisedFleet(CROSSING, {'a': (AGV, 1), 'b': (AGV, 5)}, settings=FAR, planning=0.1)
    a, b = fleet.agvs['a'], fleet.agvs['b']
    fleet.run(2.0)
    fleet.request(1, 2, robot='a')
    fleet.run_until(lambda: a.arc > 15.5)
    fleet.request(2, 6, robot='b')
    fleet.run_until(lambda: b.is_driving)
    b.stalled = stall
    a.emergency = True
    fleet.run(1.0)
    a.arc = 11.5  # a person pushes it back along its edge, behind the crossing
    fleet.run(2.0)
    fleet.network.late['a'] = fleet.network.late['b'] = late
    a.emergency = False
    fleet.run_until(lambda: fleet.agvs['a'].is_driving or outages(fleet)['a'] is None, limit=60.0)
    fleet.run_until_done(1, 2, limit=120.0)
    assert fleet.state(1) is fleet.state(2) is MissionState.SUCCEEDED


def test_a_robot_that_chooses_another_beginning_keeps_the_place_where_it_really_stands():
    graph = graph_of({1: (-4, 0), 2: (0, 0), 3: (4, 0), 5: (-0.95, -1.05), 6: (-0.95, 3)},
                     {1: (1, 2), 2: (2, 3), 5: (5, 6)})
    fleet = SupervisedFleet(graph, {'a': (AGV, 1), 'b': (AGV, 5)}, settings=FAR, planning=0.05,
                            rhythm=Rhythm(driving=0.1, standing=1.0))
    a = fleet.agvs['a']
    fleet.run(2.0)
    fleet.request(1, 2, robot='a')
    fleet.run_until(lambda: a.arc > 3.6)
    fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    fleet.run(0.5)
    a.come_to_rest_at(3.72)
    a.near = 0.29  # `a` came to rest 0.28 m before the vertex, and counts as at the vertex
    fleet.run(3.0)
    fleet.request(2, 6, robot='b')
    fleet.do(fleet.supervisor.resume_fleet(fleet.now)[1])
    for _ in range(100):
        fleet.step()
        assert beyond(fleet, 'a') < 0.1, fleet.picture()
    assert fleet.refused['a'], 'it was to refuse a route that begins on its edge'


# -- robots that a person drives -------------------------------------------------------------------

BY_HAND = graph_of({1: (0, 0), 2: (3, 0), 3: (12, 0), 5: (8.0, -3.0), 6: (8.0, 3)},
                   {1: (1, 2), 2: (2, 3), 5: (5, 6)})


@pytest.mark.parametrize('fault', ['silent', 'link lost', 'no location', 'clock set back'])
def test_a_robot_driven_on_by_hand_without_new_locations_is_not_met_by_others(fault):
    fleet = SupervisedFleet(BY_HAND, {'a': (AGV, 1), 'b': (AGV, 5)}, settings=NEAR, planning=0.05,
                            rhythm=Rhythm(driving=0.1, standing=0.5))
    a = fleet.agvs['a']
    fleet.run(2.0)
    fleet.request(1, 2, robot='a')
    fleet.run(1.0)
    a.fail(TAKEN_OVER)
    a.edge, a.arc = 1, 3.0
    fleet.run(0.5)
    a.edge, a.arc = 2, 0.0
    for _ in range(30):
        a.arc += 0.1
        fleet.step()
    if fault == 'silent':
        fleet.network.silent['a'] = math.inf
    elif fault == 'link lost':
        fleet.lose_link('a')
    elif fault == 'clock set back':
        fleet.clocks['a'] = -9.0
    else:
        a.off_graph = True
    for _ in range(20):  # `a` drives on to the crossing, and waits there
        a.arc += 0.1
        fleet.step()
        assert not beyond(fleet, 'a'), f'{beyond(fleet, "a"):.2f} m outside: {fleet.picture()}'
    fleet.run(10.0 if fault != 'clock set back' else 1.0)
    fleet.request(2, 6, robot='b')
    fleet.run(12.0)


@pytest.mark.parametrize('pace', [0.3, 1.0])
@pytest.mark.parametrize('period', [0.1, 0.5, 1.0, 1.9])
def test_a_robot_driven_by_hand_is_inside_its_places_from_the_first_report_of_it_on(period, pace):
    fleet = SupervisedFleet(graph_of({1: (0, 0), 2: (10, 0)}, {1: (1, 2)}), {'a': (AGV, 1)},
                            settings=NEAR, planning=0.05,
                            rhythm=Rhythm(driving=0.1, standing=period))
    a = fleet.agvs['a']
    fleet.run(2.0)
    fleet.do(fleet.supervisor.take_out('a', fleet.now))
    fleet.run(1.0)
    was_seen = False
    while a.arc < 9.0:
        a.arc += 0.1 * pace
        fleet.step()
        was_seen |= fleet.supervisor.robots['a'].record.pose.fraction > 0.006
        assert not was_seen or not beyond(fleet, 'a'), (
            f'{beyond(fleet, "a"):.2f} m outside: {fleet.picture()}')
    assert was_seen


def test_the_places_of_a_robot_driven_by_hand_shrink_when_it_stands():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)}, settings=NEAR, planning=0.05)
    a = fleet.agvs['a']
    fleet.run(2.0)
    for _ in range(10):
        a.arc += 0.1
        fleet.step()
    fleet.run(3.0)
    areas = fleet.supervisor.robots['a'].master.allocation.areas
    assert max(area.radius for area in areas) <= 0.1


# -- an older journal ------------------------------------------------------------------------------

def start_with(copy, fleet):
    """Ends the supervisor, replaces its journal by a copy, and starts the supervisor again."""
    fleet.disk.put_back(copy)
    fleet.restart()


def with_an_older_journal(restarts, drives):
    """Returns a fleet with an older journal, in which `c` is at another place. The silent `c` is in
    the way of `a`.

    restarts -- number of restarts after the copy was made; 0: only reports show its age
    drives   -- whether `a` has a route when the supervisor ends
    """
    fleet = SupervisedFleet(ladder(6), {'a': (AGV, 1), 'b': (AGV, 101), 'c': (AGV, 106)},
                            settings=NEAR, planning=0.05)
    fleet.run(2.0)
    old = fleet.disk.copy()
    for _ in range(restarts):
        fleet.restart()
        fleet.run(2.0)
    fleet.request(1, 3, robot='c')
    fleet.request(2, 2, robot='a')
    fleet.run_until_done(1, 2)
    fleet.network.silent['c'] = math.inf  # `c` is switched off in the middle of the lower row
    fleet.run(7.0)
    if drives:
        fleet.request(3, 1, robot='a')
        fleet.run(1.0)
    start_with(old, fleet)
    fleet.run(15.0)
    fleet.request(7, 5, robot='a')
    fleet.run(20.0)
    return fleet


WAYS_TO_AN_OLDER_JOURNAL = [
    pytest.mark.parametrize('restarts', [0, 1], ids=['same_run', 'later_run']),
    pytest.mark.parametrize('drives', [True, False], ids=['driving', 'standing'])]


def in_all_ways(test):
    """Runs the test once for each way in which an older journal can replace the present one."""
    for mark in WAYS_TO_AN_OLDER_JOURNAL:
        test = mark(test)
    return test


@in_all_ways
def test_by_an_older_journal_no_robot_drives_before_all_have_reported(restarts, drives):
    fleet = with_an_older_journal(restarts, drives)
    assert fleet.supervisor.unknown == ['c']
    assert not fleet.agvs['a'].is_driving
    fleet.restart()  # a restart does not correct the old place of c
    fleet.run(20.0)
    assert fleet.supervisor.unknown == ['c'] and not fleet.agvs['a'].is_driving
    del fleet.network.silent['c']
    fleet.run_until_done(7)
    assert fleet.state(7) is MissionState.SUCCEEDED
    fleet.restart()
    fleet.network.silent['c'] = fleet.now + 3.0
    fleet.run(1.0)
    assert not fleet.supervisor.unknown, 'the journal is believed again'


@in_all_ways
def test_places_in_an_older_journal_that_are_believed_are_found(restarts, drives, monkeypatch):
    monkeypatch.setattr(Supervisor, '_doubt_journal', lambda *_: None)
    with pytest.raises(AssertionError, match='too near'):
        with_an_older_journal(restarts, drives)


def test_a_fleet_that_is_stopped_by_an_older_journal_stops_also_robots_with_later_orders():
    """The clock was also set back, so the first stop has a number that an earlier order already
    had.
    """
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)}, settings=FAR, planning=0.05)
    fleet.run(2.0)
    fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    fleet.run(1.0)
    old = fleet.disk.copy()
    fleet.do(fleet.supervisor.resume_fleet(fleet.now)[1])
    fleet.request(1, 8, robot='a')
    fleet.run(3.0)
    assert fleet.agvs['a'].is_driving
    fleet.disk.set_back = 3600.0
    start_with(old, fleet)
    assert fleet.supervisor.is_stopped
    fleet.run(2.0)
    assert not fleet.agvs['a'].is_driving
    fleet.run(3.0)
    fleet.do(fleet.supervisor.resume_fleet(fleet.now)[1])
    fleet.request(2, 8, robot='a')
    fleet.run_until_done(2)


def test_by_an_older_journal_a_person_may_say_that_a_robot_is_not_on_the_site():
    fleet = SupervisedFleet(ladder(6), {'a': (AGV, 1), 'c': (AGV, 106)}, planning=0.05)
    fleet.run(2.0)
    old = fleet.disk.copy()
    fleet.restart()
    fleet.run(2.0)
    fleet.network.silent['c'] = math.inf
    start_with(old, fleet)
    fleet.run(7.0)
    fleet.request(1, 5, robot='a')
    fleet.run(3.0)
    assert fleet.supervisor.unknown == ['c'] and not fleet.agvs['a'].is_driving
    problem, actions = fleet.supervisor.declare_absent('c', fleet.now)
    fleet.do(actions)
    fleet.run_until_done(1)
    assert not problem and not fleet.supervisor.unknown


def test_a_restart_with_the_same_journal_believes_it():
    fleet = SupervisedFleet(ladder(6), {'a': (AGV, 1), 'c': (AGV, 106)}, planning=0.05)
    fleet.run(2.0)
    fleet.request(1, 3, robot='a')
    fleet.run(2.0)
    fleet.network.silent['c'] = math.inf
    for _ in range(3):
        fleet.restart()
        fleet.run(0.5)
        assert not fleet.supervisor.unknown
    fleet.run_until_done(1)


# -- a planner that fails --------------------------------------------------------------------------

class PoisonedFleet(SupervisedFleet):
    """A fleet whose planner fails if the question contains a plan to keep."""

    is_poisoned = False

    def _perform(self, actions: List[Action]) -> None:
        rest: List[Action] = []
        for action in actions:
            if isinstance(action, AskPlanner) and self.is_poisoned and any(
                    task.kept for task in action.tasks):
                self.do(self.supervisor.plan_failed(
                    action.number, 'it cannot use the plan that it was to keep', self.now))
            else:
                rest.append(action)
        super()._perform(rest)


def test_a_plan_on_which_the_planner_fails_is_not_kept():
    fleet = PoisonedFleet(corridor(8, siding_at=4), {'a': (AGV, 1), 'b': (AGV, 8)}, settings=NEAR,
                          planning=0.05)
    fleet.run(2.0)
    fleet.request(1, 5, robot='a')
    fleet.run(1.0)
    fleet.is_poisoned = True
    fleet.request(2, 1, robot='b')
    fleet.run_until_done(1, 2, limit=120.0)
    assert fleet.state(1) is fleet.state(2) is MissionState.SUCCEEDED
    assert not fleet.supervisor.plan_executor.trouble


# -- routes that come back to their beginning ------------------------------------------------------


@pytest.mark.parametrize('stall', [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
def test_a_robot_that_restarts_and_drives_a_loop_again_does_not_meet_others(stall):
    """After the restart, the robot's allocation grows without a check, so all robots in its way
    must stop.
    """
    graph = graph_of({1: (0, 0), 2: (8, 0), 3: (4, 6), 4: (-6, 0), 5: (4, -1.2), 6: (4, 2.5)},
                     {1: (1, 2), 2: (2, 3), 3: (3, 1), 4: (1, 4), 5: (5, 6)}, one_way=(1, 2, 3))
    fleet = SupervisedFleet(graph, {'a': (AGV, 1), 'b': (AGV, 5)}, settings=NEAR, planning=0.05)
    a, b = fleet.agvs['a'], fleet.agvs['b']
    fleet.run(2.0)
    fleet.request(1, 2, 3, 4, robot='a')
    fleet.run_until(lambda: a.is_driving and a.edge == 3 and a.arc > 3.0)
    fleet.network.deaf['a'] = math.inf
    fleet.run_until(lambda: not a.is_driving)
    fleet.request(2, 6, robot='b')
    fleet.run(0.4)
    b.stalled = stall
    # the order is repeated before the supervisor gets the report without a route
    fleet.network.late['a'] = 0.4
    fleet.run_until(lambda: any(o.robot == 'a' and o.edges for o in fleet.network.to_robots), 3.0)
    a.forget()
    fleet.network.deaf['a'] = 0.0
    fleet.run(10.0)
