"""A picture in RViz that changes without flicker and leaves no old markers behind."""
from __future__ import annotations

from typing import Iterable, List, Set, Tuple

import rospy
from visualization_msgs.msg import Marker, MarkerArray


class Picture:
    """One topic of markers. Each message has all markers, so that a late viewer sees all of them.

    RViz updates a marker that it already shows. A marker that is not shown any more is deleted by
    its name. All markers are deleted (DELETEALL) only if an earlier node may have left some.
    """

    def __init__(self, topic: str, latch: bool = False) -> None:
        self._publisher = rospy.Publisher(topic, MarkerArray, queue_size=2, latch=latch)
        self._changes = PictureChanges()

    def show(self, markers: Iterable[Marker]) -> None:
        """Shows these markers and no others."""
        message = self._changes.to(markers, afresh=not self._publisher.get_num_connections())
        if message:
            self._publisher.publish(MarkerArray(message))


class PictureChanges:
    """Finds the messages that change one picture into the next."""

    def __init__(self) -> None:
        self._known: Set[Tuple[str, int]] = set()
        self._is_first = True

    def to(self, markers: Iterable[Marker], afresh: bool = False) -> List[Marker]:
        """Returns the markers to publish: first the deletions, then all visible `markers`.

        A deletion is repeated until the name is visible again, because a viewer may have missed a
        message.

        afresh -- delete all markers first, as for the first picture
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
