"""The error for a file that cannot be used, with a message for people."""
from __future__ import annotations

import os
from typing import Optional, Union

from trajectory_graph.strict_yaml import WrongYaml


class FileError(Exception):
    """A file that cannot be used.

    file    -- its path
    line    -- number of the line, from 1; None if the problem concerns the whole file
    problem -- a clause that says what is wrong and what to do
    """

    def __init__(self, file: Union[str, os.PathLike], problem: str,
                 line: Optional[int] = None) -> None:
        super().__init__(file, problem, line)
        self.file = os.fspath(file)
        self.problem = problem
        self.line = line

    @classmethod
    def of(cls, file: Union[str, os.PathLike], wrong: WrongYaml) -> FileError:
        """Returns the error from a problem that the strict YAML reader found."""
        return cls(file, wrong.problem, wrong.line)

    def __str__(self) -> str:
        line = f', line {self.line}' if self.line is not None else ''
        end = '' if self.problem.endswith('?') else '.'
        return f'{self.file}{line}: {self.problem}{end}'
