"""A supervised fleet of simulated AGVs: missions are served however late robots are."""
from __future__ import annotations

import re
import time
from dataclasses import replace

import pytest
from fleet_builders import AGV, corridor, graph_of, ladder, with_docks

from fleet_core.interlocking.changes import Changes
from fleet_core.interlocking.reports import Report
from fleet_core.supervision.assumptions import WorldView
from fleet_core.supervision.duties import WINDOW
from fleet_core.supervision.fleet_stop import NOT_STOPPED, FleetStop, StopCause
from fleet_core.supervision.fleet_view import (
    RobotState,
    plan_progress,
    plan_views,
    robot_views,
)
from fleet_core.supervision.missions import CommandKind, MissionState
from fleet_core.supervision.outages import Outage
from fleet_core.supervision.settings import RobotSettings
from route_protocol.values import EMERGENCY_STOP, TAKEN_OVER, SymbolicPose
from world.supervised_fleet import SupervisedFleet


def test_one_robot_serves_a_mission_in_order():
    fleet = SupervisedFleet(corridor(5), {'a': (AGV, 1)})
    fleet.request(1, 3, 2, 5)
    fleet.run_until_done(1)
    assert fleet.told(1) == [MissionState.PENDING, MissionState.ACTIVE, MissionState.SUCCEEDED]
    assert fleet.supervisor.robots['a'].position.vertex == 5
    assert fleet.agvs['a'].travelled == pytest.approx(2.0 * (2 + 1 + 3))


def test_two_robots_swap_their_places_through_a_siding_ten_times():
    fleet = SupervisedFleet(corridor(6, siding_at=3), {'a': (AGV, 1), 'b': (AGV, 6)})
    for turn in range(10):
        ends = (6, 1) if turn % 2 == 0 else (1, 6)
        fleet.request(2 * turn + 1, ends[0], robot='a')
        fleet.request(2 * turn + 2, ends[1], robot='b')
        fleet.run_until_done(2 * turn + 1, 2 * turn + 2)
    assert fleet.nearest >= 0.0


def test_a_robot_that_does_not_know_yet_where_it_is_is_not_off_the_graph():
    fleet = SupervisedFleet(corridor(3), {'a': (AGV, 1)})
    nowhere = replace(fleet.agvs['a'].report(0.0), pose=SymbolicPose(), location=None)
    fleet.do(fleet.supervisor.report('a', Report(nowhere), 0.0))
    fleet.request(1, 3)
    fleet.run_until_done(1)
    assert fleet.told(1)[-1] is MissionState.SUCCEEDED


def test_the_best_placed_robot_is_sent_and_two_missions_are_shared_out():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1), 'b': (AGV, 8)})
    fleet.step()
    fleet.request(1, 6)
    fleet.request(2, 3)
    fleet.run_until_done(1, 2)
    assert fleet.robot_of(1) == 'b' and fleet.robot_of(2) == 'a'


def test_priority_goes_first_and_a_direct_mission_waits_for_its_robot():
    fleet = SupervisedFleet(corridor(6), {'a': (AGV, 1)})
    fleet.request(1, 3, robot='a')
    fleet.run(1.0)
    fleet.request(2, 5)
    fleet.request(3, 1, priority=9)
    fleet.run_until_done(1, 2, 3)
    ends = [s.request_id for s in fleet.statuses if s.state is MissionState.SUCCEEDED]
    assert ends == [1, 3, 2]


def test_the_oldest_mission_goes_first_though_a_younger_one_is_nearer():
    fleet = SupervisedFleet(corridor(6), {'a': (AGV, 1)})
    fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    fleet.request(1, 6)
    fleet.request(2, 2, robot='a')
    fleet.do(fleet.supervisor.resume_fleet(fleet.now)[1])
    fleet.run_until_done(1, 2)
    ends = [s.request_id for s in fleet.statuses if s.state is MissionState.SUCCEEDED]
    assert ends == [1, 2]


def test_a_dwell_holds_the_robot_and_release_ends_one_without_end():
    fleet = SupervisedFleet(corridor(6), {'a': (AGV, 1)})
    fleet.request(1, 3, 5, dwells=(4.0, -1.0))
    fleet.run_until(lambda: fleet.reached(1) == 1)
    assert fleet.now >= 4.0 + 4.0
    fleet.run(60.0)
    assert fleet.state(1) is MissionState.ACTIVE and fleet.agvs['a'].travelled == pytest.approx(8)
    fleet.do(fleet.supervisor.command(1, CommandKind.RELEASE, fleet.now))
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.SUCCEEDED


def test_a_robot_that_is_pushed_away_while_it_stays_comes_back_and_stays_anew():
    fleet = SupervisedFleet(corridor(6), {'a': (AGV, 1)})
    fleet.request(1, 3, 5, dwells=(10.0, 0.0))
    fleet.run_until(lambda: fleet.agvs['a'].visited[-1] == 3 and not fleet.agvs['a'].is_driving)
    fleet.agvs['a'].emergency = True
    fleet.run(1.0)
    fleet.agvs['a'].arc -= 1.0
    fleet.run(20.0)
    fleet.agvs['a'].emergency = False
    begun = fleet.now
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.SUCCEEDED
    assert fleet.now - begun > 10.0


def test_who_stays_at_a_destination_makes_room_for_nobody():
    fleet = SupervisedFleet(corridor(6, siding_at=3), {'a': (AGV, 4), 'b': (AGV, 1)},
                            parking=(1, 6, 100))
    fleet.request(1, 3, 6, dwells=(-1.0, 0.0), robot='a')
    fleet.run_until(lambda: fleet.agvs['a'].visited[-1] == 3 and not fleet.agvs['a'].is_driving)
    fleet.request(2, 5, robot='b')
    fleet.run(30.0)
    assert fleet.agvs['a'].visited == [4, 3]
    fleet.do(fleet.supervisor.command(1, CommandKind.RELEASE, fleet.now))
    fleet.run_until_done(1, 2)


def test_a_stay_of_no_time_is_none():
    with_stays, without = (SupervisedFleet(corridor(8), {'a': (AGV, 1)}) for _ in range(2))
    with_stays.request(1, 3, 5, 7, dwells=(0.0, 0.0, 0.0))
    without.request(1, 3, 5, 7)
    assert with_stays.run_until_done(1) == without.run_until_done(1)


@pytest.mark.parametrize('robot, waits_for', [('a', 'a'), ('', 'a robot')])
def test_a_mission_says_whom_at_work_it_waits_for(robot, waits_for):
    fleet = SupervisedFleet(corridor(8, siding_at=3), {'a': (AGV, 1), 'b': (AGV, 8)},
                            parking=(1, 8, 100))
    fleet.request(1, 4, robot='a')
    fleet.request(2, 7, robot='b')
    fleet.run(1.0)
    fleet.request(3, 2, robot=robot)
    fleet.run(1.0)
    assert fleet.statuses[-1].reason == f'it waits for {waits_for} to be free'


def test_a_cancelled_robot_stops_at_the_end_of_its_edge():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)},
                            settings=RobotSettings(release_ahead=8.0))
    fleet.request(1, 8)
    fleet.run(3.0)
    assert len(fleet.supervisor.robots['a'].record.ahead) > 2
    fleet.do(fleet.supervisor.command(1, CommandKind.CANCEL, fleet.now))
    fleet.run(20.0)
    assert fleet.state(1) is MissionState.CANCELLED
    assert fleet.agvs['a'].travelled < 6.1


def test_pause_and_resume():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)})
    fleet.request(1, 8)
    fleet.run(3.0)
    fleet.do(fleet.supervisor.command(1, CommandKind.PAUSE, fleet.now))
    fleet.run(30.0)
    assert fleet.state(1) is MissionState.PAUSED and fleet.agvs['a'].travelled < 4.1
    fleet.do(fleet.supervisor.command(1, CommandKind.RESUME, fleet.now))
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.SUCCEEDED


def test_a_lone_robot_is_released_so_far_ahead_that_it_never_brakes():
    fleet = SupervisedFleet(corridor(12), {'a': (AGV, 1)},
                            settings=RobotSettings(release_ahead=4.0))
    fleet.request(1, 12)
    fleet.run_until(lambda: fleet.agvs['a'].is_driving)
    begun = fleet.now
    while fleet.agvs['a'].is_driving:
        ahead = fleet.supervisor.robots['a'].record.distance_ahead()
        assert ahead <= 4.0 + 2.0, 'nothing beyond the first edge that ends beyond release_ahead'
        fleet.step()
    assert fleet.supervisor.robots['a'].position.vertex == 12
    assert fleet.now - begun == pytest.approx(22.0, abs=0.3)


def test_an_idle_robot_makes_room_only_when_somebody_needs_it():
    fleet = SupervisedFleet(corridor(6, siding_at=3), {'a': (AGV, 3), 'b': (AGV, 1)},
                            parking=(1, 6, 100))
    fleet.run(20.0)
    assert fleet.agvs['a'].travelled == 0.0
    fleet.request(1, 5, robot='b')
    fleet.run_until_done(1)
    assert fleet.agvs['a'].travelled > 0.0


def test_after_an_emergency_stop_the_robot_goes_on_by_itself():
    fleet = SupervisedFleet(corridor(6), {'a': (AGV, 1)})
    fleet.request(1, 6)
    fleet.run(3.0)
    fleet.agvs['a'].emergency = True
    told = len(fleet.notes)
    fleet.run(20.0)
    assert fleet.supervisor.robots['a'].outage is Outage.STOPPED
    assert fleet.state(1) is MissionState.ACTIVE
    fleet.agvs['a'].emergency = False
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.SUCCEEDED
    assert fleet.notes[told:] == [
        'a cannot work: emergency stop. It comes back when the emergency stop is released and the '
        'motors are on.', 'a works again.']


def test_a_robot_that_has_just_stopped_is_given_time_before_it_is_ordered_on():
    fleet = SupervisedFleet(corridor(6), {'a': (AGV, 1)})
    fleet.request(1, 6)
    fleet.run(3.0)
    fleet.agvs['a'].fail(EMERGENCY_STOP)  # the robot reports this before it refuses orders
    fleet.run_until_done(1)
    assert any(note.startswith('a cannot work: emergency stop.') for note in fleet.notes)


def test_a_robot_taken_over_needs_a_person_and_its_mission_goes_to_another():
    fleet = SupervisedFleet(corridor(8, siding_at=5), {'a': (AGV, 1), 'b': (AGV, 8)})
    fleet.step()
    fleet.request(1, 4)
    fleet.run(2.0)
    assert fleet.robot_of(1) == 'a'
    fleet.agvs['a'].fail(TAKEN_OVER)
    fleet.run(10.0)
    assert fleet.supervisor.robots['a'].outage is Outage.TAKEN_OVER
    fleet.run_until_done(1)
    assert fleet.robot_of(1) == 'b'
    problem, actions = fleet.supervisor.bring_in('a', fleet.now)
    fleet.do(actions)
    assert problem == '' and fleet.supervisor.robots['a'].works


def test_a_mission_of_which_something_is_done_fails_with_its_robot():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1), 'b': (AGV, 8)})
    fleet.request(1, 2, 5, robot='a')
    fleet.run_until(lambda: fleet.reached(1) == 1)
    fleet.run(1.0)
    fleet.agvs['a'].fail(TAKEN_OVER)
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.FAILED
    assert fleet.statuses[-1].reason == 'a: taken over'


def test_stop_all_works_without_a_planner_and_resume_goes_on():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)}, planning=0.1)
    fleet.request(1, 8)
    fleet.run(3.0)
    fleet.planner.latency = 1e9
    fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    fleet.step()
    fleet.step()
    stopped = fleet.agvs['a'].travelled
    fleet.run(20.0)
    assert fleet.agvs['a'].travelled == stopped
    fleet.planner.latency = 0.1
    fleet.do(fleet.supervisor.resume_fleet(fleet.now)[1])
    fleet.run_until_done(1)


def _stopped_between(least: float, most: float) -> SupervisedFleet:
    """Returns a fleet that was stopped when robot `a` was on an edge between these two places.

    least, most -- m from the start of the edge
    """
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)})
    fleet.request(1, 8)
    fleet.run_until(lambda: least < fleet.agvs['a'].arc < most)
    fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    return fleet


def test_a_robot_stopped_just_before_a_vertex_is_sent_over_the_rest_of_its_edge():
    fleet = _stopped_between(1.75, 1.95)
    agv = fleet.agvs['a']
    fleet.run(5.0)
    before = agv.edge
    fleet.do(fleet.supervisor.resume_fleet(fleet.now)[1])
    while not agv.edges:
        fleet.step()
    assert agv.edges[0] == before, 'not the vertex, because the robot has not arrived'
    fleet.run_until_done(1)


@pytest.mark.parametrize('near, short', [(0.0001, 0.0005), (0.001, 0.01), (0.25, 0.1)])
def test_a_robot_stricter_about_vertices_than_was_thought_is_asked_the_other_way(near, short):
    fleet = _stopped_between(1.0, 1.5)
    agv = fleet.agvs['a']
    fleet.run(1.0)
    agv.arc, agv.near = 2.0 - short, near
    fleet.run(5.0)
    fleet.do(fleet.supervisor.resume_fleet(fleet.now)[1])
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.SUCCEEDED


def test_a_stopped_fleet_stays_stopped_through_a_restart():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)})
    fleet.request(1, 8)
    fleet.run(3.0)
    fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    fleet.restart()
    fleet.run(20.0)
    assert fleet.supervisor.is_stopped and fleet.state(1) is MissionState.ACTIVE
    assert fleet.agvs['a'].travelled < 5.0


@pytest.mark.parametrize('seconds', [0.1, 0.5, 1.0, 2.1, 3.0, 4.2, 7.0])
def test_a_restart_at_any_moment_loses_no_mission_and_stops_no_robot(seconds):
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)},
                            settings=RobotSettings(release_ahead=8.0))
    fleet.request(1, 8)
    fleet.run(seconds)
    fleet.restart()
    assert fleet.run_until_done(1) <= 14.0 + 2.0
    assert fleet.state(1) is MissionState.SUCCEEDED


def test_a_silent_robot_keeps_its_places_and_others_go_round_it():
    fleet = SupervisedFleet(corridor(6, siding_at=3), {'a': (AGV, 1), 'b': (AGV, 6)})
    fleet.request(1, 4, robot='a')
    fleet.run(1.0)
    fleet.network.silent['a'] = 1e9
    fleet.run(8.0)
    fleet.request(2, 2, robot='b')
    fleet.run(30.0)
    assert fleet.supervisor.robots['a'].outage is Outage.SILENT
    assert fleet.state(2) is MissionState.ACTIVE, 'robot a may be anywhere on its edge'
    fleet.network.silent.clear()
    fleet.run_until_done(1)


def test_others_go_round_a_robot_that_reports_but_answers_no_order():
    fleet = SupervisedFleet(ladder(8), {'a': (AGV, 1), 'b': (AGV, 4)}, parking=(1, 4, 8, 108))
    fleet.network.deaf['b'] = 1e9
    fleet.request(1, 4, 8, robot='b')
    fleet.request(2, 8, robot='a')
    fleet.run_until_done(2)
    assert fleet.supervisor.robots['b'].outage is Outage.DEAF
    assert fleet.agvs['b'].travelled == 0.0
    fleet.network.deaf.clear()
    fleet.request(3, 1, robot='a')
    fleet.run_until_done(1, 3)


def test_who_waits_for_a_robot_that_answers_no_order_is_told_so_and_goes_on_once_it_does():
    fleet = SupervisedFleet(corridor(6, siding_at=3), {'a': (AGV, 1), 'b': (AGV, 3)},
                            parking=(1, 6, 100))
    fleet.network.deaf['b'] = 1e9
    fleet.request(1, 5, robot='a')
    fleet.run(30.0)
    views = {view.name: view for view in robot_views(fleet.supervisor, fleet.now)}
    assert 'blocked by b, which cannot move' in views['a'].waits_for.text
    assert views['b'].state is RobotState.OFFLINE
    assert 'reports, but has not answered an order for' in views['b'].waits_for.text
    assert any('b cannot work' in note for note in fleet.notes)
    fleet.network.deaf.clear()
    fleet.run_until_done(1)


def test_a_robot_that_answers_no_stop_is_named():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)})
    fleet.run(1.0)
    fleet.network.deaf['a'] = 1e9
    fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    fleet.run(10.0)
    assert fleet.supervisor.robots['a'].outage is Outage.DEAF
    fleet.network.deaf.clear()
    fleet.run(5.0)
    assert fleet.supervisor.robots['a'].outage is None
    fleet.do(fleet.supervisor.resume_fleet(fleet.now)[1])
    fleet.request(1, 8)
    fleet.run_until_done(1)


def test_a_robot_whose_reports_are_back_before_its_answer_is_not_called_deaf():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)})
    fleet.run(1.0)
    fleet.network.silent['a'] = 21.0
    fleet.request(1, 8)
    fleet.run_until(lambda: fleet.now >= 21.0)
    fleet.network.deaf['a'] = 24.0
    fleet.run_until_done(1)
    assert not any('answered' in note for note in fleet.notes)


def test_a_closed_edge_is_driven_by_nobody_who_was_not_let_onto_it():
    graph = graph_of({1: (0, 0), 2: (2, 0), 3: (2, 4), 4: (4, 0)},
                     {1: (1, 2), 2: (2, 4), 3: (2, 3), 4: (3, 4)})
    fleet = SupervisedFleet(graph, {'a': (AGV, 1)})
    fleet.do(fleet.supervisor.close_edges([2], 0.0))
    fleet.request(1, 4)
    fleet.run_until_done(1)
    assert fleet.agvs['a'].visited == [1, 2, 3, 4]


def test_a_robot_charges_below_one_threshold_and_works_above_another():
    kind = replace(AGV, docks=frozenset({6}))
    graph = with_docks(corridor(6), 6)
    fleet = SupervisedFleet(graph, {'a': (kind, 1), 'b': (kind, 3)}, parking=(1, 2, 3, 4, 6))
    fleet.do(fleet.supervisor.battery('a', 0.9, 0.0))
    fleet.do(fleet.supervisor.battery('b', 0.2, 0.0))
    fleet.run(30.0)
    assert fleet.supervisor.robots['b'].position.vertex == 6
    fleet.request(1, 4, robot='b')
    fleet.run(30.0)
    assert fleet.state(1) is MissionState.PENDING
    fleet.do(fleet.supervisor.battery('b', 0.85, fleet.now))
    fleet.run_until_done(1)


def test_a_mission_that_the_battery_cannot_end_is_not_begun():
    fleet = SupervisedFleet(corridor(6), {'a': (AGV, 1)},
                            settings=RobotSettings(charge_below=0.0, endurance=10.0))
    fleet.do(fleet.supervisor.battery('a', 0.5, 0.0))
    fleet.request(1, 6)
    fleet.run(10.0)
    assert fleet.state(1) is MissionState.PENDING
    assert fleet.statuses[-1].reason == 'no free robot has enough charge for it'


def test_two_robots_that_report_one_place_are_not_moved():
    fleet = SupervisedFleet(corridor(6), {'a': (AGV, 1), 'b': (AGV, 6)})
    fleet.agvs['b'] = fleet.agvs['a']
    fleet.clearance = -1e9
    fleet.request(1, 4)
    fleet.run(10.0)
    assert not any(order.edges for order in fleet.sent)
    assert 'nearer' in fleet.supervisor.plan_executor.plan.unserved['a']


def test_wrong_reports_are_ignored_with_one_sentence_until_there_are_right_ones():
    fleet = SupervisedFleet(corridor(6), {'a': (AGV, 1)})
    fleet.run(1.0)
    told = len(fleet.notes)
    for _ in range(5):
        wrong = replace(fleet.agvs['a'].report(fleet.now), pose=SymbolicPose(77, 50.0))
        fleet.do(fleet.supervisor.report('a', Report(wrong), fleet.now))
    fleet.run(2.0)
    assert fleet.notes[told:] == ['A report of a is ignored: it is on edge 77, which the graph '
                                  'does not have.', 'The reports of a make sense again.']
    assert fleet.supervisor.robots['a'].works


def test_the_serials_of_accepted_missions_only_grow_and_each_status_has_its_own():
    fleet = SupervisedFleet(corridor(6), {'a': (AGV, 1)})
    for vertex in (2, 3):
        fleet.request(1, vertex)  # the id of a mission that has ended
        fleet.run(30.0)
    fleet.request(2, 99)
    fleet.run(1.0)
    ends = [(status.request_id, status.state, status.serial) for status in fleet.statuses
            if not status.state.is_open]
    assert ends == [(1, MissionState.SUCCEEDED, 1), (1, MissionState.SUCCEEDED, 2),
                    (2, MissionState.REFUSED, 0)]
    assert {status.serial for status in fleet.statuses if status.state.is_open} == {1, 2}


def test_the_view_of_the_fleet_says_what_each_robot_is_about():
    fleet = SupervisedFleet(corridor(6), {'a': (AGV, 1)})
    fleet.request(1, 3, 5)
    fleet.run(1.0)
    view, = robot_views(fleet.supervisor, fleet.now)
    assert (view.state, view.mission, view.destination) == (RobotState.BUSY, 1, 3)
    (name, drives), = plan_views(plan_progress(fleet.supervisor))
    assert name == 'a' and [d.edge for d in drives][:4] == [1, 2, 3, 4]
    assert drives[0].released and not drives[3].released
    fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    view, = robot_views(fleet.supervisor, fleet.now)
    assert view.waits_for.text == 'the fleet is stopped'


@pytest.mark.parametrize('seconds', [0.0, 0.1, 3.0])
def test_a_robot_out_of_service_stays_where_it_is_through_a_restart(seconds):
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)},
                            settings=RobotSettings(release_ahead=8.0))
    fleet.request(1, 8)
    fleet.run(3.0)
    fleet.do(fleet.supervisor.take_out('a', fleet.now))
    fleet.run(seconds)
    fleet.restart()
    fleet.run(3.0)
    stopped = fleet.agvs['a'].travelled
    fleet.run(20.0)
    assert fleet.agvs['a'].travelled == stopped < 6.0
    assert fleet.supervisor.robots['a'].outage is Outage.OUT_OF_SERVICE


def test_a_stop_that_was_obeyed_is_not_given_again_by_a_restart():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)})
    fleet.request(1, 8)
    fleet.run(3.0)
    fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    fleet.run(3.0)
    sent = len(fleet.sent)
    fleet.restart()
    fleet.run(10.0)
    assert fleet.sent[sent:] == [], 'its present driver would be stopped'
    fleet.do(fleet.supervisor.resume_fleet(fleet.now)[1])
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.SUCCEEDED


@pytest.mark.parametrize('seconds', [1.0, 3.0])
def test_a_robot_that_was_switched_off_and_on_again_mid_route_needs_a_person(seconds):
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)})
    for id, vertex in enumerate((4, 8), 1):  # the first time on its first route
        fleet.request(id, vertex)
        fleet.run(seconds)
        fleet.agvs['a'].forget()
        fleet.run(5.0)
        robot = fleet.supervisor.robots['a']
        assert (robot.outage, robot.why) == (Outage.FAILED, 'it has forgotten its route')
        assert not fleet.bring_in('a')
        fleet.run_until_done(id)
        assert fleet.state(id) is MissionState.SUCCEEDED


@pytest.mark.parametrize('count', [WINDOW, WINDOW + 1, 2 * WINDOW + 3])
def test_a_mission_has_more_destinations_than_the_planner_is_asked_for_at_once(count):
    fleet = SupervisedFleet(ladder(5), {'a': (AGV, 1)})
    fleet.request(1, *([5, 1] * count)[:count])
    fleet.run_until_done(1, limit=10.0 * count)
    assert fleet.reached(1) == count


@pytest.mark.parametrize('seed', range(3))
def test_to_look_only_at_robots_with_news_gives_the_same_orders(seed, monkeypatch):
    """The supervisor sends the same orders as a supervisor that examines all robots at each event.
    """
    orders = []
    for looks_at_all in (False, True):
        if looks_at_all:
            world = WorldView.world

            def anew(view, *present, world=world):
                view._states.clear()
                return world(view, *present)
            monkeypatch.setattr(WorldView, 'world', anew)
            monkeypatch.setattr(Changes, 'follow', lambda changes: lambda: list(changes._last))
        fleet = SupervisedFleet(ladder(5), {'a': (AGV, 1), 'b': (AGV, 3), 'c': (AGV, 105)},
                                seed=seed, loss=0.05)
        for id, places in enumerate(((5, 101), (1, 105), (103, 3), (104, 2)), 1):
            fleet.request(id, *places, dwells=(3.0 * (id % 2), 0.0))
        fleet.run(4.0)
        fleet.do(fleet.supervisor.command(1, CommandKind.PAUSE, fleet.now))
        fleet.close(2)
        fleet.run(6.0)
        fleet.do(fleet.supervisor.command(1, CommandKind.RESUME, fleet.now))
        fleet.do(fleet.supervisor.stop_fleet(fleet.now))
        fleet.run(5.0)
        fleet.do(fleet.supervisor.resume_fleet(fleet.now)[1])
        fleet.close()
        fleet.run_until_done(1, 2, 3, 4)
        orders.append([(sent.robot, sent.order.number, sent.order.edges, sent.repeated)
                       for sent in fleet.sent])
    assert orders[0] == orders[1]


STOP = FleetStop(StopCause.PERSON, 'anna (page)', 1700000000.0)


def test_who_stopped_the_fleet_and_when_is_known_until_it_goes_on():
    """A second stop and restarts do not change the author and the time of the stop."""
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1), 'b': (AGV, 8)})
    fleet.request(1, 3, robot='a')
    fleet.run(2.0)
    assert fleet.supervisor.stop == NOT_STOPPED
    fleet.do(fleet.supervisor.stop_fleet(fleet.now, STOP))
    fleet.do(fleet.supervisor.stop_fleet(fleet.now, FleetStop(StopCause.PERSON, 'boris', 1.8e9)))
    for _ in range(2):
        assert fleet.supervisor.stop == STOP
        fleet.run(3.0)
        fleet.restart()
    fleet.do(fleet.supervisor.resume_fleet(fleet.now)[1])
    assert fleet.supervisor.stop == NOT_STOPPED
    fleet.restart()
    assert fleet.supervisor.stop == NOT_STOPPED
    fleet.run_until_done(1)


@pytest.mark.parametrize('stop, words', [
    (NOT_STOPPED, ''),
    (FleetStop(StopCause.UNKNOWN), 'The fleet is stopped.'),
    (FleetStop(StopCause.PERSON, 'anna', 1e9),
     'The fleet is stopped since 2001-09-09 TIME, by anna.'),
    (FleetStop(StopCause.DEFECT, '', 1e9 + 7e8, 'an error'),
     'The fleet is stopped since TIME: an error.')])
def test_a_stop_is_told_in_a_sentence_with_the_date_if_it_was_another_day(stop, words, monkeypatch):
    monkeypatch.setenv('TZ', 'UTC')
    time.tzset()
    told = re.sub(r'\d\d:\d\d:\d\d', 'TIME', stop.words(1e9 + 7e8 + 60.0))
    monkeypatch.undo()
    time.tzset()
    assert told == words


@pytest.mark.parametrize('busy', [True, False])
def test_an_emergency_stop_is_told_as_long_as_it_is_pressed(busy):
    """At no moment does the robot seem ready, not even after the fleet was stopped and resumed."""
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1), 'b': (AGV, 8)})
    if busy:
        fleet.request(1, 4, robot='a')
    fleet.run(2.0)
    fleet.agvs['a'].emergency = True
    fleet.run_until(lambda: fleet.supervisor.robots['a'].outage is Outage.STOPPED)

    def stays_told(seconds):
        for _ in range(int(seconds * 10)):
            fleet.run(0.1)
            view = robot_views(fleet.supervisor, fleet.now)[0]
            assert (view.state, view.outage) == (RobotState.STOPPED, Outage.STOPPED)
    stays_told(3.0)
    fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    stays_told(3.0)
    fleet.do(fleet.supervisor.resume_fleet(fleet.now)[1])
    assert fleet.supervisor.who_goes_on == 'The fleet goes on, except a: emergency stop.'
    stays_told(15.0)
    fleet.agvs['a'].emergency = False
    fleet.run_until(lambda: fleet.supervisor.robots['a'].works)
    if busy:
        fleet.run_until_done(1)
