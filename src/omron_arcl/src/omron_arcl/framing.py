"""Bytes to lines: CR, LF and CRLF end a line, blank lines are nothing, telnet bytes cut out."""
from __future__ import annotations

import re
from typing import List

LONGEST_LINE = 1 << 20  # bytes; a scan of 455 points has about 5,000

# IAC WILL/WONT/DO/DONT <option>, or IAC <command>; perhaps cut short at the end of the line
_TELNET = re.compile(rb'\xff(?:[\xfb-\xfe].?|[^\xfb-\xfe])?', re.DOTALL)


class LineBuffer:
    """Collects bytes however they are cut and gives out whole lines, without their ends.

    A line of more than `limit` bytes sets `overflowed`; what came before it is still given out, it
    and all that follows is dropped.
    """

    def __init__(self, limit: int = LONGEST_LINE) -> None:
        self.limit = limit
        self.overflowed = False
        self._tail = bytearray()

    def feed(self, data: bytes) -> List[bytes]:
        """The lines that `data` completes."""
        if self.overflowed:
            return []
        if b'\n' not in data and b'\r' not in data:
            self._tail += data
            pieces = []
        else:
            data = bytes(self._tail) + data
            pieces = data.replace(b'\r', b'\n').split(b'\n')
            self._tail = bytearray(pieces.pop())
        if len(data) + len(self._tail) > self.limit:
            pieces = self._up_to_the_limit(pieces)
        if b'\xff' in data:
            pieces = [_TELNET.sub(b'', piece) for piece in pieces]
        return [piece for piece in pieces if piece and not piece.isspace()]

    def _up_to_the_limit(self, pieces: List[bytes]) -> List[bytes]:
        lengths = [len(piece) for piece in pieces] + [len(self._tail)]
        if max(lengths) <= self.limit:
            return pieces
        self.overflowed = True
        self._tail.clear()
        return pieces[:next(i for i, length in enumerate(lengths) if length > self.limit)]
