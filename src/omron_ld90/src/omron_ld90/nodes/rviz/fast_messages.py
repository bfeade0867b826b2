"""Messages whose long arrays numpy writes.

Why not plain messages: the 44,440 points of a real map take 120 ms to serialise as Point objects
and 2 ms from an array, a grid of 2 million cells 50 ms and 0.2 ms, and a list of numbers needs
eight times the memory: a node that shows a large map would stand still for seconds. On the wire
nothing differs: each class here writes the same type, with its array in the place of the plain
message's empty one.
"""
from __future__ import annotations

import io
import struct

import numpy as np
from nav_msgs.msg import OccupancyGrid
from nav_msgs.srv import GetMapResponse, LoadMapResponse
from visualization_msgs.msg import Marker, MarkerArray

_LENGTH = struct.Struct('<I')
#: What follows the points of a marker without colours, text and mesh: three lengths and a bool.
_AFTER_POINTS = 3 * _LENGTH.size + 1


class PointsMarker(Marker):
    """A marker whose points are `array` (N, 3), metres; `points`, `colors`, `text` stay empty."""

    def __init__(self, array: np.ndarray, **fields: object) -> None:
        super().__init__(**fields)
        self.array = np.ascontiguousarray(array, '<f8').reshape(-1, 3)

    def serialize(self, buff: io.BytesIO) -> None:
        """Write the message to `buff`."""
        plain = io.BytesIO()
        super().serialize(plain)
        _write(buff, plain.getbuffer(), _AFTER_POINTS, self.array)


class FastMarkerArray(MarkerArray):
    """Markers of which any may be a PointsMarker: each writes itself."""

    def serialize(self, buff: io.BytesIO) -> None:
        """Write the message to `buff`."""
        buff.write(_LENGTH.pack(len(self.markers)))
        for marker in self.markers:
            marker.serialize(buff)


class GridMessage(OccupancyGrid):
    """An occupancy grid whose data are `cells` (height, width), int8; `data` stays empty."""

    def __init__(self, cells: np.ndarray, **fields: object) -> None:
        super().__init__(**fields)
        self.cells = np.ascontiguousarray(cells, np.int8)

    def serialize(self, buff: io.BytesIO) -> None:
        """Write the message to `buff`."""
        plain = io.BytesIO()
        super().serialize(plain)
        _write(buff, plain.getbuffer(), 0, self.cells.reshape(-1, 1))


class GetGridResponse(GetMapResponse):
    """Answer of `static_map` whose `map` is a GridMessage."""

    def serialize(self, buff: io.BytesIO) -> None:
        """Write the message to `buff`."""
        self.map.serialize(buff)


class LoadGridResponse(LoadMapResponse):
    """Answer of `change_map` whose `map` is a message that writes itself."""

    def serialize(self, buff: io.BytesIO) -> None:
        """Write the message to `buff`."""
        self.map.serialize(buff)
        buff.write(struct.pack('<B', self.result))


def _write(buff: io.BytesIO, plain: memoryview, after: int, elements: np.ndarray) -> None:
    """Write `plain` with `elements` put into the empty array `after` bytes before its end."""
    end = len(plain) - after
    buff.write(plain[:end - _LENGTH.size])
    buff.write(_LENGTH.pack(len(elements)))
    buff.write(elements.data)
    buff.write(plain[end:])
