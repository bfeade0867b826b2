"""Calls made in order by a thread of their own, so that their caller never waits."""
from __future__ import annotations

import queue
import threading
from typing import Callable, Optional

import rospy

_MAXIMUM_OPTIONAL = 1000  # calls waiting, beyond which optional ones are left out


class CallQueue:
    """Runs what `add` is given, one call after the other, until the process ends.

    Meant for calls into actionlib and rospy from a thread that must not stand still: what they
    lock and wait for holds up this queue only. A call that raises is logged, and the next one runs.
    """

    def __init__(self, name: str) -> None:
        self._calls: queue.Queue[Optional[Callable[[], object]]] = queue.Queue()
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def add(self, call: Callable[[], object], optional: bool = False) -> None:
        """Queues `call`; an `optional` one is left out where very many wait already."""
        if not optional or self._calls.qsize() < _MAXIMUM_OPTIONAL:
            self._calls.put(call)

    def close(self, timeout: float = 1.0) -> None:
        """Runs what is queued, `timeout` seconds at most, and ends the thread."""
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
