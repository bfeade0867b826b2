"""The age of a stored moment, independent of changes of the wall clock."""
from __future__ import annotations

import math
import time
from typing import Any, Dict, NamedTuple

from node_lifecycle.boot import boot_id


class Moment(NamedTuple):
    """A moment.

    boot -- id of the computer's boot
    since_boot -- s since the boot
    wall -- s of the wall clock
    """

    boot: str
    since_boot: float
    wall: float

    @classmethod
    def now(cls) -> Moment:
        """Returns the present moment."""
        return cls(boot_id(), time.clock_gettime(time.CLOCK_BOOTTIME), time.time())

    @classmethod
    def read(cls, content: Dict[str, Any]) -> Moment:
        """Returns the moment in `content`; raises KeyError, TypeError or ValueError."""
        return cls(str(content['boot']), float(content['since_boot']), float(content['time']))

    def content(self) -> Dict[str, Any]:
        """Returns the moment as plain values."""
        return {'boot': self.boot, 'since_boot': self.since_boot, 'time': self.wall}

    def age(self, now: Moment) -> float:
        """Returns the seconds from this moment to `now`.

        If the computer was booted in between, returns the difference of the wall clock, but at
        least the time since the boot. Returns infinity if the wall clock was set back.
        """
        if self.boot == now.boot:
            return now.since_boot - self.since_boot
        return max(now.wall - self.wall, now.since_boot) if now.wall >= self.wall else math.inf
