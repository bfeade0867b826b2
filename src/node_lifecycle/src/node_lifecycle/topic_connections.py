"""Corrects three faults of rospy's topic connections, which appear if many nodes start at once.

- A node's topic server lets five connections wait. The kernel drops the sixth, and its client tries
  again after 1, 3, 7 and 15 s. So a latched message may come that late.
- A subscriber may be told of a publisher twice, for example when another publisher of the topic
  appears. It then makes two connections at once. Each side drops the connection that it considers
  older. If the two sides drop different connections, no connection is left, and rospy makes no new
  one.
- A node's server reads the headers of connections one after the other, without a time limit. All
  other clients are blocked by a client that sends no header, or that sends an XML-RPC call for an
  earlier node on this port.
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

HEADER_WITHIN = 10.0  # s after connecting within which a client must send the header

Connect = Callable[[Any, str, str], Any]
Welcome = Callable[[Any, socket, Any], Any]


def mend() -> None:
    """Applies the corrections `with_room`, `one_at_a_time` and `each_by_itself` to rospy."""
    if not hasattr(ROSHandler._connect_topic, '__wrapped__'):
        ROSHandler._connect_topic = one_at_a_time(ROSHandler._connect_topic)
        TCPServer._create_server_sock = with_room(TCPServer._create_server_sock)
        TCPROSServer._tcp_server_callback = each_by_itself(TCPROSServer._tcp_server_callback)


def one_at_a_time(connect: Connect) -> Connect:
    """Wraps `connect` so that it runs only once at a time for a topic and a publisher.

    A second call then finds the connection of the first call, and makes none.
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
    """Wraps `create` so that as many connections can wait at the socket as the system allows."""
    @wraps(create)
    def roomy(server: Any) -> socket:
        made = create(server)
        made.listen(SOMAXCONN)
        return made

    return roomy


def each_by_itself(welcome: Welcome) -> Welcome:
    """Wraps `welcome` so that each client has its own thread. If no header comes, the thread ends.
    """
    def within_time(server: Any, client: socket, address: Any) -> None:
        before = client.gettimeout()
        client.settimeout(HEADER_WITHIN)
        welcome(server, client, address)
        with suppress(OSError):  # the client was rejected, and its socket is closed
            client.settimeout(before)

    @wraps(welcome)
    def apart(server: Any, client: socket, address: Any) -> None:
        threading.Thread(target=within_time, args=(server, client, address),
                         name='connection of a topic', daemon=True).start()

    return apart
