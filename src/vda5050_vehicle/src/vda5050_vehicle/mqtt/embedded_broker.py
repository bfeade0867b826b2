"""Starts a mosquitto broker on the loopback interface, for a simulated robot or a single robot.

The user writes no file: the configuration is generated. It suits mosquitto 1.6 and 2.0.
Arguments: --port (18830). Other arguments, which roslaunch gives to every node, are ignored.
"""
from __future__ import annotations

import argparse
import os
import shutil
import sys
import tempfile
from pathlib import Path

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


def main() -> None:
    """Writes the configuration and replaces this process by mosquitto."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--port', type=int, default=18830)
    options, _ = parser.parse_known_args()
    program = find_mosquitto()
    if not program:
        sys.exit('mosquitto is not installed. Install it: apt-get install mosquitto')
    folder = Path(tempfile.gettempdir()) / f'vda5050_broker_{os.getuid()}_{options.port}'
    folder.mkdir(mode=0o755, exist_ok=True)
    if folder.stat().st_uid != os.getuid():
        sys.exit(f'{folder} belongs to another user. Remove this folder.')
    file = folder / 'mosquitto.conf'
    file.write_text(configuration(options.port))
    os.execv(program, [program, '-c', str(file)])
