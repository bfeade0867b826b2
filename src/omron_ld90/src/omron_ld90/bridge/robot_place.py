"""Where the robot was last seen, how fast it goes, and how often it tells."""
from __future__ import annotations

import math
from typing import Optional

from omron_ld90.bridge.route_protocol import Located

NANOSECONDS = 1e-9
CLOCK_SET_BACK = 5_000_000_000  # ns: an older stamp than the last by more than this is no late one
USUAL_PERIOD = 0.5              # s, of the robot's status, until it has been seen


class RobotPlace:
    """The last location; times are seconds of a monotonic clock, stamps nanoseconds of ROS time."""

    def __init__(self) -> None:
        self.last: Optional[Located] = None
        self.heard = -math.inf
        """When the last location came."""
        self.speed = 0.0
        """m/s between the last two locations."""
        self.period = USUAL_PERIOD
        """Seconds between the last two locations."""

    def update(self, location: Located, now: float) -> bool:
        """Takes a location; False for one that comes late or twice, which is left out."""
        if self.last is not None:
            step = location.stamp - self.last.stamp
            if -CLOCK_SET_BACK < step <= 0:
                return False
            if step > 0:
                seconds = step * NANOSECONDS
                moved = math.dist((location.x, location.y), (self.last.x, self.last.y))
                self.speed = moved / seconds
                self.period = min(seconds, 2.0 * USUAL_PERIOD)
        self.last = location
        self.heard = now
        return True
