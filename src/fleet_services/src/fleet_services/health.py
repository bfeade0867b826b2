"""Decides what systemd is told of a unit's nodes: that all are up, and that all still work."""
from __future__ import annotations

from typing import Dict, FrozenSet, Iterable

PATIENCE = 15.0  # s that a node may be silent, or stand still, before its unit counts as hung


class Health:
    """What the watchdogs of some nodes say, by their names.

    A node that ends is started anew by roslaunch within `PATIENCE`.
    """

    def __init__(self, nodes: Iterable[str]) -> None:
        self._well: Dict[str, float] = {}  # when each node was last heard to be well
        self.nodes: FrozenSet[str] = frozenset(nodes)

    def hear(self, node: str, is_well: bool, now: float) -> None:
        """A watchdog's word at `now` (s, monotonic); those of other nodes are ignored."""
        if is_well and node in self.nodes:
            self._well[node] = now

    @property
    def is_ready(self) -> bool:
        """Whether each node has been well once."""
        return self.nodes == set(self._well)

    def hung(self, now: float) -> FrozenSet[str]:
        """The nodes that have not been well for too long."""
        return frozenset(node for node, heard in self._well.items() if now - heard > PATIENCE)
