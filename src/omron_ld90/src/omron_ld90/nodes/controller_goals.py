"""Compares the goals that the robot lists with the goals of the map file."""
from __future__ import annotations

import threading
from typing import Callable, FrozenSet, List, Optional, Tuple

import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from omron_arcl import printable, readable
from omron_map import MapDocument, MapError, wait_for_map

_MAXIMUM_NAMES = 20  # names in one message


class GoalComparison:
    """Reads the map file in a separate thread, each time the robot has listed its goals.

    Its attributes are the parts of the comparison and its last result.
    """

    def __init__(self, map_file: str, made_from: Tuple[str, ...] = (),
                 wait: Callable[..., None] = wait_for_map) -> None:
        self._map_file = map_file
        self._made_from = made_from
        self._wait = wait
        self._due = threading.Event()
        self._closing = False
        self._robot: Optional[FrozenSet[str]] = None
        self._level = DiagnosticStatus.OK
        self._message = 'the robot has not listed its goals yet'
        self._only_robot: List[str] = []
        self._only_map: List[str] = []
        self._thread = threading.Thread(target=self._run, name='goal-comparison', daemon=True)
        self._thread.start()

    def robot_goals(self, names: FrozenSet[str]) -> None:
        """Takes the goals that the robot has listed."""
        self._robot = frozenset(names)
        self._due.set()

    def close(self) -> None:
        """Ends the thread."""
        self._closing = True
        self._due.set()
        self._thread.join(0.5)

    def diagnose(self, status: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        """Fills in a status, as a task for diagnostic_updater."""
        status.summary(self._level, self._message)
        status.add('goals of the robot', str(len(self._robot or ())))
        status.add('only in the robot', ', '.join(self._only_robot[:_MAXIMUM_NAMES]) or 'none')
        status.add('only in the map file', ', '.join(self._only_map[:_MAXIMUM_NAMES]) or 'none')
        return status

    def _run(self) -> None:
        while True:
            self._due.wait()
            self._due.clear()
            if self._closing:
                return
            if self._map_file:
                self._compare(self._robot or frozenset())
            else:
                self._message = 'not compared: ~map_file is not set'

    def _compare(self, robot: FrozenSet[str]) -> None:
        try:
            if self._made_from:
                self._wait(self._map_file, self._made_from, say=rospy.loginfo,
                           given_up=lambda: self._closing)
                self._made_from = ()
            file = frozenset(readable(goal.name)
                             for goal in MapDocument.load(self._map_file).goals)
        except (MapError, OSError, ValueError) as error:
            self._level, self._message = DiagnosticStatus.WARN, f'not compared: {error}'
            rospy.logwarn('The goals of robot and map file were not compared: %s', error)
            return
        self._only_robot = _without(robot, file)
        self._only_map = _without(file, robot)
        if self._only_robot or self._only_map:
            self._level = DiagnosticStatus.WARN
            self._message = (f'the robot drives on another map than {self._map_file}: only the '
                             f'robot has {_listed(self._only_robot)}, only the file has '
                             f'{_listed(self._only_map)}')
            rospy.logwarn('Goals differ: %s.', self._message)
        else:
            self._level, self._message = (
                DiagnosticStatus.OK, 'robot and map file have the same goals')


def _without(names: FrozenSet[str], others: FrozenSet[str]) -> List[str]:
    """Returns the `names` that are not in `others`, in printable form.

    Case is ignored, because the robot ignores it.
    """
    folded = {name.casefold() for name in others}
    return sorted(printable(name) for name in names if name.casefold() not in folded)


def _listed(names: List[str]) -> str:
    shown = ', '.join(f'"{name}"' for name in names[:_MAXIMUM_NAMES])
    more = len(names) - _MAXIMUM_NAMES
    return (shown + f' and {more} more' if more > 0 else shown) or 'none'
