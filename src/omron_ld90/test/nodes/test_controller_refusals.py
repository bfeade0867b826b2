"""A failed command gives one clear message."""
from __future__ import annotations

import pytest

from omron_arcl import Outcome, Result
from omron_ld90.nodes.controller_refusals import failure


@pytest.mark.parametrize(('outcome', 'words'), [
    (Outcome.NO_GOAL, 'refused by the robot'), (Outcome.UNKNOWN_COMMAND, 'refused by the robot'),
    (Outcome.REJECTED, 'refused by the robot'), (Outcome.FAILED, 'failed'),
    (Outcome.EMERGENCY_STOPPED, 'emergency stop'), (Outcome.TIMED_OUT, 'timed out'),
    (Outcome.LOST, 'lost')])
def test_a_command_that_came_to_nothing_is_told_with_the_robots_words(outcome, words):
    sentence = failure('goto 12', Result(outcome, 'No \x1b[2J goal', ()))
    assert sentence.startswith("Command 'goto 12' ")
    assert words in sentence
    assert sentence.endswith(r': No \x1b[2J goal.')


@pytest.mark.parametrize('outcome', [Outcome.SUCCEEDED, Outcome.INTERRUPTED, Outcome.CANCELLED])
def test_a_command_that_was_done_or_replaced_did_not_come_to_nothing(outcome):
    assert failure('goto 12', Result(outcome, '', ())) is None
