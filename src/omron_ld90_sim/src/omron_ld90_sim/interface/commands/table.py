"""The command table: every ARCL command with its help text, arguments and handler."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Dict, Iterable, List, Optional

from omron_ld90_sim.behaviour.robot import SimRobot
from omron_ld90_sim.behaviour.task import split_words
from omron_ld90_sim.devices.equipment import find_name
from omron_ld90_sim.interface.dialect import Dialect, HelpLayout
from omron_ld90_sim.interface.server import ArclServer
from omron_ld90_sim.interface.session import SimSession


class CommandFailed(Exception):
    """A command cannot be done: it is answered with CommandError and CommandErrorDescription."""


class NotReady(Exception):
    """A command came in the wrong order, or a file or a feature that it needs is missing."""


@dataclass(frozen=True)
class CommandCall:
    """One command line that is being answered."""

    server: ArclServer
    session: SimSession
    line: str           # as typed, with variables expanded
    rest: str           # the text after the command's name, as typed

    @property
    def robot(self) -> SimRobot:
        """The robot of this server."""
        return self.server.robot

    @property
    def arguments(self) -> List[str]:
        """The arguments, without their quotes."""
        return split_words(self.rest)

    @property
    def text(self) -> str:
        """Everything after the name as one string, without quotes around it."""
        text = self.rest.strip()
        if len(text) >= 2 and text[0] == text[-1] == '"':
            return text[1:-1]
        return text

    def reply(self, line: str) -> None:
        """Sends a line to the client that gave the command, to no other client."""
        self.session.send(line)

    def named(self, names: Iterable[str], what: str) -> str:
        """Returns the name in `names` that equals the first argument, ignoring case.

        Raises CommandFailed if there is none; `what` is the kind of thing, for the error's text.
        """
        name = find_name(names, self.arguments[0])
        if name is None:
            raise CommandFailed(f"No {what} '{self.arguments[0]}'")
        return name

    def number(self, index: int, default: Optional[float] = None) -> float:
        """Returns the argument at `index` as a number."""
        arguments = self.arguments
        if index >= len(arguments) and default is not None:
            return default
        try:
            value = float(arguments[index])
        except (IndexError, ValueError):
            given = arguments[index] if index < len(arguments) else ''
            raise CommandFailed(f"Bad number '{given}'") from None
        if not -2147483648 <= value <= 2147483647:
            raise CommandFailed(f"Bad number '{arguments[index]}'")
        return value


Handler = Callable[[CommandCall], None]


@dataclass(frozen=True)
class CommandRow:
    """One row of the table."""

    name: str
    description: str
    usage: str
    required: int          # the least number of arguments
    shortcut: str
    handler: Handler

    def help_line(self, layout: HelpLayout) -> str:
        """Returns the row in the help list."""
        shortcut = f' [{self.shortcut}]' if self.shortcut else ''
        return layout.value.format(self.name, self.description + shortcut)


TABLE: Dict[str, CommandRow] = {}


def command(name: str, description: str, usage: str = '', required: int = 0,
            shortcut: str = '') -> Callable[[Handler], Handler]:
    """Adds a handler to the table under its name and shortcut, both case-insensitive."""
    def enter(handler: Handler) -> Handler:
        row = CommandRow(name, description, f'{name} {usage}'.strip(), required, shortcut, handler)
        for key in filter(None, (name.lower(), shortcut.lower())):
            assert key not in TABLE, f'two commands named {key}'
            TABLE[key] = row
        return handler

    return enter


def help_lines(dialect: Dialect) -> List[str]:
    """Returns the command list in the form in which the server prints it."""
    hidden = dialect.unlisted | dialect.missing
    rows = sorted((row for row in set(TABLE.values()) if row.name.lower() not in hidden),
                  key=lambda row: row.name.lower())
    if dialect.help_layout is HelpLayout.NONE:
        rows = []
    return ['Commands:', *(row.help_line(dialect.help_layout) for row in rows), 'End of commands']
