"""Two weaknesses of rospy's connections of topics, which show where many nodes start at once.

- A node's server of topics lets five connections wait. The kernel drops a sixth, whose client tries
  again after 1, 3, 7 and 15 s: a latched message may come that late.
- A subscriber that hears twice of a publisher, as whenever another publisher of the topic comes,
  makes two connections at once. Each side drops the one that is older to it. Where these are not
  the same, no connection is left, and rospy makes no other one.
"""
from __future__ import annotations

import threading
from functools import wraps
from socket import SOMAXCONN, socket
from typing import Any, Callable, Tuple
from weakref import WeakValueDictionary

from rospy.impl.masterslave import ROSHandler
from rospy.impl.tcpros_base import TCPServer

Connect = Callable[[Any, str, str], Any]


def mend() -> None:
    """Let many connections wait, and make one at a time to each publisher of a topic."""
    if not hasattr(ROSHandler._connect_topic, '__wrapped__'):
        ROSHandler._connect_topic = one_at_a_time(ROSHandler._connect_topic)
        TCPServer._create_server_sock = with_room(TCPServer._create_server_sock)


def one_at_a_time(connect: Connect) -> Connect:
    """`connect` a handler to a topic of a publisher, not twice at once to the same one.

    The second call finds the connection that the first one made, and makes none.
    """
    locks: WeakValueDictionary[Tuple[str, str], threading.Lock] = WeakValueDictionary()
    guard = threading.Lock()

    @wraps(connect)
    def alone(handler: Any, topic: str, publisher: str) -> Any:
        with guard:
            lock = locks.setdefault((topic, publisher), threading.Lock())
        with lock:
            return connect(handler, topic, publisher)

    return alone


def with_room(create: Callable[[Any], socket]) -> Callable[[Any], socket]:
    """`create` a server's socket, where as many connections may wait as the system allows."""
    @wraps(create)
    def roomy(server: Any) -> socket:
        made = create(server)
        made.listen(SOMAXCONN)
        return made

    return roomy
