"""What goes wrong ends a route with a reason, stops the robot, and completes nothing undriven."""
from __future__ import annotations

import pytest
from bridge_builders import Bench, GraphRobot, dissertation_graph, yard

from omron_ld90.bridge import route_protocol as p
from omron_ld90.bridge.route_protocol import EdgeState


def under_way(strategy: str = 'vertex_by_vertex', **settings) -> Bench:
    """A bench whose robot is half way along the second of three edges."""
    bench = Bench(dissertation_graph(), 1, strategy, **settings)
    bench.order(7, 1, 4, 5)
    bench.run(lambda bench: bench.last is not None and bench.last.pose.percentage > 50.0
              and bench.states()[0] == EdgeState.COMPLETE and bench.follower.robot.errand.confirmed)
    return bench


def assert_failed(bench: Bench, reason: str, stopped: bool = True) -> None:
    report = bench.follower.report()
    assert report.reason == reason
    assert report.states == (EdgeState.COMPLETE, EdgeState.FAILED, EdgeState.FAILED)
    assert (bench.commands[-1] == 'stop') is stopped
    assert bench.reports[-1].reason == reason  # told at once


@pytest.mark.parametrize('event, reason', [
    (p.EmergencyStop(True), 'emergency stop'),
    (p.RobotFailed('Failed going to goal'), 'Failed going to goal'),
    (p.CommandRejected('goto 7', "No goal '7'"), "No goal '7'"),
    (p.CommandRejected('goto', 'Unknown command goto'), 'Unknown command goto'),
    (p.CommandRefused('goto 7', 'the robot has no goal 7'), 'the robot has no goal 7'),
])
def test_the_robot_or_the_controller_cannot(event, reason):
    bench = under_way()
    bench.tell(event)
    assert_failed(bench, reason)


@pytest.mark.parametrize('event', [
    p.ForeignCommand('goto 3', '/goal_sender'),
    p.GoalStarted('3'),
    p.GoalStarted(''),
    p.Docking.DOCKING,
])
def test_a_motion_command_of_somebody_else_takes_over_and_is_not_stopped(event):
    bench = under_way()
    bench.tell(p.Docking.UNDOCKED)
    bench.tell(event)
    assert_failed(bench, 'taken over', stopped=False)


def test_a_strange_goal_in_the_status_text_counts_when_it_stays():
    bench = under_way()
    bench.tell(p.GoalShown('3'))
    assert bench.follower.running
    bench.tell(p.GoalShown('3'))
    assert_failed(bench, 'taken over', stopped=False)


def test_a_status_text_that_lags_behind_our_commands_is_no_stranger():
    bench = under_way()
    bench.tell(p.GoalShown('7'), p.GoalShown('3'), p.GoalShown('7'), p.GoalShown('3'))
    assert bench.follower.running


def test_an_interruption_without_a_cause_of_ours_is_a_take_over():
    bench = under_way()
    bench.tell(p.MotionInterrupted('Going to 7'))
    bench.wait(1.0)
    assert_failed(bench, 'taken over', stopped=False)


def test_an_interruption_by_the_emergency_stop_is_called_so():
    bench = under_way()
    bench.tell(p.MotionInterrupted('Going to 7'), p.EmergencyStop(True))
    bench.wait(1.0)
    assert_failed(bench, 'emergency stop')


def test_an_interruption_of_an_earlier_goal_is_our_own():
    bench = under_way()
    bench.tell(p.MotionInterrupted('Going to 2'))
    bench.wait(1.0)
    assert bench.follower.running


def test_a_lost_link_fails_the_route_after_a_while_and_the_stop_follows_when_it_is_back():
    bench = under_way()
    bench.tell(p.LinkChanged('commands', False, 'silent for 4 s'))
    bench.wait(1.0)
    assert bench.follower.running
    bench.wait(1.5)
    assert_failed(bench, 'lost link: commands: silent for 4 s')
    stops = bench.commands.count('stop')
    bench.tell(p.LinkChanged('commands', True))
    assert bench.commands.count('stop') == stops + 1  # the first one could not reach the robot
    bench.tell(p.LinkChanged('commands', True))
    assert bench.commands.count('stop') == stops + 1


def test_a_link_that_is_back_in_time_costs_nothing():
    bench = under_way()
    bench.tell(p.LinkChanged('outgoing', False, 'closed'))
    bench.wait(1.0)
    bench.tell(p.LinkChanged('outgoing', True))
    bench.run()
    assert bench.states() == [2, 2, 2]
    assert 'stop' not in bench.commands


def test_a_robot_that_no_longer_tells_where_it_is_fails_the_route():
    bench = under_way(location_timeout=5.0)
    bench.wait(5.5)
    assert_failed(bench, 'the robot has not told where it is for 5 s')


def test_no_progress_fails_the_route():
    bench = under_way(stall_timeout=10.0)
    for _ in range(21):
        bench.now += 0.5
        bench.tell(bench.robot.located(bench.now))
        bench.wait(0.05)
    assert_failed(bench, 'no progress for 10 s')


def test_off_the_corridor_fails_the_route_at_the_second_location():
    bench = under_way()
    x, _ = bench.robot.position
    bench.tell(p.Located(bench.follower.robot.seen.last.stamp + 1, x, 0.6))
    assert bench.follower.running
    bench.tell(p.Located(bench.follower.robot.seen.last.stamp + 1, x, 0.6))
    assert_failed(bench, 'off the corridor')


def test_an_arrival_elsewhere_is_not_believed():
    bench = under_way()
    bench.tell(p.GoalReached('7'))
    assert bench.states() == [2, 1, 1]
    bench.wait(2.5)
    assert_failed(bench, 'the robot says that it is at 7, but is '
                  f'{8.0 - bench.robot.position[0]:.1f} m away from it')


@pytest.mark.parametrize('event', [
    p.GoalReached('2'), p.GoalReached('6'), p.CommandRejected('goto 3', "No goal '3'"),
    p.MotionInterrupted('Going to 2'), p.GoalStarted('7'), p.EmergencyStop(False),
])
def test_words_that_are_late_or_for_others_are_harmless(event):
    bench = under_way()
    bench.tell(event)
    bench.run()
    assert bench.states() == [2, 2, 2]


def test_on_the_way_to_the_dock_the_robot_may_name_it_as_it_likes():
    bench = Bench(yard(), 1)
    bench.order(7, 9)
    bench.tell(p.GoalStarted('Charger 1'), p.GoalShown('dock at Charger 1'), p.GoalShown('Dock'),
               p.GoalStarted(''))
    assert bench.follower.running
    bench.tell(p.GoalStarted('3'))
    assert bench.follower.report().reason == 'taken over'


def test_locations_out_of_order_are_left_out():
    bench = under_way()
    before = bench.follower.report()
    bench.tell(p.Located(before.stamp - 1, 0.0, 9.0), p.Located(before.stamp, 0.0, 9.0),
               p.Located(before.stamp - 1, 0.0, 9.0))
    assert bench.follower.report() == before


def test_a_corner_cut_so_far_that_a_vertex_is_missed_is_made_good():
    bench = Bench(yard(), 1, 'direct')
    bench.order(7, 1, 5)
    assert bench.commands == ['goto 5']
    for x, y in ((2.0, 0.0), (3.5, 0.4), (5.0, 0.4)):  # by vertex 2 at 0.4 m
        bench.now += 1.0
        bench.robot.position = (x, y)
        bench.tell(bench.robot.located(bench.now))
    assert bench.commands[-1] == 'goto 2'
    assert bench.states() == [1, 1]
    bench.run()
    assert bench.states() == [2, 2]
    assert bench.commands == ['goto 5', 'goto 2', 'goto 5']


def test_a_robot_sent_back_to_a_vertex_still_goes_there_when_the_route_gets_longer():
    bench = Bench(yard(), 1, 'direct')
    bench.order(7, 1, 5)
    bench.run(lambda bench: bench.robot.position[0] > 2.0)
    for x, y in ((3.5, 0.4), (5.0, 0.4)):
        bench.now += 1.0
        bench.robot.position = (x, y)
        bench.tell(bench.robot.located(bench.now))
    assert bench.commands[-1] == 'goto 2'
    bench.order(7, 1, 5, 6)
    bench.run()
    assert bench.states() == [2, 2, 2]
    assert bench.commands == ['goto 5', 'goto 2', 'goto 6']


def test_a_failed_route_says_nothing_more_to_the_robot():
    bench = under_way()
    bench.tell(p.RobotFailed('Cannot find path'))
    commands = len(bench.commands)
    for _ in range(10):
        bench.now += GraphRobot.STEP
        bench.tell(*bench.robot.step(bench.now))
    bench.wait(60.0)
    assert len(bench.commands) == commands
    assert bench.follower.report().reason == 'Cannot find path'
