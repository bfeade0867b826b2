"""The request that `hosted` sends."""
from __future__ import annotations

import pytest

from node_host.start_request import BadRequest, StartRequest, read_request

PACKET = (b'/home\0' b'3\0' b'/bin/node\0' b'\0' b'__log:=/a.log\0'
          b'ROS_NAMESPACE=/amr1\0' b'X=a=b\0')


def test_a_packet_has_folder_arguments_and_environment():
    assert read_request(PACKET) == StartRequest(
        '/home', ('/bin/node', '', '__log:=/a.log'), {'ROS_NAMESPACE': '/amr1', 'X': 'a=b'})


def test_starts_of_one_node_are_the_same_program_whatever_their_log_file_is():
    again = read_request(PACKET.replace(b'a.log', b'b.log'))
    other = read_request(PACKET.replace(b'amr1', b'amr2'))
    assert again.identity == read_request(PACKET).identity != other.identity


@pytest.mark.parametrize('packet', [
    b'', b'\0', b'/home\0', b'/home\0' b'0\0', b'/home\0' b'1\0' b'\0', b'/home\0' b'9\0' b'node\0',
    b'/home\0' b'-1\0' b'node\0', b'/home\0' b'one\0' b'node\0', PACKET[:-1]])
def test_anything_else_is_refused(packet):
    with pytest.raises(BadRequest):
        read_request(packet)


def test_a_request_of_a_web_browser_is_refused():
    body = b'\n'.join((b'POST / HTTP/1.1\r\nHost: localhost\r\n\r\n', PACKET.replace(b'\0', b'')))
    with pytest.raises(BadRequest):
        read_request(body)
