"""The errors that are reported, each for as long as it holds, and what keeps from driving."""
from __future__ import annotations

from enum import Enum
from typing import Dict, List, Optional, Tuple

from vda5050_vehicle.core.robot_view import RobotView
from vda5050_vehicle.protocol import problems as e
from vda5050_vehicle.protocol.values import Error, EStop

MAX_REJECTIONS = 10  # of the newest, until an order is accepted


class Cause(Enum):
    """What an error hangs on."""

    DRIVE = 'drive'
    ACTION = 'action'


class Hold(Enum):
    """Why the vehicle must not drive."""

    PAUSE = 'pause'      # startPause
    FAILURE = 'failure'  # something went wrong; only a person or the master drives on


class ErrorList:
    """Rejections stay until an order is accepted; failures until they are seen to; conditions of
    the robot as long as they hold."""

    def __init__(self) -> None:
        self._rejections: List[Error] = []
        self._failures: Dict[Cause, Error] = {}

    def reject(self, error: Error) -> None:
        """An order or an instant action was not taken up."""
        self._rejections = [*(old for old in self._rejections if old != error),
                            error][-MAX_REJECTIONS:]

    def accepted(self) -> None:
        """An order was taken up."""
        self._rejections.clear()

    def fail(self, cause: Cause, error: Error) -> None:
        """The vehicle does not drive on by itself."""
        self._failures[cause] = error

    def forgive(self) -> None:
        """Failures were seen to."""
        self._failures.clear()

    @property
    def failure(self) -> Optional[Error]:
        """Why the vehicle does not drive on by itself."""
        return next(iter(self._failures.values()), None)

    def all(self, robot: RobotView) -> Tuple[Error, ...]:
        """What to report."""
        return (*self._rejections, *self._failures.values(), *_conditions(robot))


def _conditions(robot: RobotView) -> Tuple[Error, ...]:
    found = []
    if robot.e_stop is not EStop.NONE:
        found.append(e.EMERGENCY_STOP.error('the emergency stop is pressed, or not acknowledged'))
    if robot.lost:
        found.append(e.VEHICLE_LOST.error(robot.lost))
    elif not robot.localized:
        found.append(e.LOCALIZATION_ERROR.error('the robot does not know where it is'))
    return tuple(found)
