"""A command line of a client: its words, and the arguments of commands.

    queuePickup "goal 1" default xyz

Words are separated by blanks; a word with blanks is in quotation marks. `default` replaces an
argument that is left out.
"""
from __future__ import annotations

import re
from typing import List, NamedTuple

from omron_jobs.core.job_book import JobRefused

LONGEST = 127           # characters of an id, an echo or a reason
DEFAULT = 'default'
_WORD = re.compile(r'"([^"]*)"|(\S+)')
_INTEGER = re.compile(r'[+-]?\d{1,10}\Z', re.ASCII)


class CommandLine(NamedTuple):
    """A line in its parts.

    name -- first word, as typed
    rest -- the text after the first word, as typed
    """

    line: str
    name: str
    rest: str

    @property
    def words(self) -> List[str]:
        """The arguments, without quotation marks."""
        return [quoted or plain for quoted, plain in _WORD.findall(self.rest)]

    def word(self, index: int) -> str:
        """Returns an argument; empty: it was left out, or is `default`."""
        words = self.words
        found = words[index] if index < len(words) else ''
        return '' if found.lower() == DEFAULT else found

    def number(self, index: int, default: int) -> int:
        """Returns an argument that is a signed integer of 32 bits. Raises JobRefused."""
        word = self.word(index)
        if not word:
            return default
        if not _INTEGER.match(word) or not -2 ** 31 <= int(word) < 2 ** 31:
            raise JobRefused(f'needs a whole number in the place of "{word}"')
        return int(word)

    def text(self, index: int, what: str) -> str:
        """Returns an argument that is an id, an echo or a reason. Raises JobRefused.

        what -- the kind of text, for the error message
        """
        word = self.word(index)
        if len(word) > LONGEST or ' ' in word or '"' in word:
            raise JobRefused(f'needs a {what} of at most {LONGEST} characters, without blanks and '
                             'quotation marks')
        return word


def read_line(line: str) -> CommandLine:
    """Returns the parts of a line that has at least one word."""
    name, _, rest = line.strip().partition(' ')
    return CommandLine(line.strip(), name, rest.strip())
