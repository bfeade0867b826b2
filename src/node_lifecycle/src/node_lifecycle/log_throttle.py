"""Limits the log messages that strangers or robots can cause, so that these cannot fill a disk."""
from __future__ import annotations

import threading
import time
from typing import Callable, Dict, Optional

import rospy

BURST = 5  # messages of one kind that are logged within PERIOD, at most
PERIOD = 10.0  # s


class LogThrottle:
    """Passes few messages of each kind, and counts the omitted messages."""

    def __init__(self, burst: int = BURST, period: float = PERIOD,
                 clock: Callable[[], float] = time.monotonic) -> None:
        self._burst = burst
        self._period = period
        self._clock = clock
        self._lock = threading.Lock()
        self._kinds: Dict[str, _Kind] = {}

    def pass_on(self, kind: str, message: str) -> Optional[str]:
        """Returns the message to log, with the number of messages left out before; None: log
        nothing.
        """
        with self._lock:
            now = self._clock()
            state = self._kinds.setdefault(kind, _Kind(now))
            if now - state.since >= self._period:
                state.since, state.logged = now, 0
            if state.logged >= self._burst:
                state.left_out += 1
                return None
            state.logged += 1
            left_out, state.left_out = state.left_out, 0
        return f'{message} ({left_out} more like it were omitted.)' if left_out else message


class _Kind:
    """The counters of one kind of messages."""

    def __init__(self, since: float) -> None:
        self.since = since
        self.logged = 0
        self.left_out = 0


_throttle = LogThrottle()


def warn(kind: str, message: str) -> None:
    """Logs a warning of this kind, unless there were too many recently."""
    passed = _throttle.pass_on(kind, message)
    if passed is not None:
        rospy.logwarn('%s', passed)
