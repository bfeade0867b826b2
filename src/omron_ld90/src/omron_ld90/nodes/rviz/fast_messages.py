"""Messages whose long arrays numpy writes.

A list of 100,000 Point objects takes some 100 ms to serialise, and a grid's cells as a list of
numbers not much less; an array's bytes take 0.1 ms. On the wire nothing differs: each class here
writes the same type, with its array in the place of the plain message's empty one.
"""
from __future__ import annotations

import io
import struct

import numpy as np
from geometry_msgs.msg import Point
from nav_msgs.msg import OccupancyGrid
from nav_msgs.srv import GetMapResponse, LoadMapResponse
from visualization_msgs.msg import Marker

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

    def to_plain(self) -> Marker:
        """The same marker with a list of Point objects, as a MarkerArray needs it."""
        fields = {name: getattr(self, name) for name in self.__slots__}
        fields['points'] = [Point(*row) for row in self.array.tolist()]
        return Marker(**fields)


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
