"""The parameters of `fleet_devices`, and the drivers of the devices in the work file."""
from __future__ import annotations

import math
import time
from typing import Any, Dict, Hashable, List, Mapping, Tuple

from fleet_core.files.errors import FileError
from fleet_core.files.work_file import load_work
from fleet_core.work.devices import Device, ModbusAddress, RobotAddress
from fleet_devices.core.device import DeviceLimits
from fleet_devices.core.devices import Periods
from fleet_devices.drivers.driver import DevicePort
from fleet_devices.drivers.modbus import ModbusConnection, ModbusDevice, client_class
from fleet_devices.drivers.simulated import FaultKind, ScriptedFault, SimulatedDevice
from fleet_devices.nodes.robot_signals import RobotSignals
from node_lifecycle import ConfigurationError, number, parameter
from route_protocol.device_messages import LONGEST_NAME
from trajectory_graph import TrajectoryGraphError, load_graph


class Settings:
    """The checked parameters of the node; raises ConfigurationError.

    lines -- for each device the connection that it shares with others, and its driver
    """

    def __init__(self) -> None:
        path, graph_file = parameter('~work_file'), parameter('~graph_file')
        try:
            self.devices = load_work(path, load_graph(graph_file)).devices
        except FileError as error:
            raise ConfigurationError(str(error)) from None
        except (TrajectoryGraphError, OSError) as error:
            raise ConfigurationError(f'{graph_file}: {error}') from None
        for name in self.devices:
            if len(name) > LONGEST_NAME:
                raise ConfigurationError(f'{path}: the name of device {name[:20]}... has more than '
                                         f'{LONGEST_NAME} letters.')
        self.memory_file = parameter('~memory_file', 'fleet_devices/memory.json')
        if not self.memory_file:
            raise ConfigurationError('Parameter ~memory_file is empty: give the name of a file.')
        self.periods = Periods(number('~period', 0.2, 0.02, 10.0))
        offline_after = number('~offline_after', 2.0, 3 * self.periods.exchange, 60.0)
        self.limits = {name: DeviceLimits(device.timeout, offline_after)
                       for name, device in self.devices.items()}
        self._travel = number('~simulated_travel', 3.0, 0.0, 600.0)
        self._faults = scripted_faults(parameter('~simulated_faults', [], list), self.devices)

    def lines(self) -> Dict[str, Tuple[Hashable, DevicePort]]:
        """Returns the connection of each device, and its driver."""
        connections: Dict[Tuple[str, int], ModbusConnection] = {}
        return {name: self._line(device, connections) for name, device in self.devices.items()}

    def _line(self, device: Device, connections: Dict[Tuple[str, int], ModbusConnection],
              ) -> Tuple[Hashable, DevicePort]:
        address = device.address
        if isinstance(address, ModbusAddress):
            try:
                client_class()
            except ImportError as error:
                raise ConfigurationError(
                    f'Device {device.name} has the driver modbus, but pymodbus cannot be used '
                    f'({error}): install python3-pymodbus and python3-serial-asyncio.') from None
            peer = address.host, address.port
            connection = connections.setdefault(peer, ModbusConnection(*peer))
            return peer, ModbusDevice(connection, address)
        if isinstance(address, RobotAddress):
            return address.robot, RobotSignals(address)
        return 'simulated', SimulatedDevice(time.monotonic, self._travel,
                                            self._faults.get(device.name, ()))


def scripted_faults(entries: List[Any], devices: Mapping[str, Device]) -> Dict[
        str, List[ScriptedFault]]:
    """Returns the faults of `~simulated_faults` by device. Raises ConfigurationError."""
    found: Dict[str, List[ScriptedFault]] = {}
    kinds = {kind.value: kind for kind in FaultKind}
    for entry in entries:
        if not isinstance(entry, dict) or set(entry) != {'device', 'fault', 'begin', 'end'}:
            raise ConfigurationError(f'An entry of ~simulated_faults is {entry!r}, but must have '
                                     'device, fault, begin and end.')
        name, kind, begin, end = (entry[key] for key in ('device', 'fault', 'begin', 'end'))
        device = devices.get(name) if isinstance(name, str) else None
        if device is None or device.address is not None:
            raise ConfigurationError(f'~simulated_faults names {name!r}, which is no simulated '
                                     'device of the work file.')
        if kind not in kinds:
            raise ConfigurationError(f'~simulated_faults has the fault {kind!r}; there are: '
                                     f'{", ".join(kinds)}.')
        if not all(isinstance(time, (int, float)) and not isinstance(time, bool)
                   and math.isfinite(time) for time in (begin, end)) or not 0 <= begin < end:
            raise ConfigurationError(f'~simulated_faults has a fault from {begin!r} to {end!r}, '
                                     'but must have two numbers (s), the first one smaller.')
        found.setdefault(name, []).append(ScriptedFault(kinds[kind], begin, end))
    return found
