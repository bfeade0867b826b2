"""Which of the robot's lines people are told, and how."""
from __future__ import annotations

import pytest

from omron_ld90.operator.arcl_news import News, NewsReader, Tone


@pytest.mark.parametrize('line, news', [
    ('Going to 12', News(Tone.NEWS, 'Going to 12', '12')),
    ('Arrived at Meeting room', News(Tone.GOOD, 'Arrived at Meeting room', 'Meeting room')),
    ('Interrupted: Going to 12', News(Tone.NEWS, 'Interrupted: Going to 12')),
    ('Error: Failed going to goal', News(Tone.BAD, 'Error: Failed going to goal')),
    ("CommandErrorDescription: No goal '99'", News(Tone.BAD, "No goal '99'")),
    ('Stopped', News(Tone.NEWS, 'Stopped')),
])
def test_what_the_robot_does_is_told_in_its_own_words(line, news):
    assert NewsReader().read(line) == news


@pytest.mark.parametrize('line', [
    'Goal: 12', 'End of goals', 'StateOfCharge: 79.4', 'Location: 1 2 3', '', 'no such line'])
def test_answers_to_questions_are_no_news(line):
    assert NewsReader().read(line) is None


def docking(state: str, charge: str) -> str:
    return f'DockingState: {state} ForcedState: Unforced ChargeState: {charge}'


def test_docking_is_told_when_it_changes_and_not_with_every_phase_of_the_charger():
    reader = NewsReader()
    told = [reader.read(line) for line in (
        docking('Undocked', 'Not'), docking('Docking', 'Not'), docking('Docking', 'Bulk'),
        docking('Docked', 'Bulk'), docking('Docked', 'Overcharge'))]
    assert told == [None, News(Tone.NEWS, 'Docking'), None, News(Tone.GOOD, 'Docked'), None]
