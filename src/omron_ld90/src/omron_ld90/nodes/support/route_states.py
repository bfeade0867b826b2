"""Reads the states of all edges of a route as one array, for routes of any length.

Routes are reported ten times a second. If 10,000 edges became objects each time, this would take a
whole core. A forged report of a million edges would take some hundred megabytes.
"""
from __future__ import annotations

import struct

import numpy as np

from itrci_nav_msgs.msg import ExecutionRouteStates

MAX_EDGES = 20_000
EDGE: np.dtype = np.dtype([('edge', '<i4'), ('state', 'u1')])  # itrci_nav_msgs/EdgeState
_NONE = np.empty(0, EDGE)
_LENGTH = struct.Struct('<I')
_FRAME_ID, _ROUTE_ID = 12, 4  # bytes: where the header's frame_id begins; length of route_id


class RouteStates(ExecutionRouteStates):
    """An ExecutionRouteStates with its edges in the array `edges` of EDGE; `edge_states` is empty.

    If a report has more than MAX_EDGES edges, `edges` is empty and `too_long` is True.
    """

    edges = _NONE
    too_long = False

    def deserialize(self, str: bytes) -> RouteStates:  # noqa: A002  genpy's name
        """Reads the message."""
        frame_id, = _LENGTH.unpack_from(str, _FRAME_ID)
        before = _FRAME_ID + _LENGTH.size + frame_id + _ROUTE_ID
        count, = _LENGTH.unpack_from(str, before)
        begin = before + _LENGTH.size
        end = begin + count * EDGE.itemsize
        super().deserialize(str[:before] + _LENGTH.pack(0) + str[end:])
        self.too_long = count > MAX_EDGES
        self.edges = _NONE if self.too_long else np.frombuffer(str, EDGE, count, begin)
        return self
