"""Notices that a node's threads stand still, and says so in /diagnostics.

Two locks taken in opposite order stop a node for good, and nothing in it can tell: it keeps its
connections, and what it said last stays true on the screen. So a thread of its own looks once a
second at where all the others are. It takes none of their locks for that.
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

PERIOD = 1.0  # s
STANDSTILL = 10.0  # s
CALLERS = ('actionlib', 'diagnostic_updater', 'interactive_markers')
"""Libraries that call nodes with their locks held: their threads are watched, too."""


class Standstill(NamedTuple):
    """A thread that does not move on: its name, where it is, and for how long (s)."""

    thread: str
    place: str
    seconds: float


class _Look(NamedTuple):
    """What was seen of a thread: where it was, frame by frame, and how far it had run."""

    position: Tuple[Tuple[object, int], ...]
    run: str


class ThreadWatch:
    """Looks at the threads of this process; `look` tells which of them stand still.

    A thread stands still when it is inside code of `packages`, does not wait for an event, and for
    `standstill` seconds has neither got anywhere nor run at all: then it waits for a lock, or for
    another program. Threads outside of `packages` are not judged: those of rospy wait all day.
    """

    def __init__(self, packages: Tuple[str, ...], standstill: float = STANDSTILL) -> None:
        self._packages = packages
        self._standstill = standstill
        self._seen: Dict[int, Tuple[_Look, float]] = {}

    def look(self, now: float) -> List[Standstill]:
        """The threads that stand still at `now` (s, monotonic)."""
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
        """Where in the watched code a thread is; None where it is not, or waits for an event."""
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
_EVENTS = ('wait', '_wait_for_tstate_lock')  # of threading; to enter a lock is another matter


def _waits(frame: FrameType) -> bool:
    """Whether a thread waits for an event, a queue, the end of a thread, or a socket."""
    code = frame.f_code
    return (code.co_filename == _SELECTORS
            or (code.co_filename == _THREADING and code.co_name in _EVENTS))


def _run_so_far(native_id: Optional[int]) -> str:
    """What the kernel has counted of a thread: it changes whenever the thread runs at all."""
    try:
        with open(f'/proc/self/task/{native_id}/status', encoding='ascii') as status:
            switches = [line for line in status if 'ctxt_switches' in line]
        with open(f'/proc/self/task/{native_id}/stat', encoding='utf-8') as stat:
            times = stat.read().rsplit(')', 1)[-1].split()[11:13]
    except OSError:
        return str(time.monotonic())  # not known, so it is not blamed
    return ''.join(switches + times)


class Watchdog:
    """Publishes as `<node>: threads` in /diagnostics whether the node's threads move on."""

    def __init__(self, packages: Tuple[str, ...]) -> None:
        self._watch = ThreadWatch((*packages, *CALLERS))
        self._publisher = rospy.Publisher('/diagnostics', DiagnosticArray, queue_size=1)
        self._reported = False
        threading.Thread(target=self._run, name='watchdog', daemon=True).start()

    def _run(self) -> None:
        while not rospy.is_shutdown():
            time.sleep(PERIOD)
            found = self._watch.look(time.monotonic())
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
    return (f'{len(found)} thread(s) stand still, "{first.thread}" for {first.seconds:.0f} s in '
            f'{first.place}: the node does not do its work, restart it')
