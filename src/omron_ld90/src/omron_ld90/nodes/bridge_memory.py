"""What the bridge remembers of its last route over a restart, as long as the ROS master lives."""
from __future__ import annotations

import http.client
import threading
import time
import xmlrpc.client
from typing import Any, Dict, Optional, Tuple

import rospy

from omron_ld90.bridge.events import RouteRecord
from omron_ld90.nodes.support.worker import start_worker
from trajectory_graph.route_protocol import Phase

PARAMETER = '~route_record'
REFRESHED = 5.0     # s between two writings of the same record


class RouteMemory:
    """Keeps the record of the route in a private parameter, with the time.

    A thread of its own writes it, because the master may be slow to answer.
    """

    def __init__(self) -> None:
        self._record: Optional[RouteRecord] = None
        self._changed = threading.Condition()
        self._closing = False
        self._thread = start_worker('route-memory', self._run)

    def recall(self) -> Tuple[Optional[RouteRecord], float]:
        """The record left by the program before this one, and its age in s; None without one."""
        content = rospy.get_param(PARAMETER, None)
        try:
            return _record_of(content), max(time.time() - float(content['time']), 0.0)
        except (KeyError, TypeError, ValueError):
            return None, 0.0

    def keep(self, record: Optional[RouteRecord]) -> None:
        """Has a record written down."""
        with self._changed:
            if record != self._record:
                self._record = record
                self._changed.notify()

    def close(self) -> None:
        """Ends the thread; what was to be written is written."""
        with self._changed:
            self._closing = True
            self._changed.notify()
        self._thread.join(0.5)

    def _run(self) -> None:
        written: Optional[RouteRecord] = None
        closing = False
        while not closing and not rospy.is_shutdown():
            with self._changed:
                if self._record == written and not self._closing:
                    self._changed.wait(REFRESHED)
                record = written = self._record
                closing = self._closing
            try:
                if record is not None:
                    rospy.set_param(PARAMETER, _content_of(record))
            except (OSError, http.client.HTTPException, xmlrpc.client.Error) as error:
                rospy.logwarn_throttle(60.0, 'The route cannot be remembered over a restart: the '
                                             'ROS master does not answer (%s).', error)


def _content_of(record: RouteRecord) -> Dict[str, Any]:
    return {'time': time.time(), 'route_id': record.route_id, 'edges': list(record.edges),
            'stamp': str(record.stamp),  # more than the 32 bits of a parameter
            'phase': record.phase.value, 'reason': record.reason, 'completed': record.completed,
            'target': -1 if record.target is None else record.target, 'goal': record.goal,
            'owes_stop': record.owes_stop}


def _record_of(content: Dict[str, Any]) -> RouteRecord:
    """The record in a parameter; raises KeyError, TypeError or ValueError where it holds none."""
    target = int(content['target'])
    return RouteRecord(int(content['route_id']), tuple(int(id) for id in content['edges']),
                       int(content['stamp']), Phase(content['phase']), str(content['reason']),
                       int(content['completed']), None if target < 0 else target,
                       str(content['goal']), bool(content['owes_stop']))
