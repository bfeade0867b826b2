"""Driving times of edges, learned from the running fleet and kept only while it runs.

A nominal time is length over speed. The cost of bends, turns, doors and people shows only during
operation. The learned times are divided by the usual delay factor of the robot type. Otherwise each
edge on which no robot has driven yet would look faster than the known edges. Safety depends on the
order of use, never on times.
"""
from __future__ import annotations

from collections import deque
from math import inf
from statistics import median
from types import MappingProxyType
from typing import Callable, Deque, Dict, NamedTuple, Optional, Tuple

from fleet_core.interlocking.route_record import RouteRecord
from fleet_core.planning.plan_requests import Times

KEPT = 9         # last drives of an edge that are kept; their median ignores a single long wait
ENOUGH = 3       # number of drives after which the median replaces the nominal time
# relative change of a time that justifies a new table, for which planners must prepare again
WORTH_IT = 0.2
PERIOD = 60.0    # s between two tables


class Driven(NamedTuple):
    """An edge that was driven from end to end, and the time that it took, in s."""

    edge: int
    seconds: float


class EdgeTimer:
    """Measures the time of each edge of one robot, from the moment when it may drive the edge.

    Waiting before that moment does not count.
    """

    def __init__(self) -> None:
        self._number: Optional[int] = None
        self._edge = 0
        self._since: Optional[float] = None
        self._counts = False

    def stop(self) -> None:
        """Ignores the time of the edge that the robot drives now."""
        self._counts, self._since = False, None

    def follow(self, record: RouteRecord, now: float) -> Optional[Driven]:
        """Evaluates a robot after its report. Returns the edge that it completed, if any."""
        driven = None
        if self._number is not None and self._since is not None and (
                record.done == self._number + 1):
            driven = Driven(self._edge, now - self._since)
        if record.done != self._number:
            # The start of a drive that is already under way is unknown.
            self._counts = self._number is not None or record.is_standing
            self._number, self._since = record.done, None
        if self._counts and self._since is None and record.ahead:
            if record.position is None or record.position.vertex is None:
                self.stop()  # the robot begins in the middle of an edge
            else:
                self._edge, self._since = record.ahead[0], now
        return driven


class _TypeTotals:
    """The totals of all robots of a type.

    needed  -- sum of the medians of all driven edges, s
    nominal -- sum of the nominal times of the same edges, s
    drives  -- number of drives
    """

    __slots__ = ('needed', 'nominal', 'drives')

    def __init__(self) -> None:
        self.needed = self.nominal = 0.0
        self.drives = 0


class EdgeTimes:
    """The times learned so far. Planner and assignment use `table`; displays use `expected`.

    nominal -- returns length / speed, in s, for the name of a robot type and a signed edge id
    """

    def __init__(self, nominal: Callable[[str, int], float]) -> None:
        self._nominal = nominal
        self.table: Times = MappingProxyType({})
        self._latest: Dict[Tuple[str, int], Deque[float]] = {}
        self._medians: Dict[Tuple[str, int], float] = {}
        """The median times of the edges that were driven ENOUGH times."""
        self._of_types: Dict[str, _TypeTotals] = {}
        self._looked = -inf

    def learn(self, kind: str, driven: Driven) -> None:
        """Notes that a robot of this type has driven an edge."""
        key, nominal = (kind, driven.edge), self._nominal(kind, driven.edge)
        if driven.seconds <= 0.0 or nominal == inf:
            return
        latest, of_type = self._latest.get(key), self._of_types.setdefault(kind, _TypeTotals())
        if latest is None:
            latest = self._latest[key] = deque(maxlen=KEPT)
            of_type.nominal += nominal
        else:
            of_type.needed -= median(latest)
        latest.append(driven.seconds)
        middle = median(latest)
        of_type.needed += middle
        of_type.drives += 1
        if len(latest) >= ENOUGH:
            self._medians[key] = middle

    def usual(self, kind: str) -> float:
        """Returns needed time divided by nominal time, over all edges that robots of a type drove.

        It is 1 until they have made ENOUGH drives.
        """
        driven = self._of_types.get(kind)
        return driven.needed / driven.nominal if driven and driven.drives >= ENOUGH else 1.0

    def expected(self, kind: str, edge: int) -> float:
        """Returns the seconds that a robot of this type is expected to need for a signed edge."""
        learned = self._medians.get((kind, edge))
        return self.usual(kind) * self._nominal(kind, edge) if learned is None else learned

    def renew(self, now: float) -> bool:
        """Makes a new table if the times have changed enough. Returns whether there is one."""
        nominal = self._nominal
        if now - self._looked < PERIOD:
            return False
        self._looked = now
        learned: Dict[Tuple[str, int], float] = {}
        for kind in {kind for kind, _ in self._medians}:
            own = {key: seconds for key, seconds in self._medians.items() if key[0] == kind}
            usual = median(seconds / nominal(*key) for key, seconds in own.items())
            learned.update((key, seconds / usual) for key, seconds in own.items())
        if all(abs(seconds - self.table.get(key, nominal(*key))) <= WORTH_IT * nominal(*key)
               for key, seconds in learned.items()):
            return False
        self.table = MappingProxyType(learned)
        return True
