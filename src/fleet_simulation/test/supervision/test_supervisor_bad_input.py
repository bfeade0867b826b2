"""Wrong, repeated, late or foreign messages are ignored, or refused with one sentence."""
from __future__ import annotations

from dataclasses import replace

import pytest
from fleet_builders import AGV, at_place, corridor

from fleet_core.interlocking.reports import Report
from fleet_core.planning.tasks import Outcome
from fleet_core.supervision.missions import Command, MissionState
from fleet_core.supervision.outages import Outage
from route_protocol.values import EdgeState, Reason, ReasonCode, SymbolicPose
from world.supervised_fleet import SupervisedFleet, blocked


@pytest.fixture
def fleet():
    """One robot on its way from 1 to 6, with an open mission."""
    fleet = SupervisedFleet(corridor(6), {'a': (AGV, 1)})
    fleet.request(1, 6)
    fleet.run(3.0)
    assert fleet.agvs['a'].is_driving
    return fleet


def hear(fleet, said, age=0.0):
    """The supervisor receives an unexpected report; returns the orders that follow."""
    sent = len(fleet.sent)
    fleet.do(fleet.supervisor.report('a', Report(said, age), fleet.now))
    return fleet.sent[sent:]


def ends_well(fleet):
    """True if the mission ends as if nothing had happened."""
    fleet.run_until_done(1)
    return fleet.state(1) is MissionState.SUCCEEDED and fleet.agvs['a'].travelled == pytest.approx(
        10.0)


@pytest.mark.parametrize('wrong', [
    SymbolicPose(1, float('nan')), SymbolicPose(1, float('inf')), SymbolicPose(1, -50.0),
    SymbolicPose(1, 150.0), SymbolicPose(99, 50.0)])
def test_a_place_that_cannot_be_is_ignored_in_one_sentence(fleet, wrong):
    assert hear(fleet, replace(fleet.agvs['a'].report(fleet.now), pose=wrong)) == []
    assert fleet.notes[-1].startswith('A report of a is ignored: it is ')
    assert ends_well(fleet)


@pytest.mark.parametrize('wrong', [
    {'edges': (1,), 'states': ()}, {'number': 0}, {'order': 2 ** 63}, {'refused': 2 ** 64 - 1},
    {'order': 2 ** 62}, {'edges': (2, 3), 'states': (EdgeState.PROCESSING,) * 2},
    {'edges': (2,) * 2000, 'states': (EdgeState.COMPLETE,) * 2000}])
def test_a_report_that_makes_no_sense_is_ignored_in_one_sentence(fleet, wrong):
    assert hear(fleet, replace(fleet.agvs['a'].report(fleet.now), **wrong)) == []
    assert fleet.notes[-1].startswith('A report of a is ignored: ')
    assert ends_well(fleet)


def test_a_location_of_no_known_age_is_ignored_in_one_sentence(fleet):
    assert hear(fleet, fleet.agvs['a'].report(fleet.now), age=float('nan')) == []
    assert fleet.notes[-1].startswith('A report of a is ignored: ')
    assert ends_well(fleet)


def test_reports_that_come_again_late_and_out_of_order_change_nothing(fleet):
    reports = []
    for _ in range(20):
        reports.append(fleet.agvs['a'].report(fleet.now))
        fleet.step()
    done = fleet.supervisor.robots['a'].record.done
    for report in reversed(reports):
        hear(fleet, report)
        hear(fleet, report)
    assert fleet.supervisor.robots['a'].record.done == done
    assert ends_well(fleet)


def test_one_location_elsewhere_ends_no_mission_but_blocks_that_place_until_two_disprove_it(fleet):
    fleet.run_until_done(1)
    robot = fleet.supervisor.robots['a']
    hear(fleet, at_place(fleet.agvs['a'].report(fleet.now), fleet.graph, 2, 0.5))
    assert robot.outage is None and 2 in blocked(fleet, 'a')[1]
    fleet.step()
    assert 2 in blocked(fleet, 'a')[1], 'one later location must not be enough'
    fleet.step()
    assert blocked(fleet, 'a') == ((robot.position.vertex,), ())


def test_two_locations_elsewhere_in_a_row_leave_a_robot_to_a_person(fleet):
    fleet.run_until_done(1)
    agv = fleet.agvs['a']
    fleet.silent['a'] = fleet.now + 2.0
    for later in (0.1, 0.2):
        hear(fleet, at_place(agv.report(fleet.now + later), fleet.graph, 2, 0.5))
    assert fleet.supervisor.robots['a'].outage is Outage.TAKEN_OVER


def test_a_robot_off_the_graph_gets_nothing_to_drive_and_its_missions_wait():
    fleet = SupervisedFleet(corridor(6), {'a': (AGV, 1)})
    fleet.run(1.0)
    fleet.agvs['a'].off_graph = True
    fleet.request(1, 6)
    fleet.run(3.0)
    assert fleet.supervisor.robots['a'].outage is Outage.OFF_GRAPH
    assert fleet.statuses[-1].reason == 'a: it reports that it is off the graph'
    assert not [sending for sending in fleet.sent if sending.edges]


def test_a_route_of_a_stranger_takes_the_robot_over_and_nobody_else_is_sent_there(fleet):
    edge = fleet.agvs['a'].edge
    fleet.agvs['a'].obey_another((edge, edge + 1))
    fleet.step()
    robot = fleet.supervisor.robots['a']
    assert robot.outage is Outage.TAKEN_OVER
    assert 'a route that was not given to it here' in robot.why
    fleet.step()
    assert blocked(fleet, 'a')[1], 'where it is must be blocked'
    assert not robot.master.is_ready


def test_a_refusal_of_what_was_never_ordered_ends_nothing(fleet):
    told, said = len(fleet.notes), fleet.agvs['a'].report(fleet.now)
    hear(fleet, replace(said, refused=1, refusal=Reason(ReasonCode.OTHER, 'no')))
    assert len(fleet.notes) == told
    assert fleet.supervisor.robots['a'].works and ends_well(fleet)


def test_a_plan_that_was_not_asked_for_is_not_driven(fleet):
    before = fleet.supervisor.plan_executor.plan
    fleet.do(fleet.supervisor.plan_made(4711, Outcome({}, ()), fleet.now))
    fleet.do(fleet.supervisor.plan_failed(4711, 'a stranger says so', fleet.now))
    assert fleet.supervisor.plan_executor.plan is before and ends_well(fleet)


@pytest.mark.parametrize('command', list(Command))
def test_a_command_for_a_mission_that_is_not_there_is_told_so(fleet, command):
    fleet.do(fleet.supervisor.command(4711, command, fleet.now))
    assert fleet.notes[-1] == f'There is no open mission 4711 for {command.name}.'
    assert ends_well(fleet)


def test_closing_edges_that_the_graph_does_not_have_closes_nothing(fleet):
    fleet.close(4711, -4712)
    assert not fleet.supervisor.network.closed and ends_well(fleet)
