"""Reads measurements that other programs publish, with the same rule for all readers."""
from __future__ import annotations

import math
from typing import Optional

from node_lifecycle.log_throttle import warn


def measured(value: float, low: float, high: float, what: str) -> Optional[float]:
    """Returns the value; None if it is NaN or outside `low`..`high`.

    A value outside is never replaced by the nearer limit: a charge of 23.0 is a mistake of the
    program that sent it, and not a full battery. The log names the value, and the reader keeps the
    last valid one.
    """
    if low <= value <= high:
        return value
    if not math.isnan(value):
        warn(what, f'{what} is ignored: it is {value:g}, but must be from {low:g} to {high:g}.')
    return None
