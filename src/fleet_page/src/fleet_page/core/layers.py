"""The layers of the map whose entries are sent only to clients that show them."""
from __future__ import annotations

from dataclasses import dataclass
from typing import FrozenSet

PLAN, ALLOCATION, LASER = 'plan', 'allocation', 'laser'
LAYERS = (PLAN, ALLOCATION, LASER)
"""An entry of a layer has a key that begins with one of these and a colon."""


@dataclass(frozen=True)
class ShownLayers:
    """What one client shows.

    names -- of `LAYERS`, without LASER
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
        """The sources that the node receives only for such clients: `allocation`, `laser:NAME`."""
        return frozenset((
            *(name for name in self.names if name == ALLOCATION),
            *([f'{LASER}:{self.laser}'] if self.laser else [])))
