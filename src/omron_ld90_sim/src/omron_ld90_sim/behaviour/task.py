"""A task in text form: a name and arguments, for `doTask`, `listAdd`, routes and macros."""
from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import List, Optional

from omron_map import MapDocument, MapObject

_WORD = re.compile(r'"([^"]*)"?|(\S+)')


def split_words(text: str) -> List[str]:
    """Returns the words of a text; a part in double quotes is one word, without the quotes.

    A quote that is not closed extends to the end.
    """
    return [m.group(1) if m.group(2) is None else m.group(2) for m in _WORD.finditer(text)]


class BadTask(ValueError):
    """There is no such task, or its arguments are wrong."""


@dataclass(frozen=True)
class RobotTask:
    """A task with its arguments, as typed."""

    name: str
    rest: str

    def __str__(self) -> str:
        return f'{self.name} {self.rest}'.strip()

    @property
    def words(self) -> List[str]:
        """The arguments without quotes."""
        return split_words(self.rest)

    def number(self, index: int, default: Optional[float] = None) -> float:
        """Returns the argument at `index` as a number; raises BadTask."""
        if index >= len(self.words) and default is not None:
            return default
        try:
            value = float(self.words[index])
        except (IndexError, ValueError):
            raise self.bad_arguments() from None
        if not math.isfinite(value):
            raise self.bad_arguments()
        return value

    def bad_arguments(self) -> BadTask:
        """Returns the error for arguments that the task does not accept."""
        return BadTask(f"Bad arguments for task '{self}'")


def find_goal(document: MapDocument, name: str) -> Optional[MapObject]:
    """Returns the goal with that name, ignoring case."""
    return next((goal for goal in document.goals if goal.name.lower() == name.lower()), None)
