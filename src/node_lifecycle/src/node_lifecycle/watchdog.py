"""Detects blocked threads of a node, and reports them in /diagnostics.

If two threads take two locks in opposite order, they block a node for ever. Nothing else shows
this: the node keeps its connections, and its last values stay on the screen. So a separate thread,
which takes none of these locks, checks every `PERIOD` where all other threads are.
"""
from __future__ import annotations

import os
import sys
import sysconfig
import threading
import time
from types import FrameType
from typing import Dict, Iterator, List, NamedTuple, Optional, Tuple

import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from node_lifecycle.periodic import Periodic

PERIOD = 2.5  # s; the wake-up of an idle process costs more than the check
STANDSTILL = 10.0  # s
CALLERS = ('actionlib', 'diagnostic_updater', 'interactive_markers')
"""Libraries that call nodes while they hold locks: their threads are also watched."""


class Standstill(NamedTuple):
    """A blocked thread: its name, its place in the code, and how long it has been there (s)."""

    thread: str
    place: str
    seconds: float


class _Look(NamedTuple):
    """The state of a thread: its position, frame by frame, and counters that grow while it runs."""

    position: Tuple[Tuple[object, int], ...]
    run: str


class ThreadWatch:
    """Checks the threads of this process.

    A thread is blocked under these conditions:
    - It is in the code of `packages`.
    - It does not wait for an event.
    - For `standstill` seconds it has neither moved nor run. So it waits for a lock or for another
      program.
    Other threads are not judged, because rospy's own threads wait all the time.
    """

    def __init__(self, packages: Tuple[str, ...], standstill: float = STANDSTILL) -> None:
        self._packages = packages
        self._standstill = standstill
        self._seen: Dict[int, Tuple[_Look, float]] = {}

    def blocked(self, now: float) -> List[Standstill]:
        """Returns the blocked threads at `now` (s, monotonic)."""
        threads = {thread.ident: thread for thread in threading.enumerate()}
        seen: Dict[int, Tuple[_Look, float]] = {}
        found: List[Standstill] = []
        for ident, frame in sys._current_frames().items():
            thread = threads.get(ident)
            place = self._place(frame)
            if thread is None or place is None or ident == threading.get_ident():
                continue
            position = tuple((one.f_code, one.f_lasti) for one in _frames(frame))
            current = _Look(position, _run_so_far(thread.native_id))
            before, since = self._seen.get(ident, (current, now))
            seen[ident] = current, since if before == current else now
            if now - seen[ident][1] >= self._standstill:
                found.append(Standstill(thread.name, place, now - seen[ident][1]))
        self._seen = seen
        return found

    def _place(self, frame: FrameType) -> Optional[str]:
        """Returns the thread's place in the watched code; None if the thread is elsewhere, or
        waits for an event.
        """
        if _waits(frame):
            return None
        for inner in _frames(frame):
            module = inner.f_globals.get('__name__', '')
            if module.split('.')[0] in self._packages:
                return f'{inner.f_code.co_name} ({module}, line {inner.f_lineno})'
        return None


def _frames(innermost: FrameType) -> Iterator[FrameType]:
    frame: Optional[FrameType] = innermost
    while frame is not None:
        yield frame
        frame = frame.f_back


_THREADING = os.path.join(sysconfig.get_paths()['stdlib'], 'threading.py')
_SELECTORS = os.path.join(sysconfig.get_paths()['stdlib'], 'selectors.py')
_EVENTS = ('wait', '_wait_for_tstate_lock')  # threading's waits for events, not for locks


def _waits(frame: FrameType) -> bool:
    """Returns whether a thread waits for an event, a queue, the end of a thread, or a socket."""
    code = frame.f_code
    return (code.co_filename == _SELECTORS
            or (code.co_filename == _THREADING and code.co_name in _EVENTS))


def _run_so_far(native_id: Optional[int]) -> str:
    """Returns the kernel's counters of a thread. They change whenever the thread runs."""
    try:
        with open(f'/proc/self/task/{native_id}/status', encoding='ascii') as status:
            switches = [line for line in status if 'ctxt_switches' in line]
        with open(f'/proc/self/task/{native_id}/stat', encoding='utf-8') as stat:
            times = stat.read().rsplit(')', 1)[-1].split()[11:13]
    except OSError:
        return str(time.monotonic())  # unknown, so the thread counts as running
    return ''.join(switches + times)


class Watchdog:
    """Publishes as `<node>: threads` in /diagnostics whether the node's threads make progress."""

    def __init__(self, packages: Tuple[str, ...]) -> None:
        self._watch = ThreadWatch((*packages, *CALLERS))
        self._publisher = rospy.Publisher('/diagnostics', DiagnosticArray, queue_size=1)
        self._reported = False
        Periodic('watchdog', PERIOD, self._on_period)

    def _on_period(self) -> None:
        found = self._watch.blocked(time.monotonic())
        if found and not self._reported:
            rospy.logerr('%s', _sentence(found))
        self._reported = bool(found)
        self._publish(found)

    def _publish(self, found: List[Standstill]) -> None:
        status = DiagnosticStatus(name=f'{rospy.get_name().lstrip("/")}: threads',
                                  hardware_id='none', level=DiagnosticStatus.OK,
                                  message='all move on')
        if found:
            status.level = DiagnosticStatus.ERROR
            status.message = _sentence(found)
            status.values = [KeyValue(one.thread, f'{one.place}, {one.seconds:.0f} s')
                             for one in found]
        message = DiagnosticArray(status=[status])
        message.header.stamp = rospy.Time.now()
        self._publisher.publish(message)


def _sentence(found: List[Standstill]) -> str:
    first = found[0]
    return (f'{len(found)} thread(s) are blocked, "{first.thread}" for {first.seconds:.0f} s in '
            f'{first.place}: the node does not do its work, restart it')
