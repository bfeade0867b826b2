"""Statistics of many runs: means with confidence bands, quantiles, the knee, causes of waiting."""
from __future__ import annotations

import math
from enum import Enum
from typing import Container, Dict, Iterable, List, NamedTuple, Optional, Sequence

import numpy as np
from scipy.stats import t as students_t

from fleet_simulation.figures import Figures, Use, WaitingCause
from fleet_simulation.hold_ups import Bottleneck, bottlenecks, summed
from trajectory_graph import Graph

WORTH = 0.05    # a further robot is worth it if it raises the throughput by at least this share
KEPT_UP = 0.97  # a fleet serves the demand if at least this share of the requests succeeds


class Band(NamedTuple):
    """A mean, and half the width of its 95 % confidence band (infinite if there is one run)."""

    mean: float
    half: float

    def __str__(self) -> str:
        return f'{self.mean:.0f}' + (f' ± {self.half:.0f}' if self.half < math.inf else '')

    def side(self, of: float = 0.0) -> Side:
        """Returns on which side of the value `of` the whole band lies."""
        if self.mean - self.half > of:
            return Side.ABOVE
        return Side.BELOW if self.mean + self.half < of else Side.UNDECIDED


class Side(Enum):
    """Whether a confidence band lies above or below a value; UNDECIDED: the value is inside it."""

    BELOW = 'below'
    ABOVE = 'above'
    UNDECIDED = 'too few seeds to decide'


def band(values: Sequence[float]) -> Band:
    """Returns the mean of independent runs and its confidence band."""
    if len(values) < 2:
        return Band(values[0] if values else 0.0, math.inf)
    deviation = float(np.std(values, ddof=1)) / math.sqrt(len(values))
    return Band(float(np.mean(values)), float(students_t.ppf(0.975, len(values) - 1)) * deviation)


def quantile(values: Sequence[float], share: float) -> float:
    """Returns the quantile at `share` (0..1), or NaN if there are no values."""
    return float(np.quantile(values, share)) if values else math.nan


class SizeResults(NamedTuple):
    """The results of one fleet size over all seeds. Times are in s; `requested` is per hour."""

    robots: int
    runs: List[Figures]
    per_hour: Band
    requested: float
    waits: List[float]
    leads: List[float]
    use: Dict[Use, float]
    """For each activity: share (0..1) of the robots' time."""


def sizes(runs: Iterable[Figures]) -> List[SizeResults]:
    """Groups the runs by fleet size, the smallest first; runs that broke off are ignored."""
    by_size: Dict[int, List[Figures]] = {}
    for run in runs:
        if not run.trouble:
            by_size.setdefault(run.robots, []).append(run)
    found = []
    for robots, group in sorted(by_size.items()):
        whole = sum(sum(run.use.values()) for run in group) or 1.0
        found.append(SizeResults(
            robots, group, band([run.per_hour for run in group]),
            float(np.mean([3600.0 * run.requested / run.seconds for run in group])),
            [wait for run in group for wait in run.waits],
            [lead for run in group for lead in run.leads],
            {use: sum(run.use[use] for run in group) / whole for use in Use}))
    return found


def knee(all_sizes: Sequence[SizeResults]) -> SizeResults:
    """Returns the smallest fleet whose throughput a further robot raises by less than 5 %; if there
    is none, returns the largest fleet.
    """
    for size, following in zip(all_sizes, all_sizes[1:]):
        more = following.robots - size.robots
        gain = (following.per_hour.mean - size.per_hour.mean) / max(size.per_hour.mean, 1e-9)
        if gain / more < WORTH:
            return size
    return all_sizes[-1]


def served_share(size: SizeResults) -> Band:
    """Returns the share (0..1) of the requested missions that succeeded, as a mean over the seeds.
    """
    return band([min(run.succeeded / run.requested, 1.0) if run.requested else 1.0
                 for run in size.runs])


def gain(size: SizeResults, larger: SizeResults) -> Band:
    """Returns the relative gain in throughput with the larger fleet, compared seed by seed."""
    before = {run.seed: run.per_hour for run in size.runs}
    return band([(run.per_hour - before[run.seed]) / max(size.per_hour.mean, 1e-9)
                 for run in larger.runs if run.seed in before])


def waiting_by_edge(size: SizeResults) -> Dict[int, float]:
    """Returns for each edge its share (0..1) of all waiting, the highest share first."""
    return _shares((edge, seconds) for run in size.runs
                   for (edge, _), seconds in run.waiting.items())


def waiting_by_drawn_edge(size: SizeResults, graph: Graph) -> Dict[int, float]:
    """Returns for each drawn edge its share (0..1) of all waiting, including the waiting at its
    sections.
    """
    return _shares((graph.edges[edge].drawn_id if edge in graph.edges else edge, seconds)
                   for run in size.runs for (edge, _), seconds in run.waiting.items())


def waiting_by_cause(size: SizeResults,
                     edges: Optional[Container[int]] = None) -> Dict[WaitingCause, float]:
    """Returns for each cause its share (0..1) of all waiting, the highest share first.

    edges -- ids of the edges whose waiting counts; None: of all edges
    """
    return _shares((cause, seconds) for run in size.runs
                   for (one, cause), seconds in run.waiting.items()
                   if edges is None or one in edges)


def bottlenecks_of(size: SizeResults) -> List[Bottleneck]:
    """Returns stations, devices and chargers, beginning with the longest waiting time."""
    return list(bottlenecks(summed(*(run.resources for run in size.runs)),
                            sum(run.seconds for run in size.runs)))


def _shares(pairs: Iterable) -> Dict:
    sums: Dict = {}
    for key, seconds in pairs:
        sums[key] = sums.get(key, 0.0) + seconds
    whole = sum(sums.values()) or 1.0
    return {key: seconds / whole
            for key, seconds in sorted(sums.items(), key=lambda item: -item[1])}
