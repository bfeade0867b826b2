"""An actionlib server with two changes that a driven robot requires.

actionlib refuses goals (also stops) whose stamp is not newer than the last cancellation, and gives
an empty result. So a canceller whose clock is ahead would lock out all givers. And the timer with
which actionlib publishes the status follows ROS time: under /use_sim_time without /clock, clients
would believe that the server is gone.
"""
from __future__ import annotations

from typing import Any, Callable

import actionlib
import rospy
from actionlib_msgs.msg import GoalID

from node_lifecycle.periodic import Periodic
from omron_arcl import Giver
from omron_ld90.nodes.support.callers import giver_of


class ActionServer(actionlib.ActionServer):
    """A server on which a cancellation affects neither later goals nor a stop.

    `canceller` is the program whose cancellation is being carried out.

    always_taken -- returns whether a goal is accepted regardless of earlier cancellations; True for
        a stop
    on_cancel_all -- called when everything is cancelled, even if no goal is under way
    """

    status_frequency: float  # Hz; actionlib reads it from the parameter server
    status_timer: Any  # actionlib's timer, which follows ROS time
    last_cancel: rospy.Time  # actionlib refuses goals whose stamp is not newer than this

    def __init__(self, name: str, kind: type, on_goal: Callable[..., None],
                 on_cancel: Callable[..., None], always_taken: Callable[[Any], bool],
                 on_cancel_all: Callable[[], None]) -> None:
        self._on_cancel_all = on_cancel_all
        self.canceller = Giver('')
        self._always_taken = always_taken
        super().__init__(name, kind, on_goal, on_cancel, auto_start=False)

    def start(self) -> None:
        """Begins to accept goals and to publish the status."""
        super().start()
        if self.status_frequency > 0.0:
            self.status_timer.shutdown()
            Periodic('action status', 1.0 / self.status_frequency, self.publish_status)

    def internal_cancel_callback(self, goal_id: GoalID) -> None:
        """Handles an incoming cancellation."""
        with self.lock:
            self.canceller = giver_of(goal_id)
            super().internal_cancel_callback(goal_id)
            if not goal_id.id and not goal_id.stamp:
                self._on_cancel_all()
            self.last_cancel = min(self.last_cancel, rospy.Time.now())

    def internal_goal_callback(self, goal: Any) -> None:
        """Handles an incoming goal."""
        with self.lock:
            last_cancel = self.last_cancel
            if self._always_taken(goal.goal):
                self.last_cancel = rospy.Time()
            super().internal_goal_callback(goal)
            self.last_cancel = last_cancel
