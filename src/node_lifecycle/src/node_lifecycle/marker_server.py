"""An interactive marker server whose markers RViz does not lose, and that is fast with many.

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

    The server of the ROS distribution sends keep-alives from a timer's thread. A keep-alive that is
    numbered during an update arrives after the update with an older number. RViz then removes all
    markers for a second, which also ends a drag or an open menu.

    That timer also follows ROS time, which may stand still. So keep-alives come from elsewhere.

    The whole state is sent with the next keep-alive rather than with every update: it is many times
    as long as an update, and only a viewer that joins later reads it.
    """

    def __init__(self, topic_ns: str, q_size: int = 100) -> None:
        """`topic_ns`: namespace of the topics `update`, `update_full` and `feedback`.

        `q_size`: length of the queue for feedback; above it, the oldest feedback is lost.
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
        """Does nothing when the library's own timer calls it: see `keep_alive`."""

    def keep_alive(self) -> None:
        """Shows viewers that the server is alive; called twice a second."""
        with self._order:
            if self._whole_is_due:
                self._whole_is_due = False
                super().publishInit()
            super().keepAlive(None)
