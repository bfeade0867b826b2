"""The values of VDA 5050: orders in, actions in, state, connection and visualization out.

Metres, radians, percent, as on the wire. Field names are the standard's, in Python's spelling.
"""
from __future__ import annotations

from dataclasses import dataclass

from vda5050_vehicle.protocol.values.enums import (
    ActionStatus,
    BlockingType,
    ConnectionState,
    ErrorLevel,
    EStop,
    OperatingMode,
)
from vda5050_vehicle.protocol.values.orders import (
    Action,
    ActionParameter,
    Corridor,
    Deviation,
    Edge,
    Element,
    InstantActions,
    Node,
    NodePosition,
    Order,
)
from vda5050_vehicle.protocol.values.states import (
    ActionState,
    AgvPosition,
    BatteryState,
    Connection,
    Error,
    ErrorKind,
    MapInformation,
    Reference,
    SafetyState,
    State,
    Velocity,
    Visualization,
)

__all__ = [
    'Action', 'ActionParameter', 'ActionState', 'ActionStatus', 'AgvPosition', 'BatteryState',
    'BlockingType', 'Connection', 'ConnectionState', 'Corridor', 'Deviation', 'EStop', 'Edge',
    'Element', 'Error', 'ErrorKind', 'ErrorLevel', 'Header',
    'InstantActions', 'MapInformation', 'Node', 'NodePosition', 'OperatingMode',
    'Order', 'Reference', 'SafetyState', 'State', 'Velocity', 'Visualization',
]


@dataclass(frozen=True)
class Header:
    """The sender of a message, and its time; ids count per topic."""

    header_id: int
    timestamp: str
    version: str
    manufacturer: str
    serial_number: str
