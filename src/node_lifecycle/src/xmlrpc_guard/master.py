"""rosmaster: a ROS master that refuses web browsers; it takes the arguments of ROS's own rosmaster.

roslaunch and roscore find this program in PATH before ROS's own rosmaster.
"""
from __future__ import annotations

import signal

import rosmaster

from xmlrpc_guard import guard_servers


def main() -> None:
    """Runs the master until SIGINT."""
    signal.signal(signal.SIGINT, signal.default_int_handler)  # so that it closes its connections
    guard_servers()
    rosmaster.rosmaster_main()
