"""The start of the editor in its own process."""
from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
from pathlib import Path

NODE = Path(__file__).resolve().parents[2] / 'nodes' / 'graph_editor'


def test_the_editor_waits_for_its_ros_master_and_can_be_ended_meanwhile():
    with socket.socket() as held:
        held.bind(('127.0.0.1', 0))  # the port is in use, but no program listens on it
        uri = f'http://127.0.0.1:{held.getsockname()[1]}'
        with subprocess.Popen([sys.executable, str(NODE)], stderr=subprocess.PIPE, text=True,
                              env={**os.environ, 'ROS_MASTER_URI': uri}) as node:
            assert node.stderr is not None
            assert f'There is no ROS master at {uri} yet' in node.stderr.readline()
            assert node.poll() is None
            node.send_signal(signal.SIGTERM)
            assert node.wait(timeout=60) == 0, node.stderr.read()
