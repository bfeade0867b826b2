"""Limits the size of messages that rospy receives: larger messages are neither collected nor read.

rospy collects a message of any announced length (up to 4 GB), and then makes an object for each of
the message's elements. Here, the length is compared with `message_limits` as soon as it arrives:

- A topic's message that is too large is left out while it arrives. Other messages still arrive.
- A service's request or answer that is too large ends its connection. The other side gets an error
  at once.
- A header that is too large ends its connection. The first bytes of an HTTP request look like the
  length of such a header, so a web browser gets no further.
"""
from __future__ import annotations

import struct
from functools import wraps
from io import BytesIO
from socket import socket
from typing import Any, Callable, Dict, List

from rosgraph.network import ROSHandshakeException
from rospy.exceptions import TransportTerminated
from rospy.impl import tcpros_base
from rospy.impl.tcpros_base import TCPROSTransportProtocol
from rospy.impl.tcpros_pubsub import TCPROSSub
from rospy.impl.tcpros_service import TCPROSServiceClient

from node_lifecycle.log_throttle import warn
from node_lifecycle.message_limits import limit_of

LARGEST_HEADER = 2**18  # bytes; a header contains the definition of its message type
_LENGTH = struct.Struct('<I')  # the length that precedes each message and the header

Read = Callable[[Any, BytesIO, List[Any], socket], None]
OnTooLarge = Callable[[str], None]
_told: Dict[str, OnTooLarge] = {}


def limit_messages() -> None:
    """Applies the limits to all connections that rospy makes from now on."""
    if not hasattr(TCPROSTransportProtocol.read_messages, '__wrapped__'):
        TCPROSSub.read_messages = leaving_out(TCPROSTransportProtocol.read_messages)
        TCPROSTransportProtocol.read_messages = ending(TCPROSTransportProtocol.read_messages, 0)
        # one byte precedes a service's answer: it says whether the service succeeded
        TCPROSServiceClient.read_messages = ending(TCPROSServiceClient.read_messages, 1)
        tcpros_base.read_ros_handshake_header = bounded_header(
            tcpros_base.read_ros_handshake_header)


def when_too_large(topic: str, then: OnTooLarge) -> None:
    """Makes rospy call `then` with the reason when it leaves out a message of this topic.

    Without this call, a warning is logged. `topic` is the full name.
    """
    _told[topic] = then


def leaving_out(read: Read) -> Read:
    """Wraps a topic's `read_messages`, which reads all complete messages of a buffer."""
    @wraps(read)
    def within_limits(topic: Any, buffer: BytesIO, messages: List[Any], sock: socket) -> None:
        most = limit_of(topic.recv_data_class._type)
        pending = getattr(topic, '_pending', None)
        if pending or buffer.tell() > most or _length(buffer, 0) > most:
            # The first byte on a new connection begins a new message.
            rest = pending[1] if pending and pending[0] is sock else 0
            topic._pending = (sock, _leave_out(topic.resolved_name, buffer, most, rest))
            if not topic._pending[1]:
                topic._pending = None
        read(topic, buffer, messages, sock)

    return within_limits


def _leave_out(topic: str, buffer: BytesIO, most: int, rest: int) -> int:
    """Removes the next `rest` bytes, and all messages that are too large, from a buffer.

    Returns the number of further bytes to remove, which have not come yet.
    """
    data = buffer.getvalue()
    begin = position = min(rest, len(data))
    rest -= begin
    kept: List[bytes] = []
    while not rest and len(data) - position >= _LENGTH.size:
        (length,) = _LENGTH.unpack_from(data, position)
        end = position + _LENGTH.size + length
        if length > most:
            _warn(topic, length, most)
            kept.append(data[begin:position])
            rest = max(end - len(data), 0)
            begin = end = min(end, len(data))
        position = end
    kept.append(data[begin:])
    buffer.seek(0)
    buffer.truncate()
    buffer.write(b''.join(kept))
    return rest


def ending(read: Read, start: int) -> Read:
    """Wraps a service's `read_messages`. A message begins at byte `start` of the buffer."""
    @wraps(read)
    def within_limits(service: Any, buffer: BytesIO, messages: List[Any], sock: socket) -> None:
        if buffer.tell() < start + _LENGTH.size:
            return  # rospy would collect an error message of any length
        most = limit_of(service.recv_data_class._type)
        length = _length(buffer, start)
        if length > most:
            reason = _reason(length, most)
            warn(service.resolved_name, f'A call of {service.resolved_name} is ended: {reason}.')
            raise TransportTerminated(reason)
        read(service, buffer, messages, sock)

    return within_limits


def bounded_header(read: Callable[[Any, BytesIO, int], Any]) -> Callable[[Any, BytesIO, int], Any]:
    """Wraps the reading of a connection's header."""
    @wraps(read)
    def within_limits(sock: socket, buffer: BytesIO, size: int) -> Any:
        return read(_HeaderSocket(sock), buffer, size)

    return within_limits


class _HeaderSocket:
    """Reads the header of a connection. Raises an error if the header announces too many bytes."""

    def __init__(self, sock: socket) -> None:
        self._socket = sock
        self._begun = b''

    def recv(self, size: int) -> bytes:
        """Returns the next bytes."""
        data = self._socket.recv(size)
        if len(self._begun) < _LENGTH.size:
            self._begun += data[:_LENGTH.size]
            if len(self._begun) >= _LENGTH.size:
                (length,) = _LENGTH.unpack_from(self._begun)
                if length > LARGEST_HEADER:
                    raise ROSHandshakeException(f'the header has {length} bytes')
        return data


def _length(buffer: BytesIO, start: int) -> int:
    """Returns the length of the message that begins at `start`."""
    length: int = _LENGTH.unpack_from(buffer.getbuffer(), start)[0]
    return length


def _warn(topic: str, length: int, most: int) -> None:
    then = _told.get(topic)
    if then is not None:
        then(_reason(length, most))
    else:
        warn(topic, f'A message on {topic} is left out: {_reason(length, most)}.')


def _reason(length: int, most: int) -> str:
    return f'it has {length} bytes, and at most {most} are read'
