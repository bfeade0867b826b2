"""The motion of a vehicle that follows edges exactly: its position, speed and heading over time.

If the next edge has another direction, the vehicle stops and turns on the spot. A vehicle that can
drive backwards turns until its front or its rear is ahead, so by at most 90 degrees. No vehicle
stops between edges that continue smoothly.

Between two events the motion is known in closed form (`phases`), so one call may simulate a long
time. The phases are computed anew when the path or the pace changes, and when a hold begins or
ends.
Units are m, s and rad.
"""
from __future__ import annotations

import math
from typing import Iterator, List, Optional, Sequence, Tuple

from fleet_simulation.agv import phases
from fleet_simulation.agv.phases import DrivePhase
from fleet_simulation.agv.speed_limits import DriveLimits, SpeedLimits, angle_between
from trajectory_graph import Graph

AT_REST = 1e-9     # m/s and rad/s: a lower speed counts as standing
ON_PLACE = 1e-4    # m and rad: a smaller distance counts as zero
_EXACT = 1e-6      # m, and m2/s2 of a squared speed: tolerance for rounding
_TOGETHER = 1e-9   # s; a shorter time counts as zero


class AgvMotion:
    """The motion of one vehicle along a path of signed edges.

    path, index  -- edges in driving order; index of the present edge, len(path) at the end
    arc          -- m from the start of the present edge
    vertex       -- vertex on which the vehicle stands; None between vertices and while it moves
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
        self.driven = 0.0
        """Distance (m) driven so far."""
        self._phases: List[DrivePhase] = []   # motion up to the next stop, or a turn
        self._cause: Optional[Tuple[object, ...]] = None  # inputs of the phases
        self._turn_rate = 0.0
        self._turn_to: Optional[float] = None  # heading to turn to before it drives
        self._backwards = False                # whether its rear is ahead

    @property
    def edge(self) -> Optional[int]:
        """The signed id of the present edge (at the path's end, of the last edge); None: there is
        no path.
        """
        return self.path[min(self.index, len(self.path) - 1)] if self.path else None

    @property
    def at_end(self) -> bool:
        """Whether it is at the end of the path, or has no path."""
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
        """Returns whether the vehicle can follow this path from its present speed: it has enough
        distance to brake for each speed limit ahead.
        """
        return all(self.speed ** 2 <= limit ** 2 + 2.0 * self.limits.braking * distance + _EXACT
                   for distance, limit in self._ahead(path, index, arc, self._braking_distance()))

    def follow(self, path: Sequence[int], index: int, arc: float) -> None:
        """Replaces the path. The vehicle is `arc` m along edge `index` of the new path, or at the
        path's end.
        """
        goes_on = not self.at_end and index < len(path) and path[index] == self.edge
        self.path, self.index, self.arc = tuple(path), index, arc
        self._cause = None
        if index < len(path) and not goes_on:
            self._face_ahead()

    def stop_dead(self) -> None:
        """Sets the speed to 0 at once, because a person has moved the vehicle."""
        self.speed, self._cause = 0.0, None

    def advance(self, seconds: float, hold: bool = False, emergency: bool = False) -> float:
        """Simulates the next `seconds`; returns for how many of them the vehicle moved.

        With `hold` the vehicle brakes to a stop. If `emergency` is also true, it brakes harder.
        """
        left = seconds
        while left > _TOGETHER and self._wants_to_move(hold):
            left -= self._pass(left, hold, emergency)
        self._update_place()
        return seconds - max(left, 0.0)

    def next_event(self, hold: bool = False, emergency: bool = False) -> float:
        """Returns the seconds until the vehicle ends a turn, passes a vertex or stops; inf: it
        stands.
        """
        if not self._wants_to_move(hold):
            return math.inf
        self._compute(hold, emergency)
        end = sum(phase.seconds for phase in self._phases)
        if not (self._turns or self.at_end):
            end = min(phases.seconds_until(self._phases, self._length - self.arc), end)
        return max(end, 2.0 * _TOGETHER)

    def seconds_until(self, distance: float) -> float:
        """Returns the seconds until the vehicle has driven this distance (m) in its present motion.

        Infinite: the vehicle stops earlier, or must turn before it drives.
        """
        if self._cause is None or self._turn_to is not None:
            return math.inf
        return phases.seconds_until(self._phases, distance)

    # --- between two events -----------------------------------------------------------------------

    @property
    def _turns(self) -> bool:
        return self._turn_to is not None and self.speed < AT_REST

    def _wants_to_move(self, hold: bool) -> bool:
        return not self.at_rest or not hold and not (self.at_end and self._turn_to is None)

    def _compute(self, hold: bool, emergency: bool) -> None:
        """Computes the phases of the motion again if one of their inputs has changed."""
        turns = self._turns
        cause = hold, hold and emergency, turns, self.pace, self.path, self.speeds
        if cause == self._cause:
            return
        self._cause = cause
        limits, braking = self.limits, self.limits.braking
        if hold and emergency:
            braking = limits.emergency_braking
        if turns:
            assert self._turn_to is not None
            angle = abs(angle_between(self.heading, self._turn_to))
            self._phases = (
                phases.braking_to_rest(self._turn_rate, limits.turn_acceleration) if hold else
                phases.turn(angle, self._turn_rate, limits.turn_rate * self.pace,
                            limits.turn_acceleration))
        elif hold:
            self._phases = phases.braking_to_rest(self.speed, braking)
        else:
            self._phases = phases.along(list(self._stretches()), self.speed, limits.acceleration,
                                        braking)

    def _pass(self, seconds: float, hold: bool, emergency: bool) -> float:
        """Simulates `seconds`, but at most to the end of the phase. Returns the time simulated."""
        self._compute(hold, emergency)
        turns = self._turns
        if not self._phases:
            self._end_phases(turns, hold)
            return 0.0
        phase = self._phases[0]
        done = min(seconds, phase.seconds)
        distance, speed = phase.distance_after(done), phase.speed_after(done)
        rest = phase.seconds - done
        if rest > _TOGETHER:
            self._phases[0] = DrivePhase(rest, speed, phase.gain)
        else:
            del self._phases[0]
        if turns:
            self._turn_by(distance, speed)
        else:
            self._move(distance, speed)
        if not self._phases:
            self._end_phases(turns, hold)
        return done

    def _end_phases(self, turns: bool, hold: bool) -> None:
        """Notes that the vehicle stands: its turn has ended, it has arrived at a stop, or it is
        held.
        """
        self._cause = None
        if turns:
            self._turn_rate = 0.0
            if not hold and self._turn_to is not None:
                self.heading, self._turn_to = self._turn_to, None
        else:
            self.speed = 0.0
            if not hold and not self.at_end:
                self._arrive()

    def _turn_by(self, angle: float, rate: float) -> None:
        assert self._turn_to is not None
        left = angle_between(self.heading, self._turn_to)
        turned = min(angle, abs(left))
        self.heading = angle_between(0.0, self.heading + math.copysign(turned, left))
        self._turn_rate = rate

    @property
    def _length(self) -> float:
        return self.graph.curve(self.path[self.index]).length

    def _stops_behind(self, index: int) -> bool:
        """Returns whether the vehicle stops at the end of the edge with this index in its path."""
        return index + 1 == len(self.path) or (
            self.speeds.stops_between(*self.path[index:index + 2]))

    def _stretches(self) -> Iterator[Tuple[float, float]]:
        """Yields length (m) and speed limit (m/s) of each stretch ahead, up to the next stop."""
        begun = self.arc
        for index in range(self.index, len(self.path)):
            limits = self.speeds.along(self.path[index])
            ends = [begin for begin, _ in limits[1:]]
            ends.append(self.graph.curve(self.path[index]).length)
            for (begin, limit), end in zip(limits, ends):
                length = end - max(begin, begun)
                if length > 0.0:
                    yield length, self.pace * limit
            begun = 0.0
            if self._stops_behind(index):
                return

    def _ahead(self, path: Sequence[int], index: int, arc: float,
               horizon: float) -> Iterator[Tuple[float, float]]:
        """Yields the distance (m) to each speed limit ahead, and this limit (m/s). A stop is a
        limit of 0.
        """
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

    def _move(self, distance: float, speed: float) -> None:
        self.arc += distance
        self.driven += distance
        self.speed = speed
        while not self.at_end and self.arc >= self._length - _EXACT:
            if self._stops_behind(self.index):
                if self.arc > self._length + ON_PLACE:  # it was too fast to stop here
                    self._arrive()
                else:
                    self.arc = min(self.arc, self._length)
                return
            self.arc = max(self.arc - self._length, 0.0)
            self.index += 1

    def _arrive(self) -> None:
        """Notes that the vehicle stands at the end of its edge, and begins the turn to the next
        edge.
        """
        length = self._length
        self.index += 1
        self.arc, self.speed, self._cause = 0.0, 0.0, None
        self._face_along(self.path[self.index - 1], length)
        if not self.at_end:
            self._face_ahead()

    def _face_along(self, edge: int, arc: float) -> None:
        """Sets the heading to the direction of an edge at `arc`, or to the opposite if the rear is
        ahead.
        """
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
        """Chooses whether the front or the rear is ahead on the next edge, and sets the heading for
        it.
        """
        ahead = self.graph.curve(self.path[self.index]).heading_at(self.arc)
        self._backwards = self.limits.reverses and abs(
            angle_between(self.heading, ahead)) > math.pi / 2.0
        facing = angle_between(math.pi, ahead) if self._backwards else ahead
        self._turn_to = facing if abs(angle_between(self.heading, facing)) > ON_PLACE else None

    def _braking_distance(self) -> float:
        return self.speed ** 2 / (2.0 * self.limits.braking) + 0.1
