"""The effects that the vehicle requests; its caller carries them out in the given sequence."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Mapping, Optional, Tuple, Union

from vda5050_protocol.values import StateMessage
from vda5050_vehicle.core.action_table import ActionSpec
from vda5050_vehicle.core.state import VdaVehicleState
from vda5050_vehicle.drivers.robot_view import RobotPose


@dataclass(frozen=True)
class SendState:
    """Publish a state."""

    state: StateMessage


@dataclass(frozen=True)
class SendFactsheet:
    """Publish the factsheet."""


@dataclass(frozen=True)
class StartAction:
    """Start an action of the table; the caller reports with `action_ended` when it has ended."""

    action_id: str
    spec: ActionSpec
    arguments: Mapping[str, Any]


@dataclass(frozen=True)
class CancelAction:
    """Cancel an action that was started."""

    action_id: str


@dataclass(frozen=True)
class SetPose:
    """Set the pose of the robot's localization."""

    pose: RobotPose


@dataclass(frozen=True)
class WriteLog:
    """Store a log report; the caller reports with `action_ended` when it is stored."""

    action_id: str
    reason: str
    lines: Tuple[str, ...]


@dataclass(frozen=True)
class Keep:
    """Store the state for a restart, before the caller carries out the next effects.

    before -- the state that was stored last; None: no state was stored
    """

    before: Optional[VdaVehicleState]
    now: VdaVehicleState


@dataclass(frozen=True)
class DriverCommand:
    """A command of the driver; its type depends on the driver."""

    command: Any


Effect = Union[SendState, SendFactsheet, StartAction, CancelAction, SetPose, WriteLog, Keep,
               DriverCommand]
