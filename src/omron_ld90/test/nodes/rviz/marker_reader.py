"""Markers as subscribers get them: serialised and read again."""
from __future__ import annotations

import io
from typing import List

from visualization_msgs.msg import Marker, MarkerArray


def received(message: Marker) -> Marker:
    """Returns a marker as a subscriber receives it."""
    return _sent(message, Marker())


def drawn(array: MarkerArray) -> List[Marker]:
    """Returns the markers of a complete array, which begins with DELETEALL."""
    first, *markers = _sent(array, MarkerArray()).markers
    assert first.action == Marker.DELETEALL, 'the array does not begin with DELETEALL'
    return markers


def of(array: MarkerArray, namespace: str) -> List[Marker]:
    """Returns the markers of one namespace."""
    return [marker for marker in drawn(array) if marker.ns == namespace]


def _sent(message, empty):
    buffer = io.BytesIO()
    message.serialize(buffer)
    return empty.deserialize(buffer.getvalue())
