"""What is known of the robot now. Metres, radians, percent, volts."""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Optional

from vda5050_vehicle.protocol.values import BatteryState, EStop, Velocity

STANDING_SPEED = 0.02     # m/s
STANDING_ROTATION = 0.03  # rad/s
REST = 2.0                # s in which a robot that tells only poses must not have moved


@dataclass(frozen=True)
class Pose:
    """Where the robot is on the map."""

    x: float
    y: float
    theta: float


@dataclass(frozen=True)
class RobotView:
    """Nothing here is older than its limit: what is not known is None.

    seen_at  -- s; when the robot told what it tells here of its motion
    standing -- whether it says that it stands, where it has words for that
    rests    -- whether its poses have stayed the same for REST
    epoch    -- another one since another program or person drove or stopped it; 0: not known
    lost     -- why nothing is heard of the robot; empty: it is heard, or its time is not over
    """

    pose: Optional[Pose] = None
    velocity: Optional[Velocity] = None
    seen_at: float = -math.inf
    standing: Optional[bool] = None
    rests: bool = False
    epoch: int = 0
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

    @property
    def stands(self) -> bool:
        """Whether it is known to stand: nothing that it tells says otherwise, and one thing does.
        """
        return (not self.moves and self.standing is not False
                and (self.velocity is not None or self.standing is True or self.rests))


def has_moved(before: Pose, now: Pose) -> bool:
    """Does a pose differ by more than a standing robot's do within REST?"""
    turned = math.remainder(now.theta - before.theta, math.tau)
    return (math.hypot(now.x - before.x, now.y - before.y) > STANDING_SPEED * REST
            or abs(turned) > STANDING_ROTATION * REST)


def silence(heard_at: Optional[float], since: float, now: float, timeout: float) -> str:
    """Why the robot counts as lost; empty while its time is not over.

    `heard_at` is when its last pose came, `since` when we began to listen.
    """
    if now - (since if heard_at is None else heard_at) <= timeout:
        return ''
    return ('nothing was heard of where the robot is '
            + ('yet' if heard_at is None else f'for {timeout:g} s'))
