"""The identity of the vehicle, and its map."""
from __future__ import annotations

from dataclasses import dataclass

from vda5050_protocol.fields import Malformed
from vda5050_protocol.values import Header


@dataclass(frozen=True)
class Identity:
    """The identity; manufacturer and serial number are also levels of the MQTT topics."""

    manufacturer: str
    serial_number: str
    map_id: str = 'map'
    map_version: str = ''

    def check(self, header: Header) -> None:
        """Raises Malformed if a message names another vehicle; a message may name no vehicle."""
        for key, theirs, ours in (('manufacturer', header.manufacturer, self.manufacturer),
                                  ('serialNumber', header.serial_number, self.serial_number)):
            if theirs and theirs != ours:
                raise Malformed(key, f'is {theirs[:40]!r}, but this vehicle is {ours!r}')
