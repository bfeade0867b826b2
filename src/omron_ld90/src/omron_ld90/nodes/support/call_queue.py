"""Runs calls in order in a separate thread, so that the caller never waits."""
from __future__ import annotations

import queue
import threading
from typing import Callable, Optional

import rospy

_MAXIMUM_OPTIONAL = 1000  # if more calls wait, optional calls are dropped


class CallQueue:
    """Runs the calls that `add` gets, one after the other, until the process ends.

    A thread that must not block uses it to call actionlib and rospy: their locks then delay only
    this queue. If a call raises an exception, it is logged, and the next call runs.
    """

    def __init__(self, name: str) -> None:
        self._calls: queue.Queue[Optional[Callable[[], object]]] = queue.Queue()
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def add(self, call: Callable[[], object], optional: bool = False) -> None:
        """Queues `call`. Drops an `optional` call if too many calls are waiting."""
        if not optional or self._calls.qsize() < _MAXIMUM_OPTIONAL:
            self._calls.put(call)

    def close(self, timeout: float = 1.0) -> None:
        """Runs the queued calls, for at most `timeout` seconds, and ends the thread."""
        self._calls.put(None)
        self._thread.join(timeout)

    def _run(self) -> None:
        while True:
            call = self._calls.get()
            if call is None:
                return
            try:
                call()
            except Exception as error:
                rospy.logerr('%s: a call failed: %r', threading.current_thread().name, error)
