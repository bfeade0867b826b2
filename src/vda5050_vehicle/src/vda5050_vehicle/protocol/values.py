"""The values of VDA 5050: orders in, actions in, state, connection and visualization out.

Metres, radians, percent, as on the wire. Field names are the standard's, in Python's spelling.
"""
from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any, Mapping, Optional, Tuple, Union


class BlockingType(Enum):
    """What an action lets happen beside it."""

    NONE = 'NONE'  # driving and other actions
    SOFT = 'SOFT'  # other actions, no driving
    HARD = 'HARD'  # nothing

    @property
    def forbids_driving(self) -> bool:
        """Whether the vehicle must stand."""
        return self is not BlockingType.NONE


class ActionStatus(Enum):
    """Life cycle of an action."""

    WAITING = 'WAITING'
    INITIALIZING = 'INITIALIZING'
    RUNNING = 'RUNNING'
    PAUSED = 'PAUSED'
    FINISHED = 'FINISHED'
    FAILED = 'FAILED'

    @property
    def has_ended(self) -> bool:
        """Whether it will not change any more."""
        return self in (ActionStatus.FINISHED, ActionStatus.FAILED)


class ErrorLevel(Enum):
    """How bad an error is; 2.x knows the first and the last."""

    WARNING = 'WARNING'
    URGENT = 'URGENT'
    CRITICAL = 'CRITICAL'
    FATAL = 'FATAL'


class ConnectionState(Enum):
    """Between vehicle and broker."""

    ONLINE = 'ONLINE'
    OFFLINE = 'OFFLINE'
    CONNECTION_BROKEN = 'CONNECTIONBROKEN'


class EStop(Enum):
    """How an emergency stop is acknowledged."""

    AUTOACK = 'AUTOACK'
    MANUAL = 'MANUAL'
    REMOTE = 'REMOTE'
    NONE = 'NONE'


class OperatingMode(Enum):
    """Who is in control of the vehicle."""

    AUTOMATIC = 'AUTOMATIC'
    SEMIAUTOMATIC = 'SEMIAUTOMATIC'
    MANUAL = 'MANUAL'
    SERVICE = 'SERVICE'
    TEACHIN = 'TEACHIN'


@dataclass(frozen=True)
class Header:
    """Who sent a message, and when; ids count per topic."""

    header_id: int
    timestamp: str
    version: str
    manufacturer: str
    serial_number: str


# --- from the master ------------------------------------------------------------------------------

@dataclass(frozen=True)
class ActionParameter:
    """A parameter of an action; `value` is any JSON value."""

    key: str
    value: Any


@dataclass(frozen=True)
class Action:
    """Something to do, on a node, on an edge or at once."""

    action_type: str
    action_id: str
    blocking_type: BlockingType
    parameters: Tuple[ActionParameter, ...] = ()
    description: Optional[str] = None

    @property
    def arguments(self) -> Mapping[str, Any]:
        """The parameters by key."""
        return {parameter.key: parameter.value for parameter in self.parameters}


@dataclass(frozen=True)
class NodePosition:
    """Where a node is: m and rad on the map `map_id`."""

    x: float
    y: float
    map_id: str
    theta: Optional[float] = None
    allowed_deviation_xy: Optional[float] = None
    allowed_deviation_theta: Optional[float] = None
    map_description: Optional[str] = None


@dataclass(frozen=True)
class Node:
    """A place to drive over."""

    node_id: str
    sequence_id: int
    released: bool
    actions: Tuple[Action, ...] = ()
    position: Optional[NodePosition] = None
    description: Optional[str] = None


@dataclass(frozen=True)
class Corridor:
    """How far (m) the vehicle may leave an edge to either side."""

    left_width: float
    right_width: float
    reference_point: Optional[str] = None


@dataclass(frozen=True)
class Edge:
    """A connection from one node to the next."""

    edge_id: str
    sequence_id: int
    released: bool
    start_node_id: str
    end_node_id: str
    actions: Tuple[Action, ...] = ()
    description: Optional[str] = None
    max_speed: Optional[float] = None
    max_height: Optional[float] = None
    min_height: Optional[float] = None
    orientation: Optional[float] = None
    orientation_type: Optional[str] = None
    direction: Optional[str] = None
    rotation_allowed: Optional[bool] = None
    max_rotation_speed: Optional[float] = None
    length: Optional[float] = None
    trajectory: Optional[Mapping[str, Any]] = None
    corridor: Optional[Corridor] = None


Element = Union[Node, Edge]


@dataclass(frozen=True)
class Order:
    """A new order, or an update of one: nodes and edges by turns."""

    order_id: str
    order_update_id: int
    nodes: Tuple[Node, ...]
    edges: Tuple[Edge, ...] = ()
    zone_set_id: Optional[str] = None


@dataclass(frozen=True)
class InstantActions:
    """Actions to do at once."""

    actions: Tuple[Action, ...]


# --- to the master --------------------------------------------------------------------------------

@dataclass(frozen=True)
class NodeState:
    """A node that is still to be passed."""

    node_id: str
    sequence_id: int
    released: bool
    position: Optional[NodePosition] = None
    description: Optional[str] = None


@dataclass(frozen=True)
class EdgeState:
    """An edge that is still to be driven."""

    edge_id: str
    sequence_id: int
    released: bool
    description: Optional[str] = None


@dataclass(frozen=True)
class ActionState:
    """How far an action is."""

    action_id: str
    action_type: str
    status: ActionStatus
    description: Optional[str] = None
    result_description: Optional[str] = None
    instant: bool = False


@dataclass(frozen=True)
class AgvPosition:
    """Where the vehicle is."""

    x: float
    y: float
    theta: float
    map_id: str
    position_initialized: bool = True
    localization_score: Optional[float] = None


@dataclass(frozen=True)
class Velocity:
    """In the vehicle's frame, m/s and rad/s."""

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
class Reference:
    """What an error is about, e.g. nodeId and its value."""

    key: str
    value: str


@dataclass(frozen=True)
class ErrorKind:
    """A type of error: its name and level in 2.x, and both in 3.0; `hint` says what to do."""

    name: str
    level: ErrorLevel
    hint: str
    name_3: str
    level_3: ErrorLevel

    def error(self, description: str, *references: Reference) -> Error:
        """One of this kind."""
        return Error(self, description, references)


@dataclass(frozen=True)
class Error:
    """Something that is wrong now."""

    kind: ErrorKind
    description: str
    references: Tuple[Reference, ...] = ()

    @property
    def error_type(self) -> str:
        """Its name in 2.x."""
        return self.kind.name

    @property
    def level(self) -> ErrorLevel:
        """Its level in 2.x."""
        return self.kind.level

    @property
    def error_type_3(self) -> str:
        """Its name in 3.0."""
        return self.kind.name_3

    @property
    def level_3(self) -> ErrorLevel:
        """Its level in 3.0."""
        return self.kind.level_3

    @property
    def hint(self) -> str:
        """What to do about it."""
        return self.kind.hint


@dataclass(frozen=True)
class Information:
    """For people who watch; never for a master's logic."""

    info_type: str
    level: str
    description: Optional[str] = None
    references: Tuple[Reference, ...] = ()


@dataclass(frozen=True)
class SafetyState:
    """Emergency stop and protective field."""

    e_stop: EStop
    field_violation: bool


@dataclass(frozen=True)
class MapInformation:
    """A map that the vehicle has."""

    map_id: str
    map_version: str
    status: str = 'ENABLED'
    description: Optional[str] = None


@dataclass(frozen=True)
class State:
    """All that the master is told of the vehicle."""

    order_id: str
    order_update_id: int
    last_node_id: str
    last_node_sequence_id: int
    node_states: Tuple[NodeState, ...]
    edge_states: Tuple[EdgeState, ...]
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
    information: Tuple[Information, ...] = ()
    maps: Tuple[MapInformation, ...] = ()
    zone_set_id: Optional[str] = None

    @property
    def order_action_states(self) -> Tuple[ActionState, ...]:
        """Those of the order, which 3.0 tells apart."""
        return tuple(state for state in self.action_states if not state.instant)

    @property
    def instant_action_states(self) -> Tuple[ActionState, ...]:
        """Those of instant actions, which 3.0 tells apart."""
        return tuple(state for state in self.action_states if state.instant)


@dataclass(frozen=True)
class Visualization:
    """Where the vehicle is, for people who watch."""

    position: Optional[AgvPosition] = None
    velocity: Optional[Velocity] = None
    state_header_id: int = 0  # of the last state; 3.0


@dataclass(frozen=True)
class Connection:
    """Whether the vehicle is connected to the broker."""

    state: ConnectionState
