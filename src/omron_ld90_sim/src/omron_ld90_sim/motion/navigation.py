"""Plans courses for the base around obstacles, from a standstill or during a drive."""
from __future__ import annotations

from dataclasses import replace
from typing import List, Optional, Sequence

import numpy as np

from omron_ld90_sim.motion.base import Base
from omron_ld90_sim.motion.floor import SimFloor
from omron_ld90_sim.motion.kinematics import SimPose
from omron_ld90_sim.motion.manoeuvres import manoeuvres
from omron_ld90_sim.motion.planner import Blocked, NoWay, PlannedWay, planner_for
from omron_ld90_sim.motion.space import Disc
from omron_ld90_sim.motion.track import SmoothTrack

LOOK_AHEAD = 600.0          # mm beyond the stopping distance that must be free of obstacles
FARTHEST_STOP = 3000.0      # mm that another robot needs to stop, plus its size
SHORTEST_LEAD = 5.0         # mm that must be left on a track for a new course to begin on it
JOIN_AHEAD = 300.0          # mm beyond the stopping distance at which a new course begins
PLAN_AROUND = 8000.0        # mm within which paths avoid other robots
LOOK_STEP = 200.0           # mm between the examined places
STOP_STEP = 600.0           # mm between the discs that represent a braking robot
_ANGLES = np.radians(np.arange(0, 360, 30))
RING = np.column_stack([np.cos(_ANGLES), np.sin(_ANGLES)])      # a circle for the laser


class Navigation:
    """Plans for one base on one floor, around the obstacles that are not on the map."""

    def __init__(self, base: Base, floor: SimFloor) -> None:
        self.base = base
        self.blocks: List[Disc] = []                # obstacles other than robots
        self.neighbours: Sequence[Navigation] = ()  # the other robots
        self.speed_limit: Optional[float] = None    # mm/s
        self.change_floor(floor)

    def change_floor(self, floor: SimFloor) -> None:
        """Plans on another floor from now on."""
        self.floor, self.planner = floor, planner_for(floor)

    def obstacles(self, within: float = PLAN_AROUND) -> List[Disc]:
        """Returns the obstacles that are not on the map, and the other robots within `within` mm.

        A moving robot blocks its place, the place where it could come to rest, and the places
        between these two.
        """
        radius = self.floor.body.half_diagonal
        return [*self.blocks,
                *(Disc(place.x, place.y, radius) for place in self._stops(within))]

    def _stops(self, within: float) -> List[SimPose]:
        """Returns the places of other robots within `within` mm, and the places that they will pass
        until they could come to rest.
        """
        stops = []
        for other in self._near(within):
            base, track = other.base, other.base.track
            stops.append(base.pose)
            if track is not None and base.speed > 0.0:
                rest = base.stopping_distance()
                parts = int(rest / STOP_STEP) + 1
                stops += [track.pose_at(base.place + rest * part / parts)
                          for part in range(1, parts + 1)]
        return stops

    def _near(self, within: float) -> List[Navigation]:
        x, y = self.base.pose.x, self.base.pose.y
        return [other for other in self.neighbours
                if abs(other.base.pose.x - x) < within and abs(other.base.pose.y - y) < within]

    def outlines(self, within: float) -> List[np.ndarray]:
        """Returns the obstacles for the laser: the corners (K, N, 2) of robots and of blocks."""
        robots, rest = [other.base.pose for other in self._near(within)], self.blocks
        outlines = [self.floor.body.outlines(robots)] if robots else []
        if rest:
            outlines.append(np.array([[[disc.x, disc.y]] + disc.radius * RING for disc in rest]))
        return outlines

    def set_course(self, x: float, y: float, heading: Optional[float]) -> None:
        """Sends the base to a place, from standing or while it drives forwards.

        Raises `Blocked` if temporary obstacles bar all paths, and `NoWay` if there is no path.
        """
        base, limits, track = self.base, self.base.limits, self.base.track
        if self.speed_limit is not None:
            limits = replace(limits, speed=min(limits.speed, self.speed_limit))
        if track is None or base.speed == 0.0:
            way = self._plan(base.pose, x, y, heading)
            base.follow(manoeuvres(way, self.planner, limits))
        else:
            join = self._join(track)
            way = self._plan(track.pose_at(join), x, y, heading)
            lead_in = track.cut(base.place, join)
            base.follow(manoeuvres(way, self.planner, limits, lead_in, base.speed))

    def _plan(self, start: SimPose, x: float, y: float, heading: Optional[float]) -> PlannedWay:
        obstacles = self.obstacles()
        try:
            return self.planner.plan(start, x, y, heading, obstacles)
        except NoWay as reason:
            if not obstacles:
                raise
            self.planner.plan(start, x, y, heading)     # NoWay: obstacles are not the cause
            raise Blocked(str(reason)) from reason

    @property
    def can_set_course(self) -> bool:
        """Whether the base stands, or drives forwards and is not about to arrive."""
        base, track = self.base, self.base.track
        return base.still or (track is not None and not track.reverse
                              and track.length - base.place > SHORTEST_LEAD)

    def _join(self, track: SmoothTrack) -> float:
        """Returns the arc length at which a new track can begin: with room to turn and to brake."""
        first = self.base.place + self.base.stopping_distance() + JOIN_AHEAD
        for s in map(float, np.arange(first, track.length, LOOK_STEP)):
            pose = track.pose_at(s)
            if (track.curvature_at(s) == 0.0 and self.floor.clearance_of(pose.x, pose.y)
                    >= self.planner.turn_clearance):
                return s
        return track.length

    def blocked_ahead(self) -> bool:
        """Returns whether the body would soon come too near to an obstacle if it did not brake.

        If each robot brakes as soon as this is true for it, robots never touch each other, and each
        has room to turn where it comes to rest.
        """
        base, track = self.base, self.base.track
        if base.still or base.braking or not (self.blocks or self.neighbours):
            return False
        reach = base.stopping_distance() + LOOK_AHEAD
        obstacles = self.obstacles(within=reach + FARTHEST_STOP)
        if not obstacles:
            return False
        if track is None:       # turning: only obstacles inside the turning circle count
            return self._circle_taken()
        end = min(base.place + reach, track.length)
        count = int((end - base.place) / LOOK_STEP) + 2
        gaps = self._gaps([track.pose_at(s) for s in np.linspace(base.place, end, count)],
                          obstacles)
        # the robot may drive away from an obstacle that is already too near, but not nearer to it
        return float(gaps[1:].min()) < min(float(gaps[0]), 0.0) - 1.0

    def _gaps(self, poses: Sequence[SimPose], obstacles: Sequence[Disc]) -> np.ndarray:
        """Returns the distances from the body at each pose to the nearest obstacle (mm).

        A distance is negative if the obstacle overlaps the body.
        """
        discs = np.array([(disc.x, disc.y, disc.radius) for disc in obstacles])
        return (self.floor.body.distances(poses, discs[:, :2]) - discs[:, 2]).min(axis=1)

    def _circle_taken(self) -> bool:
        """Returns whether something is in the turning circle, or could come to rest there."""
        here, body = self.base.pose, self.floor.body
        within = body.half_diagonal
        stops = self._stops(FARTHEST_STOP)
        return (any(here.distance_to(disc.x, disc.y) < disc.radius + within
                    for disc in self.blocks)
                or bool(stops) and body.distances(stops, [(here.x, here.y)]).min() < within)
