"""A file with the address of the fleet manager's stop service, for use without a ROS master.

A ROS master may end while robots drive. The fleet manager still reaches the robots then, and a
person on its computer must be able to reach the fleet manager.
"""
from __future__ import annotations

import contextlib
import socket
from pathlib import Path
from typing import Optional

import rosgraph.network
import rospkg

from file_replacement import replace_file


def note(master_uri: str, service_uri: str) -> None:
    """Stores the address (rosrpc://) of the stop service in the file for this ROS master.

    Raises OSError.
    """
    path = _path(master_uri)
    path.parent.mkdir(parents=True, exist_ok=True)
    replace_file(path, service_uri)


def noted(master_uri: str) -> Optional[str]:
    """Returns the last stored address, which may be out of date; None if none was stored."""
    with contextlib.suppress(OSError, UnicodeDecodeError):
        return _path(master_uri).read_text(encoding='ascii')
    return None


def _path(master_uri: str) -> Path:
    """Returns the file for a ROS master.

    All names of this computer give the same file, because the person and the launch file may use
    different names for it. The host name of the computer counts as one of these names, even if
    it has no address.
    """
    host, port = rosgraph.network.parse_http_host_and_port(master_uri)
    is_here = host == socket.gethostname() or rosgraph.network.is_local_address(host)
    computer = 'here' if is_here else host
    return Path(rospkg.get_ros_home(), 'graph_fleet_manager', f'stop_fleet_{computer}_{port}')
