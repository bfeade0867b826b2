"""A fault ends a route with a reason, stops the robot, and completes no undriven edge."""
from __future__ import annotations

from dataclasses import replace

import pytest
from bridge_builders import Bench, dissertation_graph, yard

from omron_arcl import ActivityKind, Outcome
from omron_arcl.records import CommandFate
from omron_ld90.bridge import events as p
from omron_ld90.bridge.events import RobotLink
from omron_ld90.bridge.route_follower import RouteFollower
from route_protocol.values import EdgeState, EpochCause, ReasonCode

LINKS = (RobotLink.COMMANDS, RobotLink.OUTGOING)

def under_way(strategy: str = 'vertex_by_vertex', links=(), **settings) -> Bench:
    """Returns a bench whose robot is half way along the second of three edges."""
    bench = Bench(dissertation_graph(), 1, strategy, links=links, **settings)
    bench.order(7, 1, 4, 5)
    bench.run(lambda bench: bench.last is not None and bench.last.pose.percentage > 50.0
              and bench.states()[0] == EdgeState.COMPLETE)
    return bench

def assert_failed(bench: Bench, reason: str, stopped: bool = True) -> None:
    report = bench.follower.report()
    assert report.reason.text == reason
    assert report.states == (EdgeState.COMPLETE, EdgeState.FAILED, EdgeState.FAILED)
    assert (bench.commands[-1] == 'stop') is stopped
    assert bench.reports[-1].reason.text == reason  # reported at once

def end_of_drive(bench: Bench, ending: Outcome, text: str = '') -> None:
    """Lets the controller report the end of the present drive."""
    number, bench.robot.number = bench.robot.number, None
    bench.tell(p.CommandEnded(number, ending, text))

@pytest.mark.parametrize('text', [
    'Failed going to goal', "No goal '7'", 'the robot said nothing about it for 60 s',
    'Not sent, 200 commands are waiting already.'])
def test_a_drive_that_fails_fails_the_route_in_the_same_words(text):
    bench = under_way()
    end_of_drive(bench, Outcome.FAILED, text)
    assert_failed(bench, text)

def test_the_emergency_stop_fails_the_route():
    bench = under_way()
    bench.tell(*bench.robot.press_emergency_stop())
    assert_failed(bench, 'emergency stop')

def test_an_emergency_stop_fails_the_route_before_its_drive_ends():
    bench = under_way()
    bench.press(True)
    assert_failed(bench, 'emergency stop')

class TestWhatSomebodyElseDoes:
    """Another giver takes over at once. The controller, not the bridge, ensures that a stop is
    obeyed.
    """

    @pytest.mark.parametrize('command', ['stop', 'goto 3'])
    def test_ends_the_route_and_nothing_more_is_given(self, command):
        bench = under_way()
        epoch = bench.follower.report().epoch
        bench.overrule('"stop" of /rviz', command)
        assert bench.follower.report().reason.text == 'taken over'
        assert bench.follower.report().epoch != epoch
        assert '"stop" of /rviz' in bench.notes[-1]
        bench.drive(6.0)
        assert bench.commands[-1] == command
        assert bench.commands.count('stop') == (command == 'stop')

    def test_it_does_not_end_the_stop_that_is_owed_already(self):
        bench = under_way(links=LINKS)
        bench.give = Unreachable(bench)
        bench.link_is_up[RobotLink.COMMANDS] = False
        bench.order(9)
        bench.overrule()
        del bench.give
        bench.link_is_up[RobotLink.COMMANDS] = True
        bench.drive(3.0)
        assert bench.commands[-1] == 'stop'

    def test_a_drive_that_the_controller_refuses_because_of_it_ends_the_route(self):
        bench = under_way()
        end_of_drive(bench, Outcome.OVERRULED, 'Not sent, another command came first.')
        bench.wait(1.0)
        assert bench.follower.running, 'the next epoch tells whether the drive may be given again'
        bench.overrule()
        assert_failed(bench, 'taken over', stopped=False)

    def test_a_stop_that_the_controller_has_taken_is_told_until_the_robot_has_obeyed(self):
        bench = under_way()
        bench.give = lambda give: bench.tell(p.CommandEnded(
            give.number, Outcome.FAILED, 'the robot said nothing about it for 5 s'))
        bench.order(9)
        bench.tell(p.MotionTold(bench.epoch, stop_owed=True))
        assert bench.follower.report().reason.code is ReasonCode.STOP_OWED
        bench.tell(p.MotionTold(bench.epoch))
        assert not bench.follower.report().reason


def test_a_drive_interrupted_by_nobody_of_us_is_a_take_over():
    bench = under_way()
    end_of_drive(bench, Outcome.INTERRUPTED, 'replaced by "goto 3"')
    bench.drive(2.0)
    assert bench.follower.running, 'the next epoch tells whether it was the emergency stop'
    bench.overrule('"goto 3" of /rviz')
    assert_failed(bench, 'taken over', stopped=False)
    assert '"goto 3" of /rviz' in bench.notes[-1]

def test_nothing_is_sent_to_a_robot_that_somebody_else_may_drive():
    def rolling() -> Bench:
        bench = Bench(yard(), 1, 'rolling')
        bench.order(7, 1, 5, 6)
        return bench
    twin = rolling()
    twin.run(lambda bench: bench.commands[-1] == 'goto 6')
    bench = rolling()
    bench.drive(twin.now - bench.now - 0.3)  # shortly before the next goal is due
    end_of_drive(bench, Outcome.INTERRUPTED, 'replaced by something')
    bench.drive(1.0)
    assert 'goto 6' not in bench.commands
    bench.overrule()
    bench.drive(1.0)
    assert bench.follower.report().reason.text == 'taken over'
    assert 'goto 6' not in bench.commands


def test_an_interruption_by_the_emergency_stop_is_called_so():
    bench = under_way()
    end_of_drive(bench, Outcome.INTERRUPTED, 'Interrupted: Going to 7')
    bench.press(True)
    assert_failed(bench, 'emergency stop')

@pytest.mark.parametrize('why, reason', [
    (EpochCause.EMERGENCY_STOP, 'emergency stop'), (EpochCause.OTHER_CLIENT, 'taken over')])
@pytest.mark.parametrize('restarts', [False, True])
def test_a_drive_that_the_robot_broke_off_waits_until_the_controller_knows_why(
        why, reason, restarts):
    """After an emergency stop the robot returns to the fleet by itself; otherwise it does not."""
    def tell(**what):
        bench.epoch += 1
        bench.tell(p.MotionTold(bench.epoch, reason='Interrupted: Going to 7',
                                number=bench.robot.last[0], fate=CommandFate.NOT_OBEYED, **what))
    bench = under_way()
    given = list(bench.commands)
    end_of_drive(bench, Outcome.INTERRUPTED, 'Interrupted: Going to 7')
    bench.robot.halt(ActivityKind.STOPPED)
    if restarts:
        record = bench.follower.record
        bench.follower = RouteFollower(bench.follower.settings, bench.follower.graph, LINKS)
        bench.follower.restore(record, True, bench.now)
        for link in LINKS:
            bench.tell(p.LinkReported(link, True))
    tell(is_unexplained=True)
    for _ in range(5):
        bench.look()
        bench.wait(0.3)
    assert bench.follower.running
    assert bench.commands == given
    tell(is_ours=why is EpochCause.EMERGENCY_STOP, cause=why)
    assert bench.follower.report().reason.text == reason
    assert 'goto 7' not in bench.commands[len(given):]

@pytest.mark.parametrize('why, reason', [
    (EpochCause.EMERGENCY_STOP, 'emergency stop'), (EpochCause.OTHER_CLIENT, 'taken over')])
def test_an_order_that_waits_to_hear_why_a_drive_was_broken_off_is_not_driven(why, reason):
    """Its giver did not know yet that another client, or the emergency stop, ended the route."""
    bench = under_way()
    end_of_drive(bench, Outcome.INTERRUPTED, 'Interrupted: Going to 7')
    bench.robot.halt(ActivityKind.STOPPED)
    bench.epoch += 1
    bench.tell(p.MotionTold(bench.epoch, is_unexplained=True))
    given = len(bench.commands)
    bench.order(8, 4, 5)
    bench.epoch += 1
    bench.tell(p.MotionTold(bench.epoch, cause=why))
    bench.drive(1.0)
    assert bench.follower.report().reason.text == reason
    assert not {'goto 7', 'goto 6'}.intersection(bench.commands[given:])

def test_what_another_client_of_the_robot_does_ends_the_route():
    bench = under_way()
    given = list(bench.commands)
    bench.epoch += 1
    bench.tell(p.MotionTold(bench.epoch, reason='Stopping',
                            cause=EpochCause.OTHER_CLIENT))
    bench.drive(1.0)
    assert bench.follower.report().reason.text == 'taken over'
    assert bench.commands == given


def another_client_drives(bench):
    bench.epoch += 1
    bench.tell(p.MotionTold(bench.epoch, reason='Going to 5',
                            cause=EpochCause.OTHER_CLIENT))


def the_robot_obeys_us(bench):
    bench.epoch += 1
    bench.tell(p.MotionTold(bench.epoch, bench.epoch - 1, is_ours=True, obeys_us=True))


def test_a_robot_that_obeys_us_after_the_route_was_taken_over_is_stopped():
    """Otherwise the robot would drive without a giver."""
    bench = under_way()
    another_client_drives(bench)
    assert bench.follower.report().reason.text == 'taken over'
    assert bench.commands[-1] != 'stop'
    the_robot_obeys_us(bench)
    assert bench.commands[-1] == 'stop'


def test_the_end_of_a_drive_that_we_replaced_means_nothing():
    bench = under_way('rolling')
    first = bench.robot.number - 1
    for ending in Outcome:
        bench.tell(p.CommandEnded(first, ending, 'of an earlier command'))
    bench.run()
    assert bench.states() == [2, 2, 2]

def test_a_robot_that_no_longer_tells_where_it_is_fails_the_route():
    bench = under_way(location_timeout=5.0)
    bench.wait(5.5)
    assert_failed(bench, 'the robot has not reported its location for 5 s')

def test_no_progress_fails_the_route():
    bench = under_way(stall_timeout=10.0)
    for _ in range(21):
        bench.now += 0.5
        bench.look()
        bench.wait(0.05)
    assert_failed(bench, 'no progress for 10 s')

def test_off_the_corridor_fails_the_route_at_the_second_location():
    bench = under_way()
    bench.robot.position = (bench.robot.position[0], 0.6)
    bench.now += 0.1
    bench.look()
    assert bench.follower.running
    bench.now += 0.1
    bench.look()
    assert_failed(bench, 'off the corridor')

def test_one_location_off_the_corridor_counts_once_whatever_else_is_heard():
    bench = under_way()
    bench.robot.position = (bench.robot.position[0], 0.6)
    bench.now += 0.1
    bench.look()
    bench.tell(p.LinkReported(RobotLink.COMMANDS, True), p.LinkReported(RobotLink.OUTGOING, True))
    assert bench.follower.running

def test_on_another_route_the_robot_may_brake_on_the_edges_of_the_one_before():
    bench = Bench(yard(), 1, 'rolling')
    bench.order(7, 1, 5, 6)
    bench.run(lambda bench: bench.follower.report().pose.edge == 5)
    bench.order(8, 2)
    assert not bench.refusals
    for x in (4.5, 4.6):
        bench.now += 0.1
        bench.robot.position = (x, 0.0)
        bench.look()
    assert bench.follower.running

def test_an_arrival_elsewhere_is_not_believed():
    bench = under_way()
    end_of_drive(bench, Outcome.SUCCEEDED, 'Arrived at 7')
    bench.robot.motion = ActivityKind.ARRIVED_AT_GOAL
    assert bench.states() == [2, 1, 1]
    for _ in range(2):
        bench.now += 0.5
        bench.look()
    assert_failed(bench, 'the robot says that it is at 7, but is '
                  f'{8.0 - bench.robot.position[0]:.1f} m away from it')

def test_an_arrival_is_not_judged_while_late_locations_still_change():
    bench = under_way()
    end_of_drive(bench, Outcome.SUCCEEDED, 'Arrived at 7')
    x, y = bench.robot.position
    for step in range(1, 8):
        bench.robot.position = (x + 0.2 * step, y)
        bench.now += 0.2
        bench.look()
        assert bench.follower.running

def test_an_arrival_is_not_judged_by_late_locations_of_a_robot_that_turns_on_the_way():
    bench = under_way()
    number = bench.robot.number
    bench.tell(p.CommandEnded(number, Outcome.SUCCEEDED, 'Arrived at 7'))
    for _ in range(5):  # earlier reports of the robot: it drives, and then turns at one place
        bench.now += 0.2
        assert bench.robot.motion is ActivityKind.GOING_TO_GOAL
        bench.look()
        assert bench.follower.running

def test_an_arrival_is_judged_by_the_locations_after_it_however_late_they_come():
    bench = under_way(location_timeout=60.0)
    # the controller reports, but the robot does not
    while bench.robot.motion is not ActivityKind.ARRIVED_AT_GOAL:
        bench.now += 0.1
        bench.tell(*[event for event in bench.robot.step(bench.now)
                     if isinstance(event, p.CommandEnded)])
    bench.wait(6.0)
    assert bench.follower.running
    bench.run()
    assert bench.states() == [2, 2, 2]

def test_locations_out_of_order_are_left_out():
    bench = under_way()
    before = bench.follower.report()
    for stamp in (before.stamp - 1, before.stamp, before.stamp - 1):
        bench.tell(p.RobotSeen(stamp, place=(0.0, 9.0), heading=0.0))
    assert replace(bench.follower.report(), number=before.number) == before

def drive_by(bench: Bench, *places) -> None:
    """Lets the robot be seen at these places, one per second."""
    for place in places:
        bench.now += 1.0
        bench.robot.position = place
        bench.look()

def test_a_corner_cut_so_far_that_a_vertex_is_missed_is_made_good():
    bench = Bench(yard(), 1, 'direct')
    bench.order(7, 1, 5)
    assert bench.commands == ['goto 5']
    drive_by(bench, (2.0, 0.0), (3.5, 0.4), (5.0, 0.4))  # passes vertex 2 at 0.4 m
    assert bench.commands[-1] == 'goto 2'
    assert bench.states() == [1, 1]
    bench.run()
    assert bench.states() == [2, 2]
    assert bench.commands == ['goto 5', 'goto 2', 'goto 5']

def test_a_robot_sent_back_to_a_vertex_still_goes_there_when_the_route_gets_longer():
    bench = Bench(yard(), 1, 'direct')
    bench.order(7, 1, 5)
    bench.run(lambda bench: bench.robot.position[0] > 2.0)
    drive_by(bench, (3.5, 0.4), (5.0, 0.4))
    assert bench.commands[-1] == 'goto 2'
    bench.order(7, 1, 5, 6)
    bench.run()
    assert bench.states() == [2, 2, 2]
    assert bench.commands == ['goto 5', 'goto 2', 'goto 6']

def test_a_failed_route_says_nothing_more_to_the_robot():
    bench = under_way()
    end_of_drive(bench, Outcome.FAILED, 'Cannot find path')
    commands = len(bench.commands)
    bench.drive(1.0)
    bench.wait(60.0)
    assert len(bench.commands) == commands
    assert bench.follower.report().reason.text == 'Cannot find path'

class TestLinks:
    """A short outage has no effect; a long one ends the route, and a stop follows."""

    def test_a_lost_link_fails_the_route_after_a_while_and_the_stop_follows_when_it_is_back(self):
        bench = under_way(links=LINKS)
        bench.give = Unreachable(bench)
        bench.link_is_up[RobotLink.COMMANDS] = False
        bench.drive(1.0)
        assert bench.follower.running
        bench.drive(2.5)
        assert bench.follower.report().reason.text == 'lost link: commands: connection refused'
        assert 'stop' not in bench.commands
        del bench.give
        bench.link_is_up[RobotLink.COMMANDS] = True
        bench.drive(2.0)
        assert bench.commands.count('stop') == 1
        bench.drive(10.0)
        assert bench.commands.count('stop') == 1

    def test_a_link_that_is_back_in_time_costs_nothing(self):
        bench = under_way(links=LINKS)
        bench.link_is_up[RobotLink.OUTGOING] = False
        bench.drive(1.0)
        bench.link_is_up[RobotLink.OUTGOING] = True
        bench.run()
        assert bench.states() == [2, 2, 2]
        assert 'stop' not in bench.commands

    def test_a_link_that_is_not_the_robots_means_nothing(self):
        bench = under_way(links=(RobotLink.COMMANDS,))
        bench.tell(p.LinkReported(RobotLink.OUTGOING, False, 'forged'))
        bench.drive(3.0)
        bench.run()
        assert bench.states() == [2, 2, 2]

    def test_a_drive_that_was_lost_on_its_way_is_given_again_because_the_robot_never_heard_it(self):
        bench = Bench(yard(), 1, 'rolling', links=LINKS)
        bench.order(7, 1, 5, 6)
        deaf = Unreachable(bench)
        bench.give = deaf
        bench.run(lambda _: deaf.lost)
        assert bench.follower.running
        del bench.give
        bench.run()
        assert bench.states() == [2, 2, 2]
        assert len(set(bench.commands)) == len(bench.commands), 'a drive was given twice'

    def test_a_drive_whose_end_was_lost_is_followed_by_the_robots_status(self):
        bench = under_way(links=LINKS)
        end_of_drive(bench, Outcome.LOST, 'the connection broke')
        bench.run()
        assert bench.states() == [2, 2, 2]
        assert bench.commands == ['goto 2', 'goto 7', 'goto 6']

    def test_a_drive_whose_end_was_lost_and_that_somebody_replaced_is_a_take_over(self):
        bench = under_way(links=LINKS)
        end_of_drive(bench, Outcome.LOST, 'the connection broke')
        bench.robot.obey(None, 'goto 3')
        bench.run()
        assert bench.follower.report().reason.text == 'taken over'
        assert bench.commands[-1] == 'goto 3'

    def test_a_node_that_is_restarted_costs_no_route(self):
        for link in LINKS:
            bench = under_way(links=LINKS)
            bench.link_is_up[link] = None
            if link is RobotLink.COMMANDS:
                end_of_drive(bench, Outcome.LOST, 'the controller is gone')
            bench.drive(4.0)
            bench.link_is_up[link] = False
            bench.drive(3.0)
            bench.link_is_up[link] = True
            bench.run()
            assert bench.states() == [2, 2, 2], f'{link}: {bench.follower.report().reason.text}'
            assert bench.commands == ['goto 2', 'goto 7', 'goto 6']

    def test_a_receiver_that_stands_still_costs_no_route(self):
        bench = under_way(links=LINKS, stall_timeout=60.0)
        bench.wait(10.0)
        assert bench.follower.running
        bench.run()
        assert bench.states() == [2, 2, 2]

    def test_a_node_that_stays_away_fails_the_route(self):
        bench = under_way(links=LINKS)
        bench.link_is_up[RobotLink.COMMANDS] = None
        bench.give = Unreachable(bench)
        bench.run(seconds=40.0)
        reason = bench.follower.report().reason
        assert 'commands: its node has reported nothing for 2' in reason.text

class Unreachable:
    """Replaces the controller of the bench, so that no controller receives the commands."""

    def __init__(self, bench: Bench) -> None:
        self.bench = bench
        self.lost = []

    def __call__(self, give: p.Give) -> None:
        self.lost.append(give.command)
        self.bench.tell(p.CommandEnded(give.number, Outcome.NEVER_SENT, 'never sent: no link'))

