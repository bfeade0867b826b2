"""Files with passwords: only their owner should read them."""
from __future__ import annotations

import os

import rospy


def warn_if_exposed(what: str, path: str) -> None:
    """Tells, of a file that is there, that others than its owner can read it."""
    if os.stat(path).st_mode & 0o077:
        rospy.logwarn('The %s %s can be read by others: chmod 600.', what, path)
