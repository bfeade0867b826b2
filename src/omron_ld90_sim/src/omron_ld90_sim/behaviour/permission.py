"""The permission to drive: the motors, and the faults and other reasons that block the robot."""
from __future__ import annotations

from enum import Enum
from typing import Callable, List, Tuple

from omron_ld90_sim.behaviour.states import MotorState


class PermissionChange(Enum):
    """A change of the permission. `DrivePermission` first makes the change, then reports it."""

    BLOCKED = 'there is one more reason not to drive'
    UNBLOCKED = 'there is one reason less'
    MOTORS_CUT = 'the motors are off'
    BUTTON_RELEASED = 'the emergency stop button is released; the motors are still off'
    MOTORS_ENABLED = 'the motors are on'


class DrivePermission:
    """The state of the motors, and the reasons that forbid driving, each as (kind, name)."""

    def __init__(self, changed: Callable[[PermissionChange], None]) -> None:
        self.motors = MotorState.ENABLED
        self.blocked_by: List[Tuple[str, str]] = []
        self._changed = changed

    @property
    def granted(self) -> bool:
        """Whether the motors are on, and nothing blocks the robot."""
        return self.motors is MotorState.ENABLED and not self.blocked_by

    def block(self, kind: str, name: str) -> None:
        """Forbids driving from now on; the activity ends."""
        self.unblock(kind, name)
        self.blocked_by.append((kind, name))
        self._changed(PermissionChange.BLOCKED)

    def unblock(self, kind: str, name: str) -> bool:
        """Removes a reason that forbids driving. Returns False if it did not exist."""
        known = (kind, name) in self.blocked_by
        if known:
            self.blocked_by.remove((kind, name))
            self._changed(PermissionChange.UNBLOCKED)
        return known

    def press_estop(self) -> None:
        """Presses the emergency stop button: the motors are off, and the activity ends."""
        self.cut_motors(MotorState.ESTOP)

    def cut_motors(self, motors: MotorState = MotorState.DISABLED) -> None:
        """Switches the motors off: the activity ends, and is not resumed."""
        self.motors = motors
        self._changed(PermissionChange.MOTORS_CUT)

    def release_estop(self) -> None:
        """Releases the button; the motors stay off."""
        if self.motors is MotorState.ESTOP:
            self.motors = MotorState.RELIEVED
            self._changed(PermissionChange.BUTTON_RELEASED)

    def enable_motors(self) -> bool:
        """Switches the motors on. Returns False if the emergency stop button is pressed."""
        if self.motors is MotorState.ESTOP:
            return False
        if self.motors is not MotorState.ENABLED:
            self.motors = MotorState.ENABLED
            self._changed(PermissionChange.MOTORS_ENABLED)
        return True
