"""Nodes neither read nor collect a message that is larger than its type may be."""
from __future__ import annotations

import io
import re
import socket
import struct
from itertools import chain
from pathlib import Path
from typing import Any, Iterable, Iterator, List, Tuple

import pytest
from hypothesis import given
from hypothesis import strategies as st
from received_types import received_types
from rosgraph.network import ROSHandshakeException
from roslib.message import get_message_class, get_service_class
from rospy.exceptions import TransportTerminated
from rospy.impl.tcpros_base import TCPROSTransportProtocol, read_ros_handshake_header
from rospy.impl.tcpros_pubsub import TCPROSSub
from rospy.impl.tcpros_service import TCPROSServiceClient, TCPService
from std_msgs.msg import String

from node_lifecycle import bounded_messages
from node_lifecycle.bounded_messages import LARGEST_HEADER, bounded_header, ending, leaving_out
from node_lifecycle.message_limits import LIMITS, OTHER, limit_of

PACKAGE = Path(__file__).resolve().parents[2] / 'package.xml'
TOPIC = '/topic'
SHARES = (0.5, 1, 10)
PIECE = 2 ** 16  # bytes in one piece from a socket
#: Types that are passed as values, but are only parts of messages, or only published.
NOT_RECEIVED = {'itrci_nav_msgs/DeviceUse', 'itrci_nav_msgs/Edge', 'itrci_nav_msgs/EdgeState',
                'itrci_nav_msgs/StepParameter', 'itrci_nav_msgs/StepState', 'itrci_nav_msgs/Vertex',
                'omron_ld90_msgs/LastCommand',
                'nav_msgs/MapMetaData', 'visualization_msgs/Marker',
                'visualization_msgs/MarkerArray'}

read_topic = leaving_out(TCPROSTransportProtocol.read_messages)
read_service = ending(TCPROSTransportProtocol.read_messages, 0)
read_answer = ending(TCPROSServiceClient.read_messages, 1)


@pytest.fixture(name='warnings')
def _warnings(monkeypatch) -> List[str]:
    said: List[str] = []
    monkeypatch.setattr(bounded_messages, 'warn', lambda kind, text: said.append(text))
    return said


def class_of(message_type: str) -> Any:
    """Returns the class of a message, or of the request or response of a service."""
    for part in ('Request', 'Response'):
        service = message_type[:-len(part)]
        if message_type.endswith(part) and get_service_class(service) is not None:
            return getattr(get_service_class(service), f'_{part.lower()}_class')
    return get_message_class(message_type)


def framed(message: Any, size: int) -> bytes:
    """Returns a message as it is transmitted, made longer so that it has `size` bytes."""
    return b''.join(wire(message, size))


def wire(message: Any, size: int) -> Iterator[bytes]:
    """Yields the same bytes as `framed` in pieces, as a socket delivers them."""
    content = io.BytesIO()
    message.serialize(content)
    rest = size - content.tell()
    assert rest >= 0, f'{message._type} is larger than {size} bytes while it is empty'
    yield struct.pack('<I', size) + content.getvalue()
    for begin in range(0, rest, PIECE):
        yield bytes(min(PIECE, rest - begin))


def received(cls: Any, pieces: Iterable[bytes]) -> Tuple[List[Any], int]:
    """Returns the messages that a subscriber reads from a stream, and the largest number of bytes
    that the subscriber collects.
    """
    protocol = TCPROSSub(TOPIC, cls)
    buffer, messages, most = io.BytesIO(), [], 0
    for piece in pieces:
        buffer.write(piece)
        if buffer.tell() >= 4:
            read_topic(protocol, buffer, messages, None)
        most = max(most, buffer.tell())
    return messages, most


@pytest.mark.parametrize('message_type', sorted(LIMITS))
@pytest.mark.parametrize('share', SHARES)
def test_every_type_is_read_up_to_its_limit_and_not_above(message_type, share, warnings):
    cls, limit = class_of(message_type), LIMITS[message_type]
    size = int(limit * share)
    small = framed(cls(), 4096 if limit > 4096 else 1024)
    messages, most = received(cls, chain([small], wire(cls(), size), [small]))
    assert len(messages) == (3 if share <= 1 else 2)
    assert most <= limit + 4 + PIECE + len(small)
    assert len(warnings) == (0 if share <= 1 else 1)
    assert all(f'{size} bytes' in text and TOPIC in text for text in warnings)


def test_the_table_has_every_type_that_a_node_receives():
    missing = {kind: file for kind, file in received_types().items()
               if kind not in LIMITS and kind not in NOT_RECEIVED}
    assert not missing, f'give them a limit in message_limits.py: {missing}'


def test_the_table_has_no_type_that_nobody_receives():
    assert set(LIMITS) <= set(received_types()), 'remove them from message_limits.py'


def test_the_package_declares_the_messages_of_its_table():
    """Without these dependencies in package.xml, the tests of this package could not run alone. At
    run time, a node reads only types that its own package declares.
    """
    declared = re.findall(r'_depend>(\w+)<', PACKAGE.read_text(encoding='utf-8'))
    assert {message_type.split('/')[0] for message_type in LIMITS} <= set(declared)


def test_the_search_finds_subscribers_services_and_actions():
    found = received_types()
    for kind in ('itrci_nav_msgs/TargetRoute', 'std_srvs/TriggerRequest', 'tf2_msgs/TFMessage',
                 'omron_ld90_msgs/ExecuteCommandActionGoal', 'actionlib_msgs/GoalID'):
        assert kind in found


@pytest.mark.parametrize('message_type', sorted(LIMITS))
def test_every_limit_is_far_above_an_empty_message(message_type):
    content = io.BytesIO()
    class_of(message_type)().serialize(content)
    assert LIMITS[message_type] >= 4 * content.tell()


def test_a_type_of_a_sites_own_configuration_has_a_limit():
    assert limit_of('foreign_msgs/Unknown') == OTHER


def test_arrays_are_bounded_before_their_elements_are_made():
    cls = get_message_class('itrci_nav_msgs/MissionRequest')
    content = io.BytesIO()
    cls(destination_vertices_id=[1] * 100_000).serialize(content)
    data = content.getvalue()
    assert received(cls, [struct.pack('<I', len(data)) + data])[0] == []


@given(sizes=st.lists(st.integers(4, 3000), max_size=12), pieces=st.integers(1, 900))
def test_exactly_the_messages_within_the_limit_arrive_in_any_pieces(sizes, pieces):
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(LIMITS, 'std_msgs/String', 1000)
        patch.setattr(bounded_messages, 'warn', lambda *_: None)
        texts = [chr(97 + number) * (size - 4) for number, size in enumerate(sizes)]
        stream = b''.join(framed(String(text), len(text) + 4) for text in texts)
        messages, most = received(String, (stream[begin:begin + pieces]
                                           for begin in range(0, len(stream), pieces)))
    assert [one.data for one in messages] == [one for one in texts if len(one) <= 996]
    assert most <= 1004 + pieces


def test_after_a_new_connection_nothing_is_missing(monkeypatch, warnings):
    monkeypatch.setitem(LIMITS, 'std_msgs/String', 100)
    protocol, messages = TCPROSSub(TOPIC, String), []
    buffer = io.BytesIO()
    buffer.write(framed(String('a'), 500)[:200])
    read_topic(protocol, buffer, messages, 'first connection')
    buffer.write(framed(String('b'), 20))
    read_topic(protocol, buffer, messages, 'second connection')
    assert [one.data for one in messages] == ['b']


def test_a_node_can_say_itself_what_it_misses(monkeypatch, warnings):
    reasons: List[str] = []
    monkeypatch.setitem(bounded_messages._told, TOPIC, reasons.append)
    monkeypatch.setitem(LIMITS, 'std_msgs/String', 100)
    received(String, [framed(String(), 101)])
    assert reasons == ['it has 101 bytes, and at most 100 are read'] and not warnings


@pytest.mark.parametrize('read, start, cls', [
    (read_service, b'', TCPService), (read_answer, b'\1', TCPROSServiceClient),
    (read_answer, b'\0', TCPROSServiceClient)], ids=['request', 'answer', 'error'])
def test_a_call_of_a_service_with_too_many_bytes_is_ended(read, start, cls, warnings):
    trigger = get_service_class('std_srvs/Trigger')
    protocol, buffer, messages = cls('/stop_fleet', trigger), io.BytesIO(), []
    buffer.write(start + struct.pack('<I', 2**31))
    with pytest.raises(TransportTerminated, match='at most'):
        read(protocol, buffer, messages, None)
    assert messages == [] and '/stop_fleet' in warnings[0]


def test_a_call_of_a_service_within_the_limit_is_answered():
    trigger = get_service_class('std_srvs/Trigger')
    for read, start, cls, message in (
            (read_service, b'', TCPService, trigger._request_class()),
            (read_answer, b'\1', TCPROSServiceClient,
             trigger._response_class(True, 'stopped'))):
        protocol, buffer, messages = cls('/stop_fleet', trigger), io.BytesIO(), []
        content = io.BytesIO()
        message.serialize(content)
        for byte in start + struct.pack('<I', content.tell()) + content.getvalue():
            buffer.write(bytes([byte]))
            if buffer.tell() >= 4:
                read(protocol, buffer, messages, None)
        assert messages == [message]


@pytest.mark.parametrize('begin', [b'POST / HTTP/1.1\r\n', b'GET ', struct.pack('<I', 2**18 + 1)])
def test_a_connection_whose_header_is_no_header_ends_at_its_first_bytes(begin):
    ours, theirs = socket.socketpair()
    with ours, theirs:
        theirs.sendall(begin)
        with pytest.raises(ROSHandshakeException, match='bytes'):
            bounded_header(read_ros_handshake_header)(ours, io.BytesIO(), 4096)


def test_a_header_that_comes_byte_by_byte_is_read():
    ours, theirs = socket.socketpair()
    field = b'topic=/chatter'
    header = struct.pack('<I', len(field)) + field
    with ours, theirs:
        theirs.sendall(struct.pack('<I', len(header)) + header + b'rest')
        buffer = io.BytesIO()
        assert bounded_header(read_ros_handshake_header)(ours, buffer, 1) == {'topic': '/chatter'}
    assert 10 * max(len(class_of(one)._full_text) for one in LIMITS) < LARGEST_HEADER
