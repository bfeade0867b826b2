"""Messages with long arrays; numpy writes the arrays.

Plain messages are too slow, and a node that shows a large map would block for seconds. To serialize
the 44,440 points of a real map takes 120 ms as Point objects, but 2 ms as an array. A grid of 2
million cells takes 50 ms as a list, but 0.2 ms as an array. A list of numbers also needs eight
times the memory. The bytes on the wire are the same as those of a plain message. The message keeps
its list empty, and `serialize` writes the array in place of the list.
"""
from __future__ import annotations

import io
import struct

import numpy as np
from nav_msgs.msg import OccupancyGrid
from nav_msgs.srv import GetMapResponse, LoadMapResponse
from visualization_msgs.msg import Marker, MarkerArray

_LENGTH = struct.Struct('<I')
#: Number of bytes that follow the points of a marker. A marker without colours, text and mesh has
#: three lengths and a bool there.
_AFTER_POINTS = 3 * _LENGTH.size + 1


class PointsMarker(Marker):
    """A marker whose points are `array` (N, 3), m; `points`, `colors` and `text` stay empty."""

    def __init__(self, array: np.ndarray, **fields: object) -> None:
        super().__init__(**fields)
        self.array = np.ascontiguousarray(array, '<f8').reshape(-1, 3)

    def serialize(self, buff: io.BytesIO) -> None:
        """Writes the message to `buff`."""
        plain = io.BytesIO()
        super().serialize(plain)
        _write(buff, plain.getbuffer(), _AFTER_POINTS, self.array)


class FastMarkerArray(MarkerArray):
    """An array of markers. Each marker may be a PointsMarker, because each marker writes itself."""

    def serialize(self, buff: io.BytesIO) -> None:
        """Writes the message to `buff`."""
        buff.write(_LENGTH.pack(len(self.markers)))
        for marker in self.markers:
            marker.serialize(buff)


class GridMessage(OccupancyGrid):
    """An occupancy grid whose data are `cells` (height, width), int8; `data` stays empty."""

    def __init__(self, cells: np.ndarray, **fields: object) -> None:
        super().__init__(**fields)
        self.cells = np.ascontiguousarray(cells, np.int8)

    def serialize(self, buff: io.BytesIO) -> None:
        """Writes the message to `buff`."""
        plain = io.BytesIO()
        super().serialize(plain)
        _write(buff, plain.getbuffer(), 0, self.cells.reshape(-1, 1))


class GetGridResponse(GetMapResponse):
    """Answer of `static_map` whose `map` is a GridMessage."""

    def serialize(self, buff: io.BytesIO) -> None:
        """Writes the message to `buff`."""
        self.map.serialize(buff)


class LoadGridResponse(LoadMapResponse):
    """Answer of `change_map` whose `map` is a message that serializes itself."""

    def serialize(self, buff: io.BytesIO) -> None:
        """Writes the message to `buff`."""
        self.map.serialize(buff)
        buff.write(struct.pack('<B', self.result))


def _write(buff: io.BytesIO, plain: memoryview, after: int, elements: np.ndarray) -> None:
    """Writes the message `plain` with `elements` in place of its empty array.

    The last `after` bytes of `plain` follow the empty array.
    """
    end = len(plain) - after
    buff.write(plain[:end - _LENGTH.size])
    buff.write(_LENGTH.pack(len(elements)))
    buff.write(elements.data)
    buff.write(plain[end:])
