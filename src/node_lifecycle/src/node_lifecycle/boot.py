"""The present boot of the computer."""
from __future__ import annotations


def boot_id() -> str:
    """Returns the id of the boot. Data that are not forced to the disk are valid only in this boot.
    """
    with open('/proc/sys/kernel/random/boot_id', encoding='ascii') as stream:
        return stream.read().strip()
