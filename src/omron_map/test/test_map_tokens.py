"""Words of a metadata line: a quote ends only before white space, and there are no escapes."""
from __future__ import annotations

import pytest

from omron_map.errors import FieldError
from omron_map.tokens import quoted, tokenise


def texts(line: str) -> list:
    return [token.text for token in tokenise(line)]


@pytest.mark.parametrize('line, expected', [
    ('Cairn: Goal 1 2', ['Cairn:', 'Goal', '1', '2']),
    ('a  "b c"\t"" d ', ['a', 'b c', '', 'd']),
    ('"in"ner" x', ['in"ner', 'x']),
    ('"C:\\dir\\" x', ['C:\\dir\\', 'x']),
    ('"two  blanks\tand a tab"', ['two  blanks\tand a tab']),
    ('bare"quote x', ['bare"quote', 'x']),
    ('"Say "yes" or no" x', ['Say "yes', 'or', 'no"', 'x']),
    ('"no\u00a0break"', ['no\u00a0break']),
    ('', []),
])
def test_words_by_the_rule_of_the_format(line, expected):
    assert texts(line) == expected


def test_a_quote_that_is_never_closed_is_told_with_its_column():
    with pytest.raises(FieldError, match='column 3'):
        tokenise('a "b c')


def test_a_word_knows_its_place_in_the_line():
    line = 'a "b c" d'
    word = tokenise(line)[1]
    assert line[word.start:word.end] == '"b c"' and word.quoted


@pytest.mark.parametrize('text', ['say "hi"', 'two\nlines', 'a\0b', 'a\tb', '\x7f'])
def test_text_that_no_reader_would_get_back_is_not_written(text):
    with pytest.raises(FieldError):
        quoted(text, 'name')
