"""The actions that the supervisor requests. The caller carries them out in the given order."""
from __future__ import annotations

from dataclasses import dataclass
from typing import FrozenSet, Tuple, Union

from fleet_core.fleet import RobotType
from fleet_core.geometry.site_geometry import Alone
from fleet_core.planning.plan_requests import Times
from fleet_core.planning.tasks import Obstacle, Task
from fleet_core.supervision.missions import Status
from route_protocol.devices import DeviceRequest
from route_protocol.master import Order
from route_protocol.steps import StepCommand


@dataclass(frozen=True)
class SendRoute:
    """Publish an order. A repeated order is published with its former stamp.

    An order with the number 0 is a stop that bypasses the supervisor.

    speed -- m/s that the robot does not exceed because of its load; 0: no such limit
    """

    robot: str
    order: Order
    repeated: bool = False
    speed: float = 0.0

    @property
    def edges(self) -> Tuple[int, ...]:
        """Signed ids of the edges to drive; empty: stop."""
        return self.order.edges


@dataclass(frozen=True)
class SendStep:
    """Publish a command for a step of a robot.

    device -- the device that carries the step out; empty: the robot itself
    """

    robot: str
    command: StepCommand
    device: str = ''


@dataclass(frozen=True)
class AskDevice:
    """Publish a request to the device of a resource."""

    request: DeviceRequest


@dataclass(frozen=True)
class PublishStatus:
    """Publish the status of a request."""

    status: Status


@dataclass(frozen=True)
class AskPlanner:
    """Ask the planner for a plan. The planner's answer has the same number.

    edge_times -- learned driving times, in place of length / speed
    alone      -- groups of places; a resource allows only one robot at a time in a group
    reserved   -- places of stations and queues; robots are parked elsewhere if possible
    seed       -- for the planner's random choices; it changes if a plan did not serve all robots
    laden      -- types of robots with loads, in addition to the types of the fleet
    """

    number: int
    tasks: Tuple[Task, ...]
    obstacles: Tuple[Obstacle, ...]
    closed: FrozenSet[int]
    edge_times: Times
    alone: Tuple[Alone, ...] = ()
    reserved: FrozenSet[int] = frozenset()
    seed: int = 0
    laden: Tuple[RobotType, ...] = ()


@dataclass(frozen=True)
class Note:
    """Log a text for the operators."""

    text: str
    is_warning: bool = False


Action = Union[SendRoute, SendStep, AskDevice, PublishStatus, AskPlanner, Note]
"""Any action that the supervisor may request."""
