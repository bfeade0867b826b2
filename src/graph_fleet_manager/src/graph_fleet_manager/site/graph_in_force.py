"""Which graph is in force, and when a file may replace it: never under robots that drive on it.

The graph in force is kept in a copy. For a node that starts anew while robots drive, the file may
have changed since, and the copy is what they drive on.
"""
from __future__ import annotations

import os
from dataclasses import replace
from typing import Dict, NamedTuple, Optional

from graph_fleet_manager.site.changes import ReportedRoute, what_breaks
from trajectory_graph import Graph, GraphError, load_graph, save_graph


class Loaded(NamedTuple):
    """What came of reading a file."""

    changed: bool
    """Is another graph in force now?"""
    trouble: str
    """Why the file is not in force, as a sentence; empty: it is."""


class GraphInForce:
    """The graph in force; None before one was loaded.

    copy   -- file in which it is kept; its first line names the file that it came from
    routes -- what each robot reported last, by its name: to be kept up to date
    """

    def __init__(self, copy: str) -> None:
        self.graph: Optional[Graph] = None
        self.routes: Dict[str, ReportedRoute] = {}
        self._copy = copy

    def must_hear_robots(self, file: str) -> bool:
        """Is this the first file, and not as it was when it was last in force? Then robots may
        drive on what it was, so `load` should wait until they have reported."""
        before = self._kept(file) if self.graph is None else None
        if before is None:
            return False
        try:
            return not load_graph(file).is_same(before)
        except GraphError:
            return True

    def load(self, file: str) -> Loaded:
        """Puts the graph of a file in force if it is valid and breaks no running route."""
        new, trouble = None, ''
        try:
            new = load_graph(file)
        except GraphError as error:
            trouble = str(error)
        if self.graph is None:
            return self._load_first(file, new, trouble)
        if new is None or new.is_same(self.graph):
            return Loaded(False, trouble)
        broken = what_breaks(self.graph, new, self.routes)
        if broken is not None:
            return Loaded(False, broken)
        return self._put(file, new)

    def _load_first(self, file: str, new: Optional[Graph], trouble: str) -> Loaded:
        """Only running routes count: where robots stand, they may have been carried meanwhile."""
        before = self._kept(file)
        running = {name: replace(route, edge=0) for name, route in self.routes.items()
                   if route.left}
        if before is not None and running:
            if new is not None:
                trouble = what_breaks(before, new, running) or ''
            if trouble:
                self.graph = before
                return Loaded(True, trouble)
        return Loaded(False, trouble) if new is None else self._put(file, new)

    def _put(self, file: str, graph: Graph) -> Loaded:
        try:
            os.makedirs(os.path.dirname(os.path.abspath(self._copy)), exist_ok=True)
            save_graph(graph, self._copy, _origin(file))
        except OSError as error:
            return Loaded(False, f'{self._copy} cannot be written ({error.strerror}), so the graph '
                          'could not be kept for a restart and is not put in force.')
        self.graph = graph
        return Loaded(True, '')

    def _kept(self, file: str) -> Optional[Graph]:
        """The graph that was in force, if it came from this file."""
        try:
            with open(self._copy, encoding='utf-8') as stream:
                origin = stream.readline()
            return load_graph(self._copy) if origin == f'# {_origin(file)}\n' else None
        except (OSError, UnicodeDecodeError, GraphError):
            return None


def _origin(file: str) -> str:
    return f'The graph in force, of {os.path.abspath(file)!r}.'
