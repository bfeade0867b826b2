"""Orders: accepted, changed, refused or ignored."""
from __future__ import annotations

from dataclasses import replace

import pytest
from bridge_builders import Bench, dissertation_graph, graph_of, yard

from omron_ld90.bridge.events import LinkReported, MotionTold, RobotLink, RobotSeen
from omron_ld90.bridge.route_follower import RouteFollower
from omron_ld90.bridge.route_strategies import RouteSettings
from route_protocol.values import (
    EdgeState,
    Reason,
    ReasonCode,
    RouteOrder,
    RouteRefusal,
    RouteReport,
)
from trajectory_graph import Graph


def under_way(edges=(1, 4, 5), strategy='vertex_by_vertex') -> Bench:
    """Returns a bench whose robot is half way along the second edge of the dissertation's route."""
    bench = Bench(dissertation_graph(), 1, strategy)
    bench.order(7, *edges, stamp=50.0)
    bench.run(lambda bench: bench.last is not None and bench.last.pose.percentage > 50.0
              and bench.states()[0] == EdgeState.COMPLETE)
    return bench


def refusals(bench: Bench, route_id: int) -> list:
    return [refusal for refusal in bench.refusals if refusal.route_id == route_id]


def test_a_duplicate_is_ignored():
    bench = under_way()
    commands, reports = len(bench.commands), len(bench.reports)
    bench.order(7, 1, 4, 5, stamp=50.0)
    bench.order(7, 1, 4, 5, stamp=51.0)
    assert (len(bench.commands), len(bench.reports)) == (commands, reports)


def test_a_duplicate_after_the_end_is_ignored():
    bench = under_way()
    bench.run()
    commands = len(bench.commands)
    bench.order(7, 1, 4, 5, stamp=50.0)
    bench.order(7, 1, 4, 5, stamp=51.0)
    assert len(bench.commands) == commands
    assert bench.states() == [2, 2, 2]
    assert [note for note in bench.notes if 'needs another id' in note] == bench.notes[-1:]


def test_a_late_route_is_left_out():
    bench = under_way()
    bench.order(6, 2, stamp=49.0)
    assert bench.follower.report().route_id == 7
    assert refusals(bench, 6) == []
    assert 'came late' in bench.notes[-1]


def test_a_longer_list_extends_the_route_and_keeps_what_is_done():
    bench = under_way(edges=(1, 4))
    bench.order(7, 1, 4, 5)
    assert bench.states() == [2, 1, 1]
    bench.run()
    assert bench.states() == [2, 2, 2]
    assert bench.commands == ['goto 2', 'goto 7', 'goto 6']


def test_a_complete_route_can_be_extended():
    bench = under_way(edges=(1, 4))
    bench.run()
    bench.order(7, 1, 4, 5)
    assert bench.states() == [2, 2, 1]
    bench.run()
    assert bench.states() == [2, 2, 2]


def test_a_complete_route_cannot_be_extended_from_elsewhere():
    bench = under_way(edges=(1, 4))
    bench.run()
    bench.robot.position = (1.0, 0.0)  # a person has driven it back
    bench.now += 1.0
    bench.look()
    commands = len(bench.commands)
    bench.order(7, 1, 4, 5)
    assert refusals(bench, 7)[-1].reason.text == (
        'route 7 ended at vertex 7, but the robot is no longer there')
    assert len(bench.commands) == commands


def test_a_shorter_list_ends_the_route_earlier():
    bench = Bench(dissertation_graph(), 1, 'direct')
    bench.order(7, 1, 4, 5)
    assert bench.commands == ['goto 6']
    bench.drive(1.0)
    bench.order(7, 1, 4)
    assert bench.commands[-1] == 'goto 7'
    bench.run()
    assert bench.states() == [2, 2]
    assert bench.robot.position == pytest.approx((8.0, 0.0))


def test_a_list_that_is_shorter_than_the_robot_needs_to_brake_is_refused_and_the_route_goes_on():
    bench = under_way(strategy='direct')
    bench.order(7, 1, 4)
    assert [refusal.reason for refusal in bench.refusals] == [Reason(
        ReasonCode.CANNOT_BRAKE, 'the robot cannot stop before edge 5, which it takes away')]
    bench.run()
    assert bench.commands == ['goto 6']
    assert bench.states() == [2, 2, 2]


def test_a_robot_that_was_not_sent_beyond_the_shorter_list_needs_no_room_to_brake():
    bench = under_way()
    bench.order(7, 1, 4)
    bench.run()
    assert (bench.refusals, bench.states()) == ([], [2, 2])


def test_a_list_that_drops_the_current_edge_is_refused_and_the_route_goes_on():
    bench = under_way()
    bench.order(7, 1, 2)
    assert 'must go on with' in refusals(bench, 7)[0].reason.text
    assert not any(EdgeState.FAILED in report.states for report in bench.reports)
    assert bench.follower.report().states == (2, 1, 1)
    bench.run()
    assert bench.states() == [2, 2, 2]


def test_another_id_may_begin_on_the_edge_being_driven():
    bench = under_way()
    before = bench.follower.report().pose
    bench.order(8, 4, 5)
    assert bench.follower.report().route_id == 8
    assert bench.follower.report().pose == before
    # the robot is already on its way there, so nothing is sent again
    assert bench.commands.count('goto 7') == 1
    bench.run()
    assert bench.states() == [2, 2]


def test_another_id_may_turn_round_on_the_edge_being_driven():
    bench = under_way()
    bench.order(8, -4, -1)
    assert bench.commands[-1] == 'goto 2'
    bench.run()
    assert bench.states() == [2, 2]
    assert bench.robot.position == pytest.approx((0.0, 0.0))


def test_an_order_that_crossed_with_the_end_of_its_first_edge_is_taken_up():
    bench = Bench(dissertation_graph(), 1)
    bench.order(7, 1, 4)
    bench.run(lambda bench: bench.states() == [2, 1])
    bench.order(8, 1, 4, 5)
    bench.run()
    assert bench.follower.report().route_id == 8
    assert bench.states() == [2, 2, 2]


def test_an_edge_that_was_driven_before_is_not_complete_again():
    bench = Bench(dissertation_graph(), 1)
    bench.order(7, 1)
    bench.run()
    bench.order(8, 1)
    assert 'ends there, at vertex 2' in refusals(bench, 8)[0].reason.text


def test_an_empty_list_stops_the_robot():
    bench = under_way()
    bench.order(8)
    assert bench.commands[-1] == 'stop'
    report = bench.follower.report()
    assert (report.route_id, report.edges, report.reason.text) == (8, (), '')
    assert not bench.follower.running
    bench.order(9, 4, 5)  # the robot drives on from its place
    bench.run()
    assert bench.states() == [2, 2]


def test_a_stop_is_obeyed_even_when_it_comes_late():
    bench = under_way()
    bench.order(6, stamp=1.0)
    assert bench.commands[-1] == 'stop'


@pytest.mark.parametrize('edges, reason', [
    ((99,), 'The graph has no edge 99'),
    ((1, 0), 'The graph has no edge 0'),
    ((1, 5), 'Edge 1 ends at vertex 2, but the next edge 5 starts at vertex 7'),
    ((5,), 'edge 5 does not start where the robot is'),
    ((-4, -1), 'edge -4 does not start where the robot is'),
    ((1,) * 1001, 'more than 1000 edges'),
])
def test_a_route_that_cannot_be_driven_is_refused(edges, reason):
    bench = Bench(dissertation_graph(), 1)
    bench.order(7, *edges)
    refusal, = bench.refusals
    report, = bench.reports
    assert (report.route_id, report.edges) == (refusal.route_id, refusal.edges) == (7, edges)
    assert set(report.states) == {EdgeState.FAILED}
    assert reason in report.reason.text == refusal.reason.text
    assert bench.commands == []


def test_a_route_against_a_one_way_edge_is_refused():
    two_way = graph_of({1: (0, 0), 2: (4, 0)}, {1: (1, 2)})
    bench = Bench(Graph(two_way.vertices.values(),
                        [replace(two_way.edges[1], velocity_backwards=0.0)]), 1)
    bench.order(7, 1)
    bench.run()
    bench.order(8, -1)
    refusal, = bench.refusals
    assert refusal.reason == Reason(
        ReasonCode.WRONG_ROUTE,
        'The graph forbids driving over edge -1: its speed in this direction is 0')
    assert bench.states() == [EdgeState.COMPLETE]


def test_a_duplicate_of_a_refused_route_is_refused_again_wherever_the_robot_is_by_now():
    bench = Bench(dissertation_graph(), 1)
    bench.order(7, 4, stamp=50.0)
    bench.robot.position = (4.0, 0.0)
    bench.now += 1.0
    bench.look()
    bench.order(7, 4, stamp=50.0)
    assert len(refusals(bench, 7)) == 2
    bench.order(7, 4, stamp=60.0)  # the repeated order is checked again
    assert bench.follower.running


def test_a_refusal_leaves_the_running_route_alone():
    bench = under_way()
    commands = len(bench.commands)
    bench.order(8, 99)
    assert len(refusals(bench, 8)) == 1
    assert len(bench.commands) == commands
    bench.run()
    assert bench.follower.report().route_id == 7
    assert bench.states() == [2, 2, 2]


def test_a_failed_route_needs_another_id():
    bench = under_way()
    bench.tell(*bench.robot.press_emergency_stop())
    bench.press(False)
    bench.order(7, 1, 4)
    bench.drive(2.0)  # orders wait until the robot stands
    assert 'has failed' in refusals(bench, 7)[-1].reason.text
    bench.order(8, 4, 5)
    bench.run()
    assert bench.states() == [2, 2]


def test_a_robot_in_emergency_stop_takes_no_route():
    bench = Bench(dissertation_graph(), 1)
    bench.press(True)
    bench.order(7, 1)
    assert refusals(bench, 7)[0].reason.text == 'emergency stop'
    assert bench.commands == []


def test_who_tries_again_and_again_in_an_emergency_stop_does_not_fill_the_log():
    bench = Bench(dissertation_graph(), 1)
    bench.press(True)
    for id in (7, 8, 9):
        bench.order(id, 1)
        assert refusals(bench, id)
    bench.press(False)
    bench.order(10, 1)
    assert bench.notes == ['Route 7 was refused: emergency stop.',
                           'Route 10 is driven: the emergency stop is over.']


def test_an_order_waits_for_a_link_that_is_down_but_not_for_long():
    bench = Bench(dissertation_graph(), 1, links=[RobotLink.COMMANDS])
    bench.link_is_up[RobotLink.COMMANDS] = False
    bench.hear_links()
    bench.order(7, 1)
    assert bench.refusals == []
    bench.drive(5.2)
    assert refusals(bench, 7)[0].reason.text == 'lost link: commands: connection refused'
    assert bench.commands == []
    bench.order(8, 1)
    bench.link_is_up[RobotLink.COMMANDS] = True
    bench.drive(1.0)
    assert bench.commands == ['goto 2']


def test_an_order_from_the_future_is_refused_and_locks_nobody_out():
    follower = RouteFollower(RouteSettings(), dissertation_graph())
    follower.handle(RobotSeen(1, place=(0.0, 0.0)), 0.0)
    second = 1_000_000_000
    actions = follower.handle(RouteOrder(7, (1,), stamp=8 * second, received=second), 0.0)
    refusal, = [action for action in actions if isinstance(action, RouteRefusal)]
    assert 'is 7.0 s ahead of the clock' in refusal.reason.text
    follower.handle(RouteOrder(8, (1,), stamp=2 * second, received=second), 0.0)
    assert follower.running


def test_an_order_that_waits_does_not_pass_the_fleet_managers_own_stop():
    bench = Bench(yard(), 1, links=list(RobotLink))
    bench.link_is_up[RobotLink.OUTGOING] = False
    bench.hear_links()
    bench.order(8, 1)
    bench.order(9)
    bench.link_is_up[RobotLink.OUTGOING] = True
    bench.drive(6.0)
    assert bench.commands == ['stop']


@pytest.mark.parametrize('running', [False, True])
def test_an_order_that_waits_does_not_pass_somebodys_stop(running):
    bench = Bench(yard(), 1, links=list(RobotLink))
    if running:
        bench.order(7, 1, 5)
        bench.drive(1.0)
    bench.link_is_up[RobotLink.OUTGOING] = False
    bench.drive(1.0)
    given = list(bench.commands)
    bench.order(8, 1)
    assert not bench.refusals
    bench.overrule(command='stop')
    assert [refusal.reason.text for refusal in bench.refusals] == ['taken over']
    bench.link_is_up[RobotLink.OUTGOING] = True
    bench.drive(6.0)
    assert bench.commands == [*given, 'stop']


@pytest.mark.parametrize('sent, refused', [(99.8, True), (100.1, False), (0.0, False)])
def test_an_order_that_was_on_its_way_when_somebody_took_over_is_refused(sent, refused):
    bench = Bench(yard(), 1)
    bench.overrule()
    bench.now += 0.3
    second = 1_000_000_000
    bench.tell(RouteOrder(8, (1,), int(sent * second), int(bench.now * second)))
    assert [refusal.reason.text for refusal in bench.refusals] == ['taken over'] * refused
    assert bench.commands == ['goto 2'] * (not refused)


def test_a_sender_whose_clock_is_slow_is_heard_again_soon_after_a_take_over():
    bench = Bench(yard(), 1)
    bench.order(7, 1, 5)
    bench.overrule('"goto 3" of /rviz', 'goto 3')
    bench.drive(1.0)
    assert bench.follower.report().reason.text == 'taken over'
    second, hour = 1_000_000_000, 3600.0
    for route_id in (8, 9):
        bench.tell(RouteOrder(route_id, (1,), int((bench.now + 3.0 - hour) * second),
                              int(bench.now * second)))
        bench.now += 3.0
    assert refusals(bench, 8) and not refusals(bench, 9)


def test_an_order_waits_for_the_first_location():
    follower = RouteFollower(RouteSettings(), dissertation_graph())
    assert follower.handle(RouteOrder(7, (1,)), 0.0) == []
    actions = follower.handle(RobotSeen(1, place=(0.0, 0.0)), 0.5)
    assert [action.command for action in actions if hasattr(action, 'command')] == ['goto 2']


def test_an_order_waits_no_longer_than_the_location_may_take():
    follower = RouteFollower(RouteSettings(location_timeout=5.0), dissertation_graph())
    follower.handle(RouteOrder(7, (1,)), 0.0)
    assert follower.tick(3.9) == []
    refusal, report, _ = follower.tick(4.1)
    assert isinstance(report, RouteReport)
    assert refusal.reason.text == report.reason.text == 'the robot has not reported its location'


def test_an_old_location_starts_no_route():
    bench = Bench(dissertation_graph(), 1)
    bench.wait(60.0)
    bench.order(7, 1)
    assert bench.commands == []
    bench.robot.position = (0.0, 30.0)  # somebody has driven it off the graph
    bench.look()
    assert bench.commands == []
    assert 'does not start where the robot is' in refusals(bench, 7)[0].reason.text


def test_without_a_graph_every_route_is_refused():
    follower = RouteFollower(RouteSettings())
    follower.handle(RobotSeen(1, place=(0.0, 0.0)), 0.0)
    follower.handle(RouteOrder(7, (1,)), 0.0)
    assert follower.tick(6.0)[0].reason.text == 'there is no graph'


def test_an_order_waits_until_every_link_is_heard_of():
    follower = RouteFollower(RouteSettings(), dissertation_graph(), links=(RobotLink.COMMANDS,))
    follower.handle(RobotSeen(1, place=(0.0, 0.0)), 0.0)
    assert follower.handle(RouteOrder(7, (1,)), 0.0) == []
    follower.handle(LinkReported(RobotLink.COMMANDS, True), 0.1)
    follower.handle(MotionTold(1), 0.1)
    assert follower.running


def test_a_graph_that_comes_later_takes_up_the_order_that_waits():
    follower = RouteFollower(RouteSettings())
    follower.handle(RobotSeen(1, place=(0.0, 0.0)), 0.0)
    follower.handle(RouteOrder(7, (1,)), 0.0)
    follower.use_graph(dissertation_graph(), 0.1)
    assert follower.running


def test_a_docked_robot_starts_from_the_dock_only():
    bench = Bench(yard(), 90)
    bench.order(7, 1)
    assert refusals(bench, 7)[0].reason.text == (
        'edge 1 starts at vertex 1, but the robot is docked at vertex 90')


def test_a_new_graph_with_the_same_edges_lets_the_route_go_on():
    bench = under_way()
    bench.follower.use_graph(dissertation_graph(), bench.now)
    assert bench.follower.running
    bench.run()
    assert bench.states() == [2, 2, 2]


def test_a_complete_route_gets_longer_over_edges_that_only_the_new_graph_has():
    bench = Bench(graph_of({1: (0, 0), 2: (4, 0)}, {1: (1, 2)}), 1)
    bench.order(7, 1)
    bench.run()
    bench.follower.use_graph(dissertation_graph(), bench.now)
    bench.robot.graph = dissertation_graph()
    bench.order(7, 1, 4)
    bench.run()
    assert bench.states() == [2, 2]


def test_a_complete_route_whose_edges_are_others_now_gets_no_longer():
    bench = Bench(graph_of({1: (0, 1), 2: (4, 0)}, {1: (1, 2)}), 1)
    bench.order(7, 1)
    bench.run()
    bench.follower.use_graph(dissertation_graph(), bench.now)
    bench.order(7, 1, 4)
    assert 'the graph was replaced' in refusals(bench, 7)[-1].reason.text


def moved_graph():
    return graph_of({1: (0, 0), 2: (4, 0), 7: (9, 0), 6: (12, 2)},
                    {1: (1, 2), 4: (2, 7), 5: (7, 6)})


def test_a_new_graph_with_other_edges_is_refused_while_the_robot_drives_on_them():
    bench = under_way()
    before = bench.follower.graph
    note, = bench.follower.use_graph(moved_graph(), bench.now)
    assert note.text == 'A /graph is refused until route 7 has ended: edge 4 runs elsewhere'
    assert bench.follower.graph is before
    bench.run()
    assert bench.states() == [2, 2, 2], 'the robot must drive where the fleet manager sent it'


def test_a_refused_graph_is_in_force_once_the_route_has_ended():
    bench = under_way()
    moved = moved_graph()
    bench.follower.use_graph(moved, bench.now)
    bench.order(7)
    assert bench.follower.graph is moved


def test_the_old_graph_again_takes_a_refused_one_back():
    bench = under_way()
    before = bench.follower.graph
    bench.follower.use_graph(moved_graph(), bench.now)
    bench.follower.use_graph(dissertation_graph(), bench.now)
    bench.order(7)
    assert bench.follower.graph is before


def test_a_complete_route_gets_longer_after_another_program_used_the_robot_meanwhile():
    """The VDA 5050 adapter does this for an action at a vertex at which the robot stands."""
    bench = Bench(dissertation_graph(), 1)
    bench.order(7, 1)
    bench.run()
    bench.overrule('"doTask wait 30" of /vda5050_vehicle')
    bench.order(7, 1, 4)
    bench.run()
    assert bench.states() == [2, 2]
