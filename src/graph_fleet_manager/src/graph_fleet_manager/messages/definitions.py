"""The message definitions that both sides of joined ROS masters must have alike."""
from __future__ import annotations

import inspect
from typing import Dict

import genpy
from sensor_msgs.msg import BatteryState

import itrci_nav_msgs.msg


def own_definitions() -> Dict[str, str]:
    """The MD5 sum of every message type that crosses, by its name."""
    kinds = [kind for _, kind in inspect.getmembers(itrci_nav_msgs.msg, inspect.isclass)
             if issubclass(kind, genpy.Message)]
    return {kind._type: kind._md5sum for kind in [*kinds, BatteryState]}
