"""How the base gets its courses: from standing or out of its motion, around what is in the way."""
from __future__ import annotations

from dataclasses import replace
from typing import Dict, List, Optional, Sequence

import numpy as np

from omron_ld90_sim.floor import Floor
from omron_ld90_sim.motion import Base
from omron_ld90_sim.planner import Disc, planner_for
from omron_ld90_sim.track import Track, manoeuvres

LOOK_AHEAD = 600.0          # mm beyond the stopping distance that must be free of obstacles
FARTHEST_STOP = 3000.0      # mm that another robot comes nearer while it stops, and its size
SHORTEST_LEAD = 5.0         # mm left on a track that a new course can still begin on
JOIN_AHEAD = 300.0          # mm beyond the stopping distance where a new course begins
PLAN_AROUND = 8000.0        # mm within which other robots are planned around
LOOK_STEP = 200.0           # mm between the places that are looked at


class Navigation:
    """Plans for one base on one floor, with the obstacles that are not on the map."""

    def __init__(self, base: Base, floor: Floor) -> None:
        self.base = base
        self.blocks: Dict[str, Disc] = {}           # by name
        self.neighbours: Sequence[Navigation] = ()  # the other robots
        self.speed_limit: Optional[float] = None    # mm/s
        self.change_floor(floor)

    def change_floor(self, floor: Floor) -> None:
        """Plans on another floor from now on."""
        self.floor, self.planner = floor, planner_for(floor)

    def obstacles(self, within: float = PLAN_AROUND) -> List[Disc]:
        """Everything in the way that is not on the map, other robots within so many mm.

        A moving neighbour counts where it is, where it could come to rest, and between.
        """
        radius = self.floor.body.half_diagonal
        discs = list(self.blocks.values())
        for other in self._near(within):
            places, track = [other.base.pose], other.base.track
            if track is not None:
                here, rest = other.base.place, other.base.stopping_distance()
                places += [track.pose_at(here + rest / 2), track.pose_at(here + rest)]
            discs += [Disc(place.x, place.y, radius) for place in places]
        return discs

    def _near(self, within: float) -> List[Navigation]:
        x, y = self.base.pose.x, self.base.pose.y
        return [other for other in self.neighbours
                if abs(other.base.pose.x - x) < within and abs(other.base.pose.y - y) < within]

    def outlines(self, within: float) -> List[np.ndarray]:
        """The same as a laser sees it: corners (N, 2) of each obstacle."""
        circle = np.radians(np.arange(0, 360, 30))
        ring = np.column_stack([np.cos(circle), np.sin(circle)])
        return [*(other.floor.body.corners(other.base.pose) for other in self._near(within)),
                *(np.array([disc.x, disc.y]) + disc.radius * ring
                  for disc in self.blocks.values())]

    def set_course(self, x: float, y: float, heading: Optional[float]) -> None:
        """Sends the base to a place, out of standing or of driving forwards; raises `NoWay`."""
        obstacles = self.obstacles()
        base, limits, track = self.base, self.base.limits, self.base.track
        if self.speed_limit is not None:
            limits = replace(limits, speed=min(limits.speed, self.speed_limit))
        if track is None or base.speed == 0.0:
            way = self.planner.plan(base.pose, x, y, heading, obstacles)
            base.follow(manoeuvres(way, self.planner, limits))
        else:
            join = self._join(track)
            way = self.planner.plan(track.pose_at(join), x, y, heading, obstacles)
            lead_in = track.cut(base.place, join)
            base.follow(manoeuvres(way, self.planner, limits, lead_in, base.speed))

    @property
    def can_set_course(self) -> bool:
        """Standing or driving forwards: not turning on the spot, backing up or just arriving."""
        base, track = self.base, self.base.track
        return base.still or (track is not None and not track.reverse
                              and track.length - base.place > SHORTEST_LEAD)

    def _join(self, track: Track) -> float:
        """Where on the present track a new one can begin: room to turn, and far enough to brake."""
        first = self.base.place + self.base.stopping_distance() + JOIN_AHEAD
        for s in np.arange(first, track.length, LOOK_STEP):
            pose = track.pose_at(s)
            if (track.curvature_at(s) == 0.0 and self.floor.clearance_of(pose.x, pose.y)
                    >= self.planner.turn_clearance):
                return float(s)
        return track.length

    def blocked_ahead(self) -> bool:
        """Whether an obstacle is where the base is about to drive."""
        track = self.base.track
        if track is None or self.base.braking or not (self.blocks or self.neighbours):
            return False
        reach = self.base.stopping_distance() + LOOK_AHEAD
        obstacles = self.obstacles(within=reach + FARTHEST_STOP)
        if not obstacles:
            return False
        places = np.arange(self.base.place, min(self.base.place + reach, track.length), LOOK_STEP)
        ahead = [track.pose_at(s) for s in places]
        clear = self.floor.body.half_width
        return any(pose.distance_to(disc.x, disc.y) < disc.radius + clear
                   for pose in ahead for disc in obstacles)
