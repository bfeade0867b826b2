"""The motion of a vehicle that follows edges exactly: its position, speed and heading over time.

If the next edge has another direction, the vehicle stops and turns on the spot. A vehicle that can
drive backwards turns by the smaller angle, at most 90 degrees, and then drives with that end ahead.
It does not stop between edges that continue smoothly.
Units are m, s and rad.
"""
from __future__ import annotations

import math
from typing import Iterator, Optional, Sequence, Tuple

from fleet_simulation.agv.speed_limits import DriveLimits, SpeedLimits, angle_between
from trajectory_graph import Graph

STEP = 0.05        # s of simulated time between two decisions about the speed
AT_REST = 1e-9     # m/s and rad/s: a lower speed is standing
ON_PLACE = 1e-4    # m and rad: a smaller distance is none
_EXACT = 1e-6      # m2/s2, tolerance of a squared speed for rounding


class AgvMotion:
    """The motion of one vehicle along a path of signed edges.

    Place, speed and heading change together in each step.

    path, index  -- edges in driving order, and the index of its edge; len(path) at the end
    arc          -- m from the start of its edge
    vertex       -- vertex on which it stands; None between vertices and while it moves
    """

    def __init__(self, graph: Graph, limits: DriveLimits, speeds: SpeedLimits,
                 vertex: int) -> None:
        self.graph, self.limits, self.speeds = graph, limits, speeds
        self.path: Tuple[int, ...] = ()
        self.index = 0
        self.arc = 0.0
        self.vertex: Optional[int] = vertex
        self.speed = 0.0
        self.heading = graph.vertex(vertex).theta
        self.pace = 1.0
        """Factor on all speeds, above 0 and at most 1."""
        self._turn_rate = 0.0
        self._turn_to: Optional[float] = None  # heading to turn to before it drives
        self._backwards = False                # whether its rear is ahead

    @property
    def edge(self) -> Optional[int]:
        """The signed id of its edge, at the end of the path the last one; None without a path."""
        return self.path[min(self.index, len(self.path) - 1)] if self.path else None

    @property
    def at_end(self) -> bool:
        """Whether it is at the end of the path, or has none."""
        return self.index >= len(self.path)

    @property
    def at_rest(self) -> bool:
        """Whether it neither drives nor turns."""
        return self.speed < AT_REST and abs(self._turn_rate) < AT_REST

    @property
    def pose(self) -> Tuple[float, float, float]:
        """x, y and heading in the map frame."""
        if self.edge is None:
            assert self.vertex is not None
            return (*self.graph.vertex(self.vertex).position, self.heading)
        curve = self.graph.curve(self.edge)
        x, y = curve.point_at(curve.length if self.at_end else self.arc)
        return x, y, self.heading

    def can_follow(self, path: Sequence[int], index: int, arc: float) -> bool:
        """Returns whether it can continue on this path at its speed:
        it can brake for each limit ahead.
        """
        return all(self.speed ** 2 <= limit ** 2 + 2.0 * self.limits.braking * distance + _EXACT
                   for distance, limit in self._ahead(path, index, arc, self._braking_distance()))

    def follow(self, path: Sequence[int], index: int, arc: float) -> None:
        """Replaces the path. On the new one it is `arc` m along the edge `index`, or at the end."""
        goes_on = not self.at_end and index < len(path) and path[index] == self.edge
        self.path, self.index, self.arc = tuple(path), index, arc
        if index < len(path) and not goes_on:
            self._face_ahead()

    def advance(self, seconds: float, hold: bool = False, emergency: bool = False) -> None:
        """Simulates this time. With `hold` it brakes until it stands, with `emergency` harder."""
        if self.at_rest and (hold or (self.at_end and self._turn_to is None)):
            return
        steps = max(1, math.ceil(seconds / STEP - 1e-9))
        for _ in range(steps):
            self._step(seconds / steps, hold, emergency)
        self._update_place()

    # --- one step ---------------------------------------------------------------------------------

    def _step(self, dt: float, hold: bool, emergency: bool) -> None:
        braking = self.limits.emergency_braking if emergency else self.limits.braking
        if self._turn_to is not None and self.speed < AT_REST:
            self._turn(dt, hold)
        elif hold:
            self._move(max(0.0, self.speed - braking * dt), dt)
        elif not self.at_end:
            slowest = self.speed - braking * dt
            fastest = self.speed + self.limits.acceleration * dt
            self._move(max(min(fastest, self._allowed(dt)), slowest, 0.0), dt)

    def _turn(self, dt: float, hold: bool) -> None:
        assert self._turn_to is not None
        left = angle_between(self.heading, self._turn_to)
        if abs(left) < ON_PLACE:
            self.heading, self._turn_rate, self._turn_to = self._turn_to, 0.0, None
            return
        gain = self.limits.turn_acceleration * dt
        allowed = 0.0 if hold else speed_towards(abs(left), 0.0, self._turn_rate,
                                                 self.limits.turn_acceleration, dt)
        rate = max(min(self._turn_rate + gain, self.limits.turn_rate * self.pace, allowed),
                   self._turn_rate - gain, 0.0)
        turned = min((self._turn_rate + rate) / 2.0 * dt, abs(left))
        self.heading = angle_between(0.0, self.heading + math.copysign(turned, left))
        self._turn_rate = rate

    def _allowed(self, dt: float) -> float:
        """Returns the highest speed (m/s) after this step from
        which it can brake for each limit ahead.
        """
        assert self.edge is not None
        highest = self.pace * [limit for arc, limit in self.speeds.along(self.edge)
                               if arc <= self.arc + 1e-9][-1]
        top = self.speed + self.limits.acceleration * dt
        horizon = top * top / (2.0 * self.limits.braking) + top * dt + 0.1
        for distance, limit in self._ahead(self.path, self.index, self.arc, horizon):
            highest = min(highest, speed_towards(distance, self.pace * limit, self.speed,
                                                 self.limits.braking, dt))
        return highest

    def _ahead(self, path: Sequence[int], index: int, arc: float,
               horizon: float) -> Iterator[Tuple[float, float]]:
        """Yields the distances (m) at which speed limits (m/s) begin; the path's end is a limit of
        0."""
        base = -arc
        for number in range(index, len(path)):
            for begin, limit in self.speeds.along(path[number]):
                if base + begin > 0.0:
                    yield base + begin, limit
            base += self.graph.curve(path[number]).length
            if number + 1 == len(path) or self.speeds.stops_between(*path[number:number + 2]):
                yield max(base, 0.0), 0.0
                return
            if base > horizon:
                return

    def _move(self, speed: float, dt: float) -> None:
        self.arc += (self.speed + speed) / 2.0 * dt
        self.speed = speed
        while not self.at_end:
            length = self.graph.curve(self.path[self.index]).length
            last = self.index + 1 == len(self.path)
            stops = last or self.speeds.stops_between(*self.path[self.index:self.index + 2])
            if self.arc < length - (ON_PLACE if stops and speed < 0.01 else 0.0):
                break
            left_over = self.arc - length
            self.index += 1
            self.arc = 0.0
            if not stops:
                self.arc = left_over
                continue
            self.speed = 0.0
            self._face_along(self.path[self.index - 1], length)
            if not last:
                self._face_ahead()

    def _face_along(self, edge: int, arc: float) -> None:
        """Sets the heading to that of the curve of an edge."""
        ahead = self.graph.curve(edge).heading_at(arc)
        self.heading = angle_between(math.pi if self._backwards else 0.0, ahead)

    def _update_place(self) -> None:
        """Sets the heading on the curve, and the vertex on which the vehicle stands."""
        edge = self.edge
        if edge is None:
            return
        if self._turn_to is None:
            self._face_along(edge, self.graph.curve(edge).length if self.at_end else self.arc)
        self.vertex = None
        if self.speed < AT_REST and (self.at_end or self.arc < ON_PLACE):
            self.vertex = (self.graph.end_vertex(edge) if self.at_end
                           else self.graph.start_vertex(edge)).id

    def _face_ahead(self) -> None:
        """Chooses the end that is ahead on the edge that begins, and the heading to turn to."""
        ahead = self.graph.curve(self.path[self.index]).heading_at(self.arc)
        self._backwards = self.limits.reverses and abs(
            angle_between(self.heading, ahead)) > math.pi / 2.0
        facing = angle_between(math.pi, ahead) if self._backwards else ahead
        self._turn_to = facing if abs(angle_between(self.heading, facing)) > ON_PLACE else None

    def _braking_distance(self) -> float:
        return self.speed ** 2 / (2.0 * self.limits.braking) + 0.1


def speed_towards(distance: float, limit: float, speed: float, braking: float, dt: float) -> float:
    """Returns the highest speed after `dt` from which braking still reaches `limit` at `distance`.

    It is the v' that solves (v + v') / 2 dt + (v'^2 - limit^2) / (2 braking) = distance, and at
    least `limit`.
    """
    half = braking * dt / 2.0
    root = half * half - 2.0 * half * speed + limit * limit + 2.0 * braking * distance
    return max(limit, math.sqrt(root) - half) if root > 0.0 else limit
