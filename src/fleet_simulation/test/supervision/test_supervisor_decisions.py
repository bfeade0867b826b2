"""Decisions of the supervisor: commands of persons have precedence; which robot is sent, which one
charges, and which one goes first.
"""
from __future__ import annotations

import math
from dataclasses import replace
from random import Random
from typing import List

import pytest
from fleet_builders import AGV, corridor, graph_of, ladder, with_docks

from fleet_core.interlocking.reports import Report
from fleet_core.supervision.actions import Note, PublishStatus
from fleet_core.supervision.assignment import assign
from fleet_core.supervision.battery import MUTE
from fleet_core.supervision.fleet_view import RobotState, robot_views
from fleet_core.supervision.missions import (
    CommandCode,
    CommandKind,
    Mission,
    MissionChange,
    MissionState,
    Request,
)
from fleet_core.supervision.outages import Outage
from fleet_core.supervision.settings import RobotSettings
from fleet_core.supervision.standstills import Standstills
from fleet_simulation.virtual_fleet import route_order
from route_protocol.values import TAKEN_OVER, EdgeState, Motion, Reason, ReasonCode, RouteReport
from trajectory_graph import Graph
from world.plain_agv import LOST_LINK
from world.supervised_fleet import SupervisedFleet, blocked

# -- the last word ---------------------------------------------------------------------------------

FAR = RobotSettings(release_ahead=8.0)


def robot(fleet, name='a'):
    return fleet.supervisor.robots[name]


# -- robots that seem to stand ---------------------------------------------------------------------


@pytest.mark.parametrize('how', ['lost link', 'stop all', 'fleet out'])
def test_who_does_not_know_where_it_is_now_does_not_stand_still(how):
    """The robot's computer reports, but its link to the robot is lost, and the robot drives on
    along its route.
    """
    fleet = SupervisedFleet(corridor(10), {'a': (AGV, 1), 'b': (AGV, 10)}, settings=FAR)
    fleet.request(1, 6, robot='a')
    fleet.run(2.0)
    agv, last = fleet.agvs['a'], fleet.agvs['a'].report(fleet.now)
    fleet.network.deaf['a'] = 1e9
    last = replace(last, motion=Motion.COMING_TO_REST)
    if how == 'lost link':
        told = replace(last, states=(EdgeState.FAILED,) * len(last.edges),
                       reason=LOST_LINK)
    else:
        fleet.do(fleet.supervisor.stop_fleet(fleet.now) if how == 'stop all' else
                 fleet.supervisor.take_out('a', fleet.now))
        owed = robot(fleet).master.order
        told = replace(last, order=owed.number, edges=(), states=(),
                       first=last.done,
                       reason=Reason(ReasonCode.STOP_OWED, 'the link is down'))

    def repeat(_: float) -> RouteReport:
        agv.knows['report'] += 1
        return replace(told, number=agv.knows['report'])
    agv.report, report = repeat, agv.report
    fleet.run(4.0)
    fleet.do(fleet.supervisor.resume_fleet(fleet.now)[1])
    fleet.do(fleet.supervisor.bring_in('a', fleet.now)[1])
    fleet.request(2, 4, robot='b')
    fleet.run(4.0)
    assert not robot(fleet).works and len(robot(fleet).record.held) >= 4
    agv.report = report
    if how != 'lost link':
        agv.receive(route_order(owed))  # its computer has kept the stop for it
    fleet.network.deaf.clear()
    fleet.run(15.0)
    assert not fleet.bring_in('a')
    fleet.run(2.0)
    assert robot(fleet).works


# -- cancelled and paused -------------------------------------------------------------------------


@pytest.mark.parametrize('ahead', [0.0, 1.0, 3.0, 8.0])
def test_a_cancelled_robot_stops_at_the_end_of_its_edge_though_it_has_another_mission(ahead):
    """The plan in force also leads to the next destination, but through the cancelled
    destination.
    """
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)}, parking=(1,),
                            settings=RobotSettings(release_ahead=ahead))
    fleet.planner.rounds = 5
    fleet.request(1, 8)
    fleet.request(2, 2, robot='a')
    fleet.run_until(lambda: fleet.agvs['a'].visited[-1] == 3)
    fleet.do(fleet.supervisor.command(1, CommandKind.CANCEL, fleet.now))
    fleet.run_until_done(2)
    assert fleet.agvs['a'].visited == [1, 2, 3, 2]


def test_a_report_from_before_the_last_order_does_not_answer_a_cancel():
    """The report shows the route as it is after the cancel, but an order for a longer route is on
    its way to the robot.
    """
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)},
                            settings=RobotSettings(release_ahead=1.0))
    fleet.request(1, 8)
    fleet.run_until(lambda: len(robot(fleet).record.ahead) > 1)
    # the order that makes the route longer
    fleet.network.to_robots, orders = [], fleet.network.to_robots
    assert len(orders[-1].edges) == 2 and fleet.agvs['a'].current == 0
    fleet.do(fleet.supervisor.command(1, CommandKind.CANCEL, fleet.now))
    fleet.do(fleet.supervisor.report('a', Report(fleet.agvs['a'].report(fleet.now)), fleet.now))
    assert len(robot(fleet).record.held) == 2, 'the robot has not received the cancel'


@pytest.mark.parametrize('command', [CommandKind.CANCEL, CommandKind.PAUSE])
def test_what_a_robot_has_not_heard_yet_is_not_ordered_after_a_cancel(command):
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)}, settings=FAR)
    fleet.run(1.0)
    fleet.network.deaf['a'] = 1e9
    fleet.request(1, 8)
    fleet.run(8.0)
    assert robot(fleet).outage is Outage.DEAF
    fleet.do(fleet.supervisor.command(1, command, fleet.now))
    fleet.run(2.0)
    sent = len(fleet.sent)
    fleet.network.deaf.clear()
    fleet.run(20.0)
    assert all(len(order.edges) <= 1 for order in fleet.sent[sent:]), fleet.sent[sent:]
    assert fleet.agvs['a'].travelled <= 2.0


def test_a_restart_orders_nothing_again_that_was_cancelled_while_the_robot_was_silent():
    fleet = SupervisedFleet(corridor(9), {'a': (AGV, 1), 'b': (AGV, 9)},
                            settings=RobotSettings(release_ahead=1.0))
    fleet.request(1, 7, robot='a')
    fleet.run_until(lambda: len(robot(fleet).record.ahead) > 1)
    fleet.network.silent['a'] = fleet.network.silent['b'] = 1e9
    fleet.agvs['a'].stalled = 1e9
    fleet.run(8.0)
    fleet.do(fleet.supervisor.command(1, CommandKind.CANCEL, fleet.now))
    fleet.run(2.0)
    sent = len(fleet.sent)
    fleet.restart()
    fleet.network.silent.pop('a')
    fleet.run(3.0)
    fleet.agvs['a'].stalled = 0.0
    fleet.run(20.0)
    assert all(len(order.edges) <= 1 for order in fleet.sent[sent:]), fleet.sent[sent:]
    assert fleet.agvs['a'].travelled <= 2.1


# -- taken over and stopped -----------------------------------------------------------------------


def test_who_was_given_a_route_by_somebody_else_is_not_ordered_what_he_has_not_heard():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 4)}, settings=FAR)
    fleet.run(1.0)
    fleet.network.deaf['a'] = 1e9
    fleet.request(1, 8)
    fleet.run(2.0)
    fleet.agvs['a'].obey_another((4,))
    fleet.run(0.5)
    assert robot(fleet).outage is Outage.TAKEN_OVER
    fleet.network.deaf.clear()
    fleet.run(20.0)
    assert fleet.agvs['a'].visited == [4, 5]
    assert not fleet.bring_in('a')


def test_an_order_that_was_under_way_as_the_robot_was_taken_over_does_not_drive_it_on():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)}, settings=FAR)
    fleet.request(1, 8)
    fleet.run(1.5)
    agv = fleet.agvs['a']
    fleet.request(2, 8, robot='a')
    fleet.do(fleet.supervisor.command(1, CommandKind.CANCEL, fleet.now))
    fleet.run_until(lambda: any(o.order.number > agv.taken for o in fleet.network.to_robots))
    order = fleet.network.to_robots.pop()
    agv.fail(TAKEN_OVER)
    fleet.run(0.1)
    assert robot(fleet).outage is Outage.TAKEN_OVER
    agv.receive(route_order(order.order))  # the order came late
    before = agv.travelled
    fleet.run(20.0)
    assert agv.travelled - before < 0.5


def test_a_stop_is_repeated_until_it_is_heard_though_the_route_has_failed():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)}, settings=FAR)
    fleet.request(1, 8)
    fleet.run(2.0)
    fleet.network.deaf['a'] = fleet.now + 3.0
    fleet.agvs['a'].fail(LOST_LINK)
    fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    fleet.run(5.0)
    assert fleet.agvs['a'].edges == (), 'the stop must have reached the robot'


# -- where robots truly are -----------------------------------------------------------------------


def taken_over_as_it_was_let_go_on():
    """Robot `a` stands in the middle of an edge. Its route has failed, so it refused further edges.
    """
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1), 'b': (AGV, 8)},
                            settings=RobotSettings(release_ahead=1.0))
    fleet.request(1, 6, robot='a')
    fleet.run_until(lambda: bool(fleet.network.to_robots) and fleet.agvs['a'].arc > 0.5)
    fleet.agvs['a'].fail(TAKEN_OVER)
    fleet.run(2.0)
    assert robot(fleet).outage is Outage.TAKEN_OVER
    return fleet


def test_where_a_person_drives_who_refused_more_is_known():
    """The robot's reports still contain the route that has failed."""
    fleet = taken_over_as_it_was_let_go_on()
    fleet.agvs['a'].edge, fleet.agvs['a'].arc = 4, 1.0
    fleet.run(0.5)
    assert 4 in blocked(fleet, 'a')[1]


@pytest.mark.parametrize('is_silent', [False, True])
def test_who_refused_more_as_it_was_taken_over_keeps_its_edge_after_a_restart(is_silent):
    fleet = taken_over_as_it_was_let_go_on()
    if is_silent:
        fleet.network.silent['a'] = 1e9
    fleet.restart()
    fleet.run(1.0)
    assert abs(fleet.agvs['a'].edge) in blocked(fleet, 'a')[1]


def test_a_plan_that_does_not_know_where_a_robot_was_carried_releases_nothing():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1), 'b': (AGV, 8)}, planning=0.6)
    fleet.run(1.0)
    fleet.do(fleet.supervisor.take_out('b', fleet.now))
    fleet.run(3.0)
    fleet.request(1, 6, robot='a')
    fleet.run(0.3)
    fleet.agvs['b'].be_carried(1, 1.9)
    fleet.run(5.0)
    assert fleet.agvs['a'].travelled == 0.0


def test_a_plan_that_does_not_know_of_a_robot_releases_nothing():
    """Robot `b` is switched on in the middle of the path of `a` while this path is planned."""
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1), 'b': (AGV, 4)}, settings=FAR)
    fleet.network.silent['b'] = 1e9
    fleet.run(6.0)
    fleet.planner.latency = 1.0
    fleet.request(1, 6, robot='a')
    fleet.run(0.5)
    fleet.network.silent.clear()
    fleet.run(10.0)


@pytest.mark.parametrize('told', ['all', 'no longer', 'not of the last edges'])
def test_a_robot_that_drives_while_edges_behind_it_are_taken_out_of_the_graph(told):
    """Three cases: reports arrive, reports do not arrive, or an order has not arrived yet."""
    fleet = SupervisedFleet(corridor(10), {'a': (AGV, 1), 'b': (AGV, 10)},
                            settings=RobotSettings(release_ahead=3.0))
    fleet.request(1, 7, robot='a')
    fleet.run(4.5)
    if told == 'not of the last edges':
        fleet.network.deaf['a'] = fleet.now + 2.0
        fleet.run_until(lambda: robot(fleet).master.order is not None)
    assert len(fleet.agvs['a'].visited) > 2 and fleet.agvs['a'].is_driving
    ahead = robot(fleet).record.ahead
    fleet.agvs['a'].stalled = 10.0
    if told == 'no longer':
        fleet.network.silent['a'] = fleet.now + 15.0
    fleet.restart(Graph([v for v in fleet.graph.vertices.values() if v.id > 1],
                        [e for e in fleet.graph.edges.values() if e.id > 1]))
    fleet.run(1.0)
    assert robot(fleet).record.ahead == ahead
    fleet.request(2, 4, robot='b')
    fleet.run_until_done(1, 2)
    assert fleet.state(1) is MissionState.SUCCEEDED


# -- MODIFY: another priority, and other destinations from now on ----------------------------------

def modify(fleet, mission, priority=0, *destinations):
    actions = fleet.supervisor.command(mission, CommandKind.MODIFY, fleet.now,
                                       MissionChange(priority, destinations))
    fleet.do(actions)
    return [action.status for action in actions if isinstance(action, PublishStatus)]


def test_a_robot_under_way_goes_to_the_new_destinations():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)})
    fleet.request(1, 3, 8)
    fleet.run_until(lambda: fleet.reached(1) == 1)
    modify(fleet, 1, 0, 2, 5)
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.SUCCEEDED and fleet.reached(1) == 3
    assert fleet.agvs['a'].visited[-1] == 5 and 8 not in fleet.agvs['a'].visited
    assert 2 in fleet.agvs['a'].visited[1:]


def test_a_stay_under_way_ends_with_the_change():
    fleet = SupervisedFleet(corridor(6), {'a': (AGV, 1)})
    fleet.request(1, 3, 6, dwells=(-1.0, -1.0))
    fleet.run_until(lambda: fleet.agvs['a'].visited[-1] == 3 and not fleet.agvs['a'].is_driving)
    fleet.run(5.0)
    modify(fleet, 1, 0, 5)
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.SUCCEEDED and fleet.agvs['a'].visited[-1] == 5


def test_a_mission_that_waits_overtakes_by_its_new_priority():
    fleet = SupervisedFleet(corridor(6), {'a': (AGV, 1)})
    for mission, vertex in ((1, 3), (2, 4), (3, 5)):
        fleet.request(mission, vertex)
    fleet.run(1.0)
    modify(fleet, 3, 5)
    fleet.run_until_done(1, 3)
    assert fleet.state(2) is not MissionState.SUCCEEDED
    fleet.run_until_done(2)


@pytest.mark.parametrize('vertex', [99, -1])
def test_a_change_that_no_robot_can_do_changes_nothing(vertex):
    fleet = SupervisedFleet(corridor(6), {'a': (AGV, 1)})
    fleet.request(1, 4)
    fleet.run(1.0)
    told, = modify(fleet, 1, 0, vertex)
    assert told.command_code is CommandCode.NOT_DONE and f'no vertex {vertex}' in told.reason
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.SUCCEEDED and fleet.agvs['a'].visited[-1] == 4


def test_a_change_outlives_a_restart():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)})
    fleet.request(1, 8)
    fleet.run(2.0)
    modify(fleet, 1, 3, 5)
    fleet.restart()
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.SUCCEEDED and fleet.agvs['a'].visited[-1] == 5


def test_who_requested_a_mission_and_its_end_is_told_and_kept():
    fleet = SupervisedFleet(corridor(6), {'a': (AGV, 1)})
    notes = [action.text for action in fleet.supervisor.request(
        Request(1, (6,), requested_by='anna (page)'), fleet.now) if isinstance(action, Note)]
    assert notes == ['anna (page) requests mission 1 to 6.']
    actions = fleet.supervisor.command(1, CommandKind.CANCEL, fleet.now,
                                       requested_by='boris (page)')
    fleet.do(actions)
    assert any(isinstance(action, Note) and action.text == 'boris (page) requests CANCEL of '
               'mission 1.' for action in actions)
    told, = (action.status for action in actions if isinstance(action, PublishStatus))
    assert told.reason == 'cancelled on request of boris (page)'


# -- which robot charges, where and how long -------------------------------------------------------

def yard(robots, docks=(6,), **more):
    """Returns a fleet that charges at `docks` of a corridor with a siding at vertex 3.

    robots -- the vertex on which each robot begins, by the name of the robot
    """
    kind = replace(AGV, docks=frozenset(docks))
    return SupervisedFleet(with_docks(corridor(6, siding_at=3), *docks),
                           {name: (kind, vertex) for name, vertex in robots.items()}, **more)


def charge(fleet, **charges):
    """Sets the charge that the batteries report."""
    for name, charge in charges.items():
        fleet.do(fleet.supervisor.battery(name, charge, fleet.now))


def view_of(fleet, name):
    """Returns the published state of a robot."""
    return next(v for v in robot_views(fleet.supervisor, fleet.now) if v.name == name)


def charging_at_6(**more):
    """Returns a fleet in which robot `a` charges at vertex 6 and its charge is 0.5."""
    fleet = yard({'a': 4}, **more)
    charge(fleet, a=0.2)
    fleet.run(20.0)
    charge(fleet, a=0.5)
    fleet.run(1.0)
    assert fleet.agvs['a'].visited[-1] == 6
    assert view_of(fleet, 'a').state is RobotState.CHARGING
    return fleet


def test_who_is_charged_leaves_the_dock_to_who_waits_for_it():
    fleet = yard({'a': 4, 'b': 1})
    charge(fleet, a=0.1, b=0.2)
    fleet.run(20.0)
    assert fleet.agvs['a'].visited[-1] == 6 and (
        view_of(fleet, 'b').waits_for.text == 'a charger: dock_6 (a)')
    charge(fleet, a=0.8)
    fleet.run(40.0)
    assert fleet.agvs['b'].visited[-1] == 6


def test_a_restart_does_not_end_the_charging_half_way():
    fleet = charging_at_6()
    fleet.restart()
    charge(fleet, a=0.5)
    assert_charges_before_it_works(fleet)


def test_a_short_silence_does_not_end_the_charging_half_way():
    fleet = charging_at_6()
    fleet.network.silent['a'] = fleet.now + 8.0
    fleet.run(20.0)
    assert_charges_before_it_works(fleet)


def test_a_battery_that_falls_silent_does_not_block_the_dock_for_ever():
    fleet = yard({'a': 4, 'b': 1})
    charge(fleet, a=0.1)
    fleet.run(20.0)
    charge(fleet, a=0.4)
    for _ in range(12):  # the battery of b keeps reporting
        charge(fleet, b=0.2)
        fleet.run(10.0)
    assert fleet.agvs['b'].visited[-1] == 6 and view_of(fleet, 'b').state is RobotState.CHARGING
    assert math.isnan(view_of(fleet, 'a').battery), 'an old charge must not be reported as new'


def test_a_battery_that_falls_silent_is_named_as_what_its_robot_waits_for():
    fleet = charging_at_6()
    fleet.run(MUTE + 5.0)
    assert view_of(fleet, 'a').state is RobotState.IDLE
    assert view_of(fleet, 'a').waits_for.text == (
        'a report of its battery, which has not come for 60 s')
    charge(fleet, a=0.2)
    fleet.run(1.0)
    assert view_of(fleet, 'a').state is RobotState.CHARGING
    assert view_of(fleet, 'a').waits_for.text == ''


def test_a_mission_says_that_nothing_is_heard_of_the_battery_that_it_waits_for():
    fleet = yard({'a': 4})
    charge(fleet, a=0.2)
    fleet.run(MUTE + 5.0)
    fleet.request(1, 1)
    fleet.run(3.0)
    assert fleet.state(1) is MissionState.PENDING
    assert fleet.statuses[-1].reason == (
        'a must charge first, and there is no battery report from a')


def test_with_what_its_battery_told_last_a_robot_may_work():
    fleet = charging_at_6()  # the last known charge is one half, and the robot charges
    fleet.run(MUTE + 5.0)
    fleet.request(1, 1)
    fleet.run_until_done(1)


def test_a_long_silence_does_not_end_the_charging_half_way():
    fleet = charging_at_6()
    fleet.network.silent['a'] = fleet.now + 2.0 * MUTE
    fleet.run(2.0 * MUTE + 5.0)
    assert view_of(fleet, 'a').state is RobotState.CHARGING
    charge(fleet, a=0.5)
    assert_charges_before_it_works(fleet)


def test_after_a_restart_a_silent_battery_is_not_taken_for_a_full_one():
    fleet = yard({'a': 4}, docks=())
    charge(fleet, a=0.2)
    fleet.request(1, 3)
    fleet.do(fleet.supervisor.take_out('a', fleet.now))
    fleet.restart()
    fleet.run(3.0)
    fleet.do(fleet.supervisor.bring_in('a', fleet.now)[1])
    fleet.run(10.0)
    assert fleet.statuses[-1].reason == 'a must charge first'


def assert_charges_before_it_works(fleet: SupervisedFleet) -> None:
    fleet.request(1, 1)
    fleet.run(20.0)
    assert fleet.state(1) is MissionState.PENDING
    charge(fleet, a=0.8)
    fleet.run_until_done(1)


def test_who_drops_out_on_the_way_leaves_the_dock_to_others():
    fleet = yard({'a': 1, 'b': 4})
    charge(fleet, a=0.1, b=0.9)
    fleet.run(1.5)
    fleet.do(fleet.supervisor.take_out('a', fleet.now))
    charge(fleet, b=0.2)
    fleet.run(20.0)
    assert fleet.agvs['b'].visited[-1] == 6


def test_another_dock_is_taken_when_the_way_to_the_first_is_closed():
    fleet = yard({'a': 4}, docks=(1, 6))
    charge(fleet, a=0.2)
    fleet.run(1.5)
    fleet.close(5)
    fleet.run(30.0)
    assert fleet.agvs['a'].visited[-1] == 1


def test_a_robot_that_finds_no_dock_says_why():
    fleet = yard({'a': 4}, docks=())
    charge(fleet, a=0.2)
    fleet.request(1, 1)
    fleet.run(3.0)
    assert view_of(fleet, 'a').waits_for.text == (
        'a charger: the fleet file and the graph have no dock for its type')
    assert fleet.statuses[-1].reason == 'a must charge first'
    fleet = yard({'a': 4})
    fleet.close(5)
    charge(fleet, a=0.2)
    fleet.run(3.0)
    assert view_of(fleet, 'a').waits_for.text == 'a charger: it can reach none'


def test_for_a_mission_that_needs_more_than_is_left_a_robot_charges_first():
    fleet = yard({'a': 4}, settings=RobotSettings(release_ahead=0.0, endurance=20.0))
    charge(fleet, a=0.4)  # enough for 6 m
    fleet.request(1, 2, 4, 2)
    fleet.run(20.0)
    assert fleet.state(1) is MissionState.PENDING and fleet.agvs['a'].visited[-1] == 6
    charge(fleet, a=0.95)  # enough for 17 m, of which it needs 16 m
    fleet.run_until_done(1)


def test_near_a_dock_is_not_docked():
    kind = replace(AGV, play=0.25, docks=frozenset({3}))
    graph = with_docks(graph_of({1: (0, 0), 2: (4, 0), 3: (8, 0)}, {1: (1, 2), 2: (2, 3)}), 3)
    fleet = SupervisedFleet(graph, {'a': (kind, 1)})
    fleet.request(1, 3)
    fleet.run_until(lambda: fleet.agvs['a'].edge == 2 and fleet.agvs['a'].arc > 3.75)
    fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    fleet.run(4.0)
    assert 3.7 < fleet.agvs['a'].arc < 3.99
    fleet.do(fleet.supervisor.resume_fleet(fleet.now)[1])
    fleet.run_until_done(1)
    assert fleet.agvs['a'].arc == pytest.approx(4.0), 'the robot must have got the end of its route'


def test_who_stands_elsewhere_gives_up_a_dock_that_it_cannot_reach_any_more():
    fleet = yard({'a': 1}, planning=5.0)
    charge(fleet, a=0.2)
    fleet.run(1.0)
    assert fleet.supervisor.robots['a'].dock == 6
    fleet.close(3)
    fleet.run(1.0)
    assert fleet.supervisor.robots['a'].dock is None
    assert view_of(fleet, 'a').waits_for.text == 'a charger: it can reach none'


# -- robots go before a late one, if switching is enabled ------------------------------------------

def crossing() -> Graph:
    """Returns two lanes, from 1 to 7 and from 11 to 17, that cross at vertex 4.

    Vertex 4 is a little nearer to 1 than to 11.
    """
    places = {k: (2.5 * (k - 4), 0.0) for k in range(1, 8)}
    places.update({10 + k: (0.0, 2.6 * (k - 4)) for k in range(1, 8) if k != 4})
    across = [11, 12, 13, 4, 15, 16, 17]
    ends = {k: (k, k + 1) for k in range(1, 7)}
    ends.update({10 + k: pair for k, pair in enumerate(zip(across, across[1:]), 1)})
    return graph_of(places, ends)


def ended(fleet: SupervisedFleet) -> List[int]:
    """Returns the missions that succeeded, in order."""
    return [status.request_id for status in fleet.statuses
            if status.state is MissionState.SUCCEEDED]


def both_cross(switches: bool) -> SupervisedFleet:
    """Lets `a` and `b` cross. In the plan `a` is first, but it stands before the crossing for a
    minute.
    """
    fleet = SupervisedFleet(crossing(), {'a': (AGV, 1), 'b': (AGV, 11)}, switches=switches)
    fleet.request(1, 7, robot='a')
    fleet.request(2, 17, robot='b')
    fleet.run(2.0)
    fleet.agvs['a'].stalled = 60.0
    fleet.run_until_done(1, 2)
    return fleet


def test_a_robot_waits_for_a_late_one_that_goes_first_by_the_plan():
    assert both_cross(switches=False).statuses[-1].request_id == 2


def test_a_robot_goes_before_a_late_one_where_the_order_may_be_switched():
    fixed, switching = both_cross(switches=False), both_cross(switches=True)
    assert ended(switching) == [2, 1]
    assert switching.now < fixed.now
    assert switching.nearest >= 0.0


@pytest.mark.parametrize('seed', range(6))
def test_a_fleet_with_stalls_serves_all_and_comes_near_nobody_while_its_order_is_switched(seed):
    random = Random(seed)
    starts = random.sample((1, 3, 5, 7, 101, 103, 105, 107), 5)
    fleet = SupervisedFleet(ladder(7), {f'r{k}': (AGV, v) for k, v in enumerate(starts)},
                            seed=seed, switches=True)
    for number in range(1, 21):
        fleet.request(number, random.choice((1, 3, 5, 7, 101, 103, 105, 107)))
        fleet.run(random.uniform(0.0, 6.0))
        fleet.agvs[f'r{random.randrange(5)}'].stalled = random.choice((0.0, 10.0, 30.0))
    fleet.run_until_done(*range(1, 21), limit=900.0)
    assert fleet.nearest >= 0.0


def test_how_long_a_robot_will_stand_is_learned_from_how_long_robots_stood():
    fleet = SupervisedFleet(ladder(7), {'a': (AGV, 1)})
    robot, standstills = fleet.supervisor.robots['a'], Standstills()

    def stands(seconds: float) -> float:
        """Returns the expected further standstill, in s, after a standstill of `seconds`."""
        robot.liveness._moved = fleet.now + 100.0 - seconds
        robot.liveness.seen = fleet.now + 100.0
        return standstills.further(robot, fleet.now + 100.0)

    fleet.run(60.0)
    assert standstills.further(robot, fleet.now) == 0.0
    fleet.request(1, 7)
    fleet.run(0.3)
    assert standstills.further(robot, fleet.now) == 0.0  # an edge has just been released to it
    assert stands(1.0) == 0.0 and stands(4.0) == 4.0  # no experience: as long as it has stood
    for _ in range(6):
        stands(20.0)
        stands(0.0)
    assert stands(5.0) == pytest.approx(15.0)
    assert stands(30.0) == 30.0  # it has stood longer than in any earlier standstill


# -- many missions are assigned to many robots at once ---------------------------------------------

TRUCK = replace(AGV, name='truck')


def test_each_of_many_robots_gets_a_mission_that_its_type_can_serve():
    """The matching once took minutes if not every robot could serve every mission."""
    vertices = [100 * row + k for row in (0, 1) for k in range(1, 90)]
    graph = ladder(90)
    chance = Random(1)
    robots = {f'r{k}': (chance.choice((AGV, TRUCK)), vertex)
              for k, vertex in enumerate(vertices)}
    fleet = SupervisedFleet(graph, robots)
    fleet.run(1.0)
    missions = [Mission(id, Request(id, (chance.choice(vertices),),
                                    robot_type=chance.choice((kind.name, ''))))
                for id, (kind, _) in enumerate(robots.values(), 1)]
    supervisor = fleet.supervisor
    found = assign(missions, supervisor.own_hindrances, supervisor.robots, supervisor.acceptance,
                   supervisor.networks, fleet.now)
    assert len(found.assigned) == len(robots)
