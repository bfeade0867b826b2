"""The dialect of a robot: the words of an LD-90, and ways in which other robots differ from it.

The default follows the sources (docs/explanation/sources.md). The fault `dialect` switches to the
other settings, for developers whose software must work with less exact robots.
"""
from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import Callable, Dict, Set, Tuple

from omron_ld90_sim.behaviour.robot import SimRobot
from omron_ld90_sim.behaviour.states import InterruptedWords

PROMPT = 'Enter password:'
WELCOME = ('Welcome to the server.',
           "You can type 'help' at any time for the following help list.")


class HelpLayout(Enum):
    """The layout of the help list, as a format string for name and description."""

    RIGHT = '{0:>15}          {1}'      # the LD-90's: name right-aligned, ten blanks
    LEFT = '{0:<28}{1}'                 # a long name touches its description
    NAMES = '{0}'                       # no descriptions
    NONE = ''                           # no list after the login, and an empty one on request


class Encoding(Enum):
    """The encoding of names that are not ASCII; by default as in the map file."""

    RAW = 'raw'
    ASCII = 'ascii'
    LATIN_1 = 'latin-1'

    def encode(self, line: str) -> bytes:
        """Returns the bytes of a line that the robot sends; unknown characters become `?`."""
        if self is Encoding.RAW:
            return line.encode('utf-8', 'surrogateescape')
        return line.encode(self.value, 'replace')

    def decode(self, line: bytes) -> str:
        """Returns the text of a line that the robot receives."""
        if self is Encoding.RAW:
            return line.decode('utf-8', 'surrogateescape')
        return line.decode(self.value, 'ignore')


@dataclass
class Dialect:
    """The words and settings of one robot's server; they differ between robots."""

    prompt: bytes = PROMPT.encode() + b'\r\n'
    welcome: Tuple[str, ...] = WELCOME
    help_layout: HelpLayout = HelpLayout.RIGHT
    unlisted: Set[str] = field(default_factory=set)     # commands that the help list omits
    missing: Set[str] = field(default_factory=set)      # commands that are unknown
    encoding: Encoding = Encoding.RAW
    quoted_goals: bool = False
    names_unknown: bool = True      # `Unknown command` names the command
    volts: bool = False             # the status has the battery's voltage, as in the manual
    extended: bool = True           # `status` begins with ExtendedStatusForHumans


def _prompt(dialect: Dialect, robot: SimRobot, text: str) -> None:
    dialect.prompt = text.encode()


def _welcome(dialect: Dialect, robot: SimRobot, text: str) -> None:
    dialect.welcome = (text,) if text else ()


def _help(dialect: Dialect, robot: SimRobot, text: str) -> None:
    dialect.help_layout = HelpLayout[text.upper()]


def _unlisted(dialect: Dialect, robot: SimRobot, text: str) -> None:
    dialect.unlisted = set(text.lower().split())


def _missing(dialect: Dialect, robot: SimRobot, text: str) -> None:
    dialect.missing = set(text.lower().split())


def _encoding(dialect: Dialect, robot: SimRobot, text: str) -> None:
    dialect.encoding = Encoding(text)


def _goals(dialect: Dialect, robot: SimRobot, text: str) -> None:
    dialect.quoted_goals = {'plain': False, 'quoted': True}[text]


def _interrupted(dialect: Dialect, robot: SimRobot, text: str) -> None:
    robot.quirks.interrupted_words = InterruptedWords(text)


def _replacing(dialect: Dialect, robot: SimRobot, text: str) -> None:
    robot.quirks.stops_to_replace = {'silent': False, 'stopping': True}[text]


def _unknown(dialect: Dialect, robot: SimRobot, text: str) -> None:
    dialect.names_unknown = {'bare': False, 'named': True}[text]


def _battery(dialect: Dialect, robot: SimRobot, text: str) -> None:
    dialect.volts = {'percent': False, 'volts': True}[text]


def _status(dialect: Dialect, robot: SimRobot, text: str) -> None:
    dialect.extended = {'older': False, 'newer': True}[text]


# the settings that can be switched; a wrong value raises ValueError or KeyError
SWITCHES: Dict[str, Callable[[Dialect, SimRobot, str], None]] = {
    'prompt': _prompt, 'welcome': _welcome, 'help': _help, 'unlisted': _unlisted,
    'missing': _missing, 'encoding': _encoding, 'goals': _goals, 'interrupted': _interrupted,
    'replacing': _replacing, 'unknown': _unknown, 'battery': _battery, 'status': _status,
}
