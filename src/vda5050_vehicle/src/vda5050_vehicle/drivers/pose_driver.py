"""Drives an order as a series of poses, for robots with move_base and without a graph.

The robot plans its own path between nodes. If a node has no heading and is not the last node, it
counts as passed when the robot is within its deviation. The driver then sends the next pose, so
that the robot does not stop. If something else has stopped or moved the robot after it obeyed the
driver (`RobotSnapshot.halted`), the driver sends no next pose, because the robot may still brake
when the pose arrives.
"""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Optional, Sequence, Tuple, Union

from vda5050_protocol import problems as e
from vda5050_protocol.values import OrderEdge, OrderNode
from vda5050_vehicle.drivers.driver import (
    SETTLING,
    DriveProgress,
    Driver,
    DriverMemory,
    Leg,
    NotDrivable,
)
from vda5050_vehicle.drivers.order_fields import Abilities, check_headings, heading_of, is_within
from vda5050_vehicle.drivers.order_graph import Matching
from vda5050_vehicle.drivers.robot_view import RobotPose, RobotSnapshot

SAME_PLACE = 0.01  # m; within this distance a robot need not move from one node to the next
PASSING = 0.5  # m; a node without a deviation counts as passed within this distance


@dataclass(frozen=True)
class GoTo:
    """A pose to send as a goal (m, rad); `number` identifies the goal when it ends."""

    number: int
    x: float
    y: float
    theta: float


@dataclass(frozen=True)
class CancelGoals:
    """Cancel all active goals."""


PoseCommand = Union[GoTo, CancelGoals]


@dataclass(frozen=True)
class PoseDrive(DriveProgress):
    """The memory of the pose driver.

    goal    -- number of the active goal; negative while it is being cancelled; 0: no goal
    numbers -- number of goals so far
    until   -- number of the first leg that the driver may not drive yet
    """

    goal: int = 0
    numbers: int = 0
    until: int = 0

    @property
    def at_rest(self) -> bool:
        """See DriveProgress."""
        return self.goal == 0

    @property
    def in_order(self) -> bool:
        """See DriveProgress."""
        return self.goal == 0 and not self.failure


class PoseDriver(Driver[PoseDrive]):
    """See the module's docstring."""

    def __init__(self, memory: DriverMemory, abilities: Abilities, matching: Matching) -> None:
        super().__init__(memory, PoseDrive())
        self._abilities = abilities
        self._matching = matching
        self._pose: Optional[RobotPose] = None
        # whether the robot has obeyed the last goal, and was halted after that
        self._is_obeyed = self._is_halted = False

    # --- planning ---------------------------------------------------------------------------------

    def plan(self, nodes: Sequence[OrderNode], edges: Sequence[OrderEdge],
             pose: Optional[RobotPose]) -> Tuple[Leg, ...]:
        """See Driver."""
        check_headings(nodes, self._abilities, lambda index, node: True)
        places = [self._place(node) for node in nodes]
        return tuple(self._leg(start, end, node)
                     for start, end, node in zip(places, places[1:], nodes[1:]))

    def _leg(self, start: Tuple[float, float], end: Tuple[float, float], node: OrderNode) -> Leg:
        heading, length = heading_of(node, self._abilities), math.dist(start, end)
        if length <= SAME_PLACE and heading is None:
            return Leg(0, 0.0, *end)
        return Leg(0, max(length, 1e-3), *end, heading, _passing(node))

    def is_at(self, node: OrderNode, pose: RobotPose) -> bool:
        """See Driver."""
        return is_within(node, self._place(node), pose, self._matching.near)

    def node_at(self, pose: RobotPose) -> str:
        """See Driver; '' because without a graph no node is known."""
        return ''

    def knows(self, node_id: str, pose: RobotPose) -> bool:
        """See Driver; True because without a graph the master may use any name."""
        return True

    def _place(self, node: OrderNode) -> Tuple[float, float]:
        if node.position is None:
            raise NotDrivable(e.NO_ROUTE, f'node {node.node_id!r} has no position, and the '
                              'vehicle has no graph in which to find it', 'nodePosition')
        return node.position.x, node.position.y

    # --- driving ----------------------------------------------------------------------------------

    def begin(self) -> None:
        """See Driver."""
        self._set(passed=0, along=0.0, failure='', until=0)

    def drive(self, first: int, legs: Sequence[Leg], now: float) -> None:
        """See Driver."""
        drive = self.drive_state
        if drive.failure or not legs or drive.goal < 0:
            return
        if drive.until != first + len(legs):
            self._set(until=first + len(legs))
        if drive.goal == 0:
            self._go_to(drive.passed)
        else:
            self._update_progress()

    def _go_to(self, number: int) -> None:
        leg, goal = self._memory.leg(number), self.drive_state.numbers + 1
        if leg is not None:
            self._set(goal=goal, numbers=goal, along=0.0)
            self._is_obeyed = self._is_halted = False
            self._commands.append(GoTo(goal, leg.x, leg.y, self._heading(leg)))

    def _heading(self, leg: Leg) -> float:
        if leg.heading is not None or self._pose is None:
            return leg.heading or 0.0
        return math.atan2(leg.y - self._pose.y, leg.x - self._pose.x)

    def stop(self, now: float) -> None:
        """See Driver; the driver is at rest only after its own goal has ended."""
        self._commands.append(CancelGoals())
        self._set(goal=-abs(self.drive_state.goal), rest_since=now + SETTLING)

    def halt(self, now: float) -> None:
        """See Driver."""
        if self.drive_state.goal > 0:
            self.stop(now)

    def robot_seen(self, robot: RobotSnapshot, now: float) -> None:
        """See Driver."""
        self._pose = robot.pose
        self._is_obeyed = self._is_obeyed or not robot.halted
        self._is_halted = self._is_obeyed and robot.halted
        if robot.epoch not in (0, self.drive_state.epoch):
            self._set(epoch=robot.epoch)
        self._update_progress()

    def _update_progress(self) -> None:
        """Updates the progress; passes a node and sends the next goal."""
        pose, drive = self._pose, self.drive_state
        leg = self._memory.leg(drive.passed)
        if pose is None or leg is None or drive.goal <= 0:
            return
        away = math.dist((pose.x, pose.y), (leg.x, leg.y))
        along = max(drive.along, min(leg.length, leg.length - away))
        if along != drive.along:
            self._set(along=along)
        following = drive.passed + 1
        if (following < drive.until and leg.heading is None and away <= leg.within
                and not self._is_halted):
            self._set(passed=following)
            self._go_to(following)

    def on_goal_ended(self, number: int, succeeded: bool, text: str, now: float) -> None:
        """Notes that a goal has ended; the end of a goal that a later goal replaced is ignored."""
        drive = self.drive_state
        if number != abs(drive.goal):
            return
        self._set(goal=0, rest_since=now)
        if succeeded:
            following = drive.passed + 1
            self._set(passed=following, along=0.0)
            if following < drive.until and drive.goal > 0:
                if self._is_halted:
                    self._set(failure='another program or person has driven or stopped the robot')
                else:
                    self._go_to(following)
        elif drive.goal > 0:
            self._set(failure=text or 'the goal was not reached')

    def tick(self, now: float) -> None:
        """See Driver; does nothing because move_base has its own time limits."""

    def restart(self, now: float) -> None:
        """See Driver; cancels the goal from before the restart."""
        drive = self.drive_state
        if drive.goal > 0 and not drive.failure:
            self._set(failure='the adapter was restarted during the drive')
        if drive.goal != 0:
            self.stop(now)
        self._set(goal=0)


def _passing(node: OrderNode) -> float:
    """Returns the distance (m) within which a node counts as passed.

    A deviation of 0 means that the node sets none.
    """
    deviation = node.position.allowed_deviation_xy if node.position else None
    return deviation.radius if deviation and deviation.radius > 0.0 else PASSING
