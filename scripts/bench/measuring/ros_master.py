"""Starts a ROS master for one benchmark."""
from __future__ import annotations

import os
import signal
import subprocess
import time
from contextlib import contextmanager
from typing import Iterator

import rosgraph

from ports import free_port


@contextmanager
def own_ros_master() -> Iterator[str]:
    """Starts a master; this process and its child processes use its URI from now on."""
    port = free_port()
    uri = os.environ['ROS_MASTER_URI'] = f'http://127.0.0.1:{port}'
    core = subprocess.Popen(['roscore', '-p', str(port)], stdout=subprocess.DEVNULL,
                            stderr=subprocess.DEVNULL)
    try:
        while not rosgraph.Master('/bench').is_online():
            if core.poll() is not None:
                raise RuntimeError(f'roscore on port {port} has ended with {core.returncode}')
            time.sleep(0.05)
        yield uri
    finally:
        core.send_signal(signal.SIGINT)
        core.wait(30)
