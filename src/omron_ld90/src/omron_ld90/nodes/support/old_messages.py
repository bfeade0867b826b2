"""Decides which commands, goals and clicks are too old to be carried out."""
from __future__ import annotations

import threading
import time
from collections import OrderedDict
from typing import Callable, Dict, Iterable, NamedTuple, Optional, Set, Tuple

import rosgraph
import rospy

from omron_ld90.nodes.support.callers import header_of, process_of

LATCHED = ('It was published before this node started, or before its connection came back, and is '
           'not carried out late: send it again.')
WAITED = ('It waited while this node was suspended, and is not carried out late: send it '
          'again.')
STANDSTILL = 2.5  # s without a call of `tick` after which the process counts as suspended
WAITED_WITHIN = 1.0  # s after the suspension in which messages that have waited may arrive
_MOST_PUBLISHERS = 1000


class _Connection(NamedTuple):
    """The last connection of a latching publisher. Each connection has its own `header` object."""

    header: Dict[str, str]
    process: str


class OldMessages:
    """Decides which commands and goals are too old to be carried out.

    A latching publisher sends its last message again on every new connection. If this node obeyed
    this message after its own restart, or after a break of the connection, the robot would repeat a
    motion. So the first message of such a connection is old, unless the publisher has just started.
    Messages are also old if they waited while this process was suspended or got no processor time,
    because they were meant for another moment.
    """

    def __init__(self, publishers: Callable[[str], Iterable[str]],
                 clock: Callable[[], float] = time.monotonic,
                 process_of: Callable[[rospy.Message], str] = process_of) -> None:
        self._publishers = publishers
        self._clock = clock
        self._process_of = process_of
        self._earlier: Dict[str, Set[str]] = {}
        self._connections: OrderedDict[Tuple[str, str], _Connection] = OrderedDict()
        self._ticked = clock()
        self._waited_until = 0.0

    def start(self) -> OldMessages:
        """Begins to check whether the process is suspended."""
        threading.Thread(target=self._run, name='standstill', daemon=True).start()
        return self

    def watch(self, topic: str) -> None:
        """Notes the publishers that `topic` already has; call it before subscribing."""
        self._earlier[topic] = set(self._publishers(topic))

    def reason(self, message: rospy.Message, topic: str, is_stop: bool = False) -> Optional[str]:
        """Returns why a message is too old; None if it is not.

        A stop that only waited is not too old.
        """
        now = self._clock()
        self.tick(now)
        if self.comes_again(message, topic):
            return LATCHED
        return WAITED if now < self._waited_until and not is_stop else None

    def comes_again(self, message: rospy.Message, topic: str) -> bool:
        """Returns whether a message is the first on a new connection of a latching publisher, and
        the publisher was known before.
        """
        header = header_of(message)
        if header.get('latching') != '1':
            return False
        caller = header.get('callerid', '')
        last = self._connections.get((topic, caller))
        if last is not None and last.header is header:
            return False
        process = self._process_of(message)
        self._connections[topic, caller] = _Connection(header, process)
        self._connections.move_to_end((topic, caller))
        if len(self._connections) > _MOST_PUBLISHERS:
            self._connections.popitem(last=False)
        earlier = self._earlier.get(topic, set())
        was_there = caller in earlier if last is None else last.process == process
        earlier.discard(caller)
        return was_there

    def tick(self, now: float) -> None:
        """Notes the time `now`. Called often, unless the process is suspended."""
        if now - self._ticked > STANDSTILL:
            self._waited_until = now + WAITED_WITHIN
        self._ticked = now

    def _run(self) -> None:
        while not rospy.is_shutdown():
            time.sleep(0.2)
            self.tick(self._clock())


def publishers_by_master(topic: str) -> Iterable[str]:
    """Returns the nodes that publish `topic`, according to the ROS master."""
    resolved = rospy.resolve_name(topic)
    published, _, _ = rosgraph.Master(rospy.get_name()).getSystemState()
    return [node for name, nodes in published if name == resolved for node in nodes]
