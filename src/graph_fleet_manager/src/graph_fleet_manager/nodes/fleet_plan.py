"""The topic /fleet_plan: the planned drives of all robots, for displays and other programs."""
from __future__ import annotations

import queue
import time
from contextlib import suppress
from typing import NamedTuple, Optional

import rospy

from fleet_core.supervision.fleet_view import PlanProgress, plan_views
from graph_fleet_manager.messages import missions as messages
from graph_fleet_manager.nodes.sending import send
from itrci_nav_msgs.msg import FleetPlan
from node_lifecycle.worker import start_worker

_SHARE = 0.1  # most of the CPU time to spend on messages; large plans are published less often


class _Told(NamedTuple):
    """A plan, and the ROS time `stamp` of the monotonic time `now`."""

    progress: Optional[PlanProgress]
    now: float
    stamp: rospy.Time


class FleetPlanTopic:
    """Publishes the newest plan in a thread of its own, so that the deciding thread never waits.

    rate -- factor by which simulated robots are faster
    """

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._newest: queue.Queue[_Told] = queue.Queue(1)
        self._publisher = rospy.Publisher('/fleet_plan', FleetPlan, queue_size=1, latch=True)
        start_worker('fleet_plan', self._work)

    def set_plan(self, progress: Optional[PlanProgress], now: float, stamp: rospy.Time) -> None:
        """Sets the plan to publish. It replaces a plan that was not published yet."""
        with suppress(queue.Empty):
            self._newest.get_nowait()
        self._newest.put(_Told(progress, now, stamp))

    def _work(self) -> None:
        while not rospy.is_shutdown():
            told = self._newest.get()
            begun = time.thread_time()
            self._publish(told)
            time.sleep((time.thread_time() - begun) * (1.0 / _SHARE - 1.0))

    def _publish(self, told: _Told) -> None:
        made_at = told.now if told.progress is None else told.progress.plan.made_at

        def planned(seconds: float) -> rospy.Time:
            return messages.moment_of(made_at + (seconds - made_at) / self._rate - told.now,
                                      told.stamp)
        send(self._publisher.publish,
             messages.plan_message(plan_views(told.progress), planned, told.stamp))
