"""JSON files with data that a node must keep after the end of its process."""
from __future__ import annotations

import fcntl
import json
import os
import threading
from typing import Any

import rospkg

from file_replacement import replace_file
from node_lifecycle.parameters import ConfigurationError

PATIENCE = 4.0  # s within which an earlier node with the same file must end


def in_ros_home(path: str) -> str:
    """Returns the path of a file. A relative path is in ROS_HOME; an empty path means no file."""
    return os.path.join(rospkg.get_ros_home(), path) if path else ''


def hold(path: str, parameter: str) -> None:
    """Reserves a file for this process until its end, with a lock file beside it.

    Raises ConfigurationError if another process has reserved it. If the lock file cannot be written
    or locked, the file is not reserved: a node without stored data can still drive.
    """
    if not path:
        return
    try:
        os.makedirs(os.path.dirname(os.path.abspath(path)), exist_ok=True)
        lock = os.open(f'{path}.lock', os.O_RDWR | os.O_CREAT, 0o600)
    except OSError:
        return
    given_up = threading.Event()
    waiting = threading.Thread(target=_lock, args=(lock, given_up), name='file-lock', daemon=True)
    waiting.start()
    waiting.join(PATIENCE)
    if waiting.is_alive():
        given_up.set()
        raise ConfigurationError(f'Another node keeps its memory in {path}: end that node, or give '
                                 f'this one a file of its own with {parameter}.')


def _lock(descriptor: int, given_up: threading.Event) -> None:
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX)
    except OSError:  # a file system without locks
        given_up.set()
    if given_up.is_set():
        os.close(descriptor)


def replace_json(path: str, content: Any, on_disk: bool = False) -> None:
    """Writes a file that is complete at any time; raises OSError.

    on_disk -- True: the file survives a power cut. False: it survives only the end of the process,
               but the node does not wait for the disk
    """
    os.makedirs(os.path.dirname(os.path.abspath(path)), exist_ok=True)
    replace_file(path, json.dumps(content), on_disk=on_disk)
