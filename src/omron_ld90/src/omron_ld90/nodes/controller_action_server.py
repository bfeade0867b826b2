"""The action server of actionlib, in the ways in which it must differ for a robot that is driven.

actionlib refuses goals whose stamp is not younger than that of the last cancellation, a stop among
them, with a result that is empty; a clock that is ahead would so lock all givers out.
"""
from __future__ import annotations

from typing import Any, Callable

import actionlib
import rospy
from actionlib_msgs.msg import GoalID

from omron_arcl import Giver
from omron_ld90.nodes.support.callers import giver_of


class ActionServer(actionlib.ActionServer):
    """No cancellation counts for what is given after it, nor for a stop.

    always_taken -- whether a goal, such as a stop, is taken regardless of earlier cancellations
    on_cancel_all -- called when everything is cancelled, be anything under way or not
    `canceller` is the program whose cancellation is being carried out.
    """

    last_cancel: rospy.Time  # actionlib's own: it refuses goals whose stamp is not younger

    def __init__(self, name: str, kind: type, on_goal: Callable[..., None],
                 on_cancel: Callable[..., None], always_taken: Callable[[Any], bool],
                 on_cancel_all: Callable[[], None]) -> None:
        self._on_cancel_all = on_cancel_all
        self.canceller = Giver('')
        self._always_taken = always_taken
        super().__init__(name, kind, on_goal, on_cancel, auto_start=False)

    def internal_cancel_callback(self, goal_id: GoalID) -> None:
        """A cancellation came."""
        with self.lock:
            self.canceller = giver_of(goal_id)
            super().internal_cancel_callback(goal_id)
            if not goal_id.id and not goal_id.stamp:
                self._on_cancel_all()
            self.last_cancel = min(self.last_cancel, rospy.Time.now())

    def internal_goal_callback(self, goal: Any) -> None:
        """A goal came."""
        with self.lock:
            last_cancel = self.last_cancel
            if self._always_taken(goal.goal):
                self.last_cancel = rospy.Time()
            super().internal_goal_callback(goal)
            self.last_cancel = last_cancel
