"""Where the fleet manager of this computer takes a stop: a file for times without a ROS master.

A ROS master may end while robots drive. The fleet manager still reaches them then, and a person on
its computer must reach the fleet manager.
"""
from __future__ import annotations

import contextlib
from pathlib import Path
from typing import Optional

import rosgraph.network
import rospkg

from file_replacement import replace_file


def note(master_uri: str, service_uri: str) -> None:
    """Writes down that the fleet manager under this ROS master has its service there (rosrpc://).

    Raises OSError.
    """
    path = _path(master_uri)
    path.parent.mkdir(parents=True, exist_ok=True)
    replace_file(path, service_uri)


def noted(master_uri: str) -> Optional[str]:
    """What was written last, true by now or not; None: nothing."""
    with contextlib.suppress(OSError, UnicodeDecodeError):
        return _path(master_uri).read_text(encoding='ascii')
    return None


def _path(master_uri: str) -> Path:
    """All names of this computer are one: the person's may not be that of the launch."""
    host, port = rosgraph.network.parse_http_host_and_port(master_uri)
    computer = 'here' if rosgraph.network.is_local_address(host) else host
    return Path(rospkg.get_ros_home(), 'graph_fleet_manager', f'stop_fleet_{computer}_{port}')
