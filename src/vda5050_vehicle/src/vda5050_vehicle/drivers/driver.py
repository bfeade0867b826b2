"""What the vehicle needs of a driver, and the values that both use. Metres, radians, seconds."""
from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import Any, Generic, List, Optional, Protocol, Sequence, Tuple, TypeVar

from vda5050_vehicle.drivers.robot_view import Pose, RobotView
from vda5050_vehicle.protocol.values import Edge, ErrorKind, Node

SETTLING = 1.0  # s that what a robot tells of its motion may be older than what it was told


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
class Drive:
    """How far the robot is with what it was sent to drive: what a driver remembers.

    passed     -- how many legs of the order were driven
    along      -- m driven of the leg after these
    failure    -- why it does not drive on; empty: it does, or has nothing to drive
    rest_since -- s; what the robot told before says nothing about whether it stands
    """

    passed: int = 0
    along: float = 0.0
    failure: str = ''
    rest_since: float = -math.inf

    @property
    def at_rest(self) -> bool:
        """Whether the robot drives nothing for us: it was not sent, has obeyed, or does not."""
        raise NotImplementedError

    @property
    def in_order(self) -> bool:
        """Whether it is at rest as it was to be: what it was sent to drive was driven."""
        raise NotImplementedError


class Memory(Protocol):
    """The vehicle's state, as far as it is a driver's affair."""

    drive: Any

    def leg(self, number: int) -> Optional[Leg]:
        """The leg of the order with this number, counted from its beginning; None: driven."""


D = TypeVar('D', bound=Drive)


class Driver(ABC, Generic[D]):
    """Drives legs, numbered from the beginning of the order; a motion is never repeated by itself.

    What it knows is in the vehicle's state. `commands` are collected by the driver's caller, in
    their order.
    """

    def __init__(self, memory: Memory, drive: D) -> None:
        memory.drive = drive
        self._memory = memory
        self._commands: List[Any] = []

    @property
    def drive_state(self) -> D:
        """How far the robot is."""
        drive: D = self._memory.drive
        return drive

    def _set(self, **changes: Any) -> None:
        self._memory.drive = replace(self._memory.drive, **changes)

    def take_commands(self) -> Tuple[Any, ...]:
        """What is to be sent to the robot now."""
        commands = tuple(self._commands)
        self._commands.clear()
        return commands

    @abstractmethod
    def plan(self, nodes: Sequence[Node], edges: Sequence[Edge], pose: Optional[Pose],
             ) -> Tuple[Leg, ...]:
        """One leg per edge. `pose` is where the robot begins them; None: they go on with others.
        Raises NotDrivable."""

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
        """Stops what the robot drives for us, unless it was told to."""

    @abstractmethod
    def stop(self, now: float) -> None:
        """Stops the robot, also when it is not known to drive."""

    def forgive(self) -> None:
        """A failure was seen to: `drive` may be asked for again."""
        self._set(failure='')

    @abstractmethod
    def see(self, robot: RobotView, now: float) -> None:
        """The robot is seen."""

    @abstractmethod
    def tick(self, now: float) -> None:
        """Looks at what takes too long; several times a second."""

    @abstractmethod
    def restart(self, now: float) -> None:
        """Goes on after a restart, with the state of before it."""
