"""The whole knowledge of a vehicle in one value: order, actions, drive and errors."""
from __future__ import annotations

from copy import copy
from dataclasses import dataclass, fields
from typing import Optional, Tuple

from vda5050_protocol.action_queue import ActionQueue
from vda5050_protocol.order_state import OrderState
from vda5050_protocol.received import ReceivedMessages
from vda5050_vehicle.core.errors import Errors
from vda5050_vehicle.core.initial_pose import PoseWish
from vda5050_vehicle.drivers.driver import DriveProgress, Leg


@dataclass
class VdaVehicleState:
    """The state of a vehicle. Each field has an immutable value, so a shallow copy is a snapshot.

    taken   -- digest of the order or update that was accepted last
    legs    -- one per edge of the order
    drive   -- the memory of the driver
    paused  -- whether startPause came, and no stopPause after it
    cancels -- ids of the active cancelOrder actions
    pauses  -- ids of the active startPause actions
    wish    -- the pose of initPosition that the robot has not taken yet
    epoch   -- the robot's last known epoch
    away    -- whether nodes may have been passed while the adapter was not running

    The state is one value, so that it is stored as a whole.
    """

    order: OrderState = OrderState()
    taken: str = ''
    legs: Tuple[Leg, ...] = ()
    actions: ActionQueue = ActionQueue()
    drive: DriveProgress = DriveProgress()
    errors: Errors = Errors()
    paused: bool = False
    cancels: Tuple[str, ...] = ()
    pauses: Tuple[str, ...] = ()
    wish: Optional[PoseWish] = None
    received: ReceivedMessages = ReceivedMessages()
    epoch: int = 0
    away: bool = False

    def copy(self) -> VdaVehicleState:
        """Returns a snapshot of the state."""
        return copy(self)

    def become(self, other: VdaVehicleState) -> None:
        """Sets all fields to those of another state."""
        for field in fields(self):
            setattr(self, field.name, getattr(other, field.name))

    def differs_from(self, other: VdaVehicleState) -> bool:
        """Returns whether a field differs; an unchanged field is the same object in both states."""
        return any(getattr(self, field.name) is not getattr(other, field.name)
                   for field in fields(self))

    def leg(self, number: int) -> Optional[Leg]:
        """Returns a leg by its number; None if it has been driven, or if it has no length."""
        index = number - self.order.passed
        if not 0 <= index < len(self.legs) or self.legs[index].stands:
            return None
        return self.legs[index]

    @property
    def busy(self) -> bool:
        """Whether an order is active (question 3 of figure 8)."""
        return (not self.order.is_driven or not self.actions.order_has_ended
                or self.cancelling)

    @property
    def cancelling(self) -> bool:
        """Whether the order is being cancelled."""
        return bool(self.cancels)

    @property
    def held(self) -> bool:
        """Whether the vehicle must not drive."""
        return self.paused or self.errors.failure is not None
