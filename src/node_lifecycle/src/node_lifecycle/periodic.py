"""Work that a node repeats. Its period follows a clock that never stops and never steps back.

rospy.Timer and rospy.Rate wait for ROS time. Under /use_sim_time this time stands still until the
first /clock comes, and while a simulation pauses. It steps back when a bag is played in a loop or a
world is reset. Then a timer of rospy waits for ever, or ends with an exception. But a robot and its
network do not stop with a simulation, so no periodic work of a node may depend on ROS time.
"""
from __future__ import annotations

import threading
import traceback
from typing import Callable

import rospy

from node_lifecycle.log_throttle import warn


class Periodic:
    """Calls `call` every `period` seconds in a separate thread, until the node ends.

    An exception of `call` is logged, and the next call comes at its usual time: one wrong message
    must not end, for example, a node's diagnostics. Errors due to the end of the node are not
    logged.
    """

    def __init__(self, name: str, period: float, call: Callable[[], object]) -> None:
        """name -- what is repeated, such as `diagnostics`; the thread gets the same name"""
        self._name, self._period, self._call = name, period, call
        self._ended = threading.Event()
        rospy.on_shutdown(self.shutdown)
        threading.Thread(target=self._run, name=name, daemon=True).start()

    def shutdown(self) -> None:
        """Makes no more calls. Does not wait for a call that runs."""
        self._ended.set()

    def _run(self) -> None:
        while not self._ended.wait(self._period):
            try:
                self._call()
            except Exception:
                if not self._ended.is_set():
                    warn(self._name, f'"{self._name}", which this node does repeatedly, failed '
                         f'once:\n{traceback.format_exc()}')
