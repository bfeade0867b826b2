"""Follows the map on display, for nodes that draw on it or accept clicks on it.

Subscribes
    map_file (std_msgs/String, latched): path of the map that `map_visualisation` shows
"""
from __future__ import annotations

from typing import Callable, Optional

import rospy
from std_msgs.msg import String

from omron_ld90.nodes.support.callers import caller_of
from omron_map import MapDocument, MapError

SHOWN_BY = 'map_visualisation'
STRANGERS_TOLD = 60.0  # s between two log lines about messages of other nodes


class DisplayedMap:
    """Calls `on_map(document, path)` each time a map is displayed or loaded again.

    `document` is None if no map is displayed, or if its file cannot be read. `without` says what is
    missing then; it is written to the log if the file cannot be read. Only messages of the node
    `map_visualisation` in the same namespace are accepted: with the path in its message, another
    publisher could make this node read and reveal any file. `on_map` runs in a thread of the
    subscriber, and must take its own locks.
    """

    def __init__(self, on_map: Callable[[Optional[MapDocument], str], None], without: str) -> None:
        self._on_map = on_map
        self._without = without
        self._shown_by = rospy.resolve_name(SHOWN_BY)

    def subscribe(self) -> rospy.Subscriber:
        """Follows `map_file` from now on."""
        return rospy.Subscriber('map_file', String, self.on_message, queue_size=1, tcp_nodelay=True)

    def on_message(self, message: String) -> None:
        """Loads the map that a message of `map_file` names."""
        sender = caller_of(message)
        if sender != self._shown_by:
            rospy.logwarn_throttle(
                STRANGERS_TOLD, 'A map_file from %s is ignored: only %s says which map is '
                'displayed.', sender, self._shown_by)
            return
        document = None
        if message.data:
            try:
                document = MapDocument.load(message.data)
            except MapError as error:
                rospy.logerr('%s: %s', self._without, error)
        self._on_map(document, message.data)
