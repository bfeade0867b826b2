"""Estimates a robot's motion from its successive locations. No ROS; metres, radians, seconds.

An ARCL robot sends the pose of its own localization two to ten times a second, but it does not send
the counts of its wheels. The module assumes that the robot drove an arc between two locations. So
its mean speed and turn rate are known, but not its present motion. The variances express this: they
grow with the time between locations.
"""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Optional

from omron_ld90 import robot_model

MAX_GAP = 2.0  # s between two locations; a longer gap gives no velocity

#: Standard deviations of one location (data sheet: 100 mm, taken as two sigma), and then of the
#: change from one location to the next, including the rounding to 1 mm and 1 degree.
POSITION_SIGMA, HEADING_SIGMA = 0.05, math.radians(1.0)
STEP_SIGMA, TURN_SIGMA = 0.005, math.radians(0.5)
SIDEWAYS = 0.1  # m of apparent sideways motion that errors of the locations may cause
TURN_ACCELERATION = math.radians(180.0)  # rad/s2


@dataclass(frozen=True)
class TimedPose:
    """The pose of a robot at a time: s, m and rad in the map."""

    time: float
    x: float
    y: float
    yaw: float


@dataclass(frozen=True)
class MeanMotion:
    """The motion from the previous location to this one: mean values and their variances."""

    speed: float
    """m/s ahead, negative backwards; the robot cannot drive sideways."""
    turn_rate: float
    """rad/s, counter-clockwise."""
    speed_variance: float
    turn_rate_variance: float
    position_variance: float
    """m2, for x and for y of the location."""
    yaw_variance: float


class MotionMeter:
    """Computes the mean motion from each location to the next."""

    def __init__(self) -> None:
        self._last: Optional[TimedPose] = None

    def add(self, location: TimedPose) -> Optional[MeanMotion]:
        """Returns the motion since the previous location.

        None: there was no location within the last MAX_GAP s, or the robot was relocalized, because
        it cannot have driven from the previous location to this one.
        """
        last, self._last = self._last, location
        if last is None or not 0.0 < location.time - last.time <= MAX_GAP:
            return None
        return _between(last, location)


def _between(last: TimedPose, location: TimedPose) -> Optional[MeanMotion]:
    interval = location.time - last.time
    turn = math.remainder(location.yaw - last.yaw, 2.0 * math.pi)
    right, up = location.x - last.x, location.y - last.y
    middle = last.yaw + turn / 2.0  # an arc's chord runs along its mean heading
    chord = right * math.cos(middle) + up * math.sin(middle)
    aside = abs(up * math.cos(middle) - right * math.sin(middle))
    if aside > max(SIDEWAYS, abs(chord)):
        return None
    arc = chord * (turn / 2.0) / math.sin(turn / 2.0) if turn else chord
    speed, turn_rate = arc / interval, turn / interval
    # Within the interval the speed may have changed as far as the acceleration allows, and the
    # location may be as old as the interval is long.
    motion = MeanMotion(
        speed, turn_rate,
        speed_variance=2.0 * (STEP_SIGMA / interval) ** 2
        + _uniform(robot_model.ACCELERATION * interval),
        turn_rate_variance=2.0 * (TURN_SIGMA / interval) ** 2
        + _uniform(TURN_ACCELERATION * interval),
        position_variance=POSITION_SIGMA ** 2 + _uniform(arc),
        yaw_variance=HEADING_SIGMA ** 2 + _uniform(turn))
    return motion if _is_possible(motion) else None


def _uniform(width: float) -> float:
    """Returns the variance of a uniform distribution over a range of `width`."""
    return width ** 2 / 12.0


def _is_possible(motion: MeanMotion) -> bool:
    return (abs(motion.speed) <= robot_model.TOP_SPEED + 3.0 * math.sqrt(motion.speed_variance)
            and abs(motion.turn_rate) <= robot_model.TOP_TURN_RATE
            + 3.0 * math.sqrt(motion.turn_rate_variance))
