"""Sensor noise: it depends only on seed and time, not on the number of queries."""
from __future__ import annotations

import numpy as np


def noise(seed: int, time: float, deviation: float, count: int) -> np.ndarray:
    """Returns normally distributed errors (count,) of a measurement at `time` (s)."""
    milliseconds = int(round(time * 1000.0))
    return np.random.RandomState([seed % 2 ** 32, milliseconds % 2 ** 32]).normal(
        0.0, deviation, count)
