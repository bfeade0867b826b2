"""Decides whether all nodes of a unit have started, and whether all of them still work."""
from __future__ import annotations

from typing import Dict, FrozenSet, Iterable

PATIENCE = 15.0  # s; a unit counts as hung if one of its nodes sends no good report for so long


class Health:
    """The state of a unit's nodes, from the reports of their watchdogs.

    If a node ends, roslaunch restarts it within `PATIENCE`.
    """

    def __init__(self, nodes: Iterable[str]) -> None:
        self._well: Dict[str, float] = {}  # time of the last good report of each node
        self.nodes: FrozenSet[str] = frozenset(nodes)

    def hear(self, node: str, is_well: bool, now: float) -> None:
        """Notes the report of a watchdog at `now` (s, monotonic); ignores nodes of other units."""
        if is_well and node in self.nodes:
            self._well[node] = now

    @property
    def is_ready(self) -> bool:
        """Whether each node has had a good report."""
        return self.nodes == set(self._well)

    def hung(self, now: float) -> FrozenSet[str]:
        """Returns the nodes whose last good report is older than `PATIENCE`; `now` is in s,
        monotonic.
        """
        return frozenset(node for node, heard in self._well.items() if now - heard > PATIENCE)
