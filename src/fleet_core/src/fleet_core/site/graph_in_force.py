"""The graph in force, and when a file may replace it: never if this changes a running route.

A copy of the graph in force is kept. If the node restarts while robots drive, the file may have
changed in the meantime. The copy is the graph on which the robots drive.

States: no graph, or one graph in force. Events: a file is loaded, a robot reports its route.
Invariants: a graph is put in force only if it is valid, on the disk, and breaks no running route;
after the first graph, there is always a graph in force.
"""
from __future__ import annotations

import os
from dataclasses import replace
from typing import Dict, NamedTuple, Optional

from fleet_core.site.changes import ReportedRoute, what_breaks
from trajectory_graph import Graph, GraphError, load_graph, save_graph


class Loaded(NamedTuple):
    """The result of reading a file."""

    changed: bool
    """Whether another graph is in force now."""
    trouble: str
    """A sentence that says why the file is not in force; empty if it is."""


class GraphInForce:
    """The graph in force and its copy on the disk.

    graph  -- the graph in force; None: none was loaded yet
    copy   -- file with the copy; its first line names the file from which the graph was loaded
    routes -- the last report of each robot, by its name; the caller keeps it up to date
    """

    def __init__(self, copy: str) -> None:
        self.graph: Optional[Graph] = None
        self.routes: Dict[str, ReportedRoute] = {}
        self._copy = copy

    def must_hear_robots(self, file: str) -> bool:
        """Returns whether `load` should wait until the robots have reported.

        It should if no graph is in force yet, and the file has changed since its graph was last in
        force. Then robots may still drive on the old graph.
        """
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
        """Loads the first file after a start.

        Only running routes are checked. The place of a standing robot is not checked, because a
        person may have carried the robot elsewhere.
        """
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
                          'would be lost at a restart and is not put in force.')
        self.graph = graph
        return Loaded(True, '')

    def _kept(self, file: str) -> Optional[Graph]:
        """Returns the copied graph; None: it was not loaded from this file, or is not valid."""
        try:
            with open(self._copy, encoding='utf-8') as stream:
                origin = stream.readline()
            return load_graph(self._copy) if origin == f'# {_origin(file)}\n' else None
        except (OSError, UnicodeDecodeError, GraphError):
            return None


def _origin(file: str) -> str:
    return f'The graph in force, of {os.path.abspath(file)!r}.'
