"""Commands for steps and reports of steps are converted to messages and back without a change."""
from __future__ import annotations

import pytest

from itrci_nav_msgs import msg
from route_protocol.step_messages import (
    MOST_STEPS,
    WrongStepMessage,
    command_of,
    fill_command,
    fill_step_report,
    step_report_of,
)
from route_protocol.steps import ShownStep, StepAct, StepCode, StepCommand, StepReport, Word


@pytest.mark.parametrize('command', [
    StepCommand(2 ** 60, StepAct.DO, 2 ** 61, 'say', (('text', 'hello'), ('n', '1')), 5.0),
    StepCommand(1, StepAct.CANCEL, 2), StepCommand(1, StepAct.REVOKE, 2)])
def test_a_command_comes_back(command):
    assert command_of(fill_command(msg.StepCommand(), command, msg.StepParameter)) == command


def test_a_report_comes_back():
    steps = tuple(ShownStep(key, word, code, 'text') for key, (word, code) in enumerate(
        (word, code) for word in Word for code in StepCode))
    report = StepReport(2 ** 61, 7, 2 ** 60, steps)
    assert step_report_of(fill_step_report(msg.StepStates(), report, msg.StepState)) == report


def test_the_constants_of_the_messages_are_those_of_the_values():
    for enum, message, prefix in ((StepAct, msg.StepCommand, ''), (Word, msg.StepState, ''),
                                  (StepCode, msg.StepState, 'CODE_')):
        assert {one.name: int(one) for one in enum} == {
            one.name: getattr(message, prefix + one.name) for one in enum}


@pytest.mark.parametrize('step', [msg.StepState(state=9), msg.StepState(code=99)])
def test_a_step_with_an_unknown_number_is_refused(step):
    with pytest.raises(WrongStepMessage, match='does not exist'):
        step_report_of(msg.StepStates(steps=[step]))
    with pytest.raises(WrongStepMessage, match='act is 7'):
        command_of(msg.StepCommand(act=7))
    with pytest.raises(WrongStepMessage, match=f'more than {MOST_STEPS}'):
        step_report_of(msg.StepStates(steps=[msg.StepState()] * (MOST_STEPS + 1)))


def test_texts_are_shortened_and_printable():
    text = step_report_of(msg.StepStates(steps=[msg.StepState(text='a\n' * 999)])).steps[0].text
    assert text == 'a?' * 250
