"""The errors of graphs and routes; each error has the ids of the elements that it concerns."""
from __future__ import annotations

from typing import Optional


class TrajectoryGraphError(Exception):
    """The base class of all errors of this package."""


class GraphError(TrajectoryGraphError):
    """A graph that cannot be used.

    problem -- the error as a clause, e.g. `ends at vertex 9, which does not exist`
    kind    -- 'vertex' or 'edge'; '' if the error does not concern one element
    id      -- the element's id; None if it is unknown
    file    -- the file of the graph; None if the graph does not come from a file
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
        """Returns the same error with its file and line."""
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
    """A signed edge id that the graph does not have; 0 is never valid."""

    def __init__(self, id: int) -> None:
        super().__init__(id)
        self.id = id

    def __str__(self) -> str:
        return f'The graph has no edge {self.id}.'


class ForbiddenDirection(TrajectoryGraphError):
    """An edge of a route whose speed is 0 in the direction of the route.

    id   -- the signed id of the edge
    name -- its name for people
    """

    def __init__(self, id: int, name: str) -> None:
        super().__init__(id, name)
        self.id = id
        self.name = name

    def __str__(self) -> str:
        return f'The graph forbids driving over {self.name}: its speed in this direction is 0.'


class NoPath(TrajectoryGraphError):
    """Two vertices between which there is no path."""

    def __init__(self, start: int, end: int) -> None:
        super().__init__(start, end)
        self.start = start
        self.end = end

    def __str__(self) -> str:
        return f'There is no path from vertex {self.start} to vertex {self.end}.'


class DiscontinuousRoute(TrajectoryGraphError):
    """An edge of a route that does not start at the end of the previous edge."""

    def __init__(self, first: int, end_vertex: int, second: int, start_vertex: int) -> None:
        super().__init__(first, end_vertex, second, start_vertex)
        self.first = first
        self.end_vertex = end_vertex
        self.second = second
        self.start_vertex = start_vertex

    def __str__(self) -> str:
        return (f'Edge {self.first} ends at vertex {self.end_vertex}, '
                f'but the next edge {self.second} starts at vertex {self.start_vertex}.')
