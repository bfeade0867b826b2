"""The present knowledge of the robot. Metres, radians, percent, volts."""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Optional

from vda5050_protocol.values import BatteryState, EmergencyStop, Velocity

STANDING_SPEED = 0.02     # m/s
STANDING_ROTATION = 0.03  # rad/s
REST = 2.0                # s; a robot that reports only poses stands if it has not moved for REST


@dataclass(frozen=True)
class RobotPose:
    """The pose of the robot on the map."""

    x: float
    y: float
    theta: float


@dataclass(frozen=True)
class RobotSnapshot:
    """A view of the robot in which no value is older than its limit; unknown values are None.

    seen_at  -- s; time of the robot's report on its motion
    standing -- whether the robot reports that it stands; None if it does not report this
    rests    -- whether the poses have not changed for REST
    epoch    -- the robot's epoch; it changes when another program or person drives or stops the
                robot; 0: unknown
    halted   -- whether a stop, a cancellation, another client or the robot itself last changed the
                robot's motion, and not a drive; False if the robot does not report this
    lost     -- the reason why the robot counts as lost; '' while it reports, or while the time
                limit has not expired

    Its attributes are all values that a robot may report.
    """

    pose: Optional[RobotPose] = None
    velocity: Optional[Velocity] = None
    seen_at: float = -math.inf
    standing: Optional[bool] = None
    rests: bool = False
    epoch: int = 0
    halted: bool = False
    localization_score: Optional[float] = None
    localized: bool = True
    battery: BatteryState = BatteryState(0.0, False)
    e_stop: EmergencyStop = EmergencyStop.NONE
    field_violation: bool = False
    lost: str = ''

    @property
    def is_awaited(self) -> bool:
        """Whether the robot has not reported yet and the time limit has not expired."""
        return self.pose is None and not self.lost

    @property
    def moves(self) -> bool:
        """Whether the robot's velocity shows that it drives or turns."""
        speed = self.velocity
        return speed is not None and (
            max(abs(speed.vx), abs(speed.vy)) > STANDING_SPEED
            or abs(speed.omega) > STANDING_ROTATION)

    @property
    def stands(self) -> bool:
        """Whether the robot is known to stand: a report shows this, and none contradicts it."""
        return (not self.moves and self.standing is not False
                and (self.velocity is not None or self.standing is True or self.rests))


def has_moved(before: RobotPose, now: RobotPose) -> bool:
    """Returns whether two poses differ by more than a standing robot may move within REST."""
    turned = math.remainder(now.theta - before.theta, math.tau)
    return (math.hypot(now.x - before.x, now.y - before.y) > STANDING_SPEED * REST
            or abs(turned) > STANDING_ROTATION * REST)


def silence(heard_at: Optional[float], since: float, now: float, timeout: float) -> str:
    """Returns the reason why the robot counts as lost; '' before the time limit has expired.

    heard_at -- time of the robot's last pose, s; None: no pose came yet
    since    -- time at which the subscription began, s
    """
    if now - (since if heard_at is None else heard_at) <= timeout:
        return ''
    return ('the robot has not reported its pose '
            + ('yet' if heard_at is None else f'for {timeout:g} s'))
