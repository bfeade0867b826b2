"""Which commands, goals and clicks are too old to be carried out."""
from __future__ import annotations

import threading
import time
from typing import Callable, Dict, Iterable, Optional, Set

import rosgraph
import rospy

LATCHED = ('It was published before this node started, and is not carried out late: give it '
           'again.')
LATCHED_WITHIN = 5.0  # s from the start in which a latched message may be an old one
WAITED = ('It waited while this node stood still, and is not carried out late: give it '
          'again.')
STANDSTILL = 2.5  # s in which the process did nothing at all
WAITED_WITHIN = 1.0  # s afterwards in which what waited meanwhile comes


class OldMessages:
    """Tells which commands and goals are too old to be carried out.

    A publisher that latches gives its last message to every node that comes later. To carry that
    out after a restart of the node would be to repeat a motion by itself. And what waited
    while this process stood still (suspended, or starved) was meant for another moment.
    """

    def __init__(self, publishers: Callable[[str], Iterable[str]],
                 clock: Callable[[], float] = time.monotonic) -> None:
        self._publishers = publishers
        self._clock = clock
        self._earlier: Dict[str, Set[str]] = {}
        self._ticked = clock()
        self._latched_until = clock() + LATCHED_WITHIN
        self._waited_until = 0.0

    def start(self) -> OldMessages:
        """Begins to notice when the process stands still."""
        threading.Thread(target=self._run, name='standstill', daemon=True).start()
        return self

    def watch(self, topic: str) -> None:
        """Notes who publishes `topic` already; to be called before it is subscribed to."""
        self._earlier[topic] = set(self._publishers(topic))

    def reason(self, message: rospy.Message, topic: str, is_stop: bool = False) -> Optional[str]:
        """Why a message is too old; None where it is not. A stop never waited too long."""
        now = self._clock()
        self.tick(now)
        header = getattr(message, '_connection_header', {})
        earlier, caller = self._earlier.get(topic, set()), header.get('callerid', '')
        latched = header.get('latching') == '1' and caller in earlier
        earlier.discard(caller)
        if latched and now < self._latched_until:
            return LATCHED
        return WAITED if now < self._waited_until and not is_stop else None

    def tick(self, now: float) -> None:
        """It is `now`; called often, unless the process stands still."""
        if now - self._ticked > STANDSTILL:
            self._waited_until = now + WAITED_WITHIN
        self._ticked = now

    def _run(self) -> None:
        while not rospy.is_shutdown():
            time.sleep(0.2)
            self.tick(self._clock())


def publishers_by_master(topic: str) -> Iterable[str]:
    """The nodes that publish `topic`, by the ROS master."""
    resolved = rospy.resolve_name(topic)
    published, _, _ = rosgraph.Master(rospy.get_name()).getSystemState()
    return [node for name, nodes in published if name == resolved for node in nodes]
