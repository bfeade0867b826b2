"""All that a vehicle knows, in one value: order, actions, where it drives, and why it does not."""
from __future__ import annotations

from copy import copy
from dataclasses import dataclass, fields
from typing import Optional, Tuple

from vda5050_vehicle.core.errors import Errors
from vda5050_vehicle.core.initial_pose import PoseWish
from vda5050_vehicle.drivers.driver import Drive, Leg
from vda5050_vehicle.protocol.action_queue import ActionQueue
from vda5050_vehicle.protocol.order_state import OrderState
from vda5050_vehicle.protocol.received import ReceivedMessages


@dataclass
class VehicleState:
    """Each field is a value that never changes, so that a copy is what the vehicle knew then.

    taken   -- digest of the order or update that was taken last
    legs    -- one per edge of the order
    drive   -- what the driver remembers
    paused  -- startPause came, and no stopPause since
    cancels -- ids of cancelOrder under way; and `pauses` of startPause
    wish    -- of initPosition: where the robot is to believe that it is
    epoch   -- the robot's, in which it was sent last
    away    -- nodes may have been passed while the adapter was not running
    """

    order: OrderState = OrderState()
    taken: str = ''
    legs: Tuple[Leg, ...] = ()
    actions: ActionQueue = ActionQueue()
    drive: Drive = Drive()
    errors: Errors = Errors()
    paused: bool = False
    cancels: Tuple[str, ...] = ()
    pauses: Tuple[str, ...] = ()
    wish: Optional[PoseWish] = None
    received: ReceivedMessages = ReceivedMessages()
    epoch: int = 0
    away: bool = False

    def copy(self) -> VehicleState:
        """What it knows now."""
        return copy(self)

    def become(self, other: VehicleState) -> None:
        """Takes over what another one knows."""
        for field in fields(self):
            setattr(self, field.name, getattr(other, field.name))

    def differs_from(self, other: VehicleState) -> bool:
        """Whether a field holds another value: equal ones are kept, not made anew."""
        return any(getattr(self, field.name) is not getattr(other, field.name)
                   for field in fields(self))

    def leg(self, number: int) -> Optional[Leg]:
        """The leg of the order with this number, counted from its beginning; None: driven."""
        index = number - self.order.passed
        return self.legs[index] if 0 <= index < len(self.legs) else None

    @property
    def busy(self) -> bool:
        """Whether an order is under way (question 3 of figure 8)."""
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
