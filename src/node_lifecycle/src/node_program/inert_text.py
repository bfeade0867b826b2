"""Makes text from others harmless for a terminal, a log, or a spreadsheet that shows it.

Control characters can move the cursor of a terminal, erase lines, change the title, or type input.
A spreadsheet calculates a cell that begins like a formula.
"""
from __future__ import annotations

import io
import re
import sys
from typing import Any

LONGEST_ENTRY = 4000
"""Largest number of characters in a log entry. The rest of a longer entry is only counted."""

# C0 and C1 except tab and line feed, and characters that change the order of letters in a line
_ACTIVE = re.compile('[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069]')
_FORMULA = ('=', '+', '-', '@', '\uff1d', '\uff0b', '\uff0d', '\uff20')
_NUMBERS = re.compile(r'[-+]?[\d.][\d.,eE%: -]*\Z')


def inert(text: str) -> str:
    """Returns the text with its control characters escaped, except tabs and line ends."""
    return _ACTIVE.sub(lambda found: found.group().encode('unicode_escape').decode(), text)


def entry(text: str) -> str:
    """Returns an entry for a log: inert, and at most LONGEST_ENTRY characters."""
    left_out = len(text) - LONGEST_ENTRY
    if left_out > 0:
        text = f'{text[:LONGEST_ENTRY]}... ({left_out} more characters)'
    return inert(text)


def cell(text: str) -> str:
    """Returns a cell of a CSV file: inert, and never a formula. Numbers stay unchanged."""
    text = inert(text)
    is_formula = text.lstrip().startswith(_FORMULA) and not _NUMBERS.match(text)
    return f"'{text}" if is_formula else text


class InertStream(io.TextIOWrapper):
    """An output stream that escapes control characters in everything that is printed."""

    def write(self, text: str) -> int:
        """Writes the text."""
        return super().write(inert(text))

    def return_to_line_begin(self) -> None:
        """Makes the next text replace the present line of a terminal."""
        super().write('\r')


def return_to_line_begin(stream: Any) -> None:
    """Makes the next text replace the present line of a terminal, on any stream."""
    if isinstance(stream, InertStream):
        stream.return_to_line_begin()
    else:
        stream.write('\r')


def make_output_inert() -> None:
    """Replaces the standard output streams of this process by inert ones."""
    for name in ('stdout', 'stderr'):
        stream = getattr(sys, name)
        if type(stream) is io.TextIOWrapper:
            stream.flush()
            setattr(sys, name, InertStream(
                stream.buffer, encoding=stream.encoding, errors='backslashreplace',
                line_buffering=stream.line_buffering, write_through=stream.write_through))
