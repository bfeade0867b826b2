"""Histograms of the planning time and of the time until a release, in the form of Prometheus."""
from __future__ import annotations

from typing import Dict, List, Mapping

from fleet_page.core.fleet import ShownPlan

BOUNDS = (0.05, 0.1, 0.25, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0)  # s


class Histogram:
    """The numbers of values up to each bound, the sum of all values, and their number."""

    def __init__(self) -> None:
        self.counts = [0] * len(BOUNDS)
        self.sum = 0.0
        self.count = 0

    def add(self, value: float) -> None:
        """Adds a value."""
        for k, bound in enumerate(BOUNDS):
            if value <= bound:
                self.counts[k] += 1
        self.sum += value
        self.count += 1

    def lines(self, name: str) -> List[str]:
        """Returns the histogram in the text format of Prometheus."""
        return [*(f'{name}_bucket{{le="{bound:g}"}} {count}'
                  for bound, count in zip(BOUNDS, self.counts)),
                f'{name}_bucket{{le="+Inf"}} {self.count}',
                f'{name}_sum {self.sum:.3f}', f'{name}_count {self.count}']


class ReleaseWatch:
    """Measures how long robots without a released edge wait for the release of the next edge.

    The time begins with the first plan in which the robot has edges but no released edge. It ends
    with the first plan in which the robot has a released edge.
    """

    def __init__(self) -> None:
        self.seconds = Histogram()
        self._held: Dict[str, float] = {}  # when the wait of each robot began

    def note_plans(self, plans: Mapping[str, ShownPlan], now: float) -> None:
        """Updates the waits with the plans at the time `now` (s)."""
        for name in [name for name in self._held if name not in plans]:
            del self._held[name]
        for name, plan in plans.items():
            if plan.edges and not plan.released:
                self._held.setdefault(name, now)
            else:
                held = self._held.pop(name, None)
                if held is not None and plan.released:
                    self.seconds.add(max(now - held, 0.0))
