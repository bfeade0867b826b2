"""What all commands share, those without ROS too: exit statuses, and errors of one line."""
from __future__ import annotations

import argparse
from typing import NoReturn

OK, WRONG, NOT_DONE = 0, 1, 2
"""Exit statuses: done; wrong input, or no fleet manager; refused or not succeeded."""


class CommandError(Exception):
    """What keeps a command from doing its work: one sentence that says what to do."""

    def __init__(self, text: str, status: int = WRONG) -> None:
        super().__init__(text)
        self.status = status


class Parser(argparse.ArgumentParser):
    """Says what is wrong in one line, with exit status 1."""

    def error(self, message: str) -> NoReturn:
        """Ends the command."""
        self.exit(WRONG, f'{self.prog}: {message}; see {self.prog} --help.\n')
