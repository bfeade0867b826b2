"""The plan of one robot."""
from __future__ import annotations

from typing import NamedTuple, Tuple

from fleet_core.planning.tasks import PlannedDrive


class RobotPlan(NamedTuple):
    """The drives of one robot. Drive k is edge number `base` + k of its record."""

    drives: Tuple[PlannedDrive, ...]
    base: int

    def behind(self, number: int) -> Tuple[PlannedDrive, ...]:
        """Returns the drives that begin with edge `number` of the record or later."""
        return self.drives[max(number - self.base, 0):]
