"""Each row of the table in `last_word` holds, and no command is carried out twice."""
from __future__ import annotations

from random import Random
from typing import List, Optional

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omron_arcl import Outcome
from omron_arcl.records import CommandFate
from omron_ld90.bridge.events import CommandEnded
from omron_ld90.bridge.last_word import RETRY, STOP, LastWord


def given_once(command: str = 'goto 12', epoch: Optional[int] = None) -> LastWord:
    """Returns a command that was given as number 5 at time 0."""
    word = LastWord(command, epoch)
    assert word.due(False, 0.0), 'the first attempt needs no link'
    word.give(5, 77)
    assert not word.due(True, 60.0)
    return word


def lost(command: str = 'goto 12') -> LastWord:
    word = given_once(command)
    word.ended(CommandEnded(5, Outcome.LOST, 'the link broke'), 1.0)
    return word


@pytest.mark.parametrize('command', ['goto 12', STOP])
def test_what_was_never_sent_is_given_again_once_the_link_stands(command):
    word = given_once(command)
    word.ended(CommandEnded(5, Outcome.NEVER_SENT, 'no link'), 1.0)
    assert not word.due(True, 1.0 + RETRY / 2)
    assert not word.due(False, 60.0)
    assert word.due(True, 1.0 + RETRY)
    assert (word.problem, word.is_taken) == ('no link', False)


@pytest.mark.parametrize('ending', [Outcome.NEVER_SENT, Outcome.LOST])
@pytest.mark.parametrize('told_first', [True, False])
def test_a_stop_that_the_controller_owes_is_not_given_again(ending, told_first):
    """A second stop when the link comes back would hide what others did during the outage."""
    word = given_once(STOP)
    news = [lambda: word.told((5, CommandFate.GIVEN), 1.0),
            lambda: word.ended(CommandEnded(5, ending, 'no link'), 1.0)]
    for tell in news if told_first else reversed(news):
        tell()
    assert (word.due(True, 60.0), word.is_taken, word.problem) == (False, True, 'no link')


@pytest.mark.parametrize('told', [
    (0, CommandFate.NOT_OBEYED), (4, CommandFate.OBEYED), (5, CommandFate.NOT_OBEYED)])
def test_a_lost_drive_is_given_again_if_the_robot_does_not_obey_it(told):
    word = lost()
    assert word.told(told, 2.0) is None
    assert word.due(True, 2.0)
    assert word.give(6, 77).number == 6


@pytest.mark.parametrize('ending', [Outcome.OVERRULED, Outcome.CANCELLED, Outcome.INTERRUPTED])
@pytest.mark.parametrize('fate', CommandFate)
def test_news_of_an_older_command_says_nothing_of_a_drive_that_the_controller_has_answered(
        ending, fate):
    """Otherwise the bridge would give an overruled drive again and again until `motion` comes."""
    word = given_once()
    word.ended(CommandEnded(5, ending, 'another command came first'), 1.0)
    assert word.told((4, fate), 1.0) is None
    assert (word.due(True, 1.0), word.is_lost) == (False, True)
    word.told((5, CommandFate.NOT_OBEYED), 1.2)
    assert word.due(True, 1.2)


@pytest.mark.parametrize('fate', [None, CommandFate.GIVEN, CommandFate.OBEYED, CommandFate.UNKNOWN])
def test_it_waits_as_long_as_the_robot_may_obey_it(fate):
    word = lost()
    assert word.told((5 if fate is not None else 0, fate), 2.0) is None
    assert (word.due(True, 60.0), word.is_lost) == (False, True)


@pytest.mark.parametrize('fate', [CommandFate.COMPLETED, CommandFate.FAILED])
def test_it_ends_as_the_controller_tells(fate):
    word = lost()
    assert word.told((5, fate), 2.0) is fate
    assert (word.due(True, 60.0), word.is_lost) == (False, False)


@pytest.mark.parametrize('fate', CommandFate)
def test_a_drive_whose_result_came_is_not_judged_by_motion(fate):
    word = given_once()
    assert word.told((5, fate), 2.0) is None
    assert not word.due(True, 60.0)


@pytest.mark.parametrize('ending', [Outcome.LOST, Outcome.NEVER_SENT])
def test_a_stop_is_given_until_the_controller_has_it(ending):
    word = given_once(STOP, 3)
    word.ended(CommandEnded(5, ending, 'gone'), 1.0)
    assert word.due(True, 1.0 + RETRY)
    assert word.give(6, 77).known_epoch == 3, 'it ends no newer drive of another giver'
    word.ended(CommandEnded(6, ending, 'gone'), 3.0)
    word.told((6, CommandFate.GIVEN), 3.1)
    assert (word.due(True, 60.0), word.is_taken, word.problem) == (False, True, 'gone')


def test_a_stop_that_the_robot_does_not_obey_is_with_the_controller():
    word = given_once(STOP, 3)
    word.ended(CommandEnded(5, Outcome.FAILED, 'the robot said nothing about it'), 1.0)
    assert (word.due(True, 60.0), word.is_taken) == (False, True)
    assert word.problem == 'the robot said nothing about it'


def test_a_drive_carries_the_present_epoch():
    assert LastWord('goto 12').give(5, 77).known_epoch == 77


@given(st.integers(0, 2 ** 32), st.sampled_from(['goto 12', STOP]))
def test_it_reaches_the_controller_once_and_never_twice(seed, command):
    """Answers and `motion` are lost or late; the controller takes each number at most once."""
    random, word = Random(seed), LastWord(command)
    taken: List[int] = []
    number, now = 0, 0.0
    for step in range(40):
        now += random.choice((0.1, 0.7, 1.5))
        faulty = step < 30 and random.random() < 0.5
        if word.due(not faulty, now):
            number += 1
            word.give(number, 77)
            if faulty:
                word.ended(CommandEnded(number, random.choice((Outcome.LOST, Outcome.NEVER_SENT))),
                           now)
            else:
                taken.append(number)
                if random.random() < 0.7:
                    word.ended(CommandEnded(number, Outcome.LOST), now)
        elif not faulty:
            last = (taken[-1], CommandFate.OBEYED) if taken else (0, CommandFate.NOT_OBEYED)
            word.told(last, now)
    assert len(taken) == 1 or command == STOP and taken
