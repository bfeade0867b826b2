"""The values that go to the master: state, errors, connection and visualization."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Optional, Tuple

from vda5050_protocol.values.enums import (
    ActionStatus,
    ConnectionState,
    EmergencyStop,
    ErrorLevel,
    OperatingMode,
)
from vda5050_protocol.values.orders import OrderEdge, OrderNode


@dataclass(frozen=True)
class ActionState:
    """The progress of an action."""

    action_id: str
    action_type: str
    status: ActionStatus
    description: Optional[str] = None
    result_description: Optional[str] = None
    instant: bool = False


@dataclass(frozen=True)
class AgvPosition:
    """The pose of the vehicle on the map `map_id`, in m and rad."""

    x: float
    y: float
    theta: float
    map_id: str
    position_initialized: bool = True
    localization_score: Optional[float] = None


@dataclass(frozen=True)
class Velocity:
    """The velocity in the vehicle's frame, in m/s and rad/s."""

    vx: float
    vy: float
    omega: float


@dataclass(frozen=True)
class BatteryState:
    """Charge in percent, voltage in V."""

    charge: float
    charging: bool
    voltage: Optional[float] = None


@dataclass(frozen=True)
class ErrorReference:
    """The object of an error, e.g. the key nodeId and its value."""

    key: str
    value: str


@dataclass(frozen=True)
class ErrorKind:
    """A type of error: its name and level in 2.x and in 3.0; `hint` describes the remedy."""

    name: str
    level: ErrorLevel
    hint: str
    name_3: str
    level_3: ErrorLevel

    def error(self, description: str, *references: ErrorReference) -> Error:
        """Returns an error of this kind."""
        return Error(self, description, references)


@dataclass(frozen=True)
class Error:
    """An error that exists now."""

    kind: ErrorKind
    description: str
    references: Tuple[ErrorReference, ...] = ()


@dataclass(frozen=True)
class SafetyState:
    """Emergency stop and protective field."""

    e_stop: EmergencyStop
    field_violation: bool


@dataclass(frozen=True)
class MapInformation:
    """A map that the vehicle has."""

    map_id: str
    map_version: str
    status: str = 'ENABLED'
    description: Optional[str] = None


@dataclass(frozen=True)
class StateMessage:
    """The complete state that the master receives.

    node_states, edge_states -- the nodes and edges that are still to be driven

    The attributes are the fields of the standard.
    """

    order_id: str
    order_update_id: int
    last_node_id: str
    last_node_sequence_id: int
    node_states: Tuple[OrderNode, ...]
    edge_states: Tuple[OrderEdge, ...]
    action_states: Tuple[ActionState, ...]
    driving: bool
    battery: BatteryState
    operating_mode: OperatingMode
    errors: Tuple[Error, ...]
    safety: SafetyState
    paused: Optional[bool] = None
    new_base_request: Optional[bool] = None
    distance_since_last_node: Optional[float] = None
    position: Optional[AgvPosition] = None
    velocity: Optional[Velocity] = None
    information: Tuple[()] = ()  # for displays only; always empty: `errors` has all information
    maps: Tuple[MapInformation, ...] = ()
    zone_set_id: Optional[str] = None

    @property
    def order_action_states(self) -> Tuple[ActionState, ...]:
        """The actions of the order; 3.0 reports them separately."""
        return tuple(state for state in self.action_states if not state.instant)

    @property
    def instant_action_states(self) -> Tuple[ActionState, ...]:
        """The instant actions; 3.0 reports them separately."""
        return tuple(state for state in self.action_states if state.instant)


@dataclass(frozen=True)
class Visualization:
    """The pose and velocity of the vehicle, for displays."""

    position: Optional[AgvPosition] = None
    velocity: Optional[Velocity] = None
    state_header_id: int = 0  # 3.0: the headerId of the last state


@dataclass(frozen=True)
class ConnectionMessage:
    """Whether the vehicle is connected to the broker."""

    state: ConnectionState
