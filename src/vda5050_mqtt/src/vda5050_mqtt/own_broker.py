"""A broker for programs that kill it while a vehicle drives."""
from __future__ import annotations

import os
import subprocess

from vda5050_mqtt.embedded_broker import command, configuration_in_memory, find_mosquitto


class OwnBroker:
    """A mosquitto process that the calling program can kill and start again."""

    def __init__(self, port: int) -> None:
        self._configuration = configuration_in_memory(port)
        self.start()

    def start(self) -> None:
        """Starts the broker."""
        self._process = subprocess.Popen(
            command(find_mosquitto(), self._configuration), stderr=subprocess.DEVNULL,
            pass_fds=[self._configuration])

    def kill(self) -> None:
        """Kills the broker, as a power failure does."""
        self._process.kill()
        self._process.wait()

    def close(self) -> None:
        """Ends the broker and removes its configuration."""
        self.kill()
        os.close(self._configuration)
