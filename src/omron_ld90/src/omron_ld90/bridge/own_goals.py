"""The goals that we sent the robot to, and whether its present motion is due to one of them.

The robot's status names a goal in words. Besides the last one, it may name other goals of ours:
- The controller may not have received all our commands.
- A command may name several goals.
- A robot may have its own names for its dock, or name no goals at all.
"""
from __future__ import annotations

from typing import FrozenSet, Iterable, Optional, Tuple

from omron_ld90.bridge.events import Motion, RobotSeen

DOCK = 'dock'

_MOST_EARLIER_GOALS = 20
_TOWARDS_GOAL = (Motion.GOING, Motion.ARRIVED)
_DOCK_MOTIONS = (Motion.DOCKING, Motion.DOCKED)


class OwnGoals:
    """The goal last sent, and those before it to which the robot may still drive."""

    def __init__(self) -> None:
        self.current: Optional[str] = None
        """Name of the goal last sent; DOCK for the dock, None if we sent the robot nowhere."""
        self._earlier: Tuple[str, ...] = ()  # goals before it, the latest at the end
        self._via: FrozenSet[str] = frozenset()  # goals on the way that the last command names
        self._are_named: Optional[bool] = None  # whether the robot names the goals it drives to

    # --- our commands ----------------------------------------------------------------------------

    def send(self, goal: str, via: Iterable[str] = ()) -> None:
        """The robot is sent to `goal`, over the goals `via`."""
        self.end()
        self.current, self._via = goal, frozenset(via)

    def resume(self, goal: Optional[str]) -> None:
        """The robot was sent to `goal` before a restart of this program, and may be on its way."""
        self.current, self._via = goal, frozenset()

    def remember(self, goal: str) -> None:
        """The robot was sent to `goal` before a restart of this program; that drive is over."""
        self._earlier = (goal,) if goal else ()

    def end(self) -> None:
        """The robot need not drive to a goal of ours any more."""
        if self.current is not None:
            self._earlier = (*self._earlier, self.current)[-_MOST_EARLIER_GOALS:]
        self.current, self._via = None, frozenset()

    # --- the robot's status ----------------------------------------------------------------------

    def seen(self, status: RobotSeen, is_awaited: bool) -> None:
        """Takes a status; `is_awaited`: the robot has the last command, and its end is awaited."""
        if status.motion is Motion.GOING and is_awaited:
            self._are_named = bool(status.goal or self._are_named)
        if status.motion in _TOWARDS_GOAL and status.goal == self.current:
            self._earlier = self._earlier[-1:]  # it obeys this goal, so no older one can follow

    @property
    def last(self) -> str:
        """Name of the goal last sent, even if that drive is over."""
        return self.current or ''.join(self._earlier[-1:])

    def __contains__(self, name: str) -> bool:
        """Whether the robot may show this name because of a command of ours."""
        return name == self.current or name in self._via or name in self._earlier

    def is_obeyed(self, status: RobotSeen) -> bool:
        """Whether the status shows the robot obeying the last command."""
        if self.current == DOCK:
            return status.motion in _DOCK_MOTIONS or (
                status.motion is Motion.GOING and not status.goal.isdecimal())
        if status.motion is Motion.UNDOCKING:
            return True  # the robot leaves the dock before it drives to its goal
        if status.motion is Motion.GOING and not status.goal:
            return self._are_named is False
        return (status.motion in (Motion.GOING, Motion.ARRIVED, Motion.FAILED)
                and (status.goal == self.current or status.goal in self._via))

    def is_earlier_obeyed(self, status: RobotSeen) -> bool:
        """Whether the status shows the robot obeying a command before the last one."""
        return status.motion in _TOWARDS_GOAL and status.goal in self._earlier
