"""Decides which of the requested programs may start now.

Only a few programs start at the same time, so that the ROS master keeps up. A program that ends
soon after its start waits longer each time. This module uses neither processes nor a clock.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, Generic, Hashable, List, Optional, TypeVar

AT_A_TIME = 6
START_WITHIN = 5.0  # s; after this time a program counts as started even without its report
SOON = 10.0  # s; an end within this time after the start counts as early
FIRST_DELAY = 1.0  # s, after two early ends in a row; each further early end doubles the delay
LONGEST_DELAY = 30.0  # s

Key = TypeVar('Key', bound=Hashable)


@dataclass(frozen=True)
class _Waiting(Generic[Key]):
    key: Key
    identity: Hashable
    not_before: float


class StartQueue(Generic[Key]):
    """A queue. A key stands for one run, and an identity stands for one program. Times are
    monotonic, in s.
    """

    def __init__(self, at_a_time: int = AT_A_TIME) -> None:
        self._at_a_time = at_a_time
        self._waiting: List[_Waiting[Key]] = []
        self._starting: Dict[Key, float] = {}  # time until which each program counts as starting
        self._running: Dict[Key, _Run] = {}
        self._early_ends: Dict[Hashable, int] = {}

    def ask(self, key: Key, identity: Hashable, now: float) -> float:
        """Requests a start. Returns the delay (s) that follows from the program's early ends."""
        delay = delay_after(self._early_ends.get(identity, 0))
        self._waiting.append(_Waiting(key, identity, now + delay))
        return delay

    def next(self, now: float) -> Optional[Key]:
        """Returns the program that starts now, or None."""
        self._starting = {key: until for key, until in self._starting.items() if until > now}
        if len(self._starting) >= self._at_a_time:
            return None
        for one in self._waiting:
            if one.not_before <= now:
                self._waiting.remove(one)
                self._starting[one.key] = now + START_WITHIN
                self._running[one.key] = _Run(one.identity, now)
                return one.key
        return None

    def seconds_to_next(self, now: float) -> Optional[float]:
        """Returns the seconds until `next` may return a program, if no other event comes before;
        None: `next` returns no program before another event.
        """
        if not self._waiting:
            return None
        times = [one.not_before for one in self._waiting]
        if len(self._starting) >= self._at_a_time:
            times = [max(min(times), min(self._starting.values()))]
        return max(0.0, min(times) - now)

    def started(self, key: Key) -> None:
        """Notes that the program has registered with the master."""
        self._starting.pop(key, None)

    def ended(self, key: Key, failed: bool, now: float) -> None:
        """Notes that the program has ended, or that its request was withdrawn."""
        self._waiting = [one for one in self._waiting if one.key != key]
        self.started(key)
        run = self._running.pop(key, None)
        if run is None:
            return
        if failed and now - run.since < SOON:
            self._early_ends[run.identity] = self._early_ends.get(run.identity, 0) + 1
        else:
            self._early_ends.pop(run.identity, None)


@dataclass(frozen=True)
class _Run:
    identity: Hashable
    since: float


def delay_after(early_ends: int) -> float:
    """Returns the delay (s) of a program's next start after this number of early ends in a row."""
    if early_ends < 2:
        return 0.0
    return min(LONGEST_DELAY, FIRST_DELAY * 2.0 ** min(early_ends - 2, 10))
