"""An interactive marker server that RViz does not lose, and that is quick with many markers.

It is imported from here, not from `node_lifecycle`: most nodes have no markers.
"""
from __future__ import annotations

import threading
from typing import Any

from interactive_markers.interactive_marker_server import InteractiveMarkerServer


class OrderedMarkerServer(InteractiveMarkerServer):
    """Updates and keep-alives leave in the order of their numbers.

    The distribution's server sends keep-alives from a timer's thread. One that is numbered while
    an update is under way arrives after it with an older number, whereupon RViz takes all markers
    away for a second, a drag or an open menu included.

    The whole state, which only a viewer that joins later reads, is sent with the next keep-alive
    rather than with every update: it is many times as long as an update.
    """

    def __init__(self, topic_ns: str, q_size: int = 100) -> None:
        """`topic_ns`: namespace of the topics `update`, `update_full` and `feedback`.

        `q_size`: feedback that may wait while some is handled; more loses the oldest.
        """
        self._order = threading.RLock()
        self._whole_is_due = False
        super().__init__(topic_ns, q_size=q_size)

    def applyChanges(self) -> None:  # noqa: N802, the name is the library's
        """Sends what has changed."""
        with self._order:
            super().applyChanges()

    def publishInit(self) -> None:  # noqa: N802
        """The whole state goes out with the next keep-alive."""
        self._whole_is_due = True

    def keepAlive(self, msg: Any) -> None:  # noqa: N802
        """Twice a second: tells viewers that the server is there."""
        with self._order:
            if self._whole_is_due:
                self._whole_is_due = False
                super().publishInit()
            super().keepAlive(msg)
