"""What is known of the robot now. Metres, radians, percent, volts."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Optional

from vda5050_vehicle.drivers.driver import Pose
from vda5050_vehicle.protocol.values import BatteryState, EStop, Velocity

STANDING_SPEED = 0.02     # m/s
STANDING_ROTATION = 0.03  # rad/s


@dataclass(frozen=True)
class RobotView:
    """Nothing here is older than its limit: what is not known is None.

    lost -- why nothing is heard of the robot; empty: it is heard, or its time is not over
    """

    pose: Optional[Pose] = None
    velocity: Optional[Velocity] = None
    localization_score: Optional[float] = None
    localized: bool = True
    battery: BatteryState = BatteryState(0.0, False)
    e_stop: EStop = EStop.NONE
    field_violation: bool = False
    lost: str = ''

    @property
    def is_awaited(self) -> bool:
        """Whether nothing was heard of it yet, and its time is not over."""
        return self.pose is None and not self.lost

    @property
    def moves(self) -> bool:
        """Whether it is seen to drive or turn."""
        speed = self.velocity
        return speed is not None and (
            max(abs(speed.vx), abs(speed.vy)) > STANDING_SPEED
            or abs(speed.omega) > STANDING_ROTATION)


def silence(heard_at: Optional[float], since: float, now: float, timeout: float) -> str:
    """Why the robot counts as lost; empty while its time is not over.

    `heard_at` is when its last pose came, `since` when we began to listen.
    """
    if now - (since if heard_at is None else heard_at) <= timeout:
        return ''
    return ('nothing was heard of where the robot is '
            + ('yet' if heard_at is None else f'for {timeout:g} s'))
