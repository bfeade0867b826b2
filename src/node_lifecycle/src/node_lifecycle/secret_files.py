"""Files with passwords: only their owner should read them."""
from __future__ import annotations

import os

import rospy


def warn_if_exposed(what: str, path: str) -> None:
    """Logs a warning if users other than the owner can read an existing file."""
    if os.stat(path).st_mode & 0o077:
        rospy.logwarn('The %s %s can be read by other users: run chmod 600 on it.', what, path)
