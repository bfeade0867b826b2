"""The message definitions that must be the same on both sides of joined ROS masters."""
from __future__ import annotations

import inspect
from typing import Dict

import genpy
from sensor_msgs.msg import BatteryState

import itrci_nav_msgs.msg


def own_definitions() -> Dict[str, str]:
    """Returns the MD5 sum of each message type that joined masters share, by type name."""
    kinds = [kind for _, kind in inspect.getmembers(itrci_nav_msgs.msg, inspect.isclass)
             if issubclass(kind, genpy.Message)]
    return {kind._type: kind._md5sum for kind in [*kinds, BatteryState]}
