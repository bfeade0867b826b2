"""Lines are published byte for byte. A message that cannot be serialised does not end its topic."""
from __future__ import annotations

import struct
from io import BytesIO
from typing import List

import pytest

from omron_ld90.nodes.support import publishing
from omron_ld90.nodes.support.publishing import LineMessage, publish_checked
from omron_ld90_msgs.msg import LinkState, RobotStatus


class Publisher:
    """Serialises all messages into one buffer, as rospy does."""

    resolved_name = '/robot_status'

    def __init__(self) -> None:
        self.buffer = BytesIO()
        self.published: List[object] = []

    def publish(self, message) -> None:
        message.serialize(self.buffer)
        self.published.append(message)


@pytest.fixture(autouse=True)
def warnings(monkeypatch) -> List[str]:
    said: List[str] = []
    monkeypatch.setattr(publishing, 'warn', lambda kind, message: said.append(message))
    return said


@pytest.mark.parametrize('bad', [
    RobotStatus(state_of_charge=1e41), RobotStatus(activity=300), RobotStatus(status='\udcfc'),
    RobotStatus(temperature='hot'), LinkState(state=-1),
])
def test_a_message_that_cannot_be_serialised_is_dropped_and_leaves_nothing_behind(bad, warnings):
    publisher = Publisher()
    assert not publish_checked(publisher, bad)
    assert publisher.buffer.getvalue() == b''
    assert '/robot_status' in warnings[0]
    assert publish_checked(publisher, RobotStatus())
    assert publisher.published == [RobotStatus()]


def test_a_line_is_serialised_byte_for_byte():
    buffer = BytesIO()
    LineMessage(b'caf\xe9\x00').serialize(buffer)
    assert buffer.getvalue() == struct.pack('<I', 5) + b'caf\xe9\x00'
