"""A broker that the bench can kill while the vehicle drives."""
from __future__ import annotations

import subprocess
import tempfile
from pathlib import Path

from vda5050_vehicle.mqtt.embedded_broker import configuration, find_mosquitto


class OwnBroker:
    """A mosquitto process that the bench can kill and start again."""

    def __init__(self, port: int) -> None:
        self._folder = tempfile.TemporaryDirectory()
        self._file = Path(self._folder.name) / 'mosquitto.conf'
        Path(self._folder.name).chmod(0o755)
        self._file.write_text(configuration(port))
        self.start()

    def start(self) -> None:
        """Starts the broker."""
        self._process = subprocess.Popen([find_mosquitto(), '-c', str(self._file)],
                                         stderr=subprocess.DEVNULL)

    def kill(self) -> None:
        """Kills the broker, as a power failure does."""
        self._process.kill()
        self._process.wait()

    def close(self) -> None:
        """Ends the broker and removes its files."""
        self.kill()
        self._folder.cleanup()
