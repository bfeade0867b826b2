"""What can be wrong with a graph or a route; every error carries the ids it is about."""
from __future__ import annotations

from typing import Optional


class TrajectoryGraphError(Exception):
    """Base of all errors of this package."""


class GraphError(TrajectoryGraphError):
    """A graph that cannot be used.

    problem -- what is wrong, as a clause, e.g. `edge 3: ends at vertex 9, which does not exist`
    kind    -- 'vertex', 'edge' or '' where the problem is not that of one element
    id      -- the element's id, as far as it is known
    file    -- file it was read from, None for a graph that did not come from a file
    line    -- line in `file`, counted from 1
    """

    def __init__(self, problem: str, kind: str = '', id: Optional[int] = None,
                 file: Optional[str] = None, line: Optional[int] = None) -> None:
        super().__init__(problem, kind, id, file, line)
        self.problem = problem
        self.kind = kind
        self.id = id
        self.file = file
        self.line = line

    def located(self, file: str, line: Optional[int]) -> GraphError:
        """The same error, with the place in the file that it came from."""
        return GraphError(self.problem, self.kind, self.id, file, line)

    def __str__(self) -> str:
        element = f'{self.kind} {self.id}: ' if self.id is not None else ''
        if self.file is None:
            return f'{element}{self.problem}.'
        line = f', line {self.line}' if self.line is not None else ''
        return f'{self.file}{line}: {element}{self.problem}.'


class UnknownVertex(TrajectoryGraphError):
    """A vertex id that the graph does not have."""

    def __init__(self, id: int) -> None:
        super().__init__(id)
        self.id = id

    def __str__(self) -> str:
        return f'The graph has no vertex {self.id}.'


class UnknownEdge(TrajectoryGraphError):
    """A signed edge id whose edge the graph does not have (0 never is one)."""

    def __init__(self, id: int) -> None:
        super().__init__(id)
        self.id = id

    def __str__(self) -> str:
        return f'The graph has no edge {self.id}.'


class DiscontinuousRoute(TrajectoryGraphError):
    """An edge of a route that does not start where the one before it ends."""

    def __init__(self, first: int, end_vertex: int, second: int, start_vertex: int) -> None:
        super().__init__(first, end_vertex, second, start_vertex)
        self.first = first
        self.end_vertex = end_vertex
        self.second = second
        self.start_vertex = start_vertex

    def __str__(self) -> str:
        return (f'Edge {self.first} ends at vertex {self.end_vertex}, '
                f'but the next edge {self.second} starts at vertex {self.start_vertex}.')
