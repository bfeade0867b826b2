"""Finds paths across the floor: straight segments between points where the robot can turn.

The body is 699 x 500 mm. So a place can be wide enough to drive through (half width free) but too
narrow to turn in (half diagonal free). A path is therefore a chain of straight segments with half
the width free everywhere. Its inner vertices have half the diagonal free, so that the body touches
nothing there in any heading. `manoeuvres` rounds the vertices.
"""
from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import List, Optional, Sequence, Set, Tuple

import numpy as np
from skimage.graph import MCP_Geometric

from omron_ld90_sim.motion.floor import SimFloor
from omron_ld90_sim.motion.kinematics import SimPose
from omron_ld90_sim.motion.space import LOOK_STEP, Disc, Space

DRIVE_MARGIN = 15.0     # mm added to the half width
TURN_MARGIN = 5.0       # mm added to the half diagonal
COMFORT = 700.0         # mm; a clearance above this is not worth a detour
NARROW_COST = 8.0       # cost factor of places where the robot cannot turn
CLOSED = -1.0           # cost of a cell that no path may use
ESCAPE = 3000.0         # mm straight ahead or back within which room to turn is searched
ATTEMPTS = 6
SEARCH_AROUND = 4000.0  # mm around robot and goal within which a path is searched first
TURN_NEAR = 300.0       # mm around the ends of a narrow place to search for places to turn
TURN_PLACES = 80        # largest number of these places
COARSELY = 5            # every fifth point of many straights is examined first
DETOUR = 2.5            # highest cost of a path near the ends, as a multiple of a free straight


class NoWay(Exception):
    """There is no path for the body from the start to the goal."""


class Blocked(NoWay):
    """Only obstacles that are not on the map bar all paths."""


@dataclass(frozen=True)
class PlannedWay:
    """A path along `vertices`; before it, if necessary, a straight drive out of a narrow place."""

    start: SimPose
    escape: float               # mm straight ahead first; negative: backwards; 0: turn on the spot
    vertices: np.ndarray        # (N, 2); the first one is the end of the escape
    final_heading: Optional[float]
    space: Space                # the space in which it was planned

    @property
    def length(self) -> float:
        """Millimetres along the straight segments."""
        return abs(self.escape) + float(np.hypot(*np.diff(self.vertices, axis=0).T).sum())


class Planner:
    """Plans on one `SimFloor`."""

    def __init__(self, floor: SimFloor) -> None:
        self.floor = floor
        body = floor.body
        self.drive_clearance = body.half_width + DRIVE_MARGIN
        self.turn_clearance = body.half_diagonal + TURN_MARGIN
        clearance = floor.planning_clearance
        cost = 1.0 + 2.0 * np.clip((COMFORT - clearance) / COMFORT, 0.0, 1.0)
        cost[clearance < self.turn_clearance] = NARROW_COST
        cost[clearance < self.drive_clearance] = CLOSED
        self._cost = cost

    def plan(self, start: SimPose, goal_x: float, goal_y: float, heading: Optional[float] = None,
             obstacles: Sequence[Disc] = ()) -> PlannedWay:
        """Returns the path from `start` to a point, with a turn to `heading` (deg) at its end.

        Raises NoWay.
        """
        space = Space(self.floor, obstacles)
        escape = self._escape(space, start)
        first = start.ahead(escape)
        goal = np.array([goal_x, goal_y])
        approach = self._approach(space, goal, heading)
        cost = self._cost_among(space.obstacles)
        for _ in range(ATTEMPTS):
            raw = self._search(cost, (first.x, first.y), approach)
            vertices, stuck = self._straighten(space, raw)
            if stuck is None:
                break
            cost[stuck[:, 0], stuck[:, 1]] = CLOSED
        else:
            raise NoWay('no way with room to turn')
        if not np.array_equal(approach, goal):
            vertices = np.vstack([vertices, goal])
        elif len(vertices) > 1 and heading is None:
            last = vertices[-1] - vertices[-2]
            arrival = SimPose(goal_x, goal_y, math.degrees(math.atan2(last[1], last[0])))
            if not space.body_fits(arrival, DRIVE_MARGIN):
                raise NoWay('the body does not fit at the goal')
        return PlannedWay(start, escape, vertices, heading, space)

    def can_turn(self, pose: SimPose, obstacles: Sequence[Disc] = ()) -> bool:
        """Returns whether there is room to turn on the spot."""
        return Space(self.floor, obstacles).clearance_of(pose.x, pose.y) >= self.turn_clearance

    def straight_is_free(self, start: SimPose, distance: float,
                         obstacles: Sequence[Disc] = ()) -> bool:
        """Returns whether the body can drive straight on by `distance` mm (back when negative)."""
        space, end = Space(self.floor, obstacles), start.ahead(distance)
        return (space.straight_is_free(np.array([start.x, start.y]), np.array([end.x, end.y]),
                                       self.drive_clearance) and space.body_fits(end, DRIVE_MARGIN))

    def _cost_among(self, obstacles: Sequence[Disc]) -> np.ndarray:
        """Returns a copy of the costs that includes the obstacles."""
        cost, pitch = self._cost.copy(), self.floor.planning_pitch
        for disc in obstacles:
            row, column = self.floor.planning_cell(disc.x, disc.y)
            n = int((disc.radius + self.turn_clearance) / pitch) + 1
            top, left = max(row - n, 0), max(column - n, 0)
            window = cost[top:row + n + 1, left:column + n + 1]
            rows = self.floor.origin[1] + (top + np.arange(window.shape[0])) * pitch
            columns = self.floor.origin[0] + (left + np.arange(window.shape[1])) * pitch
            away = np.hypot(columns[None, :] - disc.x, rows[:, None] - disc.y) - disc.radius
            window[(away < self.turn_clearance) & (window > 0)] = NARROW_COST
            window[away < self.drive_clearance] = CLOSED
        return cost

    def _escape(self, space: Space, start: SimPose) -> float:
        """Returns how far to drive straight until there is room to turn (negative: backwards)."""
        here = space.clearance_of(start.x, start.y)
        if here >= self.turn_clearance:
            return 0.0
        steps = np.arange(20.0, ESCAPE, 20.0)
        found = []
        for sign in (1.0, -1.0):
            end = start.ahead(sign)
            direction = np.array([end.x - start.x, end.y - start.y])
            clear = space.clearance_at(np.array([start.x, start.y]) + steps[:, None] * direction)
            room = np.flatnonzero(clear >= self.turn_clearance)
            if len(room) and clear[:room[0]].min(initial=np.inf) >= min(here,
                                                                        self.drive_clearance) - 1.0:
                found.append(sign * steps[room[0]])
        if not found:
            raise NoWay('no room to turn, ahead or behind')
        return float(min(found, key=abs))

    def _approach(self, space: Space, goal: np.ndarray, heading: Optional[float]) -> np.ndarray:
        """Returns the point at which the robot turns into the last straight to the goal.

        This is the goal itself if the robot can turn there, or need not turn.
        """
        here = space.clearance_of(*goal)
        if here >= self.turn_clearance:
            return goal
        if here < self.drive_clearance:
            raise NoWay('no room at the goal')
        if heading is None:
            return goal
        pose = SimPose(float(goal[0]), float(goal[1]), heading)
        if not space.body_fits(pose, DRIVE_MARGIN):
            raise NoWay('the body does not fit at the goal')
        for back in np.arange(20.0, ESCAPE, 20.0):
            behind = pose.ahead(-float(back))
            clear = space.clearance_of(behind.x, behind.y)
            if clear >= self.turn_clearance:
                return np.array([behind.x, behind.y])
            if clear < self.drive_clearance:
                break
        raise NoWay('no room to turn before the goal')

    def _search(self, cost: np.ndarray, start: Tuple[float, float], goal: np.ndarray) -> np.ndarray:
        """Returns the cheapest chain of points over the planner's grid, with exact ends."""
        first = self.floor.planning_cell(*start)
        last = self.floor.planning_cell(*goal)
        saved = {cell: cost[cell] for cell in (first, last)}
        for cell in saved:
            cost[cell] = max(cost[cell], 1.0)
        cells = self._search_near(cost, np.array(first), np.array(last))
        if cells is None:
            cells, _ = _cheapest(cost, first, last)
        for cell, value in saved.items():
            cost[cell] = value
        if cells is None:
            raise NoWay('goal and robot are not connected')
        points = self.floor.planning_points(cells)
        inner = points[1:-1] if len(points) > 2 else points[:0]
        return np.vstack([start, inner, goal])

    def _search_near(self, cost: np.ndarray, first: np.ndarray, last: np.ndarray
                     ) -> Optional[np.ndarray]:
        """Returns the cheapest chain of cells near the two ends, faster than a full search.

        Returns None if a path farther away might be cheaper.
        """
        margin = int(SEARCH_AROUND / self.floor.planning_pitch)
        low = np.maximum(np.minimum(first, last) - margin, 0)
        high = np.maximum(first, last) + margin + 1
        window = cost[low[0]:high[0], low[1]:high[1]]
        if window.size > cost.size / 2:
            return None
        cells, total = _cheapest(window, tuple(first - low), tuple(last - low))
        straight = float(np.hypot(*(last - first)))
        return cells + low if cells is not None and total <= DETOUR * straight else None

    def _straighten(self, space: Space, raw: np.ndarray
                    ) -> Tuple[np.ndarray, Optional[np.ndarray]]:
        """Joins turnable points of `raw` by long straights. Returns (their vertices, None).

        If a place cannot be passed, returns (the vertices before it, the cells of the place).
        """
        clear = space.clearance_at(raw)
        last = len(raw) - 1
        turnable = clear >= self.turn_clearance
        turnable[-1] = True
        i, vertices = 0, [raw[0]]
        spare: Set[int] = set()     # indices of vertices that may be needless
        while i < last:
            candidates = i + 1 + np.flatnonzero(turnable[i + 1:])
            j = self._farthest(space, raw, clear, i, candidates)
            if j is None:
                j = int(candidates[0])
                through = self._through(space, raw[i], raw[j])
                if through is None:
                    cells = [self.floor.planning_cell(x, y) for x, y in raw[i + 1:max(j, i + 2)]]
                    return np.array(vertices), np.array(cells)
                spare |= {len(vertices) - 1, len(vertices) + len(through)}
                vertices += through
            vertices.append(raw[j])
            i = j
        return self._without(spare, vertices, space), None

    def _without(self, spare: Set[int], vertices: Sequence[np.ndarray], space: Space) -> np.ndarray:
        """Returns the vertices. Leaves out needless vertices whose indices are in `spare`.

        A vertex is needless if the straight between its neighbours is free.
        """
        kept = [vertices[0]]
        for k in range(1, len(vertices)):
            if k not in spare or k + 1 == len(vertices) or not space.straight_is_free(
                    kept[-1], vertices[k + 1], self.drive_clearance):
                kept.append(vertices[k])
        return np.array(kept)

    def _through(self, space: Space, a: np.ndarray, b: np.ndarray) -> Optional[List[np.ndarray]]:
        """Returns the points at which the robot must turn, in addition to `a` and `b`, to drive
        straight through the narrow place between them; None: this is impossible.

        Uses one turnable point near `a` and one near `b`: the pair with the largest clearance
        between the two. The planner's grid is too coarse for a gap hardly wider than the body.
        """
        before, behind = self._turnable_near(space, a, b), self._turnable_near(space, b, a)
        first, second = (index.ravel() for index in np.indices((len(before), len(behind))))
        fractions = np.linspace(0.0, 1.0, int(np.hypot(*(b - a)) / LOOK_STEP) + 2)
        for looked_at in (fractions[::COARSELY], fractions):    # coarse, then fine
            room = space.clearance_along(before[first], behind[second], looked_at)
            free = room >= self.drive_clearance
            first, second, room = first[free], second[free], room[free]
            if not len(room):
                return None
        best = int(room.argmax())
        return [place for place, end in ((before[first[best]], a), (behind[second[best]], b))
                if not np.array_equal(place, end)]

    def _turnable_near(self, space: Space, end: np.ndarray, other: np.ndarray) -> np.ndarray:
        """Returns points (N, 2): `end`, then places to turn that a straight from `end` reaches.

        If there are too many such places, returns those nearest to `other`.
        """
        if space.clearance_of(*end) < self.turn_clearance:
            return end[None]
        offsets = np.arange(-TURN_NEAR, TURN_NEAR + 1.0, self.floor.resolution)
        places = end + np.stack(np.meshgrid(offsets, offsets), axis=-1).reshape(-1, 2)
        places = places[np.hypot(*(places - end).T) <= TURN_NEAR]
        places = places[space.clearance_at(places) >= self.turn_clearance]
        places = places[np.argsort(np.hypot(*(places - other).T), kind='stable')[:TURN_PLACES]]
        room = space.clearance_along(end[None], places,
                                     np.linspace(0.0, 1.0, int(TURN_NEAR / LOOK_STEP) + 2))
        return np.vstack((end, places[room >= self.drive_clearance]))

    def _farthest(self, space: Space, raw: np.ndarray, clear: np.ndarray, i: int,
                  candidates: np.ndarray) -> Optional[int]:
        reach = len(candidates)
        while reach > 0:
            j = int(candidates[reach - 1])
            keep = min(COMFORT, float(clear[i:j + 1].min())) - 20.0
            if space.straight_is_free(raw[i], raw[j], max(self.drive_clearance, keep)):
                return j
            reach = reach * 3 // 4 if reach > 8 else reach - 1
        if len(candidates) and space.straight_is_free(raw[i], raw[int(candidates[0])],
                                                      self.drive_clearance):
            return int(candidates[0])
        return None


def _cheapest(cost: np.ndarray, first: Tuple[int, int], last: Tuple[int, int]
              ) -> Tuple[Optional[np.ndarray], float]:
    """Returns the cells (N, 2) of the cheapest chain over a grid (None: there is none), and the
    cost of the chain.
    """
    search = MCP_Geometric(cost)
    totals, _ = search.find_costs([first], [last])
    total = float(totals[last])
    return (np.array(search.traceback(last)) if math.isfinite(total) else None), total


@lru_cache(maxsize=4)
def planner_for(floor: SimFloor) -> Planner:
    """Returns the planner of a floor; robots on one floor share it."""
    return Planner(floor)
