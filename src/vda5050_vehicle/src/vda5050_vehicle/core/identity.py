"""The identity of the vehicle, and its map."""
from __future__ import annotations

from dataclasses import dataclass

from vda5050_vehicle.protocol.fields import Malformed
from vda5050_vehicle.protocol.values import Header


@dataclass(frozen=True)
class Identity:
    """Manufacturer and serial number are levels of the MQTT topics, too."""

    manufacturer: str
    serial_number: str
    map_id: str = 'map'
    map_version: str = ''

    def check(self, header: Header) -> None:
        """Raises Malformed where a message is for another vehicle; masters may name none."""
        for key, theirs, ours in (('manufacturer', header.manufacturer, self.manufacturer),
                                  ('serialNumber', header.serial_number, self.serial_number)):
            if theirs and theirs != ours:
                raise Malformed(key, f'is {theirs[:40]!r}, but this vehicle is {ours!r}')
