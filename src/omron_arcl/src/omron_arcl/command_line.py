"""One command line for the robot: reads, checks and quotes it."""
from __future__ import annotations

from typing import Callable, Mapping, Optional

from omron_arcl.command_table import COMMANDS, spec_of
from omron_arcl.commands import Command
from omron_arcl.errors import InvalidCommand
from omron_arcl.readers import split_words
from omron_arcl.replies import readable
from omron_arcl.secret import redact_passwords

LONGEST_COMMAND = 5000  # bytes; the server drops a client that sends more


def parse_command(text: str, full_name: Callable[[str], Optional[str]] = lambda name: None,
                  names: Optional[Mapping[str, bytes]] = None) -> Command:
    """Reads a command line; raises InvalidCommand.

    full_name: returns the command for a shortcut that the table does not have, for example
    `HelpList.full_name`. names: the bytes of each name that the robot has listed and that is not
    ASCII, for example `Client.names`. ARCL accepts no other characters outside ASCII.
    """
    text = text.strip(' ')
    if is_stop(text):
        text = text.split()[0]  # text after the word must not prevent a stop
    reason = _reason_against(text)
    if reason:
        raise InvalidCommand(printable(text), reason)
    line = _encode(text, names or {})
    if len(line) > LONGEST_COMMAND:
        raise InvalidCommand(printable(text), f'it has {len(line)} bytes, but the robot accepts '
                             f'at most {LONGEST_COMMAND}')
    name, _, rest = text.partition(' ')
    spec = spec_of(name)
    if spec.name.lower() not in COMMANDS:
        spec = spec_of(full_name(name) or name)
    arguments = tuple(split_words(rest))
    if len(arguments) < spec.required:
        raise InvalidCommand(printable(text), f'its syntax is "{spec.syntax}"')
    return Command(text, line, spec.name, arguments, spec)


def is_stop(text: str) -> bool:
    """Returns whether a command line is a stop. Any text may follow the word `stop`."""
    words = text.split(maxsplit=1)
    return bool(words) and spec_of(words[0]).stops


def _reason_against(text: str) -> str:
    """Returns the reason why `text` is not one command line; empty if it is one."""
    if not text:
        return 'it is empty'
    if len(text) > LONGEST_COMMAND:
        return (f'it has {len(text)} characters, but the robot accepts at most '
                f'{LONGEST_COMMAND}')
    if not text.isprintable():
        return 'it contains a line end, another control character or an unprintable character'
    return ''


def _encode(text: str, names: Mapping[str, bytes]) -> bytes:
    """Returns the bytes of a line; raises InvalidCommand if a character cannot be sent."""
    if text.isascii():
        return text.encode('ascii')
    for name in sorted(names, key=len, reverse=True):
        at = _find(name, text)
        if at >= 0:
            return (_encode(text[:at], names) + names[name]
                    + _encode(text[at + len(name):], names))
    strange = next(character for character in text if not character.isascii())
    raise InvalidCommand(printable(text), f'"{strange}" is not ASCII; ARCL accepts such '
                         'characters only in names that the robot has listed')


def _find(name: str, text: str) -> int:
    """Returns the index of `name` in `text`, or -1 if `text` does not contain `name`.

    If no part of `text` is exactly `name`, case is ignored.
    """
    at = text.find(name)
    folded, sought = text.casefold(), name.casefold()
    if at < 0 and len(folded) == len(text) and len(sought) == len(name):
        at = folded.find(sought)
    return at


def printable(text: str, longest: int = 200) -> str:
    """Returns `text` for logs and terminals: shortened, without passwords, and with control
    characters escaped.
    """
    shown = redact_passwords(text.encode('utf-8', 'backslashreplace')).decode('utf-8')
    if not shown.isprintable():
        shown = ''.join(character if character.isprintable()
                        else character.encode('unicode_escape').decode('ascii')
                        for character in shown[:longest + 1])
    return shown if len(shown) <= longest else shown[:longest - 3] + '...'


def quote(name: str) -> str:
    """Returns the name of a goal, route or other object as an argument of a command.

    A name with a blank is put in double quotes. Raises InvalidCommand for a name that ARCL cannot
    express.
    """
    name = readable(name)
    reason = _reason_against(name) or ('it contains a double quote' if '"' in name else '')
    if reason:
        raise InvalidCommand(printable(name), f'no goal can have such a name, {reason}')
    return f'"{name}"' if ' ' in name else name
