"""A command under way, as the one who gave it sees it."""
from __future__ import annotations

import threading
from dataclasses import dataclass
from enum import Enum
from typing import Callable, List, Optional, Tuple

from omron_arcl.commands import Command

_MOST_LINES = 10_000  # kept of one command's lines


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


@dataclass(frozen=True)
class Result:
    """How a command ended: `words` are the robot's, or ours where it said nothing."""

    outcome: Outcome
    words: str
    lines: Tuple[str, ...]


class Execution:
    """A command given to the robot. `result` is None until it has ended; any thread may ask."""

    def __init__(self, command: Command, silence: Optional[float],
                 on_line: Optional[Callable[[str], None]] = None,
                 on_end: Optional[Callable[[Result], None]] = None) -> None:
        self.command = command
        self.result: Optional[Result] = None
        self.on_line = on_line
        self.on_end = on_end
        # Kept by the dispatcher, its queue and its attribution:
        self.silence = silence
        self.heard: Optional[float] = None  # when it was sent, or its last line came
        self.order = 0  # of sending
        self.begun = False
        self.cancel_requested = False
        self.stopping = False  # a stop was given because of that
        self.rejected = False  # CommandError came, its description is awaited
        self._lines: List[str] = []
        self._ended = threading.Event()

    @property
    def sent(self) -> bool:
        """Whether the command has gone to the robot."""
        return self.heard is not None

    def add_line(self, text: str) -> None:
        """A line that belongs to the command."""
        if len(self._lines) < _MOST_LINES:
            self._lines.append(text)

    def end(self, outcome: Outcome, words: str) -> bool:
        """Sets the result, once; whether this was the time."""
        if self.result is not None:
            return False
        self.result = Result(outcome, words, tuple(self._lines))
        return True

    def announce(self) -> None:
        """Tells those who wait; called after `end`, without locks held."""
        self._ended.set()
        if self.on_end:
            self.on_end(self.result)

    def wait(self, timeout: Optional[float] = None) -> Optional[Result]:
        """The result, or None if the command has not ended within `timeout` seconds.

        Not from a callback: the thread that calls it is the one that would end the command.
        """
        return self.result if self._ended.wait(timeout) else None
