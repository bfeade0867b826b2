"""What a plan lets one robot drive."""
from __future__ import annotations

from typing import NamedTuple, Tuple

from graph_fleet_manager.planning.tasks import PlannedDrive


class RobotPlan(NamedTuple):
    """One robot's drives; drive k is edge number `base` + k of its record."""

    drives: Tuple[PlannedDrive, ...]
    base: int

    def behind(self, number: int) -> Tuple[PlannedDrive, ...]:
        """What is planned from an edge of the record on."""
        return self.drives[max(number - self.base, 0):]
