"""rosmaster: the ROS master, with the arguments of ROS's own; web browsers cannot use it.

roslaunch and roscore find this program in PATH before ROS's own.
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
