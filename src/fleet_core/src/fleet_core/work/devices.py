"""Devices through which edges lead, as the work file describes them."""
from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Tuple, Union

LAST_ADDRESS = 65535   # of a coil or an input of Modbus, and of a port
LAST_UNIT = 255        # of Modbus


class DeviceKind(Enum):
    """What a device is."""

    DOOR = 'door'
    AIR_LOCK = 'air_lock'
    LIGHT = 'light'


class DeviceDriver(Enum):
    """How a device is reached."""

    SIMULATED = 'simulated'
    MODBUS = 'modbus'   # Modbus TCP
    LD90 = 'ld90'       # an output and an input of an LD-90


@dataclass(frozen=True)
class ModbusAddress:
    """Where a device is reached by Modbus TCP.

    open_coil -- the coil that opens it
    is_open   -- the discrete input that says that it is open
    unit      -- the device behind a gateway
    """

    host: str
    open_coil: int
    is_open: int
    port: int = 502
    unit: int = 1


@dataclass(frozen=True)
class RobotAddress:
    """The output of a robot that opens a device, and its input that says that it is open.

    robot -- the namespace of its nodes
    """

    robot: str
    output: str
    input: str


@dataclass(frozen=True)
class Device:
    """A device through which edges lead.

    edges   -- numbers of edges, in both directions: no robot is let onto them while the device is
               not known to be open
    timeout -- s that it may take to do what it was asked for
    address -- where its driver reaches it; None: it is SIMULATED
    """

    name: str
    kind: DeviceKind
    edges: Tuple[int, ...]
    timeout: float
    driver: DeviceDriver = DeviceDriver.SIMULATED
    address: Union[ModbusAddress, RobotAddress, None] = None
