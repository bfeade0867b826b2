"""A robot takes each key once, only in the run that the command names, and keeps its steps."""
from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from route_protocol.steps import (
    KEPT,
    ActorState,
    Reaction,
    StepAct,
    StepCode,
    StepCommand,
    StepReport,
    Word,
)

RUN = 5
COMMANDS = st.builds(StepCommand, st.integers(1, 6), st.sampled_from(StepAct),
                     st.sampled_from((RUN, RUN - 1)))


def do(key: int, run: int = RUN) -> StepCommand:
    return StepCommand(key, StepAct.DO, run, 'wait')


@given(st.lists(COMMANDS, max_size=30))
def test_no_key_begins_twice_or_after_a_later_one(commands):
    state, begun = ActorState(RUN), []
    for command in commands:
        state, reaction = state.obey(command)
        if reaction is Reaction.BEGIN:
            begun.append(command.key)
    assert begun == sorted(set(begun))
    assert state.last == max([0, *(one.key for one in commands if one.known_run == RUN)])


def test_a_command_for_another_run_is_ignored():
    state = ActorState(RUN)
    for run in (RUN - 1, RUN + 1):
        assert state.obey(do(1, run)) == (state, Reaction.NOTHING)


@pytest.mark.parametrize('act', [StepAct.CANCEL, StepAct.REVOKE])
def test_a_step_that_is_to_end_before_its_command_came_is_never_begun(act):
    state, reaction = ActorState(RUN).obey(StepCommand(3, act, RUN))
    assert reaction is Reaction.NOTHING and state.report()[1].find(3).word is Word.CANCELLED
    assert state.obey(do(3))[1] is Reaction.NOTHING


@pytest.mark.parametrize('act, reaction', [
    (StepAct.CANCEL, Reaction.BREAK_OFF), (StepAct.REVOKE, Reaction.NOTHING),
    (StepAct.DO, Reaction.NOTHING)])
def test_only_a_cancellation_breaks_off_what_runs(act, reaction):
    state, _ = ActorState(RUN).obey(do(3))
    assert state.obey(StepCommand(3, act, RUN)) == (state, reaction)
    ended = state.end(3, Word.DONE)
    assert ended.obey(StepCommand(3, act, RUN)) == (ended, Reaction.NOTHING)


def test_what_has_ended_does_not_change_any_more():
    state = ActorState(RUN).obey(do(1))[0].end(1, Word.FAILED, StepCode.NOT_READY, 'no cart')
    assert state.end(1, Word.DONE) == state
    assert state.report()[1].find(1).text == 'no cart'


def test_all_running_steps_are_shown_and_the_last_that_have_ended():
    state = ActorState(RUN).obey(do(1))[0]
    for key in range(2, KEPT + 12):
        state = state.obey(do(key))[0].end(key, Word.DONE)
    keys = [step.key for step in state.obey(do(99))[0].report()[1].steps]
    assert keys == [1, *range(12, KEPT + 12), 99]


def test_reports_are_newer_by_run_and_then_by_number():
    reports = [StepReport(run, number) for run in (1, 2) for number in (1, 2)]
    for k, report in enumerate(reports):
        assert report.is_newer_than(None)
        assert [report.is_newer_than(other) for other in reports] == [
            k > other for other in range(4)]
