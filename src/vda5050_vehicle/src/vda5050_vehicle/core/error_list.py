"""The errors that are reported, each for as long as it holds, and what keeps from driving."""
from __future__ import annotations

from enum import Enum
from typing import Dict, List, Optional, Tuple

from vda5050_vehicle.core.robot_view import RobotView
from vda5050_vehicle.protocol import problems as e
from vda5050_vehicle.protocol.values import Error, EStop, Reference

# Masters take an error that refers to nothing for a rejection of their last order.
_OF_NO_ORDER = Reference('topic', 'state')
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
    """Rejections stay until an order is taken, those of instant actions until one of these is;
    failures until they are seen to; conditions of the robot as long as they hold."""

    def __init__(self) -> None:
        self._rejections: List[Error] = []
        self._refused_actions: List[Error] = []
        self._failures: Dict[Cause, Error] = {}

    def reject(self, error: Error) -> None:
        """An order was not taken up."""
        self._rejections = _with(self._rejections, error)

    def refuse_action(self, error: Error) -> None:
        """An instant action was not taken up."""
        self._refused_actions = _with(self._refused_actions, error)

    def order_taken(self, with_instant_actions: bool) -> None:
        """An order was taken up; in 2.x that ends what was said of instant actions, too."""
        self._rejections.clear()
        if with_instant_actions:
            self._refused_actions.clear()

    def instant_action_taken(self) -> None:
        """What was said of those before is over."""
        self._refused_actions.clear()

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
        return (*self._rejections, *self._refused_actions, *self._failures.values(),
                *_conditions(robot))


def _with(errors: List[Error], error: Error) -> List[Error]:
    return [*(old for old in errors if old != error), error][-MAX_REJECTIONS:]


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
