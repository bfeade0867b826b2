"""The words of a metadata line.

There is no escape character. A word that starts with `"` ends at the first `"` that is followed by
white space or the end of the line. Any other `"` is text. Lines of the vendor's tools can be
ambiguous under this rule, so an unchanged line is never composed again from its words.
"""
from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass
from typing import List

from omron_map.errors import FieldError
from omron_map.text import encode

BLANKS = ' \t\r\n\v\f'
_WORD = re.compile(r'"(?P<quoted>.*?)"(?=[ \t\r\n\v\f]|$)|(?P<bare>[^ \t\r\n\v\f]+)', re.DOTALL)


@dataclass(frozen=True)
class Token:
    """One word: its text without quotes, and its position in the line."""

    text: str
    start: int
    end: int
    quoted: bool


def tokenise(line: str) -> List[Token]:
    """Returns the words of `line`; raises FieldError if a quote is not closed."""
    words = []
    for match in _WORD.finditer(line):
        bare = match.group('bare')
        if bare is not None and bare.startswith('"'):
            raise FieldError(
                f'the quote at column {match.start() + 1} is not closed',
                expected='a closing quote followed by a blank or the end of the line')
        text = match.group('quoted') if bare is None else bare
        words.append(Token(text, match.start(), match.end(), bare is None))
    return words


def quoted(text: str, field: str) -> str:
    """Returns `text` in quotes; raises FieldError if a reader could not read the same text."""
    if '"' in text or any(unicodedata.category(letter) == 'Cc' for letter in text):
        raise FieldError(f'{text!r} cannot be written', field,
                         'no double quote, control character or line break')
    try:
        encode(text)
    except UnicodeEncodeError:
        raise FieldError(f'{text!r} cannot be written', field, 'letters of Unicode') from None
    return f'"{text}"'
