"""Evidence of one robot's place beyond the route record, and the rules that end its validity."""
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
from route_protocol.values import ReasonCode
from trajectory_graph import Graph

# m that a robot may have moved since its last location while a person drives it
MANUAL_REACH = 10.0
DISPROOFS = 2        # number of later locations elsewhere that disprove an outlier
_STANDING = 1.0      # s near one place after which a robot counts as standing
_BRAKING = 3.0       # s in which a robot brakes after the end of its own drive
_LOOK = 0.2          # s within which the area around a robot grows again; ticks come more often
_STEP = 0.5          # m: the step in which the area around a robot grows that is moved by hand
_SQUARE = 1.0        # m: such a robot's location is stored whenever it is in another such square


@dataclass(frozen=True)
class Outlier:
    """A location outside the places that the robot was granted.

    age       -- s for which the robot may have moved on from there; 0: it stands
    disproofs -- number of later locations that were elsewhere
    """

    point: Point
    age: float = 0.0
    disproofs: int = 0

    def area(self, kind: RobotType) -> Area:
        """The area in which the robot may be according to this outlier."""
        return Area((self.point,), max(self.age, 0.0) * kind.speed)


class EvidenceMemory(NamedTuple):
    """The part of the evidence that must survive a restart."""

    outliers: Tuple[Outlier, ...] = ()
    lost: Tuple[Area, ...] = ()
    foreign: Tuple[int, ...] = ()
    reach: float = 0.0
    location: Optional[Point] = None
    is_absent: bool = False
    is_moved: bool = False


class Evidence:
    """All that is known of one robot's place in addition to its grants.

    stopping -- m within which the robot stops when its route ends early
    """

    def __init__(self, kind: RobotType, stopping: float) -> None:
        self._kind, self._stopping = kind, stopping
        self.outliers: Tuple[Outlier, ...] = ()
        self.lost: Tuple[Area, ...] = ()
        """Curves that the robot held on a graph which is not in force any more."""
        self.foreign: Tuple[int, ...] = ()
        """Edges that the robot drives although this fleet manager did not order their route."""
        self.reach = 0.0
        """Radius (m) around the last location: the robot may have been driven by hand since then.
        """
        self.location: Optional[Point] = None
        """The last location, x, y in m."""
        self.is_absent = False
        self.clock_is_off = False
        self._age = 0.0          # s for which the robot may have moved on from its last location
        self._told: Tuple[float, Optional[Point]] = (0.0, None)
        self._stays_at: Optional[Point] = None  # the location near which it has stayed
        self._stays_since = 0.0                 # stamp of the first location there
        # the last location on its own drive, and its stamp; from there it may be braking still
        self._drove_to: Optional[Tuple[Point, float]] = None
        self._is_moved = False   # by another giver than the fleet manager, as last reported
        self._strays = 0         # number of consecutive locations that were outliers
        self._absent_since = -math.inf

    @property
    def is_confirmed(self) -> bool:
        """Have two consecutive locations shown that the robot is outside its grants?"""
        return self._strays >= 2

    @property
    def areas(self) -> Tuple[Area, ...]:
        """The areas in which the robot may be according to this evidence."""
        found = [*self.lost, *(outlier.area(self._kind) for outlier in self.outliers)]
        if self.reach and self.location is not None:
            found.append(Area((self.location,), self.reach))
        return tuple(found)

    # -- changes ----------------------------------------------------------------------------------

    def see(self, report: Report, graph: Graph, is_covered: bool, is_obedient: bool,
            drives: bool, is_on_route: bool) -> bool:
        """Evaluates the location in a report. Returns whether that is a new one.

        is_covered  -- the robot is on a place that it was granted
        is_obedient -- the robot drives a route that it was given here, or it drives nothing
        drives      -- it drives that route, or has just come to its end
        is_on_route -- it is on a place that it was granted, and has not driven all of them
        """
        self.clock_is_off = report.is_ahead
        self.foreign = () if is_obedient else report.left
        point = report.located(graph)
        told = report.stamp, point
        if report.stamp and told == self._told:
            return False
        self._told = told
        if point is None:
            self._strays += 1
            return False
        before, self.location = self._stays_at or self.location, point
        self.reach = 0.0
        self.outliers = tuple(
            judged for judged in (_judged(outlier, point) for outlier in self.outliers)
            if judged.disproofs < DISPROOFS)
        has_left = before is not None and math.dist(before, point) > TREMBLE
        is_explained = self._may_come_from_drive(report, point, is_on_route)
        if (self._stays_at is None or has_left or drives
                or not 0.0 < self._stays_since <= report.stamp):
            self._stays_at, self._stays_since = point, report.stamp
        # Without a stamp it is not known for how long the robot has stayed.
        has_stayed = (report.stamp - self._stays_since >= _STANDING if report.stamp
                      else not has_left)
        self._is_moved = not is_obedient or not (drives or has_stayed) and (
            self._is_moved or has_left and not is_explained)
        if drives or has_stayed:
            self._drove_to = (point, report.stamp) if drives else None
        # A robot that stands does not grow, however late its report arrives.
        self._age = 0.0 if has_stayed and not report.is_running else report.age
        if is_covered:
            self._strays = 0
        else:
            self._stray(point)
        return True

    def _may_come_from_drive(self, report: Report, point: Point, is_on_route: bool) -> bool:
        """May the robot have come here by the end of its own drive, and by braking after it?

        It may have driven unheard on places that it was granted: since its last report, or since
        its last location in the journal.
        """
        if report.reason.code is ReasonCode.TAKEN_OVER:
            return False
        if self._stays_at is None:
            return is_on_route
        if self._drove_to is None:
            return False
        end, stamp = self._drove_to
        return is_on_route and self._stays_since == stamp or (
            report.stamp - stamp <= _BRAKING
            and math.dist(end, point) <= self._stopping + TREMBLE)

    def uncover(self) -> None:
        """The robot does not hold the place of its last location any more: that is an outlier now.
        """
        if self.location is not None:
            self._stray(self.location)

    def _stray(self, point: Point) -> None:
        self._strays += 1
        self.outliers = (*(one for one in self.outliers
                           if math.dist(one.point, point) > TREMBLE), Outlier(point, self._age))

    def grow(self, age: float) -> bool:
        """Grows the area around the last location, which is `age` s old. Returns whether it grew.

        Only a robot that another giver was moving may have moved since. The robot counts as moved
        until it stays in one place for a second, so slow driving counts, too.
        """
        if not self._is_moved or self.is_absent:
            return False
        reach = min((age + CLOCK_ERROR + _LOOK) * self._kind.speed, MANUAL_REACH)
        reach = min(math.ceil(reach / _STEP) * _STEP, MANUAL_REACH)
        if reach <= self.reach:
            return False
        self.reach = reach
        return True

    def settle(self) -> None:
        """The robot stands where it is known to stand, so all other evidence is void."""
        self.outliers, self.lost, self.foreign, self.reach = (), (), (), 0.0
        self._strays, self._is_moved = 0, False

    def lose(self, areas: Tuple[Area, ...]) -> None:
        """Adds the areas of edges that the robot held and that the graph in force does not have."""
        self.lost = (*self.lost, *areas)

    def leave_lost(self, margin: float) -> None:
        """Drops the lost areas that are farther than `margin` (m) from the robot's location."""
        here = self.location
        if here is not None:
            self.lost = tuple(area for area in self.lost
                              if are_nearer(area.line, (here,), area.radius + margin))

    # -- robots that are not on the site ----------------------------------------------------------

    def declare_absent(self, now: float) -> None:
        """A person declares that the robot is not on the site. `now` is the supervisor's time."""
        self.settle()
        self.location = None
        self.is_absent, self._absent_since = True, now

    def is_back(self, report: Report, now: float) -> bool:
        """Was this location, which arrived at `now`, taken after the robot was declared absent?"""
        return now - max(report.age, 0.0) > self._absent_since

    # -- storing and restoring --------------------------------------------------------------------

    @property
    def memory(self) -> EvidenceMemory:
        """The evidence to be stored."""
        return EvidenceMemory(self.outliers, self.lost, self.foreign, self.reach, self.location,
                              self.is_absent, self._is_moved)

    @property
    def progress(self) -> EvidenceMemory:
        """The part of the evidence that must be stored as soon as a report changes it.

        The location counts only while another giver moves the robot, in squares of 1 m. Its reach
        does not count: `restore` sets the largest one for such a robot.
        """
        here = self.location if self._is_moved else None
        square = None if here is None else (here[0] // _SQUARE, here[1] // _SQUARE)
        return self.memory._replace(location=square, reach=0.0)

    def restore(self, memory: EvidenceMemory, now: float) -> None:
        """Sets the evidence to its state before a restart. `now` is the supervisor's time.

        A robot that another giver moved may have been moved on since: how long is not known.
        """
        (self.outliers, self.lost, self.foreign, self.reach, self.location,
         self.is_absent, self._is_moved) = memory
        if self._is_moved:
            self.reach = MANUAL_REACH + math.hypot(_SQUARE, _SQUARE)
        self._absent_since = now


def _judged(outlier: Outlier, point: Point) -> Outlier:
    """An outlier with its count of disproofs updated by a later location."""
    is_elsewhere = math.dist(outlier.point, point) > NEAR
    return replace(outlier, disproofs=outlier.disproofs + 1 if is_elsewhere else 0)
