"""Rows of different lengths, stored one after the other in flat arrays."""
from __future__ import annotations

import numpy as np


def count_up(lengths: np.ndarray) -> np.ndarray:
    """Returns 0, 1 .. n - 1 for each n of `lengths`, one row after the other."""
    ends = np.cumsum(lengths)
    return np.arange(ends[-1] if len(ends) else 0) - np.repeat(ends - lengths, lengths)


def order_of(numbers: np.ndarray) -> np.ndarray:
    """Returns the indices that sort small counting numbers. Equal numbers keep their order.

    If the numbers fit into 16 bits, numpy sorts them several times as fast.
    """
    largest = int(numbers.max()) if len(numbers) else 0
    return np.argsort(numbers.astype(np.min_scalar_type(largest)), kind='stable')
