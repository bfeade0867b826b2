"""The topic /fleet_plan: the planned drives of all robots, for displays and other programs."""
from __future__ import annotations

import threading
import time
from typing import Any, Callable, NamedTuple, Optional

import rospy

from fleet_core.supervision.fleet_view import PlanProgress, plan_views
from graph_fleet_manager.messages import missions as messages
from graph_fleet_manager.nodes.sending import Newcomers, send
from itrci_nav_msgs.msg import FleetPlan
from node_lifecycle.worker import start_worker

_SHARE = 0.1  # largest share of the CPU time for messages: large plans are published less often


class _Told(NamedTuple):
    """A plan, and one moment on two clocks: `now` is monotonic time, `stamp` is ROS time."""

    progress: Optional[PlanProgress]
    now: float
    stamp: rospy.Time


class FleetPlanTopic:
    """Publishes the newest plan in a separate thread, so that the deciding thread never waits.

    A message is made only if there is a subscriber. A new subscriber gets the newest plan at once,
    because the latched message may be old.

    rate -- factor by which simulated robots are faster than the clock
    """

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._newest: Optional[_Told] = None
        self._changed = threading.Condition()
        self._publisher = rospy.Publisher('/fleet_plan', FleetPlan, queue_size=1, latch=True,
                                          subscriber_listener=Newcomers(self._welcome))
        start_worker('fleet_plan', self._work)

    def set_plan(self, progress: Optional[PlanProgress], now: float, stamp: rospy.Time) -> None:
        """Sets the plan to publish. It replaces a plan that was not published yet."""
        with self._changed:
            self._newest = _Told(progress, now, stamp)
            self._changed.notify()

    def _welcome(self, _: Callable[[Any], None]) -> None:
        newest = self._newest
        if newest is not None:
            self._publish(newest)

    def _work(self) -> None:
        told: Optional[_Told] = None
        while not rospy.is_shutdown():
            told = self._next(told)
            begun = time.thread_time()
            self._publish(told)
            time.sleep((time.thread_time() - begun) * (1.0 / _SHARE - 1.0))

    def _next(self, last: Optional[_Told]) -> _Told:
        """Waits for a plan newer than `last`, and for a subscriber."""
        with self._changed:
            while True:
                newest = self._newest
                if newest is not None and newest is not last and (
                        self._publisher.get_num_connections()):
                    return newest
                self._changed.wait()

    def _publish(self, told: _Told) -> None:
        made_at = told.now if told.progress is None else told.progress.plan.made_at

        def behind(seconds: float) -> float:
            return made_at + (seconds - made_at) / self._rate - told.now
        send(self._publisher.publish,
             messages.plan_message(plan_views(told.progress), behind, told.stamp))
