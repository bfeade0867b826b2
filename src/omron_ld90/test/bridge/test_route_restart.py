"""The bridge restarts: the route continues from the robot's place, and no goal is sent twice."""
from __future__ import annotations

from dataclasses import replace

import pytest
from bridge_builders import Bench, dissertation_graph, graph_of, yard
from test_route_faults import end_of_drive

from omron_arcl import ActivityKind, Outcome
from omron_ld90.bridge import events as p
from omron_ld90.bridge.route_follower import RouteFollower
from route_protocol.values import OVERRULED, EdgeState, RouteOrder, SymbolicPose


def under_way(strategy: str = 'vertex_by_vertex') -> Bench:
    """Returns a bench whose robot is half way along the second edge of the dissertation's route."""
    bench = Bench(dissertation_graph(), 1, strategy)
    bench.order(7, 1, 4, 5, stamp=50.0)
    bench.run(lambda bench: bench.last is not None and bench.last.pose.percentage > 50.0
              and bench.states()[0] == EdgeState.COMPLETE)
    return bench


@pytest.mark.parametrize('strategy', ['vertex_by_vertex', 'direct', 'rolling'])
@pytest.mark.parametrize('away', [0.0, 3.0, 15.0])
def test_the_route_goes_on_by_itself_and_no_goal_is_given_twice(strategy, away):
    bench = under_way(strategy)
    bench.restart(away)
    bench.run()
    assert bench.states() == [2, 2, 2], bench.follower.report().reason.text
    assert bench.follower.report().pose == SymbolicPose(5, 100.0)
    assert len(set(bench.commands)) == len(bench.commands)


@pytest.mark.parametrize('step', range(1, 140, 6))
def test_whenever_it_happens_no_goal_is_given_twice(step):
    bench = Bench(yard(), 1, 'rolling')
    bench.order(7, 1, 5, 6)
    for _ in range(step):
        bench.step()
    bench.restart(2.0)
    bench.run()
    assert bench.states() == [2, 2, 2], bench.follower.report().reason.text
    assert len(set(bench.commands)) == len(bench.commands)


def test_a_goal_that_was_decided_but_never_given_is_given():
    bench = Bench(dissertation_graph(), 1)
    bench.order(7, 1, 4)
    heard, bench.give = bench.give, lambda give: None
    bench.run(lambda bench: bench.robot.motion is ActivityKind.ARRIVED_AT_GOAL)
    end_of_drive(bench, Outcome.SUCCEEDED)
    bench.give = heard
    bench.restart()
    bench.run()
    assert bench.states() == [2, 2]
    assert bench.commands == ['goto 2', 'goto 7']


def test_a_bridge_that_dies_again_before_it_has_seen_the_robot_still_knows_its_goal():
    bench = Bench(dissertation_graph(), 1)
    bench.order(7, 1, 4)
    look, bench.look = bench.look, lambda: None
    bench.restart()
    assert bench.follower.record.target == 0
    bench.look = look
    bench.restart()
    bench.run()
    assert bench.commands == ['goto 2', 'goto 7']


@pytest.mark.parametrize('command', ['', 'goto 3'])
def test_one_that_dies_again_before_it_has_seen_the_robot_still_knows_that_another_drove_it(
        command):
    bench = under_way()
    known = bench.follower.report().epoch
    look, bench.look = bench.look, lambda: None
    bench.restart()
    bench.overrule(command=command)
    bench.restart()
    bench.look = look
    driven = len(bench.commands)
    bench.run()
    assert bench.follower.report().epoch != known
    assert 'goto' not in ' '.join(bench.commands[driven:]), 'the route is over'


def test_the_same_order_once_more_changes_nothing():
    bench = under_way()
    bench.restart()
    bench.order(7, 1, 4, 5, stamp=50.0)
    assert bench.states() == [2, 1, 1]
    bench.run()
    assert bench.states() == [2, 2, 2]
    assert bench.commands == ['goto 2', 'goto 7', 'goto 6']


def test_the_route_can_be_made_longer():
    bench = Bench(dissertation_graph(), 1)
    bench.order(7, 1, 4)
    bench.run(lambda bench: bench.states() == [2, 1])
    bench.restart()
    bench.order(7, 1, 4, 5)
    bench.run()
    assert bench.states() == [2, 2, 2]


def test_another_route_is_a_new_one():
    bench = under_way()
    bench.restart()
    bench.order(8, 4, 5)
    assert bench.states() == [1, 1]
    bench.run()
    assert bench.states() == [2, 2]


def test_a_robot_that_was_carried_away_fails_the_route():
    bench = under_way()
    bench.robot.position = (10.0, 1.0)  # on an edge to which it was not sent
    bench.restart()
    report = bench.follower.report()
    assert report.states == (2, 3, 3)
    assert 'not on the route any more' in report.reason.text


def test_a_robot_that_somebody_drove_off_meanwhile_is_left_to_them():
    bench = under_way()
    bench.robot.obey(None, 'goto 3')
    bench.restart(4.0)
    bench.run()
    assert bench.follower.report().reason.text == 'taken over'
    assert bench.commands[-1] == 'goto 3'


@pytest.mark.parametrize('word', ['stop', 'goto 3'])
def test_nor_does_the_route_pass_them_where_the_robot_had_passed_its_goal_but_not_arrived(word):
    bench = Bench(dissertation_graph(), 1)
    bench.order(7, 1, 4, 5)
    bench.run(lambda bench: bench.states()[0] == EdgeState.COMPLETE)
    assert bench.commands == ['goto 2']
    bench.robot.obey(None, word)
    bench.restart(0.1)
    bench.drive(3.0)
    assert bench.follower.report().reason.text == 'taken over'
    assert bench.commands == ['goto 2', word]


@pytest.mark.parametrize('end', ['complete', 'failed', 'taken over', 'stopped'])
def test_a_route_that_has_ended_is_not_driven_again(end):
    bench = under_way()
    if end == 'complete':
        bench.run()
    elif end == 'failed':
        end_of_drive(bench, Outcome.FAILED, 'Cannot find path')
    elif end == 'taken over':
        bench.overrule('"goto 3" of /rviz', 'goto 3')
    else:
        bench.order(9)
    before, commands = bench.follower.report(), list(bench.commands)
    bench.restart(3.0)
    bench.drive(8.0)
    after = bench.follower.report()
    assert (after.route_id, after.states, after.reason) == (before.route_id, before.states,
                                                            before.reason)
    if end != 'stopped':
        bench.order(7, 1, 4, 5, stamp=50.0)
        bench.order(7, 1, 4, 5, stamp=51.0)
    bench.drive(2.0)
    assert bench.commands == commands


def returned(bench: Bench, is_recent: bool = True) -> Bench:
    """Restarts the bridge before it has seen the robot. Returns the bench."""
    record = bench.follower.record
    bench.robot.number = None
    bench.follower = RouteFollower(bench.follower.settings, bench.follower.graph)
    bench.follower.restore(record, is_recent, bench.now)
    return bench


def test_a_stop_that_comes_before_the_robot_is_seen_ends_the_route_for_good():
    bench = returned(under_way())
    bench.order(9)
    bench.drive(5.0)
    assert bench.commands[-1] == 'stop'
    report = bench.follower.report()
    assert (report.route_id, report.edges, report.states, report.reason.text) == (9, (), (), '')


def test_a_complete_route_is_complete_however_long_the_bridge_was_away():
    bench = Bench(dissertation_graph(), 1)
    bench.order(7, 1)
    bench.run()
    returned(bench, is_recent=False).drive(3.0)
    assert bench.states() == [EdgeState.COMPLETE]
    assert bench.follower.report().reason.text == ''
    assert 'stop' not in bench.commands


def test_a_route_whose_edges_the_graph_has_no_more_fails_and_stops_the_robot():
    bench = under_way()
    record = bench.follower.record
    bench.follower = RouteFollower(bench.follower.settings, yard())
    bench.follower.restore(record, True, bench.now)
    bench.drive(1.0)
    assert not bench.follower.running
    assert bench.follower.report().reason.text == (
        'Edge 1 ends at vertex 2, but the next edge 4 starts at vertex 4')
    assert bench.commands[-1] == 'stop'


@pytest.mark.parametrize('motion, reason', [
    (ActivityKind.TELEOPERATED, 'taken over'),
    (ActivityKind.STOPPED,
     'the robot was not on the route any more after a restart of the bridge')])
def test_a_robot_off_the_route_is_left_to_who_drives_it_and_else_stopped(motion, reason):
    bench = under_way()
    bench.robot.position = (4.0, 4.0)
    bench.robot.halt(motion)
    bench.robot.foreign = motion is ActivityKind.TELEOPERATED
    bench = returned(bench)
    bench.hear_news()
    bench.drive(1.0)
    assert bench.follower.report().reason.text == reason
    assert ('stop' in bench.commands) is (motion is ActivityKind.STOPPED)


def test_a_robot_that_docked_meanwhile_is_not_sent_to_its_dock_again():
    bench = Bench(yard(), 1)
    bench.order(7, 9)
    bench.drive(2.0)
    bench.restart(15.0)
    assert bench.robot.docked
    bench.run()
    assert bench.states() == [EdgeState.COMPLETE], bench.follower.report().reason.text
    assert bench.commands == ['dock']


def test_a_robot_that_still_goes_to_the_vertex_that_it_passes_is_not_sent_on_before_it_is_there():
    bench = Bench(dissertation_graph(), 1)
    bench.order(7, 1, 4)
    bench.run(lambda bench: bench.follower.vehicle.state.completed == 1)
    assert bench.robot.motion is ActivityKind.GOING_TO_GOAL
    bench.restart()
    assert bench.commands == ['goto 2']
    bench.run()
    assert bench.states() == [2, 2]
    assert bench.commands == ['goto 2', 'goto 7']


def test_a_robot_goes_on_from_where_the_last_bridge_could_not_note_that_it_sent_it():
    bench = Bench(dissertation_graph(), 1)
    bench.order(7, 1, 4, 5)
    bench.run(lambda bench: bench.commands[-1] == 'goto 7')
    record = replace(bench.follower.record, target=0,
                     number=bench.follower.record.number - 1)
    bench.robot.number = None
    while bench.robot.motion is not ActivityKind.ARRIVED_AT_GOAL:
        bench.now += 0.1
        bench.robot.step(bench.now)
    bench.follower = RouteFollower(bench.follower.settings, bench.follower.graph)
    bench.follower.restore(record, True, bench.now)
    bench.run()
    assert bench.states() == [2, 2, 2], bench.follower.report().reason.text
    assert bench.commands == ['goto 2', 'goto 7', 'goto 7', 'goto 6'], 'never back to 2'


def test_about_the_dock_the_route_goes_on_off_its_corridors():
    bench = Bench(yard(), 1)
    bench.order(7, 9)
    bench.run(lambda bench: bench.robot.position[1] < -3.0)
    bench.robot.position = (1.0, -3.0)
    returned(bench).run()
    assert bench.states() == [EdgeState.COMPLETE], bench.follower.report().reason.text


def test_a_complete_route_keeps_its_pose_and_can_be_made_longer():
    bench = Bench(dissertation_graph(), 1)
    bench.order(7, 1, 4)
    bench.run()
    bench.restart(3.0)
    assert bench.follower.report().pose == SymbolicPose(4, 100.0)
    bench.order(7, 1, 4, 5)
    bench.run()
    assert bench.states() == [2, 2, 2]


def test_a_bridge_that_was_away_for_long_fails_the_route_and_stops_a_robot_on_our_way_only():
    for foreign, stops in ((False, 1), (True, 0)):
        bench = Bench(graph_of({1: (0, 0), 2: (90, 0), 3: (0, 90)}, {1: (1, 2), 2: (1, 3)}), 1)
        bench.order(7, 1)
        bench.drive(3.0)
        if foreign:
            bench.robot.obey(None, 'goto 3')
            bench.epoch += 1
        bench.restart(25.0)
        assert bench.follower.report().reason.text == 'the bridge was away for too long'
        bench.drive(3.0)
        assert bench.commands.count('stop') == stops


def test_routes_of_long_ago_are_not_driven_again_after_a_restart():
    """A latching publisher sends its route again, although another route has been driven since.

    The node knows the publisher from before, and the message has no stamp.
    """
    bench = under_way()
    bench.run()
    bench.order(8, -5)
    bench.run()
    bench.order(9)
    given = list(bench.commands)
    bench.restart(3.0)
    for route_id, edges in ((7, (1, 4, 5)), (8, (-5,))):
        bench.tell(RouteOrder(route_id, edges, comes_again=True))
        bench.drive(1.0)
    assert bench.commands == given
    assert 'published before its connection began' in bench.notes[-1]


def test_what_somebody_did_while_the_bridge_was_away_ends_the_route():
    bench = under_way()
    bench.epoch += 1
    bench.restart(1.0)
    assert bench.follower.report().reason.text == 'taken over'


@pytest.mark.parametrize('known, reasons', [
    ('none', []), ('old', [OVERRULED]), ('new', [])])
def test_an_order_of_another_epoch_is_refused(known, reasons):
    bench = Bench(dissertation_graph(), 1)
    epochs = {'none': 0, 'old': bench.follower.report().epoch}
    bench.overrule()
    bench.drive(10.0)
    epochs['new'] = bench.follower.report().epoch
    bench.tell(RouteOrder(7, (1, 4, 5), known_epoch=epochs[known]))
    assert [refusal.reason for refusal in bench.refusals] == reasons
    assert bench.commands == ['goto 2'] * (not reasons)


def test_a_route_of_ours_begins_no_epoch_though_the_controller_counts_one():
    bench = Bench(dissertation_graph(), 1)
    known = bench.follower.report().epoch
    bench.tell(RouteOrder(7, (1, 4), known_epoch=known))
    bench.tell(p.MotionTold(2, 1, is_ours=True))
    bench.tell(RouteOrder(7, (1, 4, 5), known_epoch=known))
    assert bench.follower.report().edges == (1, 4, 5)


def test_a_stop_that_is_owed_survives_the_restart():
    bench = under_way()
    bench.give = lambda give: None  # the controller is away
    bench.order(9)
    assert 'stop' not in bench.commands
    del bench.give
    bench.restart(2.0)
    bench.drive(3.0)
    assert bench.commands[-1] == 'stop'
    assert bench.robot.speed == 0.0


def test_a_robot_that_stays_silent_fails_the_route():
    bench = under_way()
    record = bench.follower.record
    bench.follower = RouteFollower(bench.follower.settings, bench.follower.graph)
    bench.follower.restore(record, True, bench.now)
    bench.wait(19.0)
    assert bench.follower.running
    bench.wait(2.0)
    assert bench.follower.report().reason.text == 'the robot has not reported its location'
