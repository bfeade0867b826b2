"""Layers of the map. The entries of a layer are sent only to clients that show the layer."""
from __future__ import annotations

from dataclasses import dataclass
from typing import FrozenSet

PLAN, ALLOCATION, LASER = 'plan', 'allocation', 'laser'
LAYERS = (PLAN, ALLOCATION, LASER)
"""The layers of the map. The key of a layer's entry is the layer, a colon, and a name."""


@dataclass(frozen=True)
class ShownLayers:
    """The layers that one client shows.

    names -- the shown layers of `LAYERS`, without LASER
    laser -- the robot whose laser is shown; empty: none
    """

    names: FrozenSet[str] = frozenset((PLAN,))
    laser: str = ''

    def shows(self, key: str) -> bool:
        """Returns whether the entry with this key is sent to the client."""
        layer, colon, name = key.partition(':')
        if not colon or layer not in LAYERS:
            return True
        return name == self.laser if layer == LASER else layer in self.names

    @property
    def sources(self) -> FrozenSet[str]:
        """The sources that the node receives only while a client shows them: `allocation`,
        `laser:NAME`."""
        return frozenset((
            *(name for name in self.names if name == ALLOCATION),
            *([f'{LASER}:{self.laser}'] if self.laser else [])))
