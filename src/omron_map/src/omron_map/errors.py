"""The errors and warnings of maps, with the position in the file."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Optional

from omron_map.text import printable_path


class MapError(Exception):
    """A map that cannot be read, edited or written; the text is one sentence for people.

    Attributes: `file`, `problem`, and, if they apply, `line` (from 1), `field`, `expected`.
    """

    def __init__(self, file: str, problem: str, line: Optional[int] = None,
                 field: Optional[str] = None, expected: Optional[str] = None) -> None:
        super().__init__(file, problem, line, field, expected)
        self.file = file
        self.problem = problem
        self.line = line
        self.field = field
        self.expected = expected

    def __str__(self) -> str:
        where = printable_path(self.file)
        if self.line is not None:
            where += f', line {self.line}'
        if self.field is not None:
            where += f', {self.field}'
        end = f'; expected {self.expected}' if self.expected else ''
        return f'{where}: {self.problem}{end}.'


class DuplicateName(MapError):
    """An object with that name exists already; names are compared without regard to case."""


class FieldError(ValueError):
    """A wrong field, raised by code that does not know the file; it is converted to a MapError."""

    def __init__(self, problem: str, field: Optional[str] = None, expected: Optional[str] = None,
                 line: Optional[int] = None) -> None:
        super().__init__(problem)
        self.problem = problem
        self.field = field
        self.expected = expected
        self.line = line

    def in_file(self, file: str, line: Optional[int] = None) -> MapError:
        """Returns the same error as a MapError with the file and the line."""
        return MapError(file, self.problem, self.line or line, self.field, self.expected)


@dataclass(frozen=True)
class MapWarning:
    """A strange entry that does not prevent the use of the map; `line` counts from 1."""

    text: str
    line: Optional[int] = None

    def __str__(self) -> str:
        return self.text if self.line is None else f'line {self.line}: {self.text}'
