"""The interface between vehicle and driver, and their common values. Metres, radians, seconds."""
from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Generic, List, Optional, Protocol, Sequence, Tuple, TypeVar

from vda5050_protocol.values import ErrorKind, OrderEdge, OrderNode
from vda5050_vehicle.drivers.robot_view import RobotPose, RobotSnapshot

SETTLING = 1.0  # s; for this time after a command, reports may still show the earlier motion


class NotDrivable(Exception):
    """An order that this driver cannot drive: the kind of error, the reason and the field."""

    def __init__(self, kind: ErrorKind, description: str, field: str) -> None:
        super().__init__(description)
        self.kind = kind
        self.field = field


@dataclass(frozen=True)
class Leg:
    """One edge of an order as the robot drives it.

    edge    -- signed id in the graph; 0: there is no graph, or the leg has no length
    length  -- 0: start and end are at the same place, so nothing is driven
    x, y    -- the end of the leg
    heading -- the heading at the end; None: any heading
    within  -- distance from the end at which the end counts as reached
    """

    edge: int
    length: float
    x: float
    y: float
    heading: Optional[float] = None
    within: float = 0.0

    @property
    def stands(self) -> bool:
        """Whether both nodes of the leg are at the same place. Drivers never get such a leg."""
        return self.length == 0.0


@dataclass(frozen=True)
class DriveProgress:
    """The memory of a driver: the robot's progress along the legs that it was sent.

    passed     -- number of legs of the order that the robot has driven
    along      -- distance that the robot has driven on the next leg, m
    failure    -- the reason why the robot does not drive on; '' if there is none
    rest_since -- time, s; reports from before this time do not show whether the robot stands
    epoch      -- a number that changes when another program or person drives or stops the robot;
                  0: unknown
    stands     -- whether the robot's newest report says that it stands
    """

    passed: int = 0
    along: float = 0.0
    failure: str = ''
    rest_since: float = -math.inf
    epoch: int = 0
    stands: bool = False

    @property
    def at_rest(self) -> bool:
        """Whether the robot does not drive for this driver.

        The robot was sent nothing, has driven the route, has obeyed the stop, or has failed.
        """
        raise NotImplementedError

    @property
    def in_order(self) -> bool:
        """Whether the robot is at rest because it has driven everything that it was sent."""
        raise NotImplementedError


class DriverMemory(Protocol):
    """The part of the vehicle's state that a driver uses."""

    drive: Any

    def leg(self, number: int) -> Optional[Leg]:
        """Returns a leg by its number; None if it has been driven, or if it has no length."""


D = TypeVar('D', bound=DriveProgress)


class Driver(ABC, Generic[D]):
    """Drives legs; their numbers begin with 0 at each `begin`. A driver repeats no motion by
    itself.

    longest -- the largest number of legs that can be driven after a `begin`; None: any number

    A driver keeps all its knowledge in the vehicle's state. The caller collects the commands with
    `pop_commands` and sends them in the given sequence.

    The interface has a method for each event that any kind of driver needs.
    """

    longest: ClassVar[Optional[int]] = None

    def __init__(self, memory: DriverMemory, drive: D) -> None:
        memory.drive = drive
        self._memory = memory
        self._commands: List[Any] = []

    @property
    def drive_state(self) -> D:
        """The progress of the robot."""
        drive: D = self._memory.drive
        return drive

    def _set(self, **changes: Any) -> None:
        self._memory.drive = replace(self._memory.drive, **changes)

    def pop_commands(self) -> Tuple[Any, ...]:
        """Returns the commands that must be sent to the robot now, and forgets them."""
        commands = tuple(self._commands)
        self._commands.clear()
        return commands

    @abstractmethod
    def plan(self, nodes: Sequence[OrderNode], edges: Sequence[OrderEdge],
             pose: Optional[RobotPose]) -> Tuple[Leg, ...]:
        """Returns one leg per edge; raises NotDrivable.

        pose -- the robot's pose at the start of the legs; None: the legs continue earlier ones
        """

    @abstractmethod
    def is_at(self, node: OrderNode, pose: RobotPose) -> bool:
        """Returns whether the robot at `pose` may begin an order at this node.

        Raises NotDrivable.
        """

    @abstractmethod
    def node_at(self, pose: RobotPose) -> str:
        """Returns the id of the node at which the robot stands; '' if there is no known node."""

    @abstractmethod
    def knows(self, node_id: str, pose: RobotPose) -> bool:
        """Returns whether a node has this name, or a node at `pose` may get this name."""

    @abstractmethod
    def begin(self) -> None:
        """Begins a new order, or the rest of an order; the next leg gets the number 0."""

    @abstractmethod
    def drive(self, first: int, legs: Sequence[Leg], now: float) -> None:
        """Drives these legs, or extends the drive to them; `first` is the first leg's number."""

    @abstractmethod
    def halt(self, now: float) -> None:
        """Stops the robot if it drives for this driver and no stop was sent yet."""

    @abstractmethod
    def stop(self, now: float) -> None:
        """Stops the robot, even if it is not known to drive."""

    def forgive(self) -> None:
        """Clears a failure; after that, `drive` works again."""
        self._set(failure='')

    @abstractmethod
    def robot_seen(self, robot: RobotSnapshot, now: float) -> None:
        """Evaluates the present view of the robot."""

    @abstractmethod
    def tick(self, now: float) -> None:
        """Checks time limits; the caller calls it several times a second."""

    @abstractmethod
    def restart(self, now: float) -> None:
        """Continues after a restart with the stored state."""
