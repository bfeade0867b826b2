"""Computes motion in closed form as phases of constant acceleration: drives with speed limits,
turns.

Units are m and s; for a turn, rad replaces m.
"""
from __future__ import annotations

import math
from typing import Iterable, List, NamedTuple, Sequence, Tuple

_NONE = 1e-12  # s or m: a shorter phase or stretch is left out


class DrivePhase(NamedTuple):
    """A time of constant acceleration.

    seconds -- how long it lasts
    speed   -- m/s when it begins
    gain    -- m/s2, negative while it brakes
    """

    seconds: float
    speed: float
    gain: float

    def speed_after(self, seconds: float) -> float:
        """Returns the speed (m/s) `seconds` after the phase began."""
        return max(self.speed + self.gain * seconds, 0.0)

    def distance_after(self, seconds: float) -> float:
        """Returns the distance (m) driven in the first `seconds` of the phase."""
        return (self.speed + 0.5 * self.gain * seconds) * seconds

    def seconds_for(self, distance: float) -> float:
        """Returns the seconds that the vehicle needs for the first `distance` m of the phase."""
        if distance <= 0.0:
            return 0.0
        root = math.sqrt(max(self.speed * self.speed + 2.0 * self.gain * distance, 0.0))
        return min(2.0 * distance / max(self.speed + root, _NONE), self.seconds)


def braking_to_rest(speed: float, braking: float) -> List[DrivePhase]:
    """Returns the motion of a vehicle that brakes until it stands."""
    return [DrivePhase(speed / braking, speed, -braking)] if speed > 0.0 else []


def along(stretches: Sequence[Tuple[float, float]], speed: float, acceleration: float,
          braking: float) -> List[DrivePhase]:
    """Returns the fastest motion along these stretches to a stop at their end.

    Where the speed is above the limit, the vehicle brakes.

    stretches -- length (m) and speed limit (m/s) of each
    speed     -- m/s at the start
    """
    # From the last stretch to the first: the highest squared speed at the end of the stretch
    # from which the vehicle can still brake.
    ends = [0.0]
    for before, (length, limit) in zip(stretches[-2::-1], stretches[:0:-1]):
        ends.append(min(before[1] ** 2, limit ** 2, ends[-1] + 2.0 * braking * length))
    phases: List[DrivePhase] = []
    for (length, limit), end in zip(stretches, reversed(ends)):
        own = _over(length, limit, speed, end, acceleration, braking)
        phases += own
        speed = own[-1].speed_after(own[-1].seconds) if own else speed
    return phases


def turn(angle: float, rate: float, top: float, gain: float) -> List[DrivePhase]:
    """Returns the fastest turn by this angle to a stop.

    rate -- rad/s at the start
    top  -- highest rate, rad/s
    gain -- rad/s2 of acceleration and of braking
    """
    return along([(angle, top)], rate, gain, gain)


def seconds_until(phases: Iterable[DrivePhase], distance: float) -> float:
    """Returns the seconds until this distance (m) is driven. Infinite: the motion ends before that.
    """
    passed = 0.0
    for phase in phases:
        whole = phase.distance_after(phase.seconds)
        if distance <= whole:
            return passed + phase.seconds_for(max(distance, 0.0))
        distance -= whole
        passed += phase.seconds
    return math.inf


def _over(length: float, limit: float, speed: float, end: float, acceleration: float,
          braking: float) -> List[DrivePhase]:
    """Returns the motion along one stretch.

    end -- highest squared speed (m2/s2) at the end of the stretch
    """
    if length <= _NONE:
        return []
    phases: List[DrivePhase] = []
    square = speed * speed
    if square - 2.0 * braking * length >= end - 1e-9:  # it must brake along the whole stretch
        last = math.sqrt(max(square - 2.0 * braking * length, 0.0))
        return [DrivePhase(2.0 * length / (speed + last), speed, -braking)]
    if speed > limit:
        phases.append(DrivePhase((speed - limit) / braking, speed, -braking))
        length -= (square - limit * limit) / (2.0 * braking)
        speed, square = limit, limit * limit
    # squared speed at which, without a speed limit, acceleration ends and braking begins
    peak = (2.0 * acceleration * braking * length + braking * square + acceleration * end) / (
        acceleration + braking)
    fastest = square + 2.0 * acceleration * length
    top = min(math.sqrt(min(peak, fastest)), limit)
    last = math.sqrt(min(end, fastest, top * top))
    gained = (top * top - square) / (2.0 * acceleration)
    lost = (top * top - last * last) / (2.0 * braking)
    for seconds, begin, gain in (
            ((top - speed) / acceleration, speed, acceleration),
            ((length - gained - lost) / top, top, 0.0),
            ((top - last) / braking, top, -braking)):
        if seconds > _NONE:
            phases.append(DrivePhase(seconds, begin, gain))
    return phases
