"""A stop, a cancel or a takeover is the last word, even if messages are late or lost."""
from __future__ import annotations

from dataclasses import replace

import pytest
from fleet_builders import AGV, corridor

from fleet_core.interlocking.reports import Report
from fleet_core.supervision.missions import Command, MissionState
from fleet_core.supervision.outages import Outage
from fleet_core.supervision.settings import RobotSettings
from fleet_simulation.virtual_fleet import route_order
from route_protocol.values import (
    TAKEN_OVER,
    EdgeState,
    Motion,
    Reason,
    ReasonCode,
    RouteReport,
)
from trajectory_graph import Graph
from world.plain_agv import LOST_LINK
from world.supervised_fleet import SupervisedFleet, blocked

FAR = RobotSettings(release_ahead=8.0)


def carry(agv, edge, arc):
    """A person carries a robot to a place on an edge, where it stands without a route."""
    agv.forget()
    agv.edge, agv.arc = edge, arc


def robot(fleet, name='a'):
    return fleet.supervisor.robots[name]


# -- robots that seem to stand ---------------------------------------------------------------------


@pytest.mark.parametrize('how', ['lost link', 'stop all', 'fleet out'])
def test_who_does_not_know_where_it_is_now_does_not_stand_still(how):
    """Its computer reports, but has no link to the robot, which drives on along its route."""
    fleet = SupervisedFleet(corridor(10), {'a': (AGV, 1), 'b': (AGV, 10)}, settings=FAR)
    fleet.request(1, 6, robot='a')
    fleet.run(2.0)
    agv, last = fleet.agvs['a'], fleet.agvs['a'].report(fleet.now)
    fleet.deaf['a'] = 1e9
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
    fleet.deaf.clear()
    fleet.run(15.0)
    assert not fleet.bring_in('a')
    fleet.run(2.0)
    assert robot(fleet).works


# -- cancelled and paused -------------------------------------------------------------------------


@pytest.mark.parametrize('ahead', [0.0, 1.0, 3.0, 8.0])
def test_a_cancelled_robot_stops_at_the_end_of_its_edge_though_it_has_another_mission(ahead):
    """The plan in force also leads there, but through the place that was cancelled."""
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)}, parking=(1,),
                            settings=RobotSettings(release_ahead=ahead))
    fleet.rounds = 5
    fleet.request(1, 8)
    fleet.request(2, 2, robot='a')
    fleet.run_until(lambda: fleet.agvs['a'].visited[-1] == 3)
    fleet.do(fleet.supervisor.command(1, Command.CANCEL, fleet.now))
    fleet.run_until_done(2)
    assert fleet.agvs['a'].visited == [1, 2, 3, 2]


def test_a_report_from_before_the_last_order_does_not_answer_a_cancel():
    """It shows the route that the cancel asks for, but a longer one is on its way to the robot."""
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)},
                            settings=RobotSettings(release_ahead=1.0))
    fleet.request(1, 8)
    fleet.run_until(lambda: len(robot(fleet).record.ahead) > 1)
    fleet.to_robots, orders = [], fleet.to_robots  # the order that makes the route longer
    assert len(orders[-1].edges) == 2 and fleet.agvs['a'].current == 0
    fleet.do(fleet.supervisor.command(1, Command.CANCEL, fleet.now))
    fleet.do(fleet.supervisor.report('a', Report(fleet.agvs['a'].report(fleet.now)), fleet.now))
    assert len(robot(fleet).record.held) == 2, 'the robot has not received the cancel'


@pytest.mark.parametrize('command', [Command.CANCEL, Command.PAUSE])
def test_what_a_robot_has_not_heard_yet_is_not_ordered_after_a_cancel(command):
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)}, settings=FAR)
    fleet.run(1.0)
    fleet.deaf['a'] = 1e9
    fleet.request(1, 8)
    fleet.run(8.0)
    assert robot(fleet).outage is Outage.DEAF
    fleet.do(fleet.supervisor.command(1, command, fleet.now))
    fleet.run(2.0)
    sent = len(fleet.sent)
    fleet.deaf.clear()
    fleet.run(20.0)
    assert all(len(order.edges) <= 1 for order in fleet.sent[sent:]), fleet.sent[sent:]
    assert fleet.agvs['a'].travelled <= 2.0


def test_a_restart_orders_nothing_again_that_was_cancelled_while_the_robot_was_silent():
    fleet = SupervisedFleet(corridor(9), {'a': (AGV, 1), 'b': (AGV, 9)},
                            settings=RobotSettings(release_ahead=1.0))
    fleet.request(1, 7, robot='a')
    fleet.run_until(lambda: len(robot(fleet).record.ahead) > 1)
    fleet.silent['a'] = fleet.silent['b'] = 1e9
    fleet.agvs['a'].stalled = 1e9
    fleet.run(8.0)
    fleet.do(fleet.supervisor.command(1, Command.CANCEL, fleet.now))
    fleet.run(2.0)
    sent = len(fleet.sent)
    fleet.restart()
    fleet.silent.pop('a')
    fleet.run(3.0)
    fleet.agvs['a'].stalled = 0.0
    fleet.run(20.0)
    assert all(len(order.edges) <= 1 for order in fleet.sent[sent:]), fleet.sent[sent:]
    assert fleet.agvs['a'].travelled <= 2.1


# -- taken over and stopped -----------------------------------------------------------------------


def test_who_was_given_a_route_by_somebody_else_is_not_ordered_what_he_has_not_heard():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 4)}, settings=FAR)
    fleet.run(1.0)
    fleet.deaf['a'] = 1e9
    fleet.request(1, 8)
    fleet.run(2.0)
    fleet.agvs['a'].obey_another((4,))
    fleet.run(0.5)
    assert robot(fleet).outage is Outage.TAKEN_OVER
    fleet.deaf.clear()
    fleet.run(20.0)
    assert fleet.agvs['a'].visited == [4, 5]
    assert not fleet.bring_in('a')


def test_an_order_that_was_under_way_as_the_robot_was_taken_over_does_not_drive_it_on():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)}, settings=FAR)
    fleet.request(1, 8)
    fleet.run(1.5)
    agv = fleet.agvs['a']
    fleet.request(2, 8, robot='a')
    fleet.do(fleet.supervisor.command(1, Command.CANCEL, fleet.now))
    fleet.run_until(lambda: any(o.order.number > agv.taken for o in fleet.to_robots))
    order = fleet.to_robots.pop()
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
    fleet.deaf['a'] = fleet.now + 3.0
    fleet.agvs['a'].fail(LOST_LINK)
    fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    fleet.run(5.0)
    assert fleet.agvs['a'].edges == (), 'the stop must have reached the robot'


# -- where robots truly are -----------------------------------------------------------------------


def taken_over_as_it_was_let_go_on():
    """It refuses more edges, because its route has failed: it stands in the middle of an edge."""
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1), 'b': (AGV, 8)},
                            settings=RobotSettings(release_ahead=1.0))
    fleet.request(1, 6, robot='a')
    fleet.run_until(lambda: bool(fleet.to_robots) and fleet.agvs['a'].arc > 0.5)
    fleet.agvs['a'].fail(TAKEN_OVER)
    fleet.run(2.0)
    assert robot(fleet).outage is Outage.TAKEN_OVER
    return fleet


def test_where_a_person_drives_who_refused_more_is_known():
    """Its reports still contain the route that has failed."""
    fleet = taken_over_as_it_was_let_go_on()
    fleet.agvs['a'].edge, fleet.agvs['a'].arc = 4, 1.0
    fleet.run(0.5)
    assert 4 in blocked(fleet, 'a')[1]


@pytest.mark.parametrize('is_silent', [False, True])
def test_who_refused_more_as_it_was_taken_over_keeps_its_edge_after_a_restart(is_silent):
    fleet = taken_over_as_it_was_let_go_on()
    if is_silent:
        fleet.silent['a'] = 1e9
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
    carry(fleet.agvs['b'], 1, 1.9)
    fleet.run(5.0)
    assert fleet.agvs['a'].travelled == 0.0


def test_a_plan_that_does_not_know_of_a_robot_releases_nothing():
    """Robot b is switched on in the middle of the path while that path is planned."""
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1), 'b': (AGV, 4)}, settings=FAR)
    fleet.silent['b'] = 1e9
    fleet.run(6.0)
    fleet.planning = 1.0
    fleet.request(1, 6, robot='a')
    fleet.run(0.5)
    fleet.silent.clear()
    fleet.run(10.0)


@pytest.mark.parametrize('told', ['all', 'no longer', 'not of the last edges'])
def test_a_robot_that_drives_while_edges_behind_it_are_taken_out_of_the_graph(told):
    """Its reports arrive, or do not arrive, or an order is still on its way to it."""
    fleet = SupervisedFleet(corridor(10), {'a': (AGV, 1), 'b': (AGV, 10)},
                            settings=RobotSettings(release_ahead=3.0))
    fleet.request(1, 7, robot='a')
    fleet.run(4.5)
    if told == 'not of the last edges':
        fleet.deaf['a'] = fleet.now + 2.0
        fleet.run_until(lambda: robot(fleet).master.order is not None)
    assert len(fleet.agvs['a'].visited) > 2 and fleet.agvs['a'].is_driving
    ahead = robot(fleet).record.ahead
    fleet.agvs['a'].stalled = 10.0
    if told == 'no longer':
        fleet.silent['a'] = fleet.now + 15.0
    fleet.restart(Graph([v for v in fleet.graph.vertices.values() if v.id > 1],
                        [e for e in fleet.graph.edges.values() if e.id > 1]))
    fleet.run(1.0)
    assert robot(fleet).record.ahead == ahead
    fleet.request(2, 4, robot='b')
    fleet.run_until_done(1, 2)
    assert fleet.state(1) is MissionState.SUCCEEDED
