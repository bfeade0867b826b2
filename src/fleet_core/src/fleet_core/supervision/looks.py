"""The words and looks of devices and machines, the same on the page, in RViz and in lists."""
from __future__ import annotations

from enum import Enum
from typing import Collection, Mapping, Optional

from fleet_core.interlocking.claims import ClaimState
from fleet_core.supervision.machine_view import MachineState
from route_protocol.devices import DeviceMode

DEVICE_WORDS: Mapping[DeviceMode, str] = {
    DeviceMode.CLOSED: 'closed', DeviceMode.MOVING: 'moving', DeviceMode.OPEN: 'open',
    DeviceMode.OFFLINE: 'offline', DeviceMode.UNKNOWN: 'state unknown'}
"""What a device shows, as people read it."""


class QueueState(Enum):
    """The state of a queue place; the value is its words, for `str.format`."""

    FREE = '{station} {number}'
    COMING = '{station} {number}: {robot} is on its way'
    TAKEN = '{station} {number}: {robot}'


def queue_words(station: str, number: int, robot: str, is_there: bool) -> str:
    """Returns the words of a queue place.

    number -- of the queue place, from 1
    robot  -- the robot to which the place is given; empty: the place is free
    """
    state = QueueState.FREE if not robot else QueueState.TAKEN if is_there else QueueState.COMING
    return state.value.format(station=station, number=number, robot=robot)


class ResourceLook(Enum):
    """How a resource or a machine looks. Each look has its own colour; the value is its meaning."""

    PLACE = 'a station or zone, or a machine that is free'
    OPEN = 'a device that is open, or a machine at work'
    SHUT = 'a device that is not open'
    TROUBLE = 'what is not known, or is not open for a robot that is there'


_OF_DEVICE: Mapping[DeviceMode, ResourceLook] = {
    DeviceMode.CLOSED: ResourceLook.SHUT, DeviceMode.MOVING: ResourceLook.SHUT,
    DeviceMode.OPEN: ResourceLook.OPEN,
    DeviceMode.OFFLINE: ResourceLook.TROUBLE, DeviceMode.UNKNOWN: ResourceLook.TROUBLE}
LOOK_OF_MACHINE: Mapping[MachineState, ResourceLook] = {
    MachineState.SILENT: ResourceLook.TROUBLE, MachineState.FREE: ResourceLook.PLACE,
    MachineState.WORKING: ResourceLook.OPEN}


def look_of_resource(mode: Optional[DeviceMode], claims: Collection[ClaimState]) -> ResourceLook:
    """Returns the look of a resource.

    mode -- what its device shows; None: it has no device
    """
    if ClaimState.LOST in claims:
        return ResourceLook.TROUBLE
    return ResourceLook.PLACE if mode is None else _OF_DEVICE[mode]
