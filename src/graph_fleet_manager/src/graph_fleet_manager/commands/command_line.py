"""The parts that all commands share: exit statuses, errors, and the parser. They need no ROS."""
from __future__ import annotations

import argparse
from typing import NoReturn

OK, WRONG, NOT_DONE = 0, 1, 2
"""Exit statuses. OK: done; WRONG: wrong input, or no fleet manager; NOT_DONE: refused or failed."""
LARGEST = 2 ** 31 - 1
"""The largest number that a message to the fleet manager can hold."""


def whole(text: str) -> int:
    """Returns a text as a whole number that a message can hold. Raises ArgumentTypeError."""
    try:
        number = int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f'{text!r} is no whole number') from None
    if abs(number) > LARGEST:
        raise argparse.ArgumentTypeError(f'{text} is not from -{LARGEST} to {LARGEST}')
    return number


class CommandProblem(Exception):
    """A command cannot do its work. The text is one sentence that says what to do."""

    def __init__(self, text: str, status: int = WRONG) -> None:
        super().__init__(text)
        self.status = status


class Parser(argparse.ArgumentParser):
    """A parser that reports an error in one line and ends with exit status 1."""

    def error(self, message: str) -> NoReturn:
        """Prints the error and ends the command."""
        self.exit(WRONG, f'{self.prog}: {message}; see {self.prog} --help.\n')
