"""The errors that are reported, each for as long as it holds."""
from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Optional, Tuple

from vda5050_vehicle.drivers.robot_view import RobotView
from vda5050_vehicle.protocol import problems as e
from vda5050_vehicle.protocol.values import Error, EStop, Reference

# Masters take an error that refers to nothing for a rejection of their last order.
_OF_NO_ORDER = Reference('topic', 'state')
MAX_REJECTIONS = 10  # of the newest, until an order is accepted


@dataclass(frozen=True)
class Errors:
    """Rejections stay until an order is taken, those of instant actions until one of these is;
    failures until they are seen to; conditions of the robot as long as they hold.

    drive, action -- why the vehicle does not drive on: only a person or the master sees to that
    """

    rejections: Tuple[Error, ...] = ()
    refused_actions: Tuple[Error, ...] = ()
    drive: Optional[Error] = None
    action: Optional[Error] = None

    def with_rejection(self, error: Error) -> Errors:
        """An order was not taken up."""
        return replace(self, rejections=_with(self.rejections, error))

    def with_refused_action(self, error: Error) -> Errors:
        """An instant action was not taken up."""
        return replace(self, refused_actions=_with(self.refused_actions, error))

    def without_failures(self) -> Errors:
        """Failures were seen to."""
        return replace(self, drive=None, action=None) if self.failure else self

    @property
    def failure(self) -> Optional[Error]:
        """Why the vehicle does not drive on by itself."""
        return self.drive or self.action

    def all(self, robot: RobotView) -> Tuple[Error, ...]:
        """What to report."""
        failures = tuple(error for error in (self.drive, self.action) if error)
        return (*self.rejections, *self.refused_actions, *failures, *_conditions(robot))


def _with(errors: Tuple[Error, ...], error: Error) -> Tuple[Error, ...]:
    return (*(old for old in errors if old != error), error)[-MAX_REJECTIONS:]


def _conditions(robot: RobotView) -> Tuple[Error, ...]:
    found = []
    if robot.e_stop is not EStop.NONE:
        found.append(e.EMERGENCY_STOP.error('the emergency stop is pressed, or not acknowledged',
                                            _OF_NO_ORDER))
    if robot.lost:
        found.append(e.VEHICLE_LOST.error(robot.lost, _OF_NO_ORDER))
    elif not robot.localized:
        found.append(e.LOCALIZATION_ERROR.error('the robot does not know where it is',
                                                _OF_NO_ORDER))
    return tuple(found)
