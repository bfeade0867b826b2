"""Three weaknesses of rospy's connections of topics, which show where many nodes start at once.

- A node's server of topics lets five connections wait. The kernel drops a sixth, whose client tries
  again after 1, 3, 7 and 15 s: a latched message may come that late.
- A subscriber that hears twice of a publisher, as whenever another publisher of the topic comes,
  makes two connections at once. Each side drops the one that is older to it. Where these are not
  the same, no connection is left, and rospy makes no other one.
- A node's server reads the header of one connection at a time, for as long as that takes. A client
  that sends none, or an XML-RPC call to a node that had this port before, keeps all others out.
"""
from __future__ import annotations

import threading
from contextlib import suppress
from functools import wraps
from socket import SOMAXCONN, socket
from typing import Any, Callable, Tuple
from weakref import WeakValueDictionary

from rospy.impl.masterslave import ROSHandler
from rospy.impl.tcpros_base import TCPROSServer, TCPServer

HEADER_WITHIN = 10.0  # s from the connection of a client, which sends it at once

Connect = Callable[[Any, str, str], Any]
Welcome = Callable[[Any, socket, Any], Any]


def mend() -> None:
    """Let many connections wait, welcome each by itself, and make one at a time to a publisher."""
    if not hasattr(ROSHandler._connect_topic, '__wrapped__'):
        ROSHandler._connect_topic = one_at_a_time(ROSHandler._connect_topic)
        TCPServer._create_server_sock = with_room(TCPServer._create_server_sock)
        TCPROSServer._tcp_server_callback = each_by_itself(TCPROSServer._tcp_server_callback)


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


def each_by_itself(welcome: Welcome) -> Welcome:
    """`welcome` each client in a thread of its own, which ends where no header comes."""
    def within_time(server: Any, client: socket, address: Any) -> None:
        before = client.gettimeout()
        client.settimeout(HEADER_WITHIN)
        welcome(server, client, address)
        with suppress(OSError):  # it was turned away, and is closed
            client.settimeout(before)

    @wraps(welcome)
    def apart(server: Any, client: socket, address: Any) -> None:
        threading.Thread(target=within_time, args=(server, client, address),
                         name='connection of a topic', daemon=True).start()

    return apart
