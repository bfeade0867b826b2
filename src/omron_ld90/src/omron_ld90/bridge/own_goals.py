"""The goals that we have sent the robot to, and whether what it does is because of one of them.

The robot's status says in words what it does. Which goals it may name because of us is not only the
last one: the controller may not have heard of all that we gave, a command may name several, and a
robot may have names of its own for its dock, or name no goals at all.
"""
from __future__ import annotations

from typing import FrozenSet, Iterable, Optional, Tuple

from omron_ld90.bridge.events import Motion, RobotSeen

DOCK = 'dock'

_MOST_EARLIER_GOALS = 20
_TOWARDS_GOAL = (Motion.GOING, Motion.ARRIVED)
_DOCK_MOTIONS = (Motion.DOCKING, Motion.DOCKED)


class OwnGoals:
    """The goal last sent, and those before it that the robot may yet be going to."""

    def __init__(self) -> None:
        self.current: Optional[str] = None
        """Name of the goal last sent; DOCK for the dock, None when we have sent it nowhere."""
        self._earlier: Tuple[str, ...] = ()  # the last one at the end
        self._via: FrozenSet[str] = frozenset()  # those that the last command names on the way
        self._are_named: Optional[bool] = None  # the robot shows the goals that it goes to

    # --- what we do ------------------------------------------------------------------------------

    def send(self, goal: str, via: Iterable[str] = ()) -> None:
        """The robot is to go to `goal`, over the goals `via`."""
        self.end()
        self.current, self._via = goal, frozenset(via)

    def resume(self, goal: Optional[str]) -> None:
        """Before a restart of this program the robot was sent to `goal`, and may be on its way."""
        self.current, self._via = goal, frozenset()

    def remember(self, goal: str) -> None:
        """Before a restart of this program the robot was sent to `goal`, which is over."""
        self._earlier = (goal,) if goal else ()

    def end(self) -> None:
        """We have no more business with the robot."""
        if self.current is not None:
            self._earlier = (*self._earlier, self.current)[-_MOST_EARLIER_GOALS:]
        self.current, self._via = None, frozenset()

    # --- what the robot shows --------------------------------------------------------------------

    def seen(self, status: RobotSeen, is_awaited: bool) -> None:
        """The robot's status; `is_awaited`: it has the last command, and is to tell of its end."""
        if status.motion is Motion.GOING and is_awaited:
            self._are_named = bool(status.goal or self._are_named)
        if status.motion in _TOWARDS_GOAL and status.goal == self.current:
            self._earlier = self._earlier[-1:]  # it has heard of this goal: no older one will come

    @property
    def last(self) -> str:
        """Name of the goal last sent, whether or not we still have business with the robot."""
        return self.current or ''.join(self._earlier[-1:])

    def __contains__(self, name: str) -> bool:
        """Whether the robot may show this name because of us."""
        return name == self.current or name in self._via or name in self._earlier

    def is_obeyed(self, status: RobotSeen) -> bool:
        """Whether the status shows the robot obeying the last command."""
        if self.current == DOCK:
            return status.motion in _DOCK_MOTIONS or (
                status.motion is Motion.GOING and not status.goal.isdecimal())
        if status.motion is Motion.UNDOCKING:
            return True  # it leaves the dock before it goes to its goal
        if status.motion is Motion.GOING and not status.goal:
            return self._are_named is False
        return (status.motion in (Motion.GOING, Motion.ARRIVED, Motion.FAILED)
                and (status.goal == self.current or status.goal in self._via))

    def is_earlier_obeyed(self, status: RobotSeen) -> bool:
        """Whether the status shows the robot obeying a command before the last one."""
        return status.motion in _TOWARDS_GOAL and status.goal in self._earlier
