"""Promises of the interlocking about a whole fleet, in cases in which they were once broken."""
from __future__ import annotations

import math
import sqlite3
from dataclasses import replace

from fleet_builders import AGV, corridor, ladder

from fleet_core.fleet import Fleet
from fleet_core.interlocking.allocation import Knowledge
from fleet_core.interlocking.reports import Report, point_of
from fleet_core.interlocking.stop_gate import StopGate
from fleet_core.supervision.fleet_view import robot_views
from fleet_core.supervision.missions import CommandKind, MissionState
from fleet_core.supervision.outages import Outage
from fleet_core.supervision.settings import RobotSettings
from fleet_simulation.report_times import Rhythm
from trajectory_graph import Graph
from world.supervised_fleet import SupervisedFleet, blocked

FAR = RobotSettings(release_ahead=8.0)


def put(agv, edge, arc):
    """Lets a person move a robot."""
    agv.edge, agv.arc = edge, arc


def without(graph, *edges):
    """Returns a graph without these edges, and without vertices that no edge reaches any more."""
    kept = [edge for edge in graph.edges.values() if edge.id not in edges]
    used = {vertex for edge in kept for vertex in (edge.origin, edge.destination)}
    return Graph([v for v in graph.vertices.values() if v.id in used], kept)


def restart(fleet, graph=None, robots=None):
    """Restarts the supervisor with another graph, or with other robots in the fleet file."""
    if robots is not None:
        fleet.fleet = Fleet(fleet.fleet.types, tuple(
            robot for robot in fleet.fleet.robots if robot.name in robots), fleet.fleet.clearance)
        fleet.agvs = {name: agv for name, agv in fleet.agvs.items() if name in robots}
    fleet.restart(graph)


def test_a_place_where_a_robot_was_driven_while_the_planner_thought_is_given_to_no_other():
    """Robot `a` is idle when the planner is asked, but is on the path of `b` when the plan comes.
    """
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 8), 'b': (AGV, 1)}, planning=1.0)
    fleet.run(2.0)
    fleet.request(1, 5, robot='b')
    fleet.run(0.5)
    put(fleet.agvs['a'], 3, 1.0)
    fleet.run(20.0)
    assert fleet.agvs['b'].position[0] < 5.0 - 2.0 * AGV.radius - fleet.clearance + 1e-6
    assert 3 in blocked(fleet, 'a')[1]


def test_nothing_is_granted_before_every_robot_was_heard_or_declared_absent():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1), 'b': (AGV, 8)})
    fleet.network.silent['b'] = 1e9
    fleet.request(1, 4, robot='a')
    fleet.run(20.0)
    assert not any(order.edges for order in fleet.sent)
    assert fleet.supervisor.unknown == ['b']
    assert 'fleet absent b' in fleet.supervisor.plan_executor.waits_for['a']
    problem, actions = fleet.supervisor.declare_absent('b', fleet.now)
    fleet.do(actions)
    assert not problem
    fleet.run_until_done(1)
    assert fleet.supervisor.robots['b'].outage is Outage.ABSENT


def test_a_robot_that_is_absent_blocks_nothing_until_it_reports_a_later_location():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1), 'b': (AGV, 4)})
    fleet.run(1.0)
    fleet.network.silent['b'] = 1e9
    fleet.run(8.0)
    fleet.do(fleet.supervisor.declare_absent('b', fleet.now)[1])
    robot = fleet.supervisor.robots['b']
    late = fleet.agvs['b'].report(fleet.now - 7.0)
    fleet.do(fleet.supervisor.report('b', Report(late, 7.0), fleet.now))
    assert robot.knowledge is Knowledge.ABSENT, 'this location is older than the declaration'
    fleet.restart()
    assert fleet.supervisor.robots['b'].knowledge is Knowledge.ABSENT
    fleet.network.silent.clear()
    fleet.run(1.0)
    assert fleet.supervisor.robots['b'].works and blocked(fleet, 'b') == ((4,), ())


def test_a_robot_that_reports_is_not_declared_absent():
    fleet = SupervisedFleet(corridor(4), {'a': (AGV, 1)})
    fleet.run(1.0)
    problem, _ = fleet.supervisor.declare_absent('a', fleet.now)
    assert 'switch it off first' in problem and fleet.supervisor.robots['a'].works


def test_what_a_silent_robot_holds_stays_blocked_where_a_new_graph_has_no_such_edge():
    """The robot may stand on the curve of the old edge."""
    graph = ladder(5)
    fleet = SupervisedFleet(graph, {'a': (AGV, 1), 'b': (AGV, 105)}, settings=FAR)
    fleet.request(1, 5, robot='a')
    fleet.run(2.0)
    fleet.network.silent['a'] = 1e9
    held = set(blocked(fleet, 'a')[1])
    assert {1, 2, 3, 4} & held
    restart(fleet, without(graph, 2))
    lost = fleet.supervisor.robots['a'].master.memory.lost.areas
    assert any(area.line[0] == (2.0, 0.0) and area.line[-1] == (4.0, 0.0) for area in lost)
    fleet.restart()
    assert fleet.supervisor.robots['a'].master.memory.lost.areas == lost, (
        'the restart must not forget it')


def test_a_robot_that_left_the_fleet_file_keeps_its_place_until_it_is_declared_absent():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1), 'b': (AGV, 4)})
    fleet.run(1.0)
    restart(fleet, robots=('a',))
    fleet.request(1, 6, robot='a')
    fleet.run(20.0)
    assert fleet.agvs['a'].position[0] <= 6.0 - 2.0 * AGV.radius - fleet.clearance
    assert list(fleet.supervisor.removed) == ['b']
    _, view = robot_views(fleet.supervisor, fleet.now)
    assert view.name == 'b' and 'fleet absent b' in view.waits_for.text
    assert point_of(fleet.graph, view.pose) == fleet.graph.vertices[4].position
    fleet.do(fleet.supervisor.declare_absent('b', fleet.now)[1])
    fleet.run_until_done(1)
    fleet.restart()
    assert not fleet.supervisor.removed, 'the journal must also have forgotten it'


def test_nothing_is_sent_to_a_robot_that_left_the_fleet_file_not_even_the_stop_it_has_not_heard():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1), 'b': (AGV, 4)})
    fleet.run(1.0)
    fleet.network.deaf['b'] = 1e9
    fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    fleet.run(1.0)
    fleet.sent.clear()
    restart(fleet, robots=('a',))
    fleet.run(3.0)
    assert all(order.robot == 'a' for order in fleet.sent)


def test_a_place_is_as_near_as_the_robots_play_says():
    """A robot with no play that stands 0.2 m off a vertex is between vertices."""
    for play, vertex in ((0.0, None), (0.25, 2)):
        kind = replace(AGV, play=play)
        fleet = SupervisedFleet(corridor(5), {'a': (kind, 1)})
        put(fleet.agvs['a'], 1, 1.8)
        fleet.run(0.5)
        assert fleet.supervisor.robots['a'].position.vertex == vertex


def test_what_was_not_yet_left_stays_blocked_after_a_restart():
    """The journal stores which part of an edge the robot has left, not only which edges are
    complete.
    """
    kind = replace(AGV, speed=1.0)
    fleet = SupervisedFleet(corridor(8), {'a': (kind, 1)},
                            settings=RobotSettings(release_ahead=8.0, slack=1.5))
    fleet.request(1, 8)
    fleet.run_until(lambda: fleet.supervisor.robots['a'].record.done == 2)
    before = blocked(fleet, 'a')[1]
    assert 2 in before, 'with this slack the robot may still be on its last edge'
    fleet.network.silent['a'] = 1e9
    fleet.restart()
    assert 2 in blocked(fleet, 'a')[1]


def test_a_paused_robot_is_passed_where_there_is_room_and_blocks_no_other_for_ever():
    """The paused robot is an obstacle where it will stop. Once it stands, the supervisor plans for
    it again.
    """
    for seed in range(8):
        fleet = SupervisedFleet(ladder(6), {'a': (AGV, 1), 'b': (AGV, 6)}, seed=seed)
        fleet.request(1, 6, robot='a')
        fleet.request(2, 1, robot='b')
        fleet.run(2.0 + 0.4 * seed)
        fleet.do(fleet.supervisor.command(1, CommandKind.PAUSE, fleet.now))
        fleet.run_until_done(2, limit=120.0)
        assert fleet.state(2) is MissionState.SUCCEEDED


def test_a_robot_that_is_brought_too_near_to_another_stops_with_it_and_the_others_go_on():
    fleet = SupervisedFleet(corridor(12), {'a': (AGV, 1), 'b': (AGV, 4), 'c': (AGV, 12)},
                            rhythm=Rhythm(room=math.inf))  # a person brings them together
    fleet.run(1.0)
    fleet.do(fleet.supervisor.take_out('a', fleet.now))
    fleet.run(3.0)
    put(fleet.agvs['a'], 3, 1.6)
    fleet.request(1, 9, robot='c')
    fleet.run_until_done(1)
    assert fleet.supervisor.robots['b'].outage is Outage.TOO_NEAR
    assert 'too near to a' in fleet.supervisor.robots['b'].why
    put(fleet.agvs['a'], 1, 0.0)
    fleet.run(4.0)
    assert not fleet.bring_in('a') and not fleet.bring_in('b')
    fleet.request(2, 5, robot='b')
    fleet.run_until_done(2)


def test_a_robot_that_a_person_drives_and_that_falls_silent_may_be_anywhere_near():
    fleet = SupervisedFleet(corridor(12), {'a': (AGV, 3)})
    fleet.run(1.0)
    fleet.do(fleet.supervisor.take_out('a', fleet.now))
    fleet.run(1.0)
    for arc in (0.3, 0.6, 0.9):
        put(fleet.agvs['a'], 3, arc)
        fleet.step()
    fleet.network.silent['a'] = 1e9
    fleet.run(4.0)
    areas = fleet.supervisor.robots['a'].master.allocation.areas
    assert max(area.radius for area in areas) >= 4.0
    fleet.run(60.0)
    areas = fleet.supervisor.robots['a'].master.allocation.areas
    assert max(area.radius for area in areas) == 10.0


def test_a_restart_stops_no_robot_because_another_robot_that_a_person_drives_has_not_reported_yet():
    fleet = SupervisedFleet(corridor(12), {'a': (AGV, 1), 'b': (AGV, 7)})
    fleet.run(2.0)
    put(fleet.agvs['b'], 6, 1.0)
    fleet.run(3.0)
    fleet.do(fleet.supervisor.bring_in('b', fleet.now)[1])
    fleet.do(fleet.supervisor.take_out('a', fleet.now))
    for step in range(20):
        put(fleet.agvs['a'], 1, 0.1 * step)
        fleet.run(0.1)
    fleet.network.silent['a'] = fleet.now + 2.0
    restart(fleet)
    fleet.run(1.0)
    robots = fleet.supervisor.robots
    assert fleet.supervisor.interlocking.excluding('b') == ('a',) and robots['b'].outage is None
    fleet.run(3.0)
    assert robots['a'].master.is_heard and robots['b'].outage is None


def test_a_robot_last_seen_standing_does_not_grow_while_it_is_silent():
    fleet = SupervisedFleet(corridor(6), {'a': (AGV, 3)})
    fleet.run(2.0)
    fleet.network.silent['a'] = 1e9
    fleet.run(60.0)
    assert blocked(fleet, 'a') == ((3,), ()) and not fleet.supervisor.robots[
        'a'].master.allocation.areas


def test_a_journal_that_was_lost_stops_all_robots_and_draws_ids_that_were_never_given():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)}, settings=FAR)
    fleet.request(1, 8)
    fleet.run(3.0)
    used = {order.order.number for order in fleet.sent}
    with sqlite3.connect(fleet.disk.journal_path) as journal:
        for table in ('robot', 'mission', 'value'):
            journal.execute(f'DELETE FROM {table}')
    journal.close()
    fleet.restart()
    fleet.sent.clear()
    fleet.run(10.0)
    assert any('the journal does not know' in note for note in fleet.notes)
    assert not fleet.agvs['a'].is_driving and fleet.supervisor.robots['a'].works
    fleet.request(2, 4)
    fleet.run_until_done(2)
    assert not used & {order.order.number for order in fleet.sent}


# -- the check before each route is sent ----------------------------------------------------------


def test_a_route_that_was_decided_before_a_stop_does_not_pass_after_it():
    """A person stops the fleet while the disk delays a COMMIT."""
    gate = StopGate()
    with gate.passage((1, 2)) as passes:
        assert passes
    gate.close()
    with gate.passage((1, 2)) as passes:
        assert not passes
    with gate.passage(()) as passes:
        assert passes, 'a stop must always pass'


def test_a_stop_that_comes_after_a_resume_wins():
    gate = StopGate()
    gate.close()
    ticket = gate.ticket
    gate.close()
    assert not gate.open(ticket) and gate.is_closed
    assert gate.open(gate.ticket) and not gate.is_closed


def test_a_fleet_that_was_stopped_again_meanwhile_does_not_go_on():
    fleet = SupervisedFleet(corridor(6), {'a': (AGV, 1)})
    fleet.run(1.0)
    fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    ticket = fleet.supervisor.gate.ticket
    fleet.supervisor.gate.close()
    problem, actions = fleet.supervisor.resume_fleet(fleet.now, ticket)
    fleet.do(actions)
    assert problem == 'the fleet was stopped again meanwhile' and fleet.supervisor.is_stopped


def test_a_robot_that_was_stopped_inside_an_edge_leaves_it_though_the_edge_is_closed_since():
    """The robot may leave the closed edge in either direction."""
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)})
    fleet.request(1, 8)
    fleet.run_until(lambda: fleet.agvs['a'].edge == 3 and fleet.agvs['a'].arc > 0.5)
    fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    fleet.run(5.0)
    inside = fleet.agvs['a'].edge
    fleet.close(inside)
    fleet.do(fleet.supervisor.resume_fleet(fleet.now)[1])
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.SUCCEEDED
