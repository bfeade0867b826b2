"""The errors that the vehicle reports. Each error is reported as long as it applies."""
from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Optional, Tuple

from vda5050_protocol import problems as e
from vda5050_protocol.values import EmergencyStop, Error, ErrorReference
from vda5050_vehicle.drivers.robot_view import RobotSnapshot

# Masters interpret an error without references as a rejection of their last order.
_OF_NO_ORDER = ErrorReference('topic', 'state')
MAX_REJECTIONS = 100  # only the newest rejections are reported, so that a state stays small


@dataclass(frozen=True)
class Errors:
    """The present errors.

    - Rejections of orders stay until an order is accepted.
    - Rejections of instant actions stay until an instant action is accepted.
    - Failures stay until a person or the master deals with them.
    - Conditions of the robot stay as long as they exist.

    drive, action -- failures of the drive and of an action; both keep the vehicle from driving on
    """

    rejections: Tuple[Error, ...] = ()
    refused_actions: Tuple[Error, ...] = ()
    drive: Optional[Error] = None
    action: Optional[Error] = None

    def with_rejection(self, error: Error) -> Errors:
        """Returns the errors after an order was rejected."""
        return (self if error in self.rejections
                else replace(self, rejections=_with(self.rejections, error)))

    def with_refused_action(self, error: Error) -> Errors:
        """Returns the errors after an instant action was rejected."""
        return (self if error in self.refused_actions
                else replace(self, refused_actions=_with(self.refused_actions, error)))

    def without_failures(self) -> Errors:
        """Returns the errors after the failures were dealt with."""
        return replace(self, drive=None, action=None) if self.failure else self

    @property
    def failure(self) -> Optional[Error]:
        """The failure that keeps the vehicle from driving on; None if there is none."""
        return self.drive or self.action

    def all(self, robot: RobotSnapshot) -> Tuple[Error, ...]:
        """Returns all errors to report."""
        failures = tuple(error for error in (self.drive, self.action) if error)
        return (*self.rejections, *self.refused_actions, *failures, *_conditions(robot))


def _with(errors: Tuple[Error, ...], error: Error) -> Tuple[Error, ...]:
    return (*errors, error)[-MAX_REJECTIONS:]


def _conditions(robot: RobotSnapshot) -> Tuple[Error, ...]:
    found = []
    if robot.e_stop is not EmergencyStop.NONE:
        found.append(e.EMERGENCY_STOP.error('the emergency stop is pressed or not acknowledged',
                                            _OF_NO_ORDER))
    if robot.lost:
        found.append(e.VEHICLE_LOST.error(robot.lost, _OF_NO_ORDER))
    elif not robot.localized:
        found.append(e.LOCALIZATION_ERROR.error('the robot has lost its localization',
                                                _OF_NO_ORDER))
    return tuple(found)
