"""A mosquitto of its own on loopback, for a simulated robot or a single one: no files to write.

The configuration is generated, and read by mosquitto 1.6 and 2.0 alike.
Arguments: --port (18830). Others, as roslaunch gives them to every node, are left alone.
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
    """The text of mosquitto.conf."""
    return CONFIGURATION.format(port=port)


def find_mosquitto() -> str:
    """Path of the program, empty where it is not installed; Debian has it in /usr/sbin."""
    return shutil.which('mosquitto', path=os.environ.get('PATH', '') + ':/usr/sbin') or ''


def main() -> None:
    """Writes the configuration and becomes mosquitto."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--port', type=int, default=18830)
    options, _ = parser.parse_known_args()
    program = find_mosquitto()
    if not program:
        sys.exit('mosquitto is not installed: apt-get install mosquitto')
    folder = Path(tempfile.gettempdir()) / f'vda5050_broker_{os.getuid()}_{options.port}'
    folder.mkdir(mode=0o755, exist_ok=True)
    if folder.stat().st_uid != os.getuid():
        sys.exit(f'{folder} belongs to another user: remove it')
    file = folder / 'mosquitto.conf'
    file.write_text(configuration(options.port))
    os.execv(program, [program, '-c', str(file)])
