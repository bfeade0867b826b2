"""What the vehicle needs of a driver, and the values that both use. Metres, radians, seconds."""
from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, Dict, List, Optional, Sequence, Tuple

from vda5050_vehicle.protocol.values import Edge, ErrorKind, Node


@dataclass(frozen=True)
class Pose:
    """Where the robot is on the map."""

    x: float
    y: float
    theta: float


class NotDrivable(Exception):
    """An order that this driver cannot drive: a kind of error, why, and the field that says so."""

    def __init__(self, kind: ErrorKind, description: str, field: str) -> None:
        super().__init__(description)
        self.kind = kind
        self.field = field


@dataclass(frozen=True)
class Leg:
    """One edge of an order as the robot drives it.

    edge    -- signed id in the graph; 0 where there is no graph
    x, y    -- where it ends
    heading -- to take there; None: any
    within  -- the end is reached at this distance
    """

    edge: int
    length: float
    x: float
    y: float
    heading: Optional[float] = None
    within: float = 0.0


@dataclass(frozen=True)
class Progress:
    """How far the robot is.

    passed   -- how many legs of the order were driven
    along    -- m driven of the leg after these
    halted   -- it was not sent anywhere, or has stopped as it was told to
    complete -- it has driven all that it was sent to drive
    failure  -- why it does not drive on; empty: it does, or has nothing to drive
    """

    passed: int = 0
    along: float = 0.0
    halted: bool = True
    complete: bool = True
    failure: str = ''


class Driver(ABC):
    """Drives legs, numbered from the beginning of the order; a motion is never repeated by itself.

    `commands` are collected by whoever runs the driver, in their order.
    """

    def __init__(self) -> None:
        self.progress = Progress()
        self._commands: List[Any] = []

    def take_commands(self) -> Tuple[Any, ...]:
        """What is to be sent to the robot now."""
        commands = tuple(self._commands)
        self._commands.clear()
        return commands

    @abstractmethod
    def plan(self, nodes: Sequence[Node], edges: Sequence[Edge], pose: Optional[Pose],
             ) -> Tuple[Leg, ...]:
        """One leg per edge; `pose` is where the robot is. Raises NotDrivable."""

    @abstractmethod
    def is_at(self, node: Node, pose: Pose) -> bool:
        """Whether the robot at `pose` may begin an order at this node. Raises NotDrivable."""

    @abstractmethod
    def node_at(self, pose: Pose) -> str:
        """Id of the node on which the robot stands; empty: none that is known."""

    @abstractmethod
    def knows(self, node_id: str, pose: Pose) -> bool:
        """Whether there is a node of this name, or one at `pose` that a master may call so."""

    @abstractmethod
    def begin(self) -> None:
        """A new order: its legs are numbered from 0."""

    @abstractmethod
    def drive(self, first: int, legs: Sequence[Leg], now: float) -> None:
        """Drive these legs, the first of which is number `first`; what is driven is extended."""

    @abstractmethod
    def halt(self, now: float) -> None:
        """Stop, wherever the robot is."""

    @abstractmethod
    def forgive(self) -> None:
        """A failure was seen to: `drive` may be asked for again."""

    @abstractmethod
    def tick(self, now: float) -> None:
        """Looks at what takes too long; several times a second."""

    @abstractmethod
    def know_legs(self, first: int, legs: Sequence[Leg]) -> None:
        """After `restore`: what the legs of the order are, from number `first` on."""

    @property
    @abstractmethod
    def record(self) -> Dict[str, Any]:
        """What a restarted driver must know, as JSON."""

    @abstractmethod
    def restore(self, record: Dict[str, Any], now: float) -> None:
        """Goes on after a restart; raises KeyError, TypeError or ValueError on a wrong record."""
