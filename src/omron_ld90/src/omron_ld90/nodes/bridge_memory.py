"""What the bridge remembers over a restart of its own, as long as the ROS master lives."""
from __future__ import annotations

import time
from typing import Any, Dict, Optional

import rospy

from omron_ld90.graph.route_protocol import RouteRecord

PARAMETER = '~route_record'
REFRESHED = 5.0   # s between two writings of the same record
LONGEST_GAP = 20.0  # s: a record that is older than this is of another day


class RouteMemory:
    """Keeps the record of the route in a private parameter, with the time."""

    def __init__(self) -> None:
        self._kept: Optional[RouteRecord] = None
        self._kept_at = 0.0

    def recall(self) -> Optional[RouteRecord]:
        """The record left by the program before this one; None when there is none, or it is old."""
        content = rospy.get_param(PARAMETER, None)
        return _record_of(content) if isinstance(content, dict) else None

    def keep(self, record: Optional[RouteRecord]) -> None:
        """Writes a record down where it is new, or was written some time ago."""
        now = time.monotonic()
        if record == self._kept and (record is None or now - self._kept_at < REFRESHED):
            return
        self._kept, self._kept_at = record, now
        if record is None:
            rospy.delete_param(PARAMETER)
            return
        rospy.set_param(PARAMETER, {
            'time': time.time(), 'route_id': record.route_id, 'edges': list(record.edges),
            'completed': record.completed, 'target': record.target})


def _record_of(content: Dict[str, Any]) -> Optional[RouteRecord]:
    try:
        if not 0.0 <= time.time() - content['time'] <= LONGEST_GAP:
            return None
        return RouteRecord(int(content['route_id']), tuple(int(id) for id in content['edges']),
                           int(content['completed']), int(content['target']))
    except (KeyError, TypeError, ValueError):
        return None
