"""The present boot of the computer."""
from __future__ import annotations


def boot_id() -> str:
    """Returns the id of the boot. What is not forced to the disk counts within one boot only."""
    with open('/proc/sys/kernel/random/boot_id', encoding='ascii') as stream:
        return stream.read().strip()
