"""A command under way, as its giver sees it."""
from __future__ import annotations

import math
import threading
from dataclasses import dataclass
from enum import Enum
from typing import Callable, List, NamedTuple, Optional, Set, Tuple

from omron_arcl.commands import ACKNOWLEDGE_TIMEOUT, Command

MAXIMUM_LINES = 10_000  # kept of one command's lines,
MAXIMUM_CHARACTERS = 4_000_000  # and of what they hold


class Outcome(Enum):
    """How a command ended."""

    SUCCEEDED = 'succeeded'
    REJECTED = 'rejected'  # the robot did not take the command
    NO_GOAL = 'no such goal'
    UNKNOWN_COMMAND = 'unknown command'
    FAILED = 'failed'  # the robot tried, and said why it gave up
    EMERGENCY_STOPPED = 'emergency stop'
    INTERRUPTED = 'interrupted'  # another command, or a stop that was not ours
    CANCELLED = 'cancelled'  # we asked for it
    TIMED_OUT = 'timed out'  # the robot fell silent about it
    LOST = 'lost'  # the link broke; the robot may still be driving
    NEVER_SENT = 'never sent'  # it certainly did not reach the robot
    OVERRULED = 'overruled'  # never sent: the command of another giver came first


@dataclass(frozen=True)
class Result:
    """How a command ended: `words` are the robot's, or ours where it said nothing.

    `lines` are those that belonged to the command; `left_out` counts the ones beyond what is kept.
    """

    outcome: Outcome
    words: str
    lines: Tuple[str, ...]
    left_out: int = 0


@dataclass
class Doubt:
    """The robot says something else than that it carries the command out.

    outcome, words: how the command ends if this holds. since: when it was said first, `count`:
    how often since. broken_off: an `Interrupted` was said that names something unknown.
    """

    outcome: Outcome
    words: str
    since: float
    count: int = 1
    broken_off: bool = False


class Giver(NamedTuple):
    """A program that gives commands; `process` tells it from the one that had its name before."""

    name: str
    process: str = ''


NO_GIVER = Giver('')


class Execution:
    """A command given to the robot. `result` is None until it has ended; any thread may ask."""

    def __init__(self, command: Command, timeout: Optional[float] = None,
                 on_line: Optional[Callable[[str], None]] = None,
                 on_end: Optional[Callable[[Result], None]] = None,
                 stop_on_timeout: bool = False, giver: Giver = NO_GIVER,
                 known_epoch: int = 0) -> None:
        self.command = command
        self.giver = giver
        self.known_epoch = known_epoch
        self.result: Optional[Result] = None
        self.on_line = on_line
        self.on_end = on_end
        # Kept by the dispatcher, its queue, its attribution and its watch:
        self.timeout = timeout or command.spec.timeout  # s without a word about it
        self.acknowledge_timeout = timeout or min(command.spec.timeout, ACKNOWLEDGE_TIMEOUT)
        self.stop_on_timeout = stop_on_timeout
        self.epoch = 0  # in which it was taken
        self.replaces = False  # a drive that was under way when it was taken
        self.over_at = -math.inf
        self.sent_at = 0.0
        self.heard: Optional[float] = None  # when it was sent, or last heard of
        self.order = 0  # of sending
        self.begun = False  # the robot has acknowledged it
        self.set_out = False  # it stood, and moves since: it leaves the dock, or drives to it
        self.cancel_requested: Optional[float] = None  # when
        self.stopping = False  # a stop was given because of that
        self.rejected_at: Optional[float] = None  # CommandError came, its description is awaited
        self.doubt: Optional[Doubt] = None
        self.shown_when_sent = ''  # the robot's status text then
        self.points: Set[Tuple[float, ...]] = set()  # that the robot showed for its goal
        self._lines: List[str] = []
        self._characters = 0
        self._left_out = 0
        self._ended = threading.Event()

    @property
    def sent(self) -> bool:
        """Whether the command has gone to the robot."""
        return self.heard is not None

    def add_line(self, text: str) -> None:
        """A line that belongs to the command."""
        self._characters += len(text)
        if len(self._lines) < MAXIMUM_LINES and self._characters <= MAXIMUM_CHARACTERS:
            self._lines.append(text)
        else:
            self._left_out += 1

    def end(self, outcome: Outcome, words: str) -> bool:
        """Sets the result, once; whether this was the time."""
        if self.result is not None:
            return False
        self.result = Result(outcome, words, tuple(self._lines), self._left_out)
        return True

    def announce(self) -> None:
        """Tells the waiting callers; called after `end`, without locks held."""
        self._ended.set()
        if self.on_end and self.result:
            self.on_end(self.result)

    def wait(self, timeout: Optional[float] = None) -> Optional[Result]:
        """The result, or None if the command has not ended within `timeout` seconds.

        Not from a callback: the thread that calls it is the one that would end the command.
        """
        return self.result if self._ended.wait(timeout) else None
