"""Reads measurements that foreign programs publish: one rule for all readers."""
from __future__ import annotations

import math
from typing import Optional

from node_lifecycle.log_throttle import warn


def measured(value: float, low: float, high: float, what: str) -> Optional[float]:
    """Returns the value, or None if it says nothing: NaN, or a number outside `low`..`high`.

    A number outside is never moved to a limit: a percentage of 23.0 is a mistake of its program,
    and not a full battery. The log names it; the reader keeps the last valid value.
    """
    if low <= value <= high:
        return value
    if not math.isnan(value):
        warn(what, f'{what} is ignored: it is {value:g}, but must be from {low:g} to {high:g}.')
    return None
