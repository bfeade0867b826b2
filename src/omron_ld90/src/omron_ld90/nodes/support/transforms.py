"""Waits for a transform that comes soon. The wait ends even while ROS time stands still.

The timeout of tf2's own functions is ROS time: under /use_sim_time without /clock it never ends.
"""
from __future__ import annotations

import time
from typing import Callable, TypeVar

import tf2_ros

PAUSE = 0.01  # s between two attempts

Found = TypeVar('Found')


def wait_for_transform(seconds: float, look: Callable[[], Found]) -> Found:
    """Calls `look` until TF has the transform, at most for `seconds`. Returns the result of `look`.

    Raises the tf2_ros.TransformException of the last attempt.
    """
    deadline = time.monotonic() + seconds
    while True:
        try:
            return look()
        except tf2_ros.TransformException:
            if time.monotonic() >= deadline:
                raise
            time.sleep(PAUSE)
