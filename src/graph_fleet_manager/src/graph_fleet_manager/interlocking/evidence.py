"""What reports tell of where a robot is, beyond the route record, and until when that counts."""
from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple, Optional, Tuple

from graph_fleet_manager.fleet import RobotType
from graph_fleet_manager.geometry.areas import Area, Point, are_nearer
from graph_fleet_manager.interlocking.reports import (
    CLOCK_ERROR,
    NEAR,
    TREMBLE,
    Report,
)
from trajectory_graph import Graph

MANUAL_REACH = 10.0  # m that a robot which a person drives, and which is silent, may have come
DISPROOFS = 2        # later locations elsewhere that disprove an outlier
_STEP = 0.5          # m in which the area around such a robot grows


@dataclass(frozen=True)
class Outlier:
    """A location outside of what the robot was granted.

    age       -- s for which the robot may have moved on from there; 0: it stands
    disproofs -- later locations that were elsewhere
    """

    point: Point
    age: float = 0.0
    disproofs: int = 0

    def area(self, kind: RobotType) -> Area:
        """Where the robot may be by it."""
        return Area((self.point,), max(self.age, 0.0) * kind.speed)


class EvidenceMemory(NamedTuple):
    """What of it must outlive a restart."""

    outliers: Tuple[Outlier, ...] = ()
    lost: Tuple[Area, ...] = ()
    foreign: Tuple[int, ...] = ()
    reach: float = 0.0
    location: Optional[Point] = None
    is_absent: bool = False


class Evidence:
    """All that is known of one robot beside what it was granted."""

    def __init__(self, kind: RobotType) -> None:
        self._kind = kind
        self.outliers: Tuple[Outlier, ...] = ()
        self.lost: Tuple[Area, ...] = ()
        """Curves that it held on a graph which is not in force any more."""
        self.foreign: Tuple[int, ...] = ()
        """Edges of a route that it was not given here, and drives."""
        self.reach = 0.0
        """m around its last location that it may have been driven by hand, silently."""
        self.location: Optional[Point] = None
        """The last one, x, y in m."""
        self.is_absent = False
        self.clock_is_off = False
        self._age = 0.0          # s for which the robot may have moved on from its last location
        self._told: Tuple[float, Optional[Point]] = (0.0, None)
        self._is_moved = False   # by a giver other than the fleet manager, as last reported
        self._strays = 0         # locations in a row that were outliers
        self._absent_since = -math.inf

    @property
    def is_confirmed(self) -> bool:
        """Do two locations, one after the other, tell that the robot is outside?"""
        return self._strays >= 2

    @property
    def areas(self) -> Tuple[Area, ...]:
        """Where the robot may be by all this."""
        found = [*self.lost, *(outlier.area(self._kind) for outlier in self.outliers)]
        if self.reach and self.location is not None:
            found.append(Area((self.location,), self.reach))
        return tuple(found)

    # -- what changes it --------------------------------------------------------------------------

    def see(self, report: Report, graph: Graph, is_covered: bool, is_obedient: bool) -> None:
        """Takes up a location.

        is_covered  -- the robot is on what it was granted
        is_obedient -- it drives a route that it was given here, or nothing
        """
        self.clock_is_off = report.is_ahead
        self.foreign = () if is_obedient else report.left
        point = report.located(graph)
        told = report.stamp, point
        if report.stamp and told == self._told:
            return
        self._told = told
        if point is None:
            self._strays += 1
            return
        before, self.location = self.location, point
        has_moved = before is None or math.dist(before, point) > TREMBLE
        drives = is_obedient and report.is_running
        self._is_moved = before is not None and has_moved and not drives
        self.reach = 0.0
        self.outliers = tuple(
            judged for judged in (_judged(outlier, point) for outlier in self.outliers)
            if judged.disproofs < DISPROOFS)
        # A robot that stands does not grow, however late its report arrives.
        self._age = report.age if has_moved or drives else 0.0
        if is_covered:
            self._strays = 0
        else:
            self._stray(point)

    def uncover(self) -> None:
        """What covered the last location is not the robot's any more."""
        if self.location is not None:
            self._stray(self.location)

    def _stray(self, point: Point) -> None:
        self._strays += 1
        self.outliers = (*(one for one in self.outliers
                           if math.dist(one.point, point) > TREMBLE), Outlier(point, self._age))

    def grow(self, silence: float) -> bool:
        """Nothing was heard of the robot for so many seconds; tells whether that changes anything.

        Only a robot that was last seen to move by another giver may be elsewhere by now.
        """
        if not self._is_moved or self.is_absent:
            return False
        reach = min((silence + CLOCK_ERROR) * self._kind.speed, MANUAL_REACH)
        reach = min(math.ceil(reach / _STEP) * _STEP, MANUAL_REACH)
        if reach <= self.reach:
            return False
        self.reach = reach
        return True

    def settle(self) -> None:
        """The robot stands where it is known to stand, and nowhere else."""
        self.outliers, self.lost, self.foreign, self.reach = (), (), (), 0.0
        self._strays, self._is_moved = 0, False

    def lose(self, areas: Tuple[Area, ...]) -> None:
        """The graph in force lacks what the robot held."""
        self.lost = (*self.lost, *areas)

    def leave_lost(self, margin: float) -> None:
        """The robot cannot come to the lost areas any more that are farther away than this (m)."""
        here = self.location
        if here is not None:
            self.lost = tuple(area for area in self.lost
                              if are_nearer(area.line, (here,), area.radius + margin))

    # -- robots that are not on the site ----------------------------------------------------------

    def declare_absent(self, now: float) -> None:
        """A person says that the robot is not on the site; `now`: the supervisor's time."""
        self.settle()
        self.location = None
        self.is_absent, self._absent_since = True, now

    def is_back(self, report: Report, now: float) -> bool:
        """Was this location, which arrived at `now`, taken after the robot was declared absent?"""
        return now - max(report.age, 0.0) > self._absent_since

    # -- what outlives a restart ------------------------------------------------------------------

    @property
    def memory(self) -> EvidenceMemory:
        """What is to be stored."""
        return EvidenceMemory(self.outliers, self.lost, self.foreign, self.reach, self.location,
                              self.is_absent)

    def restore(self, memory: EvidenceMemory, now: float) -> None:
        """As it was before a restart; `now`: the supervisor's time."""
        (self.outliers, self.lost, self.foreign, self.reach, self.location,
         self.is_absent) = memory
        self._absent_since = now


def _judged(outlier: Outlier, point: Point) -> Outlier:
    """An outlier after a later location."""
    is_elsewhere = math.dist(outlier.point, point) > NEAR
    return replace(outlier, disproofs=outlier.disproofs + 1 if is_elsewhere else 0)
