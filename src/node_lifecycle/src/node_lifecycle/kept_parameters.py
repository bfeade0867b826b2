"""What a node found on the parameter server at its start, for a ROS master that does not have it.

Parameters die with their master, and a launch file sets them only once: a node that is respawned
under a new master would find none of them.
"""
from __future__ import annotations

from typing import Any, Collection, Dict, Iterator, Protocol, Tuple


class ParameterServer(Protocol):
    """As `rosgraph.Master` has it."""

    def hasParam(self, name: str) -> bool:
        """Is there such a parameter?"""

    def setParam(self, name: str, value: Any) -> object:
        """Sets one."""


class KeptParameters:
    """Parameters by their full names."""

    def __init__(self) -> None:
        self._values: Dict[str, Any] = {}

    def keep(self, name: str, value: Any, but: Collection[str] = ()) -> None:
        """Remembers a parameter, or a namespace of them, as it is now, without those named in
        `but`, which the node writes by itself."""
        for leaf, content in _leaves(name, value):
            if leaf not in but:
                self._values[leaf] = content

    def set_missing(self, server: ParameterServer) -> None:
        """Sets those again that the server does not have; what it has stays."""
        for name, value in list(self._values.items()):
            if not server.hasParam(name):
                server.setParam(name, value)


def _leaves(name: str, value: Any) -> Iterator[Tuple[str, Any]]:
    if not isinstance(value, dict):
        yield name, value
        return
    for key, content in value.items():
        yield from _leaves(f'{name}/{key}', content)


KEPT = KeptParameters()
"""Those of this process, which is one node."""
