"""A command that was given to the robot, as its giver sees it."""
from __future__ import annotations

import threading
from dataclasses import dataclass, field
from enum import Enum
from typing import Callable, List, NamedTuple, Optional, Set, Tuple

from omron_arcl.activity import Activity
from omron_arcl.commands import ACKNOWLEDGE_TIMEOUT, Command

MAXIMUM_LINES = 10_000  # maximum number of lines that are kept for one command
MAXIMUM_CHARACTERS = 4_000_000  # maximum number of characters in these lines


class Outcome(Enum):
    """How a command ended."""

    SUCCEEDED = 'succeeded'
    REJECTED = 'rejected'  # the robot did not accept the command
    NO_GOAL = 'no such goal'
    UNKNOWN_COMMAND = 'unknown command'
    FAILED = 'failed'  # the robot tried and gave up, with a reason
    EMERGENCY_STOPPED = 'emergency stop'
    INTERRUPTED = 'interrupted'  # by another command, or by another client's stop
    CANCELLED = 'cancelled'  # its giver or another giver cancelled it
    TIMED_OUT = 'timed out'  # the robot sent no more lines about it
    LOST = 'lost'  # the link broke; the robot may still be driving
    NEVER_SENT = 'never sent'  # it certainly did not reach the robot
    OVERRULED = 'overruled'  # never sent: the command of another giver came first


@dataclass(frozen=True)
class Result:
    """How a command ended. `words` are the robot's words, or ours if the robot gave none.

    `lines` are the lines that belonged to the command. `left_out` is the number of lines that were
    dropped because of the limits.
    """

    outcome: Outcome
    words: str
    lines: Tuple[str, ...]
    left_out: int = 0


@dataclass
class CommandProgress:
    """The progress of a command since it was sent, as the queue and the attribution note it.
    The command's record says whether the robot obeys, and whether this is doubted; see `drives`.

    epoch -- the epoch in which the command was given
    sent_at -- when the command was sent
    heard -- when the last line about it came
    shown_when_sent -- the activity in the last status before the command was sent
    set_out -- whether the robot stood when the command was sent, and has since left the dock or
        driven to it
    seemed_to_begin -- the line with which the robot seemed to set out for the command, before it
        acknowledged the command
    cancel_requested -- when a giver cancelled the command
    stopping -- whether a stop was given because of this cancellation
    rejected_at -- when `CommandError` came; the reason follows in another line
    points -- the coordinates that the robot showed as its goal
    dock_name -- the goal's name that the robot shows while it drives to its dock
    """

    epoch: int = 0
    sent_at: float = 0.0
    heard: float = 0.0
    shown_when_sent: Optional[Activity] = None
    set_out: bool = False
    seemed_to_begin: str = ''
    cancel_requested: Optional[float] = None
    stopping: bool = False
    rejected_at: Optional[float] = None
    points: Set[Tuple[float, ...]] = field(default_factory=set)
    dock_name: str = ''

    def begin(self, now: float, shown: Optional[Activity]) -> None:
        """Notes that the command is sent."""
        self.heard = self.sent_at = now
        self.shown_when_sent = shown


class Giver(NamedTuple):
    """A program that gives commands; an earlier run with the same name has another `process`."""

    name: str
    process: str = ''


NO_GIVER = Giver('')


class _KeptLines:
    """The lines of one command, up to the limits."""

    def __init__(self) -> None:
        self.kept: List[str] = []
        self.left_out = 0
        self._characters = 0

    def add(self, text: str) -> None:
        """Keeps a line if there is room."""
        self._characters += len(text)
        if len(self.kept) < MAXIMUM_LINES and self._characters <= MAXIMUM_CHARACTERS:
            self.kept.append(text)
        else:
            self.left_out += 1


class Execution:
    """A command given to the robot. `result` is None until it has ended; readable by any thread.

    The class has many attributes: they are all that the giver says about one command, and all that
    the giver gets back. Only this package uses `progress`.
    """

    def __init__(self, command: Command, timeout: Optional[float] = None,
                 on_line: Optional[Callable[[str], None]] = None,
                 on_end: Optional[Callable[[Result], None]] = None,
                 stop_on_timeout: bool = False, giver: Giver = NO_GIVER,
                 known_epoch: int = 0, number: int = 0) -> None:
        self.command = command
        self.number = number
        self.giver = giver
        self.known_epoch = known_epoch
        self.result: Optional[Result] = None
        self.on_line = on_line
        self.on_end = on_end
        self.timeout = timeout or command.spec.timeout  # s without a line about it
        self.acknowledge_timeout = timeout or min(command.spec.timeout, ACKNOWLEDGE_TIMEOUT)
        self.stop_on_timeout = stop_on_timeout
        self.order = 0  # its number in the order of sending; 0: not sent yet
        self.progress = CommandProgress()
        self._lines = _KeptLines()
        self._ended = threading.Event()

    @property
    def sent(self) -> bool:
        """Whether the command was sent to the robot."""
        return self.order > 0

    @property
    def is_answered(self) -> bool:
        """Whether the command has no documented answer, and a line came that may be its answer."""
        return (self.command.spec.completed_by is None and self.progress.rejected_at is None
                and self.progress.heard > self.progress.sent_at)

    @property
    def has_lines(self) -> bool:
        """Whether the robot has sent any line about the command."""
        return bool(self._lines.kept)

    def add_line(self, text: str) -> None:
        """Adds a line that belongs to the command."""
        self._lines.add(text)

    def end(self, outcome: Outcome, words: str) -> bool:
        """Sets the result once; returns whether this call set it."""
        if self.result is not None:
            return False
        self.result = Result(outcome, words, tuple(self._lines.kept), self._lines.left_out)
        return True

    def announce(self) -> None:
        """Wakes the threads in `wait` and calls `on_end`. Called after `end`, without locks."""
        self._ended.set()
        if self.on_end and self.result:
            self.on_end(self.result)

    def wait(self, timeout: Optional[float] = None) -> Optional[Result]:
        """Returns the result, or None if the command has not ended within `timeout` seconds.

        Do not call it from a callback: the thread that runs callbacks also ends the commands.
        """
        return self.result if self._ended.wait(timeout) else None
