"""What the bridge remembers over a restart of its own, as long as the ROS master lives."""
from __future__ import annotations

import threading
import time
from typing import Any, Dict, Optional

import rospy

from omron_ld90.bridge.route_protocol import RouteRecord

PARAMETER = '~route_record'
REFRESHED = 5.0     # s between two writings of the same record
LONGEST_GAP = 20.0  # s: a record that is older than this is of another day


class RouteMemory:
    """Keeps the record of the route in a private parameter, with the time.

    A thread of its own writes it, because the master may be slow to answer.
    """

    def __init__(self) -> None:
        self._record: Optional[RouteRecord] = None
        self._changed = threading.Condition()
        threading.Thread(target=self._run, name='route-memory', daemon=True).start()

    def recall(self) -> Optional[RouteRecord]:
        """The record left by the program before this one; None when there is none, or it is old."""
        content = rospy.get_param(PARAMETER, None)
        return _record_of(content) if isinstance(content, dict) else None

    def keep(self, record: Optional[RouteRecord]) -> None:
        """Has a record written down; None: there is no route to go on with."""
        with self._changed:
            if record != self._record:
                self._record = record
                self._changed.notify()

    def _run(self) -> None:
        written = None
        while not rospy.is_shutdown():
            with self._changed:
                if self._record == written:
                    self._changed.wait(REFRESHED)
                record, before, written = self._record, written, self._record
            try:
                _write(record, before)
            except OSError as error:
                rospy.logwarn_throttle(60.0, 'The route cannot be remembered over a restart: the '
                                             'ROS master does not answer (%s).', error)


def _write(record: Optional[RouteRecord], before: Optional[RouteRecord]) -> None:
    if record is not None:
        rospy.set_param(PARAMETER, {
            'time': time.time(), 'route_id': record.route_id, 'edges': list(record.edges),
            'completed': record.completed, 'target': record.target})
    elif before is not None and rospy.has_param(PARAMETER):
        rospy.delete_param(PARAMETER)


def _record_of(content: Dict[str, Any]) -> Optional[RouteRecord]:
    try:
        if not 0.0 <= time.time() - content['time'] <= LONGEST_GAP:
            return None
        return RouteRecord(int(content['route_id']), tuple(int(id) for id in content['edges']),
                           int(content['completed']), int(content['target']))
    except (KeyError, TypeError, ValueError):
        return None
