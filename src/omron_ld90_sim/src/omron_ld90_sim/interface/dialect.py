"""How a robot speaks: as an LD-90 does, and in ways in which other robots differ.

The default is what the sources tell (docs/explanation/sources.md). Everything else is for
developers whose software has to get along with robots that are less exact; the fault
`dialect` switches it on.
"""
from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import Callable, Dict, Set, Tuple

from omron_ld90_sim.behaviour.robot import Robot
from omron_ld90_sim.behaviour.states import InterruptedWords

PROMPT = 'Enter password:'
WELCOME = ('Welcome to the server.',
           "You can type 'help' at any time for the following help list.")


class HelpLayout(Enum):
    """How the help list is set, as formats of name and description."""

    RIGHT = '{0:>15}          {1}'      # the LD-90's: name right-aligned, ten blanks
    LEFT = '{0:<28}{1}'                 # a long name touches its description
    NAMES = '{0}'                       # no descriptions
    NONE = ''                           # no list after the login, and an empty one on demand


class Encoding(Enum):
    """What becomes of names that are not ASCII; the map's bytes as they are, by default."""

    RAW = 'raw'
    ASCII = 'ascii'
    LATIN_1 = 'latin-1'

    def encode(self, line: str) -> bytes:
        """A line as the robot sends it; what the encoding does not have becomes `?`."""
        if self is Encoding.RAW:
            return line.encode('utf-8', 'surrogateescape')
        return line.encode(self.value, 'replace')

    def decode(self, line: bytes) -> str:
        """A line as the robot reads it."""
        if self is Encoding.RAW:
            return line.decode('utf-8', 'surrogateescape')
        return line.decode(self.value, 'ignore')


@dataclass
class Dialect:
    """What one robot's server says where robots differ."""

    prompt: bytes = PROMPT.encode() + b'\r\n'
    welcome: Tuple[str, ...] = WELCOME
    help_layout: HelpLayout = HelpLayout.RIGHT
    unlisted: Set[str] = field(default_factory=set)     # commands that the help list leaves out
    missing: Set[str] = field(default_factory=set)      # and those that are unknown
    encoding: Encoding = Encoding.RAW
    quoted_goals: bool = False


def _prompt(dialect: Dialect, robot: Robot, text: str) -> None:
    dialect.prompt = text.encode()


def _welcome(dialect: Dialect, robot: Robot, text: str) -> None:
    dialect.welcome = (text,) if text else ()


def _help(dialect: Dialect, robot: Robot, text: str) -> None:
    dialect.help_layout = HelpLayout[text.upper()]


def _unlisted(dialect: Dialect, robot: Robot, text: str) -> None:
    dialect.unlisted = set(text.lower().split())


def _missing(dialect: Dialect, robot: Robot, text: str) -> None:
    dialect.missing = set(text.lower().split())


def _encoding(dialect: Dialect, robot: Robot, text: str) -> None:
    dialect.encoding = Encoding(text)


def _goals(dialect: Dialect, robot: Robot, text: str) -> None:
    dialect.quoted_goals = {'plain': False, 'quoted': True}[text]


def _interrupted(dialect: Dialect, robot: Robot, text: str) -> None:
    robot.interrupted_words = InterruptedWords(text)


# what can be switched, and to what; a wrong value raises ValueError or KeyError
SWITCHES: Dict[str, Callable[[Dialect, Robot, str], None]] = {
    'prompt': _prompt, 'welcome': _welcome, 'help': _help, 'unlisted': _unlisted,
    'missing': _missing, 'encoding': _encoding, 'goals': _goals, 'interrupted': _interrupted,
}
