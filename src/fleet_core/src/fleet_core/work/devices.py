"""Devices of a site, as in the work file: devices on edges, such as doors, and machines."""
from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Optional, Tuple, Union

LAST_ADDRESS = 65535   # the highest address of a coil or an input of Modbus, and the highest port
LAST_UNIT = 255        # the highest unit of Modbus
KEY_REGISTERS = 4      # number of registers (16 bits each) for a key; the highest bits come first


class DeviceKind(Enum):
    """What a device is."""

    DOOR = 'door'
    AIR_LOCK = 'air_lock'
    LIGHT = 'light'
    MACHINE = 'machine'   # no edges lead through it; it carries out steps


class DeviceDriver(Enum):
    """How a device is reached."""

    SIMULATED = 'simulated'
    MODBUS = 'modbus'   # Modbus TCP
    LD90 = 'ld90'       # an output and an input of an LD-90


@dataclass(frozen=True)
class ModbusAddress:
    """Where a device is reached by Modbus TCP.

    open_coil -- the coil that opens the device
    is_open   -- the discrete input that says that the device is open
    unit      -- number of the device behind a gateway
    """

    host: str
    open_coil: int
    is_open: int
    port: int = 502
    unit: int = 1


@dataclass(frozen=True)
class RobotAddress:
    """The output of a robot that opens a device, and the robot's input that says that the device is
    open.

    robot -- the namespace of the robot's nodes
    """

    robot: str
    output: str
    input: str


@dataclass(frozen=True)
class HandOverAddress:
    """Where a device that hands over is reached by Modbus TCP.

    start_coil   -- the coil that begins a hand-over
    key_register -- the first of the KEY_REGISTERS holding registers that receive the step's key
    done, failed -- the discrete inputs that say how the hand-over has ended
    unit         -- number of the device behind a gateway
    """

    host: str
    start_coil: int
    key_register: int
    done: int
    failed: int
    port: int = 502
    unit: int = 1


@dataclass(frozen=True)
class StepDevice:
    """A device that carries out steps: a press or a conveyor that hands over to robots.

    timeout -- s that the device may take to get ready for a step, or to break off a step
    at      -- vertices at which it stands; empty: the work file names none
    address -- where its driver reaches it; None: it is SIMULATED
    """

    name: str
    timeout: float
    address: Optional[HandOverAddress] = None
    at: Tuple[int, ...] = ()


@dataclass(frozen=True)
class Device:
    """A device through which edges lead.

    edges   -- ids of edges, in both directions: no robot is let onto them unless the device is
               known to be open
    timeout -- s that it may take to do what it was asked for
    address -- where its driver reaches it; None: it is SIMULATED
    """

    name: str
    kind: DeviceKind
    edges: Tuple[int, ...]
    timeout: float
    driver: DeviceDriver = DeviceDriver.SIMULATED
    address: Union[ModbusAddress, RobotAddress, None] = None
