"""Starts a mosquitto broker on the loopback interface, for a simulated robot or a single robot.

The configuration is generated, so the user writes no file. It works with mosquitto 1.6 and 2.0.
Arguments: --port (18830). Other arguments, which roslaunch gives to every node, are ignored.
"""
from __future__ import annotations

import argparse
import os
import shutil
import sys
from typing import List

CONFIGURATION = '''# Generated. Anonymous, as only this computer can reach it.
listener {port} 127.0.0.1
allow_anonymous true
set_tcp_nodelay true
persistence false
max_queued_messages 1000
message_size_limit 1000000
log_dest stderr
log_type error
log_type warning
'''


def configuration(port: int) -> str:
    """Returns the text of mosquitto.conf."""
    return CONFIGURATION.format(port=port)


def find_mosquitto() -> str:
    """Returns the path of the program, or '' if it is not installed; Debian: /usr/sbin."""
    return shutil.which('mosquitto', path=os.environ.get('PATH', '') + ':/usr/sbin') or ''


def configuration_in_memory(port: int) -> int:
    """Returns a descriptor of mosquitto.conf, a file in memory that no other user can replace."""
    descriptor = os.memfd_create('mosquitto.conf', 0)  # programs that this process runs inherit it
    os.write(descriptor, configuration(port).encode())
    return descriptor


def command(program: str, descriptor: int) -> List[str]:
    """Returns the command that starts mosquitto with an inherited configuration."""
    return [program, '-c', f'/proc/self/fd/{descriptor}']


def main() -> None:
    """Makes the configuration and replaces this process by mosquitto."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--port', type=int, default=18830)
    options, _ = parser.parse_known_args()
    program = find_mosquitto()
    if not program:
        sys.exit('mosquitto is not installed. Install it: apt-get install mosquitto')
    words = command(program, configuration_in_memory(options.port))
    os.execv(program, words)
