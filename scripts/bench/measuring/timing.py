"""Measures durations."""
from __future__ import annotations

import statistics
import time
from typing import Callable, Sequence

import numpy as np


def milliseconds(run: Callable[[], object], runs: int = 7) -> float:
    """Returns the median duration of several runs, in ms of wall-clock time."""
    times = []
    for _ in range(runs):
        begun = time.perf_counter()
        run()
        times.append(time.perf_counter() - begun)
    return 1e3 * statistics.median(times)


def p50_and_p99(values: Sequence[float]) -> str:
    """Returns a text with the median and the 99th percentile (ms) of times in s."""
    p50, p99 = np.percentile(values, (50, 99))
    return f'p50 {p50:.2f} ms, p99 {p99:.2f} ms'
