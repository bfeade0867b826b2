"""The values of VDA 5050.

The vehicle receives orders and actions, and sends state, connection and visualization. Units are
metres, radians and percent, as in the messages. Field names are those of the standard, in the
spelling of Python.
"""
from __future__ import annotations

from dataclasses import dataclass

from vda5050_protocol.values.enums import (
    ActionStatus,
    BlockingType,
    ConnectionState,
    ErrorLevel,
    EStop,
    OperatingMode,
)
from vda5050_protocol.values.orders import (
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
from vda5050_protocol.values.states import (
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
    """The sender and the time of a message; each topic counts its ids."""

    header_id: int
    timestamp: str
    version: str
    manufacturer: str
    serial_number: str
