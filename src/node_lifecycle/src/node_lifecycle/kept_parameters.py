"""Keeps the parameters that a node found at its start, and sets them again at a new ROS master.

When a master ends, its parameters are lost, and a launch file sets them only once. So without this
module, a node that is respawned under a new master would find no parameters.
"""
from __future__ import annotations

from typing import Any, Collection, Dict, Iterator, Protocol, Tuple


class ParameterServer(Protocol):
    """The interface of `rosgraph.Master` that is used here."""

    def hasParam(self, name: str) -> bool:
        """Returns whether the parameter exists."""

    def setParam(self, name: str, value: Any) -> object:
        """Sets a parameter."""


class KeptParameters:
    """Parameters by their full names."""

    def __init__(self) -> None:
        self._values: Dict[str, Any] = {}

    def keep(self, name: str, value: Any, but: Collection[str] = ()) -> None:
        """Keeps the present value of a parameter, or of all parameters in a namespace.

        but -- names to leave out, because the node itself writes these parameters
        """
        for leaf, content in _leaves(name, value):
            if leaf not in but:
                self._values[leaf] = content

    def set_missing(self, server: ParameterServer) -> None:
        """Sets the parameters that the server lacks; existing values stay."""
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
"""The parameters of this process, which is one node."""
