"""Texts for RViz contain only letters that its font has."""
from __future__ import annotations

import pytest

from rviz_drawing.drawing import LONGEST_TEXT, colour, drawable, text


@pytest.mark.parametrize('words', ['Küche', 'Łódź 3', 'Ελλάδα', 'one\ntwo', "a 'b' \"c\""])
def test_what_rviz_has_is_left_as_it_is(words):
    assert drawable(words) == words


@pytest.mark.parametrize('words, drawn', [
    ('robot\u2019s \u201cdock\u201d', 'robot\'s "dock"'),
    ('5 \u20ac \u2013 10 \u20ac\u2026', '5 EUR - 10 EUR...'),
    ('Ti\u1ebfp', 'Tiep'), ('a\tb\u3000c', 'a b c')])
def test_what_it_lacks_becomes_what_is_next_to_it(words, drawn):
    assert drawable(words) == drawn


@pytest.mark.parametrize('words', ['門', '\x1b[2J', '\x00', '\u200b', '\ufffd', '\udcfc'])
def test_nothing_vanishes_and_nothing_unprintable_is_sent(words):
    assert drawable(words).startswith('?')


def test_a_text_has_an_end():
    assert len(drawable('x' * 100_000)) <= LONGEST_TEXT + 4


def test_a_text_marker_can_be_sent_whatever_it_says():
    marker = text('names', 0, 'K\udcfcche \u95e8', (1.0, 2.0), 0.3, colour(1.0, 1.0, 1.0))
    assert marker.text.encode('utf-8') == b'K?che ?'
