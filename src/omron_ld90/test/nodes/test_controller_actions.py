"""A goal of an action is one command. Its result has the robot's words."""
from __future__ import annotations

from typing import Any, Callable, Dict, Iterator, List, Optional, Tuple

import pytest
import rospy

from omron_arcl import ArclError, Busy, Giver, NotConnected, Outcome, Result
from omron_arcl.drives import Overruled, Unclear
from omron_ld90.nodes import controller_actions
from omron_ld90.nodes.controller_execute_command import _OUTCOMES, ExecuteCommandServer
from omron_ld90.nodes.support.old_messages import LATCHED, WAITED
from omron_ld90_msgs.msg import (
    ExecuteCommandActionGoal,
    ExecuteCommandGoal,
    ExecuteCommandResult,
)

R = ExecuteCommandResult


class Handle:
    """A goal as actionlib passes it. `calls` lists the calls of its methods, in order.

    Each method of actionlib's handle takes the lock that actionlib holds while it calls `_on_goal`.
    So the handle must not be used under the lock of `CommandActions`, because this could cause a
    deadlock.
    """

    def __init__(self, id: str, command: str, timeout: float = 0.0, caller: str = '/rviz',
                 known_epoch: int = 0) -> None:
        self.goal = ExecuteCommandActionGoal(goal=ExecuteCommandGoal(
            command=command, timeout=timeout, known_epoch=known_epoch))
        self.goal.goal_id.id = id
        self.goal._connection_header = {'callerid': caller}
        self.calls: List[Tuple[str, Any, str]] = []

    def get_goal(self) -> ExecuteCommandGoal:
        _assert_no_lock_is_held()
        return self.goal.goal

    def get_goal_id(self) -> Any:
        _assert_no_lock_is_held()
        return self.goal.goal_id

    def __getattr__(self, name: str) -> Callable[..., None]:
        _assert_no_lock_is_held()
        return lambda result=None, text='': self.calls.append((name, result, text))

    @property
    def ended(self) -> Tuple[str, int, str, str]:
        """The final state, outcome, message and status text of the goal."""
        how, result, text = self.calls[-1]
        return how, result.outcome, result.message, text


def _assert_no_lock_is_held() -> None:
    lock = Server.last.on_goal.__self__._lock
    assert not lock.locked(), 'a handle is used while CommandActions holds its lock: deadlock'


class Server:
    """Replaces actionlib's server."""

    last: Server

    def __init__(self, name: str, kind: type, on_goal: Callable, on_cancel: Callable,
                 is_stop: Callable, on_cancel_all: Callable) -> None:
        self.on_goal, self.on_cancel, self.is_stop = on_goal, on_cancel, is_stop
        self.on_cancel_all = on_cancel_all
        self.canceller = Giver('')
        Server.last = self

    def start(self) -> None:
        pass


class Old:
    """Replaces OldMessages. `why` says why messages are too old; a stop is never too old."""

    def __init__(self) -> None:
        self.why: Optional[str] = None

    def watch(self, topic: str) -> None:
        assert topic == 'execute_command/goal'

    def reason(self, message: Any, topic: str, is_stop: bool) -> Optional[str]:
        assert isinstance(message, ExecuteCommandActionGoal) and topic == 'execute_command/goal'
        return None if is_stop else self.why


class Bench:
    """The action, and a client of the robot that the test controls."""

    def __init__(self) -> None:
        self.old = Old()
        self.refusal: Optional[ArclError] = None
        self.given: List[Tuple[str, Giver, Dict[str, Any]]] = []
        self.cancelled: List[Tuple[object, Giver]] = []
        self.cancelled_all: List[Giver] = []
        self.obeyed: Optional[str] = None  # present drive; each command repeats it
        self.commands = ExecuteCommandServer(self._execute, self._cancel, self.cancelled_all.append,
                                             lambda *_: self.obeyed, self.old)
        self.server = Server.last

    def _execute(self, text: str, giver: Giver, **options: Any) -> object:
        if self.refusal:
            raise self.refusal
        self.given.append((text, giver, options))
        return text  # stands for the execution

    def _cancel(self, execution: object, canceller: Giver) -> None:
        self.cancelled.append((execution, canceller))

    def give(self, *words: Any, **more: Any) -> Handle:
        """Lets a goal arrive. Returns its handle."""
        handle = Handle(f'goal {len(self.given)}', *words, **more)
        self.server.on_goal(handle)
        return handle

    def end(self, handle: Handle, result: Result) -> None:
        """Ends the command of a goal, and waits until the result is reported."""
        text = handle.get_goal().command
        next(options for given, _, options in self.given if given == text)['on_end'](result)
        self.told()

    def told(self) -> None:
        """Waits until all results have been reported."""
        self.commands._calls.close(10.0)
        self.commands._calls = controller_actions.CallQueue('again')


@pytest.fixture
def bench(monkeypatch) -> Iterator[Bench]:
    monkeypatch.setattr(controller_actions, 'ActionServer', Server)
    monkeypatch.setattr(rospy, 'has_param', lambda name: True)
    made = Bench()
    yield made
    made.commands._calls.close()


def test_a_goal_is_given_for_whom_it_comes_from_and_accepted(bench):
    handle = bench.give('goto 12', caller='/bridge')
    (text, giver, options), = bench.given
    assert (text, giver) == ('goto 12', Giver('/bridge'))
    assert options['known_epoch'] == 0, 'any'
    assert options['stop_on_timeout'] is True
    assert options['timeout'] is None, "the command's own"
    assert [how for how, _, _ in handle.calls] == ['set_accepted']


def test_the_epoch_that_its_giver_knows_goes_with_a_goal(bench):
    bench.give('goto 12', known_epoch=2 ** 64 - 1)
    assert bench.given[0][2]['known_epoch'] == 2 ** 64 - 1


def test_the_time_out_of_a_goal_is_that_of_its_command(bench):
    bench.give('goto 12', 7.5)
    assert bench.given[0][2]['timeout'] == 7.5


@pytest.mark.parametrize('timeout', [-0.1, float('nan'), float('inf')])
def test_a_time_out_that_is_none_is_refused(bench, timeout):
    handle = bench.give('goto 12', timeout)
    assert bench.given == []
    assert handle.ended == ('set_rejected', R.REFUSED, *2 * (
        f'the timeout is {timeout}, but must be 0 or more seconds',))


@pytest.mark.parametrize(('error', 'outcome', 'message'), [
    (ArclError('not allowed'), R.REFUSED, 'not allowed'),
    (NotConnected('no route'), R.NEVER_SENT, str(NotConnected('no route'))),
    (Unclear('Not sent, it is unknown.'), R.NEVER_SENT, 'Not sent, it is unknown.'),
    (Busy(20, 'drives'), R.NEVER_SENT, str(Busy(20, 'drives'))),
    (Overruled('"stop" of /rviz'), R.OVERRULED,
     'Not sent, another command came first: "stop" of /rviz.')])
def test_a_goal_that_cannot_be_given_is_rejected_with_its_reason(bench, error, outcome, message):
    bench.refusal = error
    handle = bench.give('goto 12')
    assert handle.ended == ('set_rejected', outcome, message, str(error))
    bench.server.on_cancel(handle)
    assert bench.cancelled == bench.commands._handles() == [], 'nothing may be left of the goal'


@pytest.mark.parametrize('why', [LATCHED, WAITED])
def test_a_goal_that_is_too_old_was_never_sent_and_a_stop_is(bench, why):
    bench.old.why = why
    handle = bench.give('goto 12')
    assert bench.given == []
    assert handle.ended == ('set_rejected', R.NEVER_SENT, why, why)
    bench.give('stop')
    assert [text for text, _, _ in bench.given] == ['stop']


@pytest.mark.parametrize(('outcome', 'ending', 'told'), [
    (Outcome.SUCCEEDED, 'set_succeeded', R.SUCCEEDED),
    (Outcome.INTERRUPTED, 'set_canceled', R.INTERRUPTED),
    (Outcome.CANCELLED, 'set_canceled', R.CANCELLED),
    (Outcome.FAILED, 'set_aborted', R.FAILED), (Outcome.NO_GOAL, 'set_aborted', R.FAILED),
    (Outcome.REJECTED, 'set_aborted', R.FAILED),
    (Outcome.UNKNOWN_COMMAND, 'set_aborted', R.FAILED),
    (Outcome.EMERGENCY_STOPPED, 'set_aborted', R.EMERGENCY_STOPPED),
    (Outcome.TIMED_OUT, 'set_aborted', R.TIMED_OUT), (Outcome.LOST, 'set_aborted', R.LOST),
    (Outcome.NEVER_SENT, 'set_aborted', R.NEVER_SENT),
    (Outcome.OVERRULED, 'set_aborted', R.OVERRULED)])
def test_the_end_of_the_command_is_that_of_the_goal(bench, outcome, ending, told):
    handle = bench.give('goto 12')
    bench.end(handle, Result(outcome, 'Arrived \x1b at 12', ('Going to 12', 'Arrived at 12')))
    assert handle.ended == (ending, told, r'Arrived \x1b at 12',
                            rf'{outcome.value}: Arrived \x1b at 12')
    assert handle.calls[-1][1].lines == ['Going to 12', 'Arrived at 12']


def test_lines_that_were_left_out_are_counted(bench):
    handle = bench.give('getGoals')
    bench.end(handle, Result(Outcome.SUCCEEDED, 'End of goals', ('Goal: 1',), 5))
    assert handle.ended[2] == 'End of goals (5 more lines were omitted)'


def test_lines_of_the_robot_are_feedback_of_the_goal_that_they_belong_to(bench):
    first, second = bench.give('goto 12'), bench.give('getGoals')
    bench.given[1][2]['on_line']('Goal: 1')
    bench.told()
    assert second.calls[-1][1].line == 'Goal: 1'
    assert len(first.calls) == 1


def test_a_cancellation_cancels_the_command_for_who_cancels(bench):
    first, second = bench.give('goto 12'), bench.give('getGoals')
    bench.server.canceller = Giver('/person')
    bench.server.on_cancel(second)
    bench.server.on_cancel(first)
    assert bench.cancelled == [
        ('getGoals', Giver('/person')), ('goto 12', Giver('/person'))]


def test_who_cancels_everything_is_heard_also_while_there_is_nothing(bench):
    bench.server.canceller = Giver('/person')
    bench.server.on_cancel_all()
    assert bench.cancelled_all == [Giver('/person')]


def test_what_has_ended_is_cancelled_no_more(bench):
    handle = bench.give('goto 12')
    bench.end(handle, Result(Outcome.SUCCEEDED, '', ()))
    bench.server.on_cancel(handle)
    assert bench.cancelled == []


@pytest.mark.parametrize(('command', 'stops'), [('stop', True), (' STOP ', True),
                                                ('goto stop', False), ('goto 12', False)])
def test_only_a_stop_is_taken_whatever_was_cancelled_before(bench, command, stops):
    assert bench.server.is_stop(ExecuteCommandGoal(command=command)) is stops


def test_an_empty_result_is_no_outcome():
    """Once, a goal that was recalled before its start had the outcome 0, which meant SUCCEEDED."""
    assert ExecuteCommandResult().outcome == ExecuteCommandResult.NONE
    assert ExecuteCommandResult.NONE not in _OUTCOMES.values()


def test_a_goal_given_again_takes_the_drive_over_without_a_second_command(bench):
    first = bench.give('goto 12')
    bench.obeyed = 'goto 12'
    second = Handle('again', 'goto 12')
    bench.server.on_goal(second)
    assert [text for text, _, _ in bench.given] == ['goto 12']
    how, _, text = first.calls[-1]
    assert (how, text) == ('set_canceled', 'the same goal was given again')
    bench.end(second, Result(Outcome.SUCCEEDED, 'Arrived at 12', ()))
    assert second.ended[0] == 'set_succeeded'
    assert len(first.calls) == 2, 'a goal ends once'


def test_a_cancellation_of_the_goal_that_took_over_cancels_the_drive(bench):
    bench.give('goto 12')
    bench.obeyed = 'goto 12'
    second = Handle('again', 'goto 12')
    bench.server.on_goal(second)
    bench.server.on_cancel(second)
    assert [execution for execution, _ in bench.cancelled] == ['goto 12']


def test_a_drive_that_did_not_come_by_this_action_is_given_anew_because_its_end_must_be_told(bench):
    bench.obeyed = 'a drive of another interface'
    bench.give('goto 12')
    assert [text for text, _, _ in bench.given] == ['goto 12']
