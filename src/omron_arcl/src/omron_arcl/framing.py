"""Splits bytes into lines. CR, LF and CRLF end a line; blank lines and telnet bytes are dropped."""
from __future__ import annotations

import re
from typing import List

LONGEST_LINE = 1 << 17  # bytes; a scan of 455 points has about 5,000

# IAC WILL/WONT/DO/DONT <option>, or IAC <command>; it may be incomplete at the end of the line
_TELNET = re.compile(rb'\xff(?:[\xfb-\xfe].?|[^\xfb-\xfe])?', re.DOTALL)


def decode(line: bytes) -> str:
    """Returns a line as text.

    According to its manual, ARCL is ASCII. But the names of goals come from the map, and map files
    are UTF-8, or Latin-1 if an older tool wrote them. A line that is not valid UTF-8 is read as
    Latin-1.
    """
    try:
        return line.decode('utf-8')
    except UnicodeDecodeError:
        return line.decode('latin-1')


class LineBuffer:
    """Collects bytes in pieces of any size and returns whole lines, without their ends.

    A line of more than `limit` bytes sets `overflowed`. The lines before this line are still
    returned. The line itself and all later data are dropped.
    """

    def __init__(self, limit: int = LONGEST_LINE) -> None:
        self.limit = limit
        self.overflowed = False
        self._tail = bytearray()

    @property
    def tail(self) -> bytes:
        """The beginning of a line whose end has not come yet."""
        return bytes(self._tail)

    def pop_tail(self) -> bytes:
        """Returns and clears the tail, as if the line had ended here."""
        tail = bytes(self._tail)
        self._tail.clear()
        return tail

    def feed(self, data: bytes) -> List[bytes]:
        """Returns the lines that `data` completes."""
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
