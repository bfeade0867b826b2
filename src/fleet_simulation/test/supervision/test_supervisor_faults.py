"""Robots fail, stand at an unexpected place, or return: which robots then move, and how.

Wrong, repeated, late or foreign messages are ignored, or refused with one sentence.
"""
from __future__ import annotations

from dataclasses import replace

import pytest
from fleet_builders import AGV, at_place, corridor, graph_of

from fleet_core.interlocking.reports import CLOCK_ERROR, Report
from fleet_core.planning.tasks import PlanningOutcome
from fleet_core.supervision.fleet_view import robot_views
from fleet_core.supervision.missions import CommandKind, MissionState
from fleet_core.supervision.outages import Outage
from fleet_core.supervision.settings import RobotSettings
from route_protocol.values import (
    LARGEST_RECORD_NUMBER,
    EdgeState,
    EpochCause,
    Reason,
    ReasonCode,
    SymbolicPose,
)
from world.plain_agv import LOST_LINK
from world.supervised_fleet import SupervisedFleet, blocked

# -- robots ----------------------------------------------------------------------------------------

def test_a_paused_mission_whose_robot_drops_out_stays_paused():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1), 'b': (AGV, 8)})
    fleet.step()
    fleet.request(1, 4)
    fleet.run(2.0)
    assert fleet.robot_of(1) == 'a'
    fleet.do(fleet.supervisor.command(1, CommandKind.PAUSE, fleet.now))
    fleet.do(fleet.supervisor.take_out('a', fleet.now))
    fleet.run(20.0)
    assert fleet.state(1) is MissionState.PAUSED and fleet.agvs['b'].travelled == 0.0
    fleet.do(fleet.supervisor.command(1, CommandKind.RESUME, fleet.now))
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.SUCCEEDED and fleet.robot_of(1) == 'b'


def test_only_refusals_in_a_row_count_against_a_robot():
    fleet = SupervisedFleet(corridor(10), {'a': (AGV, 1)})
    for vertex in (3, 5, 7, 9):
        fleet.request(vertex, vertex)
        fleet.agvs['a'].refusing = 1
        fleet.run_until_done(vertex)
    assert fleet.refused['a'] >= 4
    assert fleet.supervisor.robots['a'].works


def test_what_is_refused_in_an_emergency_stop_does_not_count_against_the_robot():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)})
    fleet.request(1, 8)
    fleet.run(2.5)
    fleet.agvs['a'].emergency = True
    fleet.run(15.0)
    fleet.agvs['a'].emergency = False
    fleet.agvs['a'].refusing = 1
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.SUCCEEDED


@pytest.mark.parametrize('before', ['it drove', 'it never had a route'])
def test_who_was_driven_elsewhere_while_it_had_nothing_to_do_needs_a_person(before):
    fleet = SupervisedFleet(corridor(10), {'a': (AGV, 2), 'b': (AGV, 10)})
    if before == 'it drove':
        fleet.request(1, 1, robot='a')
        fleet.run_until_done(1)
    fleet.run(1.0)
    fleet.agvs['a'].be_carried(5, 1.0)
    fleet.run(2.0)
    assert fleet.supervisor.robots['a'].outage is Outage.TAKEN_OVER
    fleet.request(2, 4, robot='b')
    fleet.run(20.0)
    assert fleet.agvs['b'].travelled == 0.0, 'robot a stands in its way'


def test_who_stands_as_far_from_a_vertex_as_still_counts_as_on_it_may_tremble():
    fleet = SupervisedFleet(corridor(6), {'a': (AGV, 1)})
    agv = fleet.agvs['a']
    for step in range(20):
        agv.arc = 0.28 + 0.04 * (step % 2)
        fleet.run(0.2)
    assert fleet.supervisor.robots['a'].works


def test_nobody_is_sent_to_where_a_robot_was_carried():
    """Beyond vertex 2, the upper path is the shorter one, until a person puts `b` on this path."""
    graph = graph_of({1: (0, 0), 2: (4, 0), 3: (8, 0), 4: (12, 0), 5: (16, 0), 6: (4, -6),
                      7: (16, -6), 8: (24, 0), 9: (30, 0)},
                     {1: (1, 2), 2: (2, 3), 3: (3, 4), 4: (4, 5), 5: (2, 6), 6: (6, 7), 7: (7, 5),
                      8: (5, 8), 9: (8, 9)})
    fleet = SupervisedFleet(graph, {'a': (AGV, 1), 'b': (AGV, 9)})
    fleet.step()
    fleet.do(fleet.supervisor.take_out('b', fleet.now))
    fleet.run(1.0)
    fleet.request(1, 5, robot='a')
    fleet.run(1.0)
    fleet.agvs['b'].be_carried(3, 2.0)
    fleet.run_until_done(1)
    assert fleet.agvs['a'].visited[-3:] == [6, 7, 5], 'the robot must take the other path'


def test_nobody_is_sent_to_where_a_robot_comes_back_into_service_without_a_planner():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1), 'b': (AGV, 8)})
    fleet.step()
    fleet.do(fleet.supervisor.take_out('b', fleet.now))
    fleet.run(1.0)
    fleet.request(1, 6, robot='a')
    fleet.run(1.0)
    fleet.planner.latency = 1e9
    fleet.agvs['b'].be_carried(4, 1.0)
    fleet.run(3.0)
    problem, actions = fleet.supervisor.bring_in('b', fleet.now)
    fleet.do(actions)
    assert not problem
    fleet.run(30.0)
    fleet.planner.latency = 0.1
    fleet.run_until_done(1)


def test_a_lost_link_gives_nothing_to_others_when_it_is_back_before_a_new_plan():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 3), 'b': (AGV, 1)},
                            settings=RobotSettings(release_ahead=4.0))
    fleet.step()
    fleet.request(1, 8, robot='a')
    fleet.request(2, 6, robot='b')
    fleet.run(2.5)
    fleet.planner.latency = 1e9
    fleet.agvs['a'].fail(LOST_LINK)
    fleet.run(20.0)
    fleet.planner.latency = 0.1
    fleet.run_until_done(1)


def test_a_planner_that_does_not_answer_is_told_of_where_robots_wait():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)}, planning=1e9)
    fleet.request(1, 8)
    fleet.run(25.0)
    view, = robot_views(fleet.supervisor, fleet.now)
    assert view.waits_for.text == 'a plan: the planner does not answer'
    fleet.planner.latency = 0.1
    fleet.run_until_done(1)
    assert fleet.supervisor.plan_executor.trouble == ''


def test_a_mission_for_a_stopped_fleet_says_what_it_waits_for():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)})
    fleet.run(1.0)
    fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    fleet.request(1, 8)
    fleet.run(1.0)
    assert fleet.statuses[-1].reason == 'the fleet is stopped'
    fleet.do(fleet.supervisor.resume_fleet(fleet.now)[1])
    fleet.run(5.0)
    assert (fleet.state(1), fleet.statuses[-1].reason) == (MissionState.ACTIVE, '')


def test_a_command_that_changes_nothing_says_so():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)})
    fleet.request(1, 8)
    fleet.run(1.0)
    for command, note in ((CommandKind.RELEASE, 'Mission 1 is not staying anywhere: nothing to '
                                            'release.'),
                          (CommandKind.RESUME, 'Mission 1 is not paused.')):
        fleet.do(fleet.supervisor.command(1, command, fleet.now))
        assert fleet.notes[-1] == note
    fleet.run_until_done(1)


@pytest.mark.parametrize('before, after', [(0.0, 0.0), (-3600.0, -3600.0), (0.0, -3600.0),
                                           (0.0, -5.0), (0.0, 3600.0)])
def test_a_lost_link_comes_back_whatever_the_robots_clock_says(before, after):
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)})
    fleet.now = 1e6
    agv = fleet.agvs['a']
    wrong, report = [before], agv.report
    agv.report = lambda stamp: report(stamp + wrong[0])
    fleet.request(1, 8)
    fleet.run(2.5)
    agv.fail(LOST_LINK)
    fleet.run(1.0)
    wrong[0] = after
    fleet.run(15.0)
    if after > CLOCK_ERROR:
        assert fleet.supervisor.robots['a'].outage is Outage.CLOCK, 'its locations have no stamp'
    else:
        assert agv.is_driving or agv.visited[-1] == 8
        old = any('clock' in note for note in fleet.notes)
        assert old == (after < -10.0)


def test_who_is_elsewhere_once_its_link_is_back_needs_a_person():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)})
    fleet.request(1, 4)
    fleet.run(1.0)
    fleet.lose_link('a')
    fleet.run(5.0)
    fleet.agvs['a'].be_carried(7, 1.0)
    fleet.find_link('a')
    fleet.run(10.0)
    assert fleet.supervisor.robots['a'].outage is Outage.TAKEN_OVER
    why = fleet.supervisor.robots['a'].why
    assert 'it was expected at vertex 1, but is on edge 7 at 50 %' in why


def test_who_left_the_graph_from_its_place_comes_back_only_by_a_person():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)})
    fleet.run(1.0)
    fleet.agvs['a'].off_graph = True
    fleet.run(2.0)
    assert fleet.supervisor.robots['a'].outage is Outage.OFF_GRAPH
    fleet.agvs['a'].be_carried(4, 1.0)
    fleet.agvs['a'].off_graph = False
    fleet.run(10.0)
    assert fleet.supervisor.robots['a'].outage is Outage.OFF_GRAPH
    fleet.do(fleet.supervisor.bring_in('a', fleet.now)[1])
    assert fleet.supervisor.robots['a'].works


@pytest.mark.parametrize('is_restarted', [False, True])
def test_who_leaves_the_graph_where_a_person_drove_it_keeps_the_place_where_it_was(is_restarted):
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)})
    fleet.run(1.0)
    fleet.agvs['a'].be_carried(5, 1.0)
    fleet.run(2.0)
    fleet.agvs['a'].off_graph = True
    fleet.run(1.0)
    if is_restarted:
        fleet.restart()
        fleet.run(1.0)
    assert blocked(fleet, 'a') == ((), (5,))
    fleet.agvs['a'].be_carried(7, 1.0)
    fleet.agvs['a'].off_graph = False
    fleet.run(2.0)
    assert blocked(fleet, 'a') == ((), (7,))


@pytest.mark.parametrize('how', ['it reports', 'it refuses'])
def test_an_emergency_stop_makes_orders_void_and_what_they_gave_is_held_until_the_robot_stands(how):
    """During the emergency stop no useless order is sent. Afterwards the mission goes on."""
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)},
                            settings=RobotSettings(release_ahead=3.0))
    robot, agv = fleet.supervisor.robots['a'], fleet.agvs['a']
    agv.braking = 0.5
    fleet.run(1.0)
    fleet.request(1, 8)
    if how == 'it reports':
        fleet.run(2.0)
    else:
        fleet.run_until(lambda: bool(fleet.network.to_robots))
    held = robot.master.protocol.may_be_on
    agv.emergency = True
    fleet.step()
    if how == 'it reports':
        assert agv.is_driving and held and set(held) <= set(robot.master.protocol.may_be_on)
    fleet.run(2.0)
    assert robot.outage is Outage.STOPPED and robot.master.protocol.may_be_on == ()
    assert fleet.supervisor.interlocking.is_free(robot, robot.position), 'it keeps its place'
    sent = len(fleet.sent)
    fleet.run(10.0)
    assert fleet.sent[sent:] == []
    agv.emergency = False
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.SUCCEEDED


def test_who_cannot_work_is_given_nothing_more_by_the_plan_in_force():
    fleet = SupervisedFleet(corridor(12), {'a': (AGV, 1)}, planning=2.0)
    fleet.request(1, 12)
    fleet.run(5.0)
    fleet.network.deaf['a'] = 1e9
    fleet.run_until(lambda: fleet.supervisor.robots['a'].outage is Outage.DEAF)
    held = fleet.supervisor.robots['a'].record.held
    fleet.run(5.0)
    assert fleet.supervisor.robots['a'].record.held == held


@pytest.mark.parametrize('commands_only', [False, True])
def test_a_lost_link_is_not_back_before_the_robot_is_known_to_stand(commands_only):
    """The robot still drives its route, so it keeps all edges of the route."""
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)})
    fleet.now = 1e6
    fleet.request(1, 8)
    fleet.run(2.5)
    ahead = fleet.agvs['a'].ahead
    fleet.lose_link('a', commands_only)
    fleet.run(20.0)
    robot = fleet.supervisor.robots['a']
    assert robot.outage is Outage.LOST_LINK
    assert ahead and set(ahead) <= {step.edge for step in robot.master.protocol.may_be_on}


@pytest.mark.parametrize('deafness', [0.0, 2.0])
def test_a_robot_switched_off_and_on_where_it_stands_does_not_drive_its_old_route_again(deafness):
    """The robot must make room, so the supervisor extends the old route, perhaps just before the
    robot is switched off.
    """
    fleet = SupervisedFleet(corridor(8, siding_at=3), {'a': (AGV, 1), 'b': (AGV, 8)},
                            parking=(1, 8, 100))
    fleet.request(1, 2, 1, robot='a')
    fleet.run_until_done(1)
    agv, before = fleet.agvs['a'], fleet.agvs['a'].travelled
    if not deafness:
        agv.forget()
        fleet.run(1.0)
        assert fleet.supervisor.robots['a'].works, 'it had no route'
    fleet.network.deaf['a'] = fleet.now + deafness
    fleet.request(2, 1, robot='b')
    fleet.run_until(lambda: bool(fleet.supervisor.robots['a'].record.ahead))
    agv.forget()
    fleet.run(10.0)
    # It is unknown how much of the route it has driven.
    assert fleet.supervisor.robots['a'].why == 'it has forgotten its route'
    assert agv.travelled == before
    assert not fleet.bring_in('a')
    fleet.run_until_done(2)
    assert agv.travelled - before == pytest.approx(6.0)


def test_who_is_silent_is_ordered_nothing_new_but_to_stop():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)})
    fleet.run(1.0)
    fleet.network.silent['a'] = 1e9
    fleet.request(1, 8)
    fleet.run(6.0)
    sent, last = len(fleet.sent), fleet.sent[-1].order
    fleet.run(10.0)
    assert {sending.order for sending in fleet.sent[sent:]} <= {last}
    sent = len(fleet.sent)
    fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    fleet.run(3.5)
    assert [sending.edges for sending in fleet.sent[sent:]] == [()] * 4
    fleet.do(fleet.supervisor.resume_fleet(fleet.now)[1])
    fleet.network.silent.clear()
    fleet.run_until_done(1)


def test_an_order_that_is_repeated_drives_no_robot_that_was_switched_off_and_on_meanwhile():
    """The order was sent before the robot was switched off and on. The robot may have been moved
    since.
    """
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)})
    fleet.run(1.0)
    fleet.network.silent['a'] = 1e9
    fleet.request(1, 8)
    fleet.run(6.0)
    fleet.agvs['a'].forget()
    fleet.network.deaf['a'], fleet.network.silent['a'] = 0.0, 0.0
    fleet.hangs = True  # the repetition comes before a report of the restart
    fleet.network.to_robots = fleet.sent[-1:]
    fleet.step()
    fleet.hangs = False
    fleet.run(10.0)
    assert fleet.sent[-1].edges and fleet.agvs['a'].travelled == 0.0
    assert fleet.supervisor.robots['a'].why == 'it has forgotten its route'


def trembling(fleet, name, metres):
    """Makes a robot report a location that is never the same twice, as on a real floor."""
    agv, report = fleet.agvs[name], fleet.agvs[name].report

    def tremble(stamp):
        told = report(stamp)
        edge, length = told.pose.edge, fleet.graph.curve(told.pose.edge).length
        fraction = told.pose.percentage / 100.0 + fleet.random.uniform(-metres, metres) / length
        return at_place(told, fleet.graph, edge, min(max(fraction, 0.0), 1.0))
    agv.report = tremble


@pytest.mark.parametrize('how', ['stop all', 'lost link', 'out and in'])
def test_a_robot_whose_location_trembles_stands_still_all_the_same(how):
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)})
    trembling(fleet, 'a', 0.015)
    fleet.request(1, 8)
    fleet.run(2.5)
    if how == 'lost link':
        fleet.agvs['a'].fail(LOST_LINK)
    elif how == 'stop all':
        fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    else:
        fleet.do(fleet.supervisor.take_out('a', fleet.now))
    fleet.run(5.0)
    fleet.do(fleet.supervisor.resume_fleet(fleet.now)[1])
    fleet.do(fleet.supervisor.bring_in('a', fleet.now)[1])
    fleet.run_until_done(1, limit=60.0)


@pytest.mark.parametrize('edge, arc, left', [(2, 1.02, False), (3, 0.05, False), (2, 1.8, True)])
def test_a_robot_that_stands_on_an_edge_has_left_when_it_is_elsewhere(edge, arc, left):
    """A report may show the robot on a nearby edge. If the robot was pushed along its edge, it has
    left its place.
    """
    graph = graph_of({1: (0, 0), 2: (2, 0), 3: (4, 0), 4: (3.1, 0.05), 5: (3.1, 3)},
                     {1: (1, 2), 2: (2, 3), 3: (4, 5), 4: (3, 5)})
    fleet = SupervisedFleet(graph, {'a': (AGV, 1)})
    fleet.request(1, 3)
    fleet.run_until(lambda: fleet.agvs['a'].edge == 2 and fleet.agvs['a'].arc > 0.9)
    fleet.do(fleet.supervisor.take_out('a', fleet.now))
    fleet.do(fleet.supervisor.command(1, CommandKind.CANCEL, fleet.now))
    fleet.run(4.0)
    fleet.do(fleet.supervisor.bring_in('a', fleet.now)[1])
    assert fleet.supervisor.robots['a'].works
    fleet.agvs['a'].be_carried(edge, arc)
    fleet.run(2.0)
    assert (fleet.supervisor.robots['a'].outage is Outage.TAKEN_OVER) == left


@pytest.mark.parametrize('command', [CommandKind.CANCEL, CommandKind.PAUSE])
@pytest.mark.parametrize('before', [0.1, 0.6, 0.9])
def test_who_cannot_brake_in_time_for_a_cancel_stops_later_and_has_not_failed(command, before):
    fleet = SupervisedFleet(corridor(9), {'a': (AGV, 1)},
                            settings=RobotSettings(release_ahead=6.0))
    agv = fleet.agvs['a']
    agv.braking = 1.0
    fleet.request(1, 9)
    fleet.run_until(lambda: agv.travelled >= 4.0 - before)
    fleet.do(fleet.supervisor.command(1, command, fleet.now))
    fleet.run(10.0)
    assert fleet.supervisor.robots['a'].works, fleet.notes[-1]
    assert agv.travelled == pytest.approx(6.0)


@pytest.mark.parametrize('are_locations_fresh', [False, True])
def test_a_standing_robot_whose_link_is_down_needs_no_person_and_goes_on_once_it_is_back(
        are_locations_fresh):
    """The robot's computer refuses each order. If only the link for commands is down, locations
    still come.
    """
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)})
    fleet.run(1.0)
    fleet.lose_link('a', commands_only=are_locations_fresh)
    fleet.request(1, 8)
    fleet.run_until(lambda: fleet.supervisor.robots['a'].outage is Outage.LOST_LINK)
    fleet.run(60.0)
    assert fleet.supervisor.robots['a'].outage in (None, Outage.LOST_LINK)
    fleet.find_link('a')
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.SUCCEEDED


def test_a_robot_whose_clock_is_mended_while_the_fleet_is_stopped_goes_on_with_it():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)})
    fleet.run(1.0)
    fleet.clocks['a'] = 3.0
    fleet.run(2.0)
    assert fleet.supervisor.robots['a'].outage is Outage.CLOCK
    fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    fleet.clocks.clear()
    fleet.run(10.0)
    fleet.do(fleet.supervisor.resume_fleet(fleet.now)[1])
    fleet.request(1, 4)
    fleet.run_until_done(1, limit=60.0)
    assert fleet.state(1) is MissionState.SUCCEEDED


@pytest.mark.parametrize('restart_after', [0.2, 0.6, 1.0, 1.4, 1.8, 2.2, 2.6, 3.0, 4.0])
def test_an_emergency_stop_a_lost_link_and_a_restart_do_not_stop_the_fleet_for_ever(restart_after):
    """Each outage is stored, so the next supervisor knows why the robot does not drive."""
    fleet = SupervisedFleet(corridor(8, siding_at=4), {'a': (AGV, 1), 'b': (AGV, 8)},
                            settings=RobotSettings(release_ahead=3.0))
    fleet.run(2.0)
    fleet.request(1, 6, robot='a')
    stopped = fleet.agvs['a']
    fleet.run_until(lambda: stopped.is_driving and stopped.edge == 2)
    stopped.emergency = True
    fleet.run(0.5)
    stopped.emergency = False
    fleet.run_until(lambda: any(order.robot == 'a' and order.edges
                                for order in fleet.network.to_robots))
    fleet.lose_link('a')
    fleet.run(1.6)
    fleet.find_link('a')
    fleet.run(restart_after)
    fleet.restart()
    fleet.request(2, 1, robot='b')
    fleet.run_until_done(1, 2)
    assert (fleet.state(1), fleet.state(2)) == (MissionState.SUCCEEDED, MissionState.SUCCEEDED)


# -- messages --------------------------------------------------------------------------------------

@pytest.fixture
def fleet():
    """Returns one robot on its way from 1 to 6, with an open mission."""
    fleet = SupervisedFleet(corridor(6), {'a': (AGV, 1)})
    fleet.request(1, 6)
    fleet.run(3.0)
    assert fleet.agvs['a'].is_driving
    return fleet


def hear(fleet, said, age=0.0):
    """Gives the supervisor an unexpected report. Returns the orders that the supervisor then sends.
    """
    sent = len(fleet.sent)
    fleet.do(fleet.supervisor.report('a', Report(said, age), fleet.now))
    return fleet.sent[sent:]


def ends_well(fleet):
    """Returns whether the mission ends as if nothing had happened."""
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
    {'edges': (1,), 'states': ()}, {'number': 0}, {'number': 2 ** 64 - 1}, {'order': 2 ** 63},
    {'refused': 2 ** 64 - 1}, {'edges': (2, 3), 'states': (EdgeState.PROCESSING,) * 2},
    {'first': 1}, {'first': LARGEST_RECORD_NUMBER},
    {'edges': (2,) * 2000, 'states': (EdgeState.COMPLETE,) * 2000}])
def test_a_report_that_makes_no_sense_is_ignored_in_one_sentence(fleet, wrong):
    assert hear(fleet, replace(fleet.agvs['a'].report(fleet.now), **wrong)) == []
    assert fleet.notes[-1].startswith('A report of a is ignored: ')
    assert ends_well(fleet)


def test_a_record_at_its_last_number_is_ignored_also_if_no_edge_is_ordered(fleet):
    fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    fleet.run(2.0)
    stands = fleet.agvs['a'].report(fleet.now)
    assert not stands.edges
    assert hear(fleet, replace(stands, first=LARGEST_RECORD_NUMBER)) == []
    fleet.run(1.0)
    assert any(note.startswith('A report of a is ignored: its route record is at number ')
               for note in fleet.notes)
    fleet.do(fleet.supervisor.resume_fleet(fleet.now)[1])
    assert ends_well(fleet)


def goes_on_by_a_person(fleet, told, words):
    """Returns True if the mission ends after a person has brought the robot in.

    Before that, the robot must hold its places until it stands, and one sentence must tell the
    person about it.
    """
    agv, held = fleet.agvs['a'], set(fleet.supervisor.robots['a'].record.held)
    sent = len(fleet.sent)
    fleet.run_until(lambda: not agv.is_driving)
    fleet.run(2.0)
    assert {abs(edge) for edge in agv.edges[agv.current:]} <= held
    assert [words in note for note in fleet.notes[told:]] == [True]
    assert not any(order.edges for order in fleet.sent[sent:])
    assert not fleet.bring_in('a')
    fleet.run_until_done(1)
    return fleet.state(1) is MissionState.SUCCEEDED


def test_one_report_of_an_unknown_epoch_voids_the_route_with_one_sentence(fleet):
    told, said = len(fleet.notes), fleet.agvs['a'].report(fleet.now)
    sent = hear(fleet, replace(said, epoch=77))
    assert not any(one.order.edges for one in sent)
    assert goes_on_by_a_person(fleet, told, 'it has forgotten its route')


def test_a_new_epoch_of_no_known_cause_voids_the_route_with_one_sentence(fleet):
    """A later version of the protocol may have causes that this version does not know."""
    told = len(fleet.notes)
    fleet.agvs['a'].begin_epoch(EpochCause.NONE)
    fleet.step()
    assert goes_on_by_a_person(fleet, told, 'its orders were made void')


@pytest.mark.parametrize('numbers', [{'order': 2 ** 62}, {'refused': 2 ** 62}])
def test_a_robot_that_shows_an_order_that_nobody_has_given_is_stopped_and_then_used_again(
        fleet, numbers):
    agv = fleet.agvs['a']
    sent = hear(fleet, replace(agv.report(fleet.now), **numbers))
    assert sent and all(not one.order.edges for one in sent)
    assert any('the journal does not know' in note for note in fleet.notes)
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
    fleet.network.silent['a'] = fleet.now + 2.0
    for later in (0.1, 0.2):
        hear(fleet, at_place(agv.report(fleet.now + later), fleet.graph, 2, 0.5))
    assert fleet.supervisor.robots['a'].outage is Outage.TAKEN_OVER


def test_a_robot_that_does_not_know_its_place_yet_is_not_off_the_graph():
    """A bridge sends reports as soon as it starts, but learns the robot's place some seconds later.
    """
    fleet = SupervisedFleet(corridor(6), {'a': (AGV, 1)})
    fleet.network.silent['a'] = 3.0
    for later in (0.1, 0.2, 0.3):
        hear(fleet, replace(fleet.agvs['a'].report(fleet.now + later), stamp=0, pose=SymbolicPose(),
                            location=None))
    assert fleet.supervisor.robots['a'].outage is None
    fleet.request(1, 6)
    fleet.run_until_done(1)


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
    fleet.do(fleet.supervisor.plan_made(4711, PlanningOutcome({}, ()), fleet.now))
    fleet.do(fleet.supervisor.plan_failed(4711, 'a stranger says so', fleet.now))
    assert fleet.supervisor.plan_executor.plan is before and ends_well(fleet)


@pytest.mark.parametrize('command', list(CommandKind))
def test_a_command_for_a_mission_that_is_not_there_is_told_so(fleet, command):
    fleet.do(fleet.supervisor.command(4711, command, fleet.now))
    assert fleet.notes[-1] == f'There is no open mission 4711 for {command.name}.'
    assert ends_well(fleet)


def test_closing_edges_that_the_graph_does_not_have_closes_nothing(fleet):
    fleet.close(4711, -4712)
    assert not fleet.supervisor.network.closed and ends_well(fleet)
