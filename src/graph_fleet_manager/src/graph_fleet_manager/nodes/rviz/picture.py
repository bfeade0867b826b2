"""A picture in RViz that changes without flickering, and of which nothing stays behind."""
from __future__ import annotations

from typing import Iterable, List, Set, Tuple

import rospy
from visualization_msgs.msg import Marker, MarkerArray


class Picture:
    """One topic of markers. Every message tells all there is to see: a late viewer gets no other.

    RViz changes in place what it has already; what is gone is deleted by its name. Everything is
    only taken away (DELETEALL) where a node before this one may have left something.
    """

    def __init__(self, topic: str, latch: bool = False) -> None:
        self._publisher = rospy.Publisher(topic, MarkerArray, queue_size=2, latch=latch)
        self._changes = Changes()

    def show(self, markers: Iterable[Marker]) -> None:
        """Shows these, and nothing else."""
        message = self._changes.to(markers, afresh=not self._publisher.get_num_connections())
        if message:
            self._publisher.publish(MarkerArray(message))


class Changes:
    """From one picture to the next."""

    def __init__(self) -> None:
        self._known: Set[Tuple[str, int]] = set()
        self._is_first = True

    def to(self, markers: Iterable[Marker], afresh: bool = False) -> List[Marker]:
        """All `markers` that are to be seen, after those that are to be deleted.

        A name stays among the deleted until it comes back: a viewer may have missed a message.

        afresh -- begin with nothing, as the first picture does
        """
        seen = [marker for marker in markers if marker.action == Marker.ADD]
        names = {(marker.ns, marker.id) for marker in seen}
        if afresh or self._is_first:
            gone = [Marker(action=Marker.DELETEALL)]
        else:
            gone = [Marker(ns=namespace, id=number, action=Marker.DELETE)
                    for namespace, number in sorted(self._known - names)]
        self._is_first = False
        self._known |= names
        return [*gone, *seen]
