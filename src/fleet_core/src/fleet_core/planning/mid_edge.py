"""Where a robot stands between two vertices."""
from __future__ import annotations

from math import inf
from typing import List, NamedTuple, Tuple

from fleet_core.fleet import RobotType
from fleet_core.planning.road_network import RoadNetwork


class MidEdgePosition(NamedTuple):
    """A robot that stands at a fraction of a drive, at x, y (m), free to go on in both directions.
    """

    drive: int
    fraction: float
    x: float
    y: float

    def behind(self, drive: int) -> float:
        """Returns the fraction of `drive` that lies behind the robot.

        drive -- one of the two drives on its edge
        """
        return self.fraction if drive == self.drive else 1.0 - self.fraction

    def exits(self, network: RoadNetwork, kind: RobotType) -> List[Tuple[int, int, float]]:
        """Returns each drive by which it may leave: (drive, vertex at its end, seconds to this
        end).

        Drives on closed edges and into docks are included.
        """
        times = network.times(kind)
        return [(drive, network.destination(drive), times[drive] * (1.0 - self.behind(drive)))
                for drive in (self.drive, self.drive ^ 1) if times[drive] < inf]
