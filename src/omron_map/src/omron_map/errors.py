"""What can be wrong with a map, as types that carry where it is."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Optional

from omron_map.text import printable_path


class MapError(Exception):
    """A map that cannot be read, edited or written; the text is one sentence for people.

    Attributes: `file`, `problem`, and where they apply `line` (from 1), `field`, `expected`.
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
    """An object of that name is there already: names are looked up without regard to case."""


class FieldError(ValueError):
    """A bad field, raised where the file is not known; the document makes a MapError of it."""

    def __init__(self, problem: str, field: Optional[str] = None, expected: Optional[str] = None,
                 line: Optional[int] = None) -> None:
        super().__init__(problem)
        self.problem = problem
        self.field = field
        self.expected = expected
        self.line = line

    def in_file(self, file: str, line: Optional[int] = None) -> MapError:
        """The same error, with the file and the line it was found in."""
        return MapError(file, self.problem, self.line or line, self.field, self.expected)


@dataclass(frozen=True)
class MapWarning:
    """Something odd that does not stop the map from being used; `line` counts from 1."""

    text: str
    line: Optional[int] = None

    def __str__(self) -> str:
        return self.text if self.line is None else f'line {self.line}: {self.text}'
