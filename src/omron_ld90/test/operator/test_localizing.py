"""The next score of a robot decides whether it is localized: the scan must fit the map."""
from __future__ import annotations

import pytest

from omron_arcl import parse_line
from omron_ld90.operator.localizing import (
    ASKED_FOR,
    SCORE_WITHIN,
    LocalizeQuestion,
    LocalizingWatch,
)
from omron_ld90.operator.notices import NoticeSeverity

PLACE = (1.0, 2.0)
WORDS = 'Localized to point'


@pytest.fixture
def localizing() -> LocalizingWatch:
    waiting = LocalizingWatch()
    waiting.begin(WORDS, PLACE, 100.0)
    return waiting


@pytest.mark.parametrize(('score', 'severity', 'words'), [
    ('0.060000', NoticeSeverity.BAD, 'probably elsewhere'),
    ('0.19', NoticeSeverity.BAD, 'localize it again'),
    ('0.2', NoticeSeverity.GOOD, 'score 0.20'), ('0.870000', NoticeSeverity.GOOD, 'score 0.87')])
@pytest.mark.parametrize('line', [
    'LocalizationScore: {}',
    'Status: Stopped StateOfCharge: 90 Location: 1 2 3 LocalizationScore: {} Temperature: 40'])
def test_the_answer_follows_from_the_score(localizing, line, score, severity, words):
    notice, place = localizing.observe(parse_line(line.format(score)))
    assert notice.severity is severity and notice.text.startswith(WORDS) and place == PLACE
    assert words in notice.text


def test_each_answer_is_given_once(localizing):
    score = parse_line('LocalizationScore: 0.87')
    assert localizing.observe(score) is not None
    assert localizing.observe(score) is None and localizing.check(1e9) is None


def test_other_lines_are_no_answer(localizing):
    assert localizing.observe(parse_line('Location: 1 2 3')) is None
    assert localizing.observe(parse_line('LocalizationScore: 0.87')) is not None


def test_without_a_score_the_answer_is_not_green(localizing):
    assert localizing.check(100.0 + SCORE_WITHIN) is None
    notice, place = localizing.check(100.1 + SCORE_WITHIN)
    assert notice.severity is NoticeSeverity.INFO and place == PLACE
    assert 'compare its laser points' in notice.text


def test_a_score_that_nobody_awaits_is_no_answer():
    assert LocalizingWatch().observe(parse_line('LocalizationScore: 0.06')) is None


def test_a_place_is_taken_only_if_it_is_chosen_twice_in_time():
    question = LocalizeQuestion()
    assert not question.is_confirmed(PLACE, 100.0)
    assert question.is_confirmed(PLACE, 100.0 + ASKED_FOR)
    assert not question.is_confirmed(PLACE, 101.0 + ASKED_FOR), 'each time it is asked anew'
    assert not question.is_confirmed((9.0, 9.0), 102.0 + ASKED_FOR), 'another place'
    assert not question.is_confirmed((9.0, 9.0), 103.0 + 2.0 * ASKED_FOR), 'too late'


def test_another_act_between_ends_the_question():
    question = LocalizeQuestion()
    question.is_confirmed(PLACE, 100.0)
    question.forget()
    assert not question.is_confirmed(PLACE, 101.0)
