"""Functions that read lines about inputs, outputs and range devices; see `readers`."""
from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omron_arcl import replies

if TYPE_CHECKING:
    import numpy.typing as npt

_COORDINATE_LIMIT = 2 ** 31  # ARCL's integers are signed 32 bit
_STATES = ('on', 'off', 'broken')


def digital_input(text: str, output: bool) -> replies.Input:
    """Reads `<name> on`, or only the name: according to the manual, some lists have no state."""
    name, _, state = text.rpartition(' ')
    if state.lower() not in _STATES:
        name, state = text, ''
    if not name:
        raise ValueError
    return replies.Input(name.strip('"'), state.lower(), output)


def external_io_update(text: str) -> replies.ExternalIOUpdate:
    """Reads `input <name> updated with 0x20 from 32`, or
    `output <name> updated with 1 at bit 32 to 0x80`.
    """
    what, updated, _ = text.partition(' updated with ')
    side, _, name = what.partition(' ')
    if side.lower() not in ('input', 'output') or not (name and updated):
        raise ValueError
    return replies.ExternalIOUpdate(name)


def range_reading(text: str, cumulative: bool) -> replies.RangeReading:
    """Reads `<device> x y x y ...`: whole mm in the map frame.

    An unpaired last number is dropped.
    """
    device, _, numbers = text.partition(' ')
    if not device:
        raise ValueError
    flat = _integers(numbers)
    points = flat[:flat.size // 2 * 2].reshape(-1, 2)
    points.setflags(write=False)
    return replies.RangeReading(device, points, cumulative)


def _integers(text: str) -> npt.NDArray[np.int64]:
    """Reads integers that are separated by blanks, with one call of numpy.

    numpy stops silently at the first word that is not an integer. Therefore the text is checked
    before: it may contain only digits, blanks and minus signs. Each sign must follow a blank, and a
    digit must follow the sign.
    """
    padded = f' {text} '.encode('ascii')
    if (padded.translate(None, b'0123456789 -') or b'- ' in padded
            or padded.count(b'-') != padded.count(b' -')):
        raise ValueError
    if not padded.strip():
        return np.empty(0, np.int64)
    numbers = np.fromstring(text, dtype=np.int64, sep=' ')
    if numbers.max() >= _COORDINATE_LIMIT or numbers.min() < -_COORDINATE_LIMIT:
        raise ValueError
    return numbers
