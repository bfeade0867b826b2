"""Data that survives restarts of the supervisor, changes of the graph, and a full or missing
disk.
"""
from __future__ import annotations

import math
import tempfile
from dataclasses import replace

import pytest
from fleet_builders import AGV, corridor, ladder

from fleet_core.interlocking.changes import Changes
from fleet_core.interlocking.interlocking import Interlocking
from fleet_core.interlocking.reports import Report
from fleet_core.interlocking.route_master import MANUAL_REACH
from fleet_core.supervision.fleet_view import robot_views
from fleet_core.supervision.missions import CommandKind, MissionState
from fleet_core.supervision.outages import Outage, Sign
from fleet_core.supervision.restoring import robots_of
from fleet_core.supervision.settings import RobotSettings
from fleet_simulation.virtual_fleet import route_order
from route_protocol.master import Order
from route_protocol.values import EdgeState, Motion
from trajectory_graph import Graph
from world.supervised_fleet import SupervisedFleet, blocked

# -- restarts --------------------------------------------------------------------------------------

def cut_short(graph, length):
    """Returns a corridor without the vertices whose ids are above `length`."""
    return Graph([v for v in graph.vertices.values() if v.id <= length],
                 [e for e in graph.edges.values() if e.destination <= length])


def test_a_mission_to_a_vertex_that_the_graph_lost_has_failed_and_the_others_go_on():
    fleet = SupervisedFleet(corridor(6), {'a': (AGV, 1)})
    fleet.do(fleet.supervisor.take_out('a', fleet.now))
    fleet.request(1, 6)
    fleet.request(2, 3)
    fleet.run(3.0)
    fleet.restart(cut_short(fleet.graph, 4))
    fleet.run(3.0)
    assert fleet.state(1) is MissionState.FAILED
    assert fleet.statuses[-1].reason == 'the graph has no vertex 6'
    fleet.do(fleet.supervisor.bring_in('a', fleet.now)[1])
    fleet.run_until_done(2)
    assert fleet.state(2) is MissionState.SUCCEEDED


def test_a_robot_that_stays_until_released_is_released_before_the_first_tick_after_a_restart():
    fleet = SupervisedFleet(corridor(4), {'a': (AGV, 1)})
    fleet.request(1, 2, 4, dwells=(-1.0, 0.0))
    fleet.run(20.0)
    assert fleet.reached(1) == 0 and fleet.agvs['a'].visited[-1] == 2
    fleet.restart()
    fleet.do(fleet.supervisor.command(1, CommandKind.RELEASE, fleet.now))
    assert fleet.reached(1) == 1
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.SUCCEEDED


def test_allocations_in_the_journal_never_exclude_each_other():
    """When a robot is granted a place, the journal also stores that another robot has left this
    place.
    """
    fleet = SupervisedFleet(corridor(12), {'a': (AGV, 1), 'b': (AGV, 2), 'c': (AGV, 3)})
    for id, (vertex, robot) in enumerate(((8, 'a'), (10, 'b'), (12, 'c')), 1):
        fleet.request(id, vertex, robot=robot)
    while fleet.supervisor.book.open:
        fleet.step()
        robots = robots_of(fleet.fleet, {}, fleet.graph, fleet.disk.journal.robots(), None,
                           fleet.now, int, Changes())
        stored = Interlocking(fleet.supervisor.network.geometry, fleet.clearance, robots)
        assert [stored.excluding(name) for name in robots] == [(), (), ()], fleet.picture()


@pytest.mark.parametrize('restarts', [1, 3])
def test_a_stay_does_not_begin_anew_after_a_restart(restarts):
    fleet = SupervisedFleet(corridor(4), {'a': (AGV, 1)})
    fleet.request(1, 2, dwells=(60.0,))
    fleet.run_until(lambda: fleet.agvs['a'].visited[-1:] == [2] and not fleet.agvs['a'].is_driving)
    begun = fleet.now
    for _ in range(restarts):
        fleet.run(12.0)
        fleet.restart()
    fleet.run_until_done(1)
    assert 59.0 < fleet.now - begun < 65.0


def test_the_second_of_two_stays_at_one_place_has_its_whole_time_after_a_restart():
    fleet = SupervisedFleet(corridor(4), {'a': (AGV, 1)})
    fleet.request(1, 2, 2, dwells=(20.0, 30.0))
    fleet.run_until(lambda: fleet.reached(1) == 1)
    begun = fleet.now
    fleet.run(1.0)
    fleet.restart()
    fleet.run_until_done(1)
    assert 29.0 < fleet.now - begun < 32.0


def test_a_robot_whose_place_the_graph_lost_stays_out_of_service():
    fleet = SupervisedFleet(corridor(6), {'a': (AGV, 6), 'b': (AGV, 1)})
    fleet.run(1.0)
    fleet.do(fleet.supervisor.take_out('a', fleet.now))
    fleet.run(1.0)
    fleet.network.silent['a'] = 1e9
    fleet.restart(cut_short(fleet.graph, 4))
    fleet.request(1, 3)
    fleet.run_until_done(1)
    assert fleet.robot_of(1) == 'b'
    assert fleet.supervisor.robots['a'].outage is Outage.OUT_OF_SERVICE


def test_a_robot_whose_track_the_graph_lost_stays_out_of_service():
    fleet = SupervisedFleet(corridor(6), {'a': (AGV, 1)},
                            settings=RobotSettings(release_ahead=8.0))
    fleet.request(1, 6)
    fleet.run(2.0)
    fleet.do(fleet.supervisor.take_out('a', fleet.now))
    fleet.run(1.0)
    fleet.restart(cut_short(fleet.graph, 4))
    fleet.run(10.0)
    assert fleet.supervisor.robots['a'].outage is Outage.OUT_OF_SERVICE


def test_a_stop_that_a_robot_has_not_heard_outlives_a_graph_without_its_track():
    fleet = SupervisedFleet(corridor(6), {'a': (AGV, 1)}, settings=RobotSettings(release_ahead=8.0))
    fleet.request(1, 6)
    fleet.run(2.0)
    fleet.network.silent['a'] = 1e9
    fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    fleet.agvs['a'].stalled = 10.0
    fleet.restart(cut_short(fleet.graph, 4))
    fleet.run(1.0)
    fleet.network.silent.clear()
    fleet.run(3.0)
    assert fleet.agvs['a'].edges == () and not fleet.supervisor.robots['a'].master.is_stopping


@pytest.mark.parametrize('edges', [(1, 99), (2, 1), (0,)])
@pytest.mark.parametrize('state', [EdgeState.PROCESSING, EdgeState.COMPLETE, EdgeState.FAILED])
def test_a_route_that_the_graph_does_not_have_is_nobodys_but_the_robots(edges, state):
    fleet = SupervisedFleet(corridor(12), {'a': (AGV, 1), 'b': (AGV, 12)})
    motion = Motion.ON_ROUTE if state is EdgeState.PROCESSING else Motion.STANDING
    foreign = replace(fleet.agvs['a'].report(fleet.now), edges=edges, states=(state,) * len(edges),
                      master='another', order=7, motion=motion)
    fleet.network.silent['a'] = 1e9
    fleet.do(fleet.supervisor.report('a', Report(foreign), fleet.now))
    fleet.request(1, 11, robot='b')  # far from the robot that may be driving unseen
    fleet.run_until_done(1)
    protocol = fleet.supervisor.robots['a'].master.protocol
    assert protocol.is_anywhere == (motion is Motion.ON_ROUTE) and not protocol.may_be_on


def test_who_drives_a_route_of_another_master_may_be_far_from_its_last_place_after_a_restart():
    """The fleet manager does not know where this route leads, and the new graph may have edges
    there.
    """
    whole = corridor(12)
    fleet = SupervisedFleet(cut_short(whole, 4), {'a': (AGV, 1)})
    fleet.run(1.0)
    fleet.agvs['a'].obey_another((1, 2))
    fleet.run(1.0)
    x, y = fleet.agvs['a'].position
    fleet.network.silent['a'] = 1e9
    fleet.restart(whole)
    allocation = fleet.supervisor.robots['a'].master.allocation
    assert any(area.radius >= MANUAL_REACH and math.dist(area.line[0], (x, y)) <= 1.0
               for area in allocation.areas), allocation
    assert not fleet.supervisor.robots['a'].master.is_ready


@pytest.mark.parametrize('crash', [True, False])
def test_a_cancelled_robot_is_not_sent_on_by_a_restart(crash):
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)},
                            settings=RobotSettings(release_ahead=8.0))
    fleet.request(1, 8)
    fleet.run(3.0)
    fleet.do(fleet.supervisor.command(1, CommandKind.CANCEL, fleet.now))
    orders, fleet.network.to_robots = fleet.network.to_robots, []
    fleet.restart()
    # the order may or may not have reached the robot
    fleet.network.to_robots = orders if crash else []
    fleet.run(20.0)
    assert fleet.state(1) is MissionState.CANCELLED
    assert fleet.agvs['a'].travelled < 6.1


def test_a_pause_outlives_a_restart_while_the_robot_is_silent():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)},
                            settings=RobotSettings(release_ahead=8.0))
    fleet.request(1, 8)
    fleet.run(2.0)
    fleet.agvs['a'].emergency = True
    fleet.run(2.0)
    fleet.do(fleet.supervisor.command(1, CommandKind.PAUSE, fleet.now))
    fleet.run(1.0)
    fleet.restart()
    fleet.run(2.0)
    fleet.agvs['a'].emergency = False
    fleet.run(30.0)
    assert fleet.state(1) is MissionState.PAUSED and fleet.agvs['a'].travelled < 4.1
    fleet.do(fleet.supervisor.command(1, CommandKind.RESUME, fleet.now))
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.SUCCEEDED


@pytest.mark.parametrize('starts_anew', [True, False])
def test_a_request_that_comes_again_after_others_with_its_id_is_not_driven_twice(starts_anew):
    """The request was latched: it comes again whenever the node that accepts missions subscribes
    again.
    """
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)})
    for stamp, vertex in ((100.0, 3), (200.0, 1)):
        fleet.request(7, vertex, stamp=stamp)
        fleet.run_until_done(7)
    if starts_anew:
        fleet.restart()
        fleet.run(1.0)
    travelled = fleet.agvs['a'].travelled
    fleet.request(7, 3, stamp=100.0)
    fleet.run(10.0)
    assert fleet.agvs['a'].travelled == travelled
    last = fleet.statuses[-1]
    assert (last.state, last.stamp) == (MissionState.SUCCEEDED, 100.0)
    fleet.request(7, 3, stamp=300.0)
    fleet.run_until_done(7)
    assert fleet.agvs['a'].travelled > travelled


SIGNS = {Outage.STOPPED: Sign.EMERGENCY, Outage.LOST_LINK: Sign.LINK_LOST,
         Outage.TAKEN_OVER: Sign.TAKEN}


@pytest.mark.parametrize('outage, after', [
    (Outage.STOPPED, Outage.UNSEEN), (Outage.LOST_LINK, Outage.UNSEEN), (None, Outage.UNSEEN),
    (Outage.TAKEN_OVER, Outage.TAKEN_OVER)])
def test_after_a_restart_only_what_needs_a_person_is_still_wrong_with_an_unseen_robot(outage,
                                                                                      after):
    fleet = SupervisedFleet(corridor(6), {'a': (AGV, 1)})
    fleet.run(1.0)
    if outage is not None:
        fleet.supervisor.robots['a'].notice(SIGNS[outage], 'for a reason')
        fleet.step()
    fleet.network.silent['a'] = 1e9
    fleet.restart()
    assert fleet.supervisor.robots['a'].outage is after
    assert not fleet.supervisor.robots['a'].works


def test_edges_that_the_disk_does_not_know_to_be_driven_may_be_gone_from_the_graph():
    """The robot's remaining edges are in the new graph. The robot holds them even before its first
    report.
    """
    fleet = SupervisedFleet(ladder(8), {'a': (AGV, 1)},
                            settings=RobotSettings(release_ahead=8.0))
    fleet.request(1, 8)
    fleet.run(1.0)
    fleet.disk.fails()
    fleet.run(4.0)
    assert fleet.agvs['a'].edge == 3
    fleet.network.silent['a'] = 1e9
    fleet.restart(Graph(fleet.graph.vertices.values(),
                            [e for e in fleet.graph.edges.values() if e.id not in (1, 2)]))
    held = blocked(fleet, 'a')[1]
    assert set(fleet.agvs['a'].edges[2:]) <= set(held)


@pytest.mark.parametrize('gone', [2, 3])
def test_a_robot_on_its_route_behind_an_edge_that_the_graph_lost_serves_its_mission(gone):
    """The journal does not show that the robot has left this edge, so the robot is stopped once."""
    fleet = SupervisedFleet(corridor(7), {'a': (AGV, 1)},
                            settings=RobotSettings(release_ahead=8.0))
    fleet.run(2.0)
    fleet.request(1, 7)
    fleet.run_until(lambda: fleet.agvs['a'].edge == 2)
    fleet.disk.fails()
    fleet.run_until(lambda: fleet.agvs['a'].edge == 4 and fleet.agvs['a'].arc > 0.6)
    fleet.restart(Graph(fleet.graph.vertices.values(),
                        [e for e in fleet.graph.edges.values() if e.id != gone]))
    fleet.run_until(lambda: fleet.supervisor.robots['a'].master.is_heard)
    assert {4, 5, 6} <= set(blocked(fleet, 'a')[1])
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.SUCCEEDED
    assert not any('cannot work' in note for note in fleet.notes)


def test_a_robot_that_is_off_the_graph_keeps_its_place_though_it_has_an_unknown_route():
    """A person stopped the robot without the fleet manager, because the fleet manager hung; then
    the fleet manager was ended.
    """
    fleet = SupervisedFleet(corridor(6), {'a': (AGV, 3)})
    fleet.run(1.0)
    fleet.agvs['a'].off_graph = True
    fleet.agvs['a'].receive(route_order(Order(0, 0, 0, ())))
    fleet.restart()
    fleet.run(1.0)
    assert fleet.supervisor.is_stopped and blocked(fleet, 'a') == ((3,), ())
    fleet.do(fleet.supervisor.resume_fleet(fleet.now)[1])
    fleet.run(1.0)
    assert fleet.supervisor.robots['a'].outage is Outage.OFF_GRAPH
    assert blocked(fleet, 'a') == ((3,), ())


# -- the disk cannot be written: only stops are sent, and nothing is lost --------------------------

AHEAD = RobotSettings(release_ahead=8.0)


def driving(to: int = 8, **others: int) -> SupervisedFleet:
    """Returns a fleet in which robot `a` drives from vertex 1 and serves mission 1."""
    robots = {'a': (AGV, 1), **{name: (AGV, vertex) for name, vertex in others.items()}}
    fleet = SupervisedFleet(corridor(8), robots, settings=AHEAD)
    fleet.request(1, to, robot='a')
    fleet.run(2.0)
    assert fleet.agvs['a'].is_driving
    return fleet


def travelled(fleet: SupervisedFleet) -> float:
    return fleet.agvs['a'].travelled


def test_stop_all_is_sent_and_the_robots_stand_although_nothing_can_be_stored():
    fleet = driving(to=6, b=8)
    fleet.disk.fails()
    fleet.sent.clear()
    fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    assert {(order.robot, order.edges) for order in fleet.sent} == {('a', ()), ('b', ())}
    fleet.run(1.0)
    stood = travelled(fleet)
    fleet.run(30.0)
    assert travelled(fleet) == stood


def test_a_stop_that_gets_lost_is_repeated_although_nothing_can_be_stored():
    fleet = driving()
    fleet.disk.fails()
    fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    fleet.network.to_robots.clear()
    fleet.run(2.0)
    assert not fleet.agvs['a'].is_driving


def test_after_the_stop_the_mission_goes_on_once_the_disk_has_room_and_people_say_so():
    fleet = driving()
    fleet.disk.fails()
    fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    fleet.run(5.0)
    problem, actions = fleet.supervisor.resume_fleet(fleet.now)
    fleet.do(actions)
    assert not problem and 'go on only after this is stored' in fleet.supervisor.who_goes_on
    stood = travelled(fleet)
    fleet.run(10.0)
    assert travelled(fleet) == stood, 'the robot drives on although its order is not stored'
    fleet.disk.fails(False)
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.SUCCEEDED and fleet.agvs['a'].visited[-1] == 8


def test_a_stop_that_was_stored_later_outlives_a_restart():
    fleet = driving()
    fleet.disk.fails()
    fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    fleet.run(3.0)
    fleet.disk.fails(False)
    fleet.run(3.0)
    fleet.restart()
    assert fleet.supervisor.is_stopped


@pytest.mark.parametrize('command', [CommandKind.CANCEL, CommandKind.PAUSE])
def test_a_mission_is_cancelled_or_paused_although_that_cannot_be_stored(command):
    fleet = driving()
    fleet.disk.fails()
    fleet.do(fleet.supervisor.command(1, command, fleet.now))
    fleet.run(20.0)
    assert fleet.agvs['a'].visited == [1, 2], 'the robot must stop at the end of its edge'
    assert fleet.told(1)[-1] is MissionState.ACTIVE, 'nothing may be published that is not stored'
    assert f'{command.name} is carried out, but will be lost' in fleet.statuses[-1].reason
    fleet.disk.fails(False)
    fleet.run(5.0)
    assert fleet.told(1)[-1] is (MissionState.CANCELLED if command is CommandKind.CANCEL
                                 else MissionState.PAUSED)


def test_who_cancels_what_no_robot_was_told_of_moves_no_robot():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)}, settings=AHEAD)
    fleet.run(1.0)
    fleet.request(1, 8)
    fleet.run_until(lambda: fleet.supervisor.plan_executor.is_planning)
    fleet.disk.fails()  # before the plan comes, so that its first edges are not sent
    fleet.run(5.0)
    fleet.do(fleet.supervisor.command(1, CommandKind.CANCEL, fleet.now))
    fleet.run(5.0)
    fleet.disk.fails(False)
    fleet.run(10.0)
    assert fleet.state(1) is MissionState.CANCELLED and travelled(fleet) == 0.0


@pytest.mark.parametrize('command', [CommandKind.RESUME, CommandKind.RELEASE])
def test_what_would_let_a_robot_drive_on_is_not_done_and_that_is_said(command):
    fleet = driving()
    fleet.do(fleet.supervisor.command(1, CommandKind.PAUSE, fleet.now))
    fleet.run(5.0)
    fleet.disk.fails()
    fleet.close(7)  # this must be stored, so the fault appears
    fleet.do(fleet.supervisor.take_out('a', fleet.now))
    fleet.do(fleet.supervisor.command(1, command, fleet.now))
    assert f'{command.name} is not done: the journal' in fleet.statuses[-1].reason


def test_a_mission_that_cannot_be_stored_is_refused_and_leaves_nothing_behind():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)}, settings=AHEAD)
    fleet.run(1.0)
    fleet.disk.fails()
    fleet.request(1, 8)
    fleet.run(1.0)
    fleet.request(2, 5)
    assert fleet.told(1) == fleet.told(2) == [MissionState.REFUSED]
    assert 'cannot be written' in fleet.statuses[-1].reason
    assert 'free space on its disk' in fleet.statuses[-1].reason
    fleet.run(10.0)
    assert travelled(fleet) == 0.0
    fleet.disk.fails(False)
    fleet.run(10.0)
    assert fleet.supervisor.book.find(1) is None and travelled(fleet) == 0.0
    fleet.request(1, 3)
    fleet.run_until_done(1)


def test_a_refusal_for_the_disk_leaves_the_ended_mission_with_that_id_known():
    fleet = SupervisedFleet(corridor(4), {'a': (AGV, 1)})
    fleet.request(1, 2, stamp=5.0)
    fleet.run_until_done(1)
    fleet.disk.fails()
    fleet.request(1, 3, stamp=6.0)
    fleet.disk.fails(False)
    fleet.run(3.0)
    fleet.request(1, 2, stamp=5.0)  # a late repeat
    assert fleet.statuses[-1].state is MissionState.SUCCEEDED


def test_robots_drive_to_the_end_of_what_they_have_and_go_on_when_the_disk_has_room():
    fleet = driving()
    fleet.run(1.0)
    fleet.disk.fails()
    fleet.sent.clear()
    fleet.run(60.0)
    assert not fleet.agvs['a'].is_driving and 8 not in fleet.agvs['a'].visited
    assert not fleet.sent
    view, = robot_views(fleet.supervisor, fleet.now)
    assert 'cannot be written' in view.waits_for.text
    assert [note for note in fleet.notes if 'cannot be written' in note] != []
    fleet.disk.fails(False)
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.SUCCEEDED
    assert fleet.notes[-1] == 'The journal can be written again.'
    assert travelled(fleet) == pytest.approx(14.0)


def test_an_end_that_cannot_be_stored_is_told_once_it_is():
    fleet = driving()
    fleet.run_until(lambda: fleet.agvs['a'].edge == 7)
    fleet.disk.fails()
    fleet.run(20.0)
    assert fleet.agvs['a'].visited[-1] == 8 and fleet.told(1)[-1] is MissionState.ACTIVE
    fleet.disk.fails(False)
    fleet.run(3.0)
    assert fleet.told(1)[-1] is MissionState.SUCCEEDED


def test_neither_a_command_nor_who_comes_late_is_told_what_is_on_no_disk():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)}, settings=AHEAD)
    fleet.request(1, 3, 8)
    fleet.run(2.0)
    fleet.disk.fails()
    fleet.run_until(lambda: fleet.reached(1) == 1)
    fleet.do(fleet.supervisor.command(1, CommandKind.PAUSE, fleet.now))
    assert fleet.statuses[-1].reason.startswith('PAUSE is carried out, but will be lost')
    status, = fleet.supervisor.book.stored_open
    for told in (fleet.statuses[-1], status):
        assert (told.state, told.reached) == (MissionState.ACTIVE, 0)


def test_who_comes_late_is_told_of_an_end_only_once_it_is_stored():
    fleet = driving()
    fleet.disk.fails()
    fleet.do(fleet.supervisor.command(1, CommandKind.CANCEL, fleet.now))
    assert [status.state for status in fleet.supervisor.book.stored_open] == [MissionState.ACTIVE]
    fleet.disk.fails(False)
    fleet.run(3.0)
    assert fleet.supervisor.book.stored_open == []


def test_a_death_while_nothing_could_be_stored_loses_and_repeats_nothing():
    fleet = driving()
    fleet.disk.fails()
    fleet.run(7.0)
    fleet.restart()
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.SUCCEEDED
    assert travelled(fleet) == pytest.approx(14.0)


def test_no_number_of_a_stop_that_was_on_no_disk_is_given_again_after_a_death():
    fleet = driving()
    fleet.disk.fails()
    fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    fleet.run(2.0)
    stopped = {order.order.number for order in fleet.sent}
    fleet.restart()
    fleet.sent.clear()
    fleet.run(10.0)
    assert not fleet.bring_in('a')
    fleet.request(2, 4)
    fleet.run_until_done(2)
    assert fleet.sent and min(order.order.number for order in fleet.sent) > max(stopped)


def test_a_robot_that_was_moved_meanwhile_is_not_ordered_on_as_from_where_it_was():
    fleet = driving()
    fleet.agvs['a'].emergency = True
    fleet.disk.fails()
    fleet.run(5.0)
    fleet.agvs['a'].edge, fleet.agvs['a'].arc = 7, 1.0
    fleet.sent.clear()
    fleet.run(1.0)
    fleet.disk.fails(False)
    fleet.run(5.0)
    assert fleet.supervisor.robots['a'].why == (
        'it was moved without a route: it was expected on edge 1 at 85 %, but is on edge 7 at 50 %')
    assert fleet.sent == []


def test_a_robot_whose_order_waits_for_the_disk_is_not_deaf_and_waits_for_the_disk():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)}, settings=AHEAD)
    fleet.run(1.0)
    fleet.request(1, 8)
    fleet.run_until(lambda: fleet.supervisor.plan_executor.is_planning)
    fleet.disk.fails()
    fleet.run(10.0)
    robot = fleet.supervisor.robots['a']
    assert robot.master.order is None, 'a grant that cannot be stored is taken back'
    view, = robot_views(fleet.supervisor, fleet.now)
    assert robot.outage is None and view.waits_for.text.startswith('the disk: the journal')
    fleet.disk.fails(False)
    fleet.run(1.0)
    assert robot.outage is None
    fleet.run_until_done(1)


def test_a_robot_that_does_not_answer_is_deaf_5_s_after_its_order_was_sent():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)}, settings=AHEAD)
    fleet.run(1.0)
    fleet.network.deaf['a'] = 1e9
    fleet.request(1, 8)
    fleet.run_until(lambda: fleet.supervisor.plan_executor.is_planning)
    fleet.disk.fails()
    fleet.run(10.0)
    fleet.disk.fails(False)
    fleet.run_until(lambda: any(order.edges for order in fleet.sent))
    sent = fleet.now
    fleet.run_until(lambda: fleet.supervisor.robots['a'].outage is Outage.DEAF)
    assert 4.5 < fleet.now - sent < 5.5


@pytest.mark.parametrize('fault, reason', [('full', 'database or disk is full'),
                                           ('gone', 'No such file or directory')])
def test_a_disk_that_fails_and_comes_back(on_small_disk, monkeypatch, fault, reason):
    """A real disk, with the real messages of SQLite and Linux."""
    def act(disk):
        monkeypatch.setattr(tempfile, 'tempdir', str(disk.folder))
        fleet = driving(to=6, b=8)
        with getattr(disk, fault)():
            fleet.run(1.0)
            fleet.sent.clear()
            fleet.request(2, 7, robot='b')
            refusal = fleet.statuses[-1]
            assert refusal.state is MissionState.REFUSED
            assert 'cannot be written' in refusal.reason and reason in refusal.reason
            assert reason in fleet.supervisor.trouble, '/diagnostics must name the fault'
            fleet.run(10.0)
            assert not any(order.edges for order in fleet.sent), 'nothing new may be granted'
            fleet.do(fleet.supervisor.stop_fleet(fleet.now))
            assert ('a', ()) in {(order.robot, order.edges) for order in fleet.sent}
            fleet.run(2.0)
            assert not fleet.agvs['a'].is_driving
        fleet.run(3.0)
        problem, actions = fleet.supervisor.resume_fleet(fleet.now)
        fleet.do(actions)
        assert not problem and not fleet.supervisor.trouble
        fleet.request(3, 7, robot='b')
        fleet.run_until_done(1, 3)
        assert fleet.state(1) is fleet.state(3) is MissionState.SUCCEEDED
        fleet.end()
    on_small_disk(act)
