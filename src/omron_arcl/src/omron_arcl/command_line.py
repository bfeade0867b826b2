"""One line for the robot: read, checked, quoted."""
from __future__ import annotations

from typing import Callable, Optional

from omron_arcl.command_table import spec_of
from omron_arcl.commands import Command
from omron_arcl.errors import InvalidCommand
from omron_arcl.readers import split_words
from omron_arcl.secret import blank_configured

LONGEST_COMMAND = 5000  # characters; the server drops a client that sends more


def parse_command(text: str, full_name: Callable[[str], Optional[str]] = lambda name: name
                  ) -> Command:
    """Reads a command line; raises InvalidCommand.

    `full_name` resolves shortcuts, e.g. `HelpList.full_name`; a name that it does not know stays
    as it is.
    """
    text = text.strip(' ')
    reason = _unsendable(text)
    if reason:
        raise InvalidCommand(printable(text), reason)
    name, _, rest = text.partition(' ')
    spec = spec_of(full_name(name) or name)
    arguments = tuple(split_words(rest))
    if len(arguments) < spec.required:
        raise InvalidCommand(printable(text), f'its syntax is "{spec.syntax}"')
    return Command(text, spec.name, arguments, spec)


def _unsendable(text: str) -> str:
    """Why `text` is not one command line; empty if it is."""
    if not text:
        return 'it is empty'
    if len(text) > LONGEST_COMMAND:
        return f'it has {len(text)} characters, the robot takes {LONGEST_COMMAND}'
    if not all(' ' <= character <= '~' for character in text):
        return 'it holds a line end, another control character, or one that is not ASCII'
    return ''


def printable(text: str, longest: int = 200) -> str:
    """`text` fit for a log: control characters escaped, shortened, without passwords."""
    shown = blank_configured(text.encode('unicode_escape', 'replace')).decode('ascii')
    return shown if len(shown) <= longest else shown[:longest - 3] + '...'


def quote(name: str) -> str:
    """`name` of a goal, route, ... as an argument: in double quotes where it holds a blank.

    Raises InvalidCommand for a name that ARCL cannot express.
    """
    reason = _unsendable(name) or ('it holds a double quote' if '"' in name else '')
    if reason:
        raise InvalidCommand(printable(name), f'no goal can have such a name, {reason}')
    return f'"{name}"' if ' ' in name else name
