"""The values of VDA 5050.

The vehicle receives orders and actions, and sends state, connection and visualization. Units are
metres, radians and percent, as in the messages. The fields have the names of the standard, in the
spelling of Python.
"""
from __future__ import annotations

from dataclasses import dataclass

from vda5050_protocol.values.enums import (
    ActionStatus,
    BlockingType,
    ConnectionState,
    EmergencyStop,
    ErrorLevel,
    OperatingMode,
)
from vda5050_protocol.values.orders import (
    ActionParameter,
    Corridor,
    Deviation,
    Element,
    InstantActions,
    NodePosition,
    OrderEdge,
    OrderMessage,
    OrderNode,
    VdaAction,
)
from vda5050_protocol.values.states import (
    ActionState,
    AgvPosition,
    BatteryState,
    ConnectionMessage,
    Error,
    ErrorKind,
    ErrorReference,
    MapInformation,
    SafetyState,
    StateMessage,
    Velocity,
    Visualization,
)

__all__ = [
    'ActionParameter', 'ActionState', 'ActionStatus', 'AgvPosition', 'BatteryState', 'BlockingType',
    'ConnectionMessage', 'ConnectionState', 'Corridor', 'Deviation', 'Element', 'EmergencyStop',
    'Error', 'ErrorKind', 'ErrorLevel', 'ErrorReference', 'Header', 'InstantActions',
    'MapInformation', 'NodePosition', 'OperatingMode', 'OrderEdge', 'OrderMessage', 'OrderNode',
    'SafetyState', 'StateMessage', 'VdaAction', 'Velocity', 'Visualization',
]


@dataclass(frozen=True)
class Header:
    """The sender, the time and the id of a message; each topic has its own count of ids."""

    header_id: int
    timestamp: str
    version: str
    manufacturer: str
    serial_number: str
