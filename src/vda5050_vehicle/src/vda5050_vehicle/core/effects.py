"""What the vehicle wants done; carried out in this order by its caller."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Mapping, Optional, Tuple, Union

from vda5050_vehicle.core.action_table import ActionSpec
from vda5050_vehicle.core.state import VehicleState
from vda5050_vehicle.drivers.robot_view import Pose
from vda5050_vehicle.protocol.values import State


@dataclass(frozen=True)
class SendState:
    """Publish a state."""

    state: State


@dataclass(frozen=True)
class SendFactsheet:
    """Publish the factsheet."""


@dataclass(frozen=True)
class StartAction:
    """Begin an action of the table; its end is told by `action_ended`."""

    action_id: str
    spec: ActionSpec
    arguments: Mapping[str, Any]


@dataclass(frozen=True)
class CancelAction:
    """End an action that was started."""

    action_id: str


@dataclass(frozen=True)
class SetPose:
    """Tell the robot where it is."""

    pose: Pose


@dataclass(frozen=True)
class WriteLog:
    """Store a log report; its end is told by `action_ended`."""

    action_id: str
    reason: str
    lines: Tuple[str, ...]


@dataclass(frozen=True)
class Keep:
    """Store what a restarted vehicle must know, before what comes after.

    before -- what was stored last; None: nothing was
    """

    before: Optional[VehicleState]
    now: VehicleState


@dataclass(frozen=True)
class Command:
    """A command of the driver's own kind."""

    command: Any


Effect = Union[SendState, SendFactsheet, StartAction, CancelAction, SetPose, WriteLog, Keep,
               Command]
