"""The recorded poses and states of all robots, in a ring of files: the oldest is deleted first.

Each line is one moment: `{"t": seconds, "k": true, "r": {name: [x, y, theta, state, waits for,
works]}}`. A moment has only the robots that have changed. A key moment, which has `k`, has all
robots. So a reader can begin with any key moment.
"""
from __future__ import annotations

import json
import os
import re
from bisect import bisect_right
from typing import Any, Dict, List, Optional, Tuple

SIZE = 50_000_000      # bytes of all files
SEGMENTS = 20
KEY_PERIOD = 30.0      # s between two key moments
_NAME = re.compile(r'replay_(\d{10})\.jsonl')

Moment = Dict[str, List[Any]]


class ReplayRing:
    """The ring of files in a folder of its own; `size`: bytes of all files together."""

    def __init__(self, folder: str, size: int = SIZE) -> None:
        self._folder, self._segment_size = folder, size // SEGMENTS
        os.makedirs(folder, exist_ok=True)
        self._numbers = sorted(int(found.group(1)) for found in map(
            _NAME.fullmatch, os.listdir(folder)) if found)
        self._index: List[Tuple[float, int, int]] = []  # time, file and offset of key moments
        for number in self._numbers:
            self._read_index(number)
        self._last: Moment = {}
        self._key_at = -KEY_PERIOD
        self._size = self._segment_size  # the first moment begins a new file
        self._end: Optional[float] = None

    @property
    def span(self) -> Optional[Tuple[float, float]]:
        """The times of the first and the last moment; None: there is no moment."""
        if not self._index:
            return None
        begin = self._index[0][0]
        return begin, max(begin, self._index[-1][0] if self._end is None else self._end)

    def add(self, time: float, robots: Moment) -> None:
        """Adds a moment. Raises OSError if the disk cannot be written."""
        if self._end is not None and time <= self._end:
            return  # the clock was set back, but the recorded moments must stay in order
        begins = self._size >= self._segment_size
        is_key = begins or not self._index or time - self._key_at >= KEY_PERIOD
        changed = robots if is_key else {
            name: values for name, values in robots.items() if self._last.get(name) != values}
        if not changed and not is_key:
            return
        values = {'t': round(float(time), 2), **({'k': True} if is_key else {}), 'r': changed}
        line = json.dumps(values, separators=(',', ':')).encode() + b'\n'
        if begins:
            self._begin_file()
        number = self._numbers[-1]
        with open(self._path(number), 'ab') as stream:
            offset = stream.tell()
            stream.write(line)
        if is_key:
            self._index.append((time, number, offset))
            self._key_at = time
        self._last, self._end, self._size = dict(robots), time, offset + len(line)

    def at(self, time: float) -> Optional[Dict[str, Any]]:
        """Returns all robots at a time, `{"t": moment, "r": ...}`; None before the first moment."""
        place = bisect_right([entry[0] for entry in self._index], time + 0.005)
        if not place:
            return None
        _, number, offset = self._index[place - 1]
        robots: Moment = {}
        moment = 0.0
        for line in self._lines(number, offset):
            if line['t'] > time + 0.005:
                break
            moment = line['t']
            robots = dict(line['r']) if line.get('k') else {**robots, **line['r']}
        return {'t': moment, 'r': robots}

    def _begin_file(self) -> None:
        self._numbers.append(self._numbers[-1] + 1 if self._numbers else 1)
        while len(self._numbers) > SEGMENTS:
            oldest = self._numbers.pop(0)
            os.remove(self._path(oldest))
            self._index = [entry for entry in self._index if entry[1] != oldest]

    def _path(self, number: int) -> str:
        return os.path.join(self._folder, f'replay_{number:010d}.jsonl')

    def _read_index(self, number: int) -> None:
        with open(self._path(number), 'rb') as stream:
            offset = 0
            for line in stream:
                if b'"k":true' in line[:60]:
                    values = _moment(line)
                    if values is not None:
                        self._index.append((values['t'], number, offset))
                offset += len(line)

    def _lines(self, number: int, offset: int) -> List[Dict[str, Any]]:
        """Returns the moments from a key moment to the next key moment."""
        found: List[Dict[str, Any]] = []
        with open(self._path(number), 'rb') as stream:
            stream.seek(offset)
            for line in stream:
                values = _moment(line)
                if values is None or (found and values.get('k')):
                    break
                found.append(values)
        return found


def _moment(line: bytes) -> Optional[Dict[str, Any]]:
    """Returns the values of a line; None if the line is incomplete."""
    try:
        values = json.loads(line)
        return values if isinstance(values['t'], float) and isinstance(values['r'], dict) else None
    except (ValueError, KeyError, TypeError):
        return None
