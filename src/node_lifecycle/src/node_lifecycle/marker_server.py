"""An interactive marker server that is fast, and whose markers RViz does not lose.

Import it from here, not from `node_lifecycle`, because most nodes have no markers.
"""
from __future__ import annotations

import threading
from typing import Any

from interactive_markers.interactive_marker_server import InteractiveMarkerServer

from node_lifecycle.periodic import Periodic

KEEP_ALIVE = 0.5  # s, as in the library


class OrderedMarkerServer(InteractiveMarkerServer):
    """Sends updates and keep-alives in the order of their numbers.

    The server of the ROS distribution sends keep-alives from the thread of a timer. A keep-alive
    that gets its number during an update arrives after the update, with an older number. RViz then
    removes all markers for a second, which also ends a drag or closes a menu.

    The library's timer also follows ROS time, which may stand still. So this server sends its
    keep-alives from a `Periodic`.

    The whole state is sent with the next keep-alive, not with every update: it is many times as
    long as an update, and only a viewer that joins later reads it.
    """

    def __init__(self, topic_ns: str, q_size: int = 100) -> None:
        """topic_ns -- namespace of the topics `update`, `update_full` and `feedback`

        q_size -- length of the queue for feedback; if it is full, the oldest feedback is lost
        """
        self._order = threading.RLock()
        self._whole_is_due = False
        super().__init__(topic_ns, q_size=q_size)
        Periodic('keep-alive', KEEP_ALIVE, self.keep_alive)

    def applyChanges(self) -> None:  # noqa: N802, the name is the library's
        """Sends the changes."""
        with self._order:
            super().applyChanges()

    def publishInit(self) -> None:  # noqa: N802
        """Schedules the whole state for the next keep-alive."""
        self._whole_is_due = True

    def keepAlive(self, msg: Any) -> None:  # noqa: N802
        """Does nothing: the library's own timer calls this. See `keep_alive`."""

    def keep_alive(self) -> None:
        """Shows viewers that the server works. It is called twice a second."""
        with self._order:
            if self._whole_is_due:
                self._whole_is_due = False
                super().publishInit()
            super().keepAlive(None)
