"""Which command would only repeat the drive that the robot obeys."""
from __future__ import annotations

from typing import Optional

import pytest

from omron_arcl import Execution, Giver, Outcome
from omron_arcl.command_line import parse_command
from omron_ld90.nodes.controller_repeats import ObeyedDrive

PERSON, FLEET = Giver('/person', 'a'), Giver('/fleet', 'b')


def after(*texts: str, giver: Giver = PERSON) -> ObeyedDrive:
    drive = ObeyedDrive()
    for text in texts:
        drive.given(Execution(parse_command(text), giver=giver))
    return drive


def repeats(drive: ObeyedDrive, text: str, giver: Giver = PERSON, epoch: int = 0) -> bool:
    return drive.same_as(text, giver, epoch) is not None


@pytest.mark.parametrize('text', ['goto 12', 'goto 12 90', 'gotoPoint 1000 -200 90',
                                  'gotoRouteGoal tour 12', 'dock', ' goto 12 '])
def test_a_drive_to_a_place_is_repeated_by_the_same_words_of_the_same_giver(text):
    assert repeats(after(text), text)
    assert repeats(after(text, 'getGoals', 'say hello'), text)


@pytest.mark.parametrize('text', ['move 1000', 'patrolOnce tour', 'queueDropoff 12', 'say hello',
                                  'undock', 'stop', 'localizeToPoint 1 2 3'])
def test_a_command_that_is_meant_again_each_time_is_never_a_repetition(text):
    assert not repeats(after(text), text)


@pytest.mark.parametrize('text, giver, epoch', [
    ('goto 13', PERSON, 0), ('goto 12 90', PERSON, 0), ('goto 12', FLEET, 0),
    ('goto 12', Giver('/person', 'restarted'), 0), ('goto 12', PERSON, 7)])
def test_another_command_giver_or_epoch_is_no_repetition(text, giver, epoch):
    assert not repeats(after('goto 12'), text, giver, epoch)


@pytest.mark.parametrize('between', ['stop', 'goto 13', 'undock', 'move 100'])
def test_after_other_motion_the_same_drive_is_given_anew(between):
    assert not repeats(after('goto 12', between), 'goto 12')


@pytest.mark.parametrize('outcome', [None, *Outcome])
def test_after_its_end_and_its_cancellation_a_drive_is_given_anew(outcome: Optional[Outcome]):
    drive, execution = ObeyedDrive(), Execution(parse_command('goto 12'), giver=PERSON)
    drive.given(execution)
    assert repeats(drive, 'goto 12')
    if outcome is None:
        execution.cancel_requested = 1.0
    else:
        execution.end(outcome, '')
    assert not repeats(drive, 'goto 12')
