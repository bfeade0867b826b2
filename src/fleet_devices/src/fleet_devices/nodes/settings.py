"""The parameters of `fleet_devices`, and the drivers of the devices in the work file."""
from __future__ import annotations

import math
import time
from typing import Any, Dict, Hashable, List, Mapping, Sequence, Tuple

from fleet_core.files.errors import FileError
from fleet_core.files.work_file import load_work
from fleet_core.work.devices import Device, ModbusAddress, RobotAddress, StepDevice
from fleet_devices.core.device import DeviceLimits
from fleet_devices.core.devices import Periods
from fleet_devices.drivers.driver import DevicePort, HandOverPort
from fleet_devices.drivers.modbus import (
    ModbusConnection,
    ModbusDevice,
    ModbusHandOver,
    client_class,
)
from fleet_devices.drivers.simulated import (
    FAULTS_OF_DOORS,
    FAULTS_OF_MACHINES,
    FaultKind,
    ScriptedFault,
    SimulatedDevice,
    SimulatedHandOver,
)
from fleet_devices.nodes.robot_signals import RobotSignals
from node_lifecycle import ConfigurationError, number, parameter
from route_protocol.device_messages import LONGEST_NAME
from trajectory_graph import TrajectoryGraphError, load_graph

SIMULATED = 'simulated'  # the connection of all simulated devices


class Settings:
    """The checked parameters of the node; raises ConfigurationError.

    devices  -- the devices through which edges lead
    machines -- the devices that carry out steps
    """

    def __init__(self) -> None:
        path, graph_file = parameter('~work_file'), parameter('~graph_file')
        try:
            work = load_work(path, load_graph(graph_file))
        except FileError as error:
            raise ConfigurationError(str(error)) from None
        except (TrajectoryGraphError, OSError) as error:
            raise ConfigurationError(f'{graph_file}: {error}') from None
        self.devices, self.machines = work.devices, work.step_devices
        for name in (*self.devices, *self.machines):
            if len(name) > LONGEST_NAME:
                raise ConfigurationError(f'{path}: the name of device {name[:20]}... has more than '
                                         f'{LONGEST_NAME} letters.')
        self.memory_file = parameter('~memory_file', 'fleet_devices/memory.json')
        if not self.memory_file:
            raise ConfigurationError('Parameter ~memory_file is empty: give the name of a file.')
        self.steps_file = parameter('~steps_file', 'fleet_devices/steps.json')
        if not self.steps_file:
            raise ConfigurationError('Parameter ~steps_file is empty: give the name of a file.')
        self.periods = Periods(number('~period', 0.2, 0.02, 10.0))
        offline_after = number('~offline_after', 2.0, 3 * self.periods.exchange, 60.0)
        self.limits = {name: DeviceLimits(device.timeout, offline_after)
                       for name, device in self.devices.items()}
        self.machine_limits = {name: DeviceLimits(machine.timeout, offline_after)
                               for name, machine in self.machines.items()}
        self._travel = number('~simulated_travel', 3.0, 0.0, 600.0)
        self._faults = scripted_faults(parameter('~simulated_faults', [], list), self.devices,
                                       self.machines)
        self._connections: Dict[Tuple[str, int], ModbusConnection] = {}

    def lines(self) -> Dict[str, Tuple[Hashable, DevicePort]]:
        """Returns the connection and the driver of each device. Devices may share a connection."""
        return {name: self._line(device) for name, device in self.devices.items()}

    def machine_lines(self) -> Dict[str, Tuple[Hashable, HandOverPort]]:
        """Returns the connection and the driver of each machine. They may share a connection."""
        return {name: self._machine_line(machine) for name, machine in self.machines.items()}

    def _machine_line(self, machine: StepDevice) -> Tuple[Hashable, HandOverPort]:
        address = machine.address
        if address is not None:
            connection = self._connection(machine.name, address.host, address.port)
            return (address.host, address.port), ModbusHandOver(connection, address)
        return SIMULATED, SimulatedHandOver(time.monotonic, self._travel,
                                            self._faults.get(machine.name, ()))

    def _connection(self, device: str, host: str, port: int) -> ModbusConnection:
        try:
            client_class()
        except ImportError as error:
            raise ConfigurationError(
                f'Device {device} has the driver modbus, but pymodbus cannot be used '
                f'({error}): install python3-pymodbus and python3-serial-asyncio.') from None
        return self._connections.setdefault((host, port), ModbusConnection(host, port))

    def _line(self, device: Device) -> Tuple[Hashable, DevicePort]:
        address = device.address
        if isinstance(address, ModbusAddress):
            connection = self._connection(device.name, address.host, address.port)
            return (address.host, address.port), ModbusDevice(connection, address)
        if isinstance(address, RobotAddress):
            return address.robot, RobotSignals(address)
        return SIMULATED, SimulatedDevice(time.monotonic, self._travel,
                                          self._faults.get(device.name, ()))


def scripted_faults(entries: List[Any], devices: Mapping[str, Device],
                    machines: Mapping[str, StepDevice]) -> Dict[str, List[ScriptedFault]]:
    """Returns the faults of `~simulated_faults` by device. Raises ConfigurationError."""
    found: Dict[str, List[ScriptedFault]] = {}
    for entry in entries:
        if not isinstance(entry, dict) or set(entry) != {'device', 'fault', 'begin', 'end'}:
            raise ConfigurationError(f'An entry of ~simulated_faults is {entry!r}, but must have '
                                     'device, fault, begin and end.')
        name, kind, begin, end = (entry[key] for key in ('device', 'fault', 'begin', 'end'))
        device = (devices.get(name) or machines.get(name)) if isinstance(name, str) else None
        if device is None or device.address is not None:
            raise ConfigurationError(f'~simulated_faults names {name!r}, which is no simulated '
                                     'device of the work file.')
        fault = _fault_of(name, kind, FAULTS_OF_MACHINES if name in machines else FAULTS_OF_DOORS)
        if not (_is_time(begin) and _is_time(end) and 0 <= begin < end):
            raise ConfigurationError(f'~simulated_faults has a fault from {begin!r} to {end!r}, '
                                     'but must have two numbers (s), the first one smaller.')
        found.setdefault(name, []).append(ScriptedFault(fault, begin, end))
    return found


def _fault_of(device: str, word: Any, own: Sequence[FaultKind]) -> FaultKind:
    """Returns the kind of fault that a word names, if the device can have it.

    Raises ConfigurationError.
    """
    kinds = {kind.value: kind for kind in FaultKind}
    if word not in kinds:
        raise ConfigurationError(f'~simulated_faults has the fault {word!r}; there are: '
                                 f'{", ".join(kinds)}.')
    if kinds[word] not in own:
        raise ConfigurationError(f'~simulated_faults gives {device} the fault {word}, but it has '
                                 f'only: {", ".join(one.value for one in own)}.')
    return kinds[word]


def _is_time(value: Any) -> bool:
    return (isinstance(value, (int, float)) and not isinstance(value, bool)
            and math.isfinite(value))
