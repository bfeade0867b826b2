"""Which numbered orders the bridge takes, refuses and ignores, and where the robot drives."""
from __future__ import annotations

import math
from typing import Optional, Sequence, Tuple

import pytest
from bridge_builders import DOCK_VERTEX, Bench, yard
from hypothesis import given
from hypothesis import strategies as st

from omron_arcl import ActivityKind, Outcome
from omron_arcl.records import MotionState
from omron_ld90.bridge import events as p
from omron_ld90.bridge.route_follower import RouteFollower
from route_protocol.values import (
    LARGEST_NUMBER,
    LARGEST_RECORD_NUMBER,
    EdgeState,
    EpochCause,
    Motion,
    ReasonCode,
    RouteOrder,
    RouteReport,
)

NANOSECONDS = 1_000_000_000


class Fleet(Bench):
    """A bench whose master numbers its orders."""

    def __init__(self, vertex: int = 1, strategy: str = 'vertex_by_vertex', **settings) -> None:
        super().__init__(yard(), vertex, strategy, **settings)
        self.number = 100

    @property
    def report(self) -> RouteReport:
        return self.follower.report()

    def send(self, *edges: int, first: int = 0, number: Optional[int] = None,
             epoch: Optional[int] = None, master: str = 'fleet', route_id: int = 7) -> RouteOrder:
        """Orders a route, or a stop if there are no edges. Returns the order."""
        self.number += 1
        order = RouteOrder(
            route_id, edges, known_epoch=self.report.epoch if epoch is None else epoch,
            order=self.number if number is None else number, first=first, master=master)
        self.tell(order)
        return order

    def until_on(self, edge: int) -> None:
        self.run(lambda bench: bench.follower.report().pose.edge == edge)

    def started_anew(self, is_sure: bool) -> None:
        """Restarts the bridge. is_sure -- its memory certainly contains the last order."""
        record, dead = self.follower.record, self.follower
        self.robot.number = None
        self.follower = RouteFollower(dead.settings, dead.graph, tuple(self.link_is_up), self.draw,
                                      self.clock)
        self.follower.restore(record, True, self.now, is_sure)
        self.hear_motion('')
        self.look()


def test_a_route_is_driven_and_reported_with_its_numbers():
    fleet = Fleet()
    order = fleet.send(1, 5, first=3)
    fleet.run()
    report = fleet.report
    assert (report.master, report.order, report.first, report.done) == ('fleet', order.order, 3, 5)
    assert report.states == (EdgeState.COMPLETE, EdgeState.COMPLETE)
    assert fleet.commands == ['goto 2', 'goto 5']


def test_a_route_may_pass_a_place_twice():
    fleet = Fleet()
    fleet.send(1, 5, -5, -1, 1)
    fleet.run()
    assert fleet.commands == ['goto 2', 'goto 5', 'goto 2', 'goto 1', 'goto 2']
    fleet.send(1, 2, first=4)
    fleet.run()
    assert fleet.report.done == 6
    assert fleet.commands[-1] == 'goto 3'


def test_which_of_two_passes_of_a_place_an_order_means_is_said_by_its_number():
    fleet = Fleet()
    fleet.send(1, 5, -5, -1)
    fleet.run(lambda bench: bench.follower.report().done == 2)
    fleet.send(-5, 2, first=2)
    fleet.run()
    assert fleet.refusals == []
    assert fleet.commands == ['goto 2', 'goto 5', 'goto 2', 'goto 3']
    assert fleet.report.states == (EdgeState.COMPLETE, EdgeState.COMPLETE)


@pytest.mark.parametrize('edges, first', [((1, 5, 6), 0), ((5, 6), 1)])
def test_an_order_that_goes_on_may_leave_out_what_is_driven(edges, first):
    fleet = Fleet()
    fleet.send(1, 5)
    fleet.until_on(5)
    before = fleet.report.pose
    fleet.send(*edges, first=first)
    assert fleet.report.pose == before
    fleet.run()
    assert fleet.commands == ['goto 2', 'goto 5', 'goto 6']
    assert (fleet.report.done, fleet.report.first) == (3, first)


@pytest.mark.parametrize('is_late', [True, False])
def test_an_order_that_crosses_what_its_master_did_itself_is_driven(is_late, monkeypatch):
    fleet = Fleet()
    fleet.send(1)
    fleet.run()
    epoch = fleet.report.epoch
    gives = []
    if is_late:
        with monkeypatch.context() as on_the_way:
            on_the_way.setattr(fleet, 'give', gives.append)
            fleet.send(5, first=1)
    fleet.master_acts('fleet')
    for give in gives:
        fleet.give(give)  # the controller refuses the drive, which names the previous epoch
    if not is_late:
        fleet.send(5, first=1, epoch=epoch)
    fleet.run()
    assert (fleet.refusals, fleet.report.epoch) == ([], epoch)
    assert (fleet.commands, fleet.report.states) == (['goto 2', 'goto 5'], (EdgeState.COMPLETE,))


def test_the_next_route_begins_where_its_master_has_brought_the_robot_itself():
    fleet = Fleet()
    fleet.send(1)
    fleet.run()
    fleet.robot.obey(None, 'goto 3')
    fleet.robot.foreign = False
    fleet.master_acts('fleet', MotionState.DRIVING)
    assert fleet.report.motion is Motion.MOVED
    fleet.run(lambda bench: bench.robot.goal is None)
    fleet.hear_motion('')
    fleet.run(lambda bench: bench.follower.report().motion is Motion.STANDING)
    assert fleet.report.states == (EdgeState.COMPLETE,)
    fleet.send(5, first=1)
    assert fleet.refusals.pop().reason.code is ReasonCode.STARTS_ELSEWHERE
    fleet.send(3, first=1)
    fleet.run()
    assert (fleet.refusals, fleet.commands[-1]) == ([], 'goto 4')
    assert fleet.report.states == (EdgeState.COMPLETE,)


def test_each_edge_on_which_a_stopped_robot_rolls_on_is_reported_at_once():
    """Otherwise the master would not know which vertices the robot has passed."""
    fleet = Fleet(strategy='rolling')
    fleet.send(1, 5, 6)
    fleet.send(first=0)
    fleet.reports.clear()
    for k in range(1, 6):
        fleet.tell(p.RobotSeen(int((fleet.now + 0.1 * k) * NANOSECONDS), ActivityKind.STOPPING,
                               None, (2.0 * k, 0.0)))
    assert {report.motion for report in fleet.reports} == {Motion.COMING_TO_REST}
    assert [report.pose.edge for report in fleet.reports] == [5, 6]


@pytest.mark.parametrize('giver', ['rviz', 'fleet2'])
def test_what_another_than_the_master_did_overrules_an_order_on_its_way(giver):
    fleet = Fleet()
    fleet.send(1)
    fleet.run()
    epoch = fleet.report.epoch
    fleet.master_acts(giver)
    fleet.send(5, first=1, epoch=epoch)
    assert fleet.refusals.pop().reason.code is ReasonCode.OVERRULED
    assert (fleet.report.cause, fleet.commands) == (EpochCause.OTHER_GIVER, ['goto 2'])


def test_an_order_that_does_not_go_on_with_the_edge_under_way_is_refused():
    fleet = Fleet()
    fleet.send(1, 5)
    fleet.until_on(5)
    order = fleet.send(2, first=1)
    assert fleet.refusals[-1].reason.text == 'it must go on with the edge under way, 5'
    assert fleet.refusals[-1].order == order.order == fleet.report.refused
    assert fleet.report.refusal.code is ReasonCode.WRONG_CHANGE
    fleet.run()
    assert fleet.commands == ['goto 2', 'goto 5']


def test_repeated_late_and_reordered_orders_move_nothing():
    fleet = Fleet()
    first, second = fleet.send(1), fleet.send(1, 5)
    fleet.run()
    stop = fleet.send()
    given = list(fleet.commands)
    before = fleet.report
    for late in (second, first, stop, second):
        fleet.tell(late)
        fleet.drive(2.0)
    after = fleet.report
    assert (after.order, after.refused, after.epoch) == (before.order, before.refused,
                                                         before.epoch)
    assert fleet.commands == given
    assert fleet.refusals == []


def test_orders_that_arrive_in_the_wrong_sequence_leave_the_newest_in_force():
    fleet = Fleet()
    epoch = fleet.report.epoch
    fleet.send(1, 5, 6, number=120, epoch=epoch)
    fleet.send(1, 5, number=110, epoch=epoch)
    fleet.send(number=115)
    fleet.run()
    assert fleet.report.order == 120
    assert fleet.report.states == (EdgeState.COMPLETE,) * 3


def test_the_newer_one_of_two_orders_that_wait_is_driven_whatever_their_sequence():
    for numbers in ((120, 110), (110, 120)):
        fleet = Fleet(links=tuple(p.RobotLink))
        fleet.link_is_up[p.RobotLink.OUTGOING] = False
        fleet.hear_links()
        epoch = fleet.report.epoch
        for number in numbers:
            fleet.send(*((1, 5) if number == 120 else (1,)), number=number, epoch=epoch)
        fleet.link_is_up[p.RobotLink.OUTGOING] = True
        fleet.drive(2.0)
        assert (fleet.report.order, fleet.report.edges) == (120, (1, 5))


def test_a_stop_of_the_master_keeps_its_epoch_and_one_without_a_number_begins_one():
    fleet = Fleet()
    epoch = fleet.report.epoch
    fleet.send(1, 5)
    fleet.drive(2.0)
    fleet.send(epoch=0)
    assert (fleet.report.epoch, fleet.commands[-1]) == (epoch, 'stop')
    under_way = RouteOrder(7, (1, 5), known_epoch=epoch, order=500, master='fleet')
    fleet.tell(RouteOrder(9, ()))
    assert fleet.report.epoch != epoch
    assert (fleet.report.cause, fleet.report.order) == (EpochCause.STOP, 0)
    given = list(fleet.commands)
    fleet.tell(under_way)
    fleet.drive(5.0)
    assert fleet.refusals[-1].reason.code is ReasonCode.OVERRULED
    assert fleet.commands == given


def test_a_new_route_after_a_stop_waits_until_the_robot_stands():
    fleet = Fleet()
    fleet.send(1, 5)
    fleet.drive(2.0)
    fleet.send(epoch=0)
    assert fleet.report.motion is Motion.COMING_TO_REST
    fleet.send(1, 5, first=0)
    assert fleet.commands[-1] == 'stop'
    fleet.run()
    assert fleet.report.states == (EdgeState.COMPLETE,) * 2


def test_a_robot_that_does_not_come_to_rest_in_time_refuses_the_route():
    fleet = Fleet()
    fleet.send(1, 5)
    fleet.drive(2.0)
    fleet.give = lambda give: None  # the stop does not reach the robot
    fleet.send(epoch=0)
    order = fleet.send(1, 5, first=0)
    fleet.drive(5.0)
    assert (fleet.report.refused, fleet.report.refusal.text) == (
        order.order, 'the robot is still coming to rest')
    assert fleet.report.motion is Motion.COMING_TO_REST


def test_after_a_failure_the_route_goes_on_from_the_same_number():
    fleet = Fleet()
    fleet.send(1, 5)
    fleet.until_on(5)
    number, fleet.robot.number = fleet.robot.number, None
    fleet.tell(p.CommandEnded(number, Outcome.FAILED, 'Cannot find path'))
    assert (fleet.report.is_failed, fleet.report.done) == (True, 1)
    fleet.send(5, 6, first=1)
    fleet.run()
    assert fleet.report.done == 3


@pytest.mark.parametrize('cause', [
    EpochCause.OTHER_GIVER, EpochCause.STOP, EpochCause.CANCEL, EpochCause.EMERGENCY_STOP])
def test_whoever_overrules_the_fleet_begins_an_epoch_with_that_cause(cause):
    fleet = Fleet()
    fleet.send(1, 5)
    epoch = fleet.report.epoch
    fleet.epoch += 1
    fleet.tell(p.MotionTold(fleet.epoch, is_ours=cause is EpochCause.EMERGENCY_STOP,
                            reason='why', cause=cause))
    assert fleet.report.epoch != epoch
    assert (fleet.report.cause, fleet.report.order, fleet.report.is_failed) == (cause, 0, True)


def test_a_link_that_is_lost_for_too_long_begins_an_epoch():
    fleet = Fleet(links=tuple(p.RobotLink))
    fleet.send(1, 5)
    fleet.drive(1.0)
    epoch = fleet.report.epoch
    fleet.link_is_up[p.RobotLink.COMMANDS] = False
    fleet.drive(1.5)
    assert fleet.report.epoch == epoch
    fleet.drive(3.0)
    assert (fleet.report.cause, fleet.report.motion) == (EpochCause.LOST_LINK, Motion.UNKNOWN)
    assert fleet.report.epoch != epoch


@pytest.mark.parametrize('stops', [False, True])
def test_an_order_of_another_master_takes_over(stops):
    fleet = Fleet()
    fleet.send(1, 5)
    fleet.drive(1.0)
    epoch = fleet.report.epoch
    fleet.send(*(() if stops else (1,)), first=6, number=1, master='other')
    report = fleet.report
    assert (report.cause, report.master, report.order) == (EpochCause.OTHER_MASTER, 'other', 1)
    fleet.send(1, 5, 6, epoch=epoch)
    fleet.drive(5.0)
    assert fleet.refusals[-1].reason.code is ReasonCode.OVERRULED
    assert fleet.report.refused == 0, 'it counts the orders of the other master'


def test_an_order_without_a_number_takes_over_and_is_taken_over():
    fleet = Fleet()
    fleet.send(1, 5)
    fleet.drive(1.0)
    fleet.order(3, 1, 2)
    assert (fleet.report.master, fleet.report.edges) == ('', (1, 2))
    fleet.send(1, 5, first=0)
    assert (fleet.report.master, fleet.report.edges) == ('fleet', (1, 5))
    fleet.run()
    assert fleet.report.states == (EdgeState.COMPLETE,) * 2


@pytest.mark.parametrize('is_sure', [True, False])
def test_after_a_restart_with_memory_the_route_goes_on_and_without_it_fails(is_sure):
    fleet = Fleet()
    order = fleet.send(1, 5)
    fleet.until_on(5)
    before, given = fleet.report, list(fleet.commands)
    fleet.started_anew(is_sure)
    fleet.tell(order)
    if is_sure:
        fleet.run()
        assert (fleet.report.epoch, fleet.report.order) == (before.epoch, order.order)
        assert fleet.report.states == (EdgeState.COMPLETE,) * 2
        assert fleet.commands == ['goto 2', 'goto 5'], 'no goal is sent twice'
    else:
        fleet.drive(3.0)
        assert fleet.report.epoch != before.epoch
        assert (fleet.report.cause, fleet.report.is_failed) == (EpochCause.RESTART, True)
        assert fleet.commands == [*given, 'stop']
        assert fleet.refusals[-1].reason.code is ReasonCode.OVERRULED
    assert fleet.report.number > before.number


def test_a_robot_that_still_rolls_after_a_restart_without_memory_takes_no_route():
    fleet = Fleet()
    fleet.send(1, 5)
    fleet.drive(2.0)
    fleet.give = lambda give: None  # the stop does not reach the robot
    fleet.started_anew(False)
    assert fleet.report.motion is Motion.UNKNOWN
    fleet.send(1)
    fleet.drive(5.0)
    assert fleet.report.refusal.text == 'the robot is still coming to rest'
    assert fleet.commands == ['goto 2']


def test_numbers_that_were_refused_are_remembered_over_a_restart():
    fleet = Fleet()
    fleet.send(1)
    refused = fleet.send(1, 99)
    fleet.run()
    fleet.started_anew(True)
    before = fleet.report
    fleet.tell(refused)
    fleet.drive(2.0)
    assert before.refused == refused.order
    assert fleet.report.epoch == before.epoch
    assert len(fleet.refusals) == 1


def test_a_shorter_route_is_taken_only_if_the_robot_can_stop_in_it():
    fleet = Fleet(strategy='direct')
    fleet.send(1, 5, 6)
    fleet.drive(1.0)
    fleet.send(1, 5)
    assert (fleet.refusals, fleet.commands[-1]) == ([], 'goto 5')
    fleet.until_on(5)
    fleet.send(5, 6, first=1)
    fleet.send(5, first=1)
    assert fleet.commands[-1] == 'goto 6'
    assert fleet.report.refusal.code is ReasonCode.CANNOT_BRAKE
    fleet.run()
    assert fleet.report.states == (EdgeState.COMPLETE,) * 2


@pytest.mark.parametrize('bad', [
    {'epoch': 0}, {'first': LARGEST_RECORD_NUMBER}, {'first': 9}, {'epoch': 12345},
    {'number': LARGEST_NUMBER}, {'master': ''}])
def test_bad_input_is_one_sentence_and_nothing_moves_and_nothing_is_lost(bad):
    fleet = Fleet()
    fleet.send(1, 5)
    fleet.drive(2.0)
    before, given, notes = fleet.report, list(fleet.commands), len(fleet.notes)
    fleet.send(1, 5, 6, **bad)
    assert len(fleet.refusals) == 1
    assert fleet.notes[notes:] == [f'Route 7 was refused: {fleet.refusals[0].reason}.']
    after = fleet.report
    assert (after.order, after.edges, after.epoch) == (before.order, before.edges, before.epoch)
    assert fleet.commands == given
    fleet.send(1, 5, 6)
    fleet.run()
    assert fleet.report.states == (EdgeState.COMPLETE,) * 3
    fleet.send(epoch=0)
    assert fleet.commands[-1] == 'stop'


# -- for all orders and events ---------------------------------------------------------------------

TURNS = st.lists(st.integers(0, 3), min_size=1, max_size=3)
HAPPENINGS = st.one_of(
    st.tuples(st.just('drive'), st.integers(1, 150)),
    st.tuples(st.just('drive'), st.integers(1, 150)),
    st.tuples(st.just('grant'), st.integers(0, 3), TURNS),
    st.tuples(st.just('grant'), st.integers(0, 3), TURNS),
    st.tuples(st.just('shorten')), st.tuples(st.just('stop')), st.tuples(st.just('stop 0')),
    st.tuples(st.just('again'), st.integers(0, 40)),
    st.tuples(st.just('other'), TURNS), st.tuples(st.just('old'), st.integers(1, 3), TURNS),
    st.tuples(st.just('restart'), st.booleans()),
    st.tuples(st.just('overrule'), st.sampled_from(['stop', 'goto 3'])),
    st.tuples(st.just('emergency')), st.tuples(st.just('fail')))


class WatchedFleet(Fleet):
    """A fleet that checks each report and each goal against the robot's path and the last order."""

    def __init__(self, strategy: str) -> None:
        super().__init__(1, strategy)
        self._said, self._seen = self.report, 0

    def check(self) -> None:
        """Checks that numbers only grow within an epoch, and that the robot was at the end of each
        complete edge.
        """
        before, now = self._said, self.report
        self._said = now
        assert now.number > before.number
        if (now.epoch, now.master) == (before.epoch, before.master):
            assert now.refused >= before.refused and now.order >= before.order
            assert before.order == 0 or now.done >= before.done
            if before.order and now.order:
                for index in range(max(before.done - now.first, 0), now.completed):
                    self._check_passed(now.edges[index])
        self._seen = len(self.robot.trail)

    def _check_passed(self, edge: int) -> None:
        end = self.follower.graph.end_vertex(edge).position
        trail = self.robot.trail[max(self._seen - 10, 0):]  # locations are up to 0.5 s old
        assert min(math.dist(place, end) for place in trail) < 0.4, f'edge {edge} was not driven'

    def give(self, give: p.Give) -> None:
        if give.command != 'stop':
            goal = give.command.split()[-1]
            report = self.follower.report()
            allowed = {self._name(edge) for edge in report.edges[report.completed:]}
            assert self.follower.running and goal in allowed, (
                f'{give.command} is outside of {report.edges}, order {report.order}')
        super().give(give)

    def _name(self, edge: int) -> str:
        vertex = self.follower.graph.end_vertex(edge).id
        return 'dock' if vertex == DOCK_VERTEX else str(vertex)

    def way(self, edges: Sequence[int], turns: Sequence[int]) -> Tuple[int, ...]:
        """Returns these edges and one more for each turn; without edges, begins at the robot."""
        graph, found = self.follower.graph, list(edges)
        for turn in turns:
            if found:
                ways = graph.edges_from(graph.end_vertex(found[-1]).id)
            else:
                edge = graph.nearest_edge(*self.robot.position)[0]
                ways = [edge, -edge]
            found.append(ways[turn % len(ways)])
        return tuple(found)


@given(st.lists(HAPPENINGS, min_size=5, max_size=25),
       st.sampled_from(['vertex_by_vertex', 'rolling', 'direct']))
def test_the_robot_is_never_sent_outside_of_the_last_order_that_was_taken(happenings, strategy):
    fleet = WatchedFleet(strategy)
    sent = [fleet.send(1, 5, 6)]
    for what, *values in happenings:
        report = fleet.report
        ahead = report.edges[report.completed:]
        if what == 'drive':
            fleet.drive(0.1 * values[0])
        elif what == 'grant':
            back = min(values[0], report.completed)
            edges = report.edges[report.completed - back:]
            sent.append(fleet.send(*fleet.way(edges, values[1]), first=report.done - back))
        elif what == 'shorten' and len(ahead) > 1:
            sent.append(fleet.send(*ahead[:-1], first=report.done))
        elif what == 'stop':
            sent.append(fleet.send())
        elif what == 'stop 0':
            fleet.tell(RouteOrder(9, ()))
        elif what == 'again' and sent:
            fleet.tell(sent[values[0] % len(sent)])
        elif what == 'other':
            sent.append(fleet.send(*fleet.way((), values[0]), master='other'))
        elif what == 'old':
            fleet.tell(RouteOrder(values[0], fleet.way((), values[1]),
                                  int(fleet.now * NANOSECONDS)))
        elif what == 'restart':
            fleet.started_anew(values[0])
        elif what == 'overrule':
            fleet.overrule(command=values[0])
        elif what == 'emergency':
            fleet.tell(*fleet.robot.press_emergency_stop())
            fleet.hear_motion('')
            fleet.robot.emergency = False
        elif what == 'fail' and fleet.robot.number is not None:
            number, fleet.robot.number = fleet.robot.number, None
            fleet.tell(p.CommandEnded(number, Outcome.FAILED, 'Failed going to goal'))
        fleet.check()


# -- masters with and without numbers --------------------------------------------------------------

def rolling() -> Fleet:
    """Returns a fleet whose robot comes to rest after the stop of its master."""
    fleet = Fleet()
    fleet.send(1, 5)
    fleet.until_on(5)
    fleet.send(first=1)
    assert fleet.report.motion is Motion.COMING_TO_REST
    return fleet


def test_a_route_that_waits_is_refused_when_another_master_orders():
    fleet = rolling()
    waits = fleet.send(5, first=1)
    fleet.send(5, number=1, master='other')
    assert [refusal.order for refusal in fleet.refusals] == [waits.order]
    assert fleet.report.refused == waits.order
    fleet.run(lambda bench: bench.follower.running)
    assert fleet.report.master == 'other'


def test_a_route_that_waits_outlives_a_stop_that_came_late():
    fleet = rolling()
    waits = fleet.send(5, first=1, number=200)
    fleet.send(first=1, number=150)
    fleet.run(lambda bench: bench.follower.running)
    assert fleet.report.order == waits.order


def test_only_the_first_order_of_another_master_begins_an_epoch_for_old_masters():
    fleet = Fleet()
    fleet.order(8, 1)
    fleet.run()
    fleet.send(number=5)
    fleet.run(seconds=300.0)
    fleet.drive(5.0)
    fleet.send(2, first=fleet.report.first)
    fleet.tell(RouteOrder(9, (2,), stamp=int((fleet.now - 0.1) * NANOSECONDS),
                          received=int(fleet.now * NANOSECONDS)))
    assert fleet.refusals == []
