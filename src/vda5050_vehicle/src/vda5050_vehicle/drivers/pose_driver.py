"""Drives an order as poses, one after another: for robots with move_base and without a graph.

The robot plans its own way between nodes. A node that is not the last one, and has no heading, is
passed within its deviation; the next pose is sent then, so that the robot need not stop.
"""
from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Dict, Optional, Sequence, Tuple, Union

from vda5050_vehicle.drivers.driver import Driver, Leg, NotDrivable, Pose, Progress
from vda5050_vehicle.drivers.order_fields import Abilities, check_headings, heading_of, is_within
from vda5050_vehicle.drivers.order_graph import Matching
from vda5050_vehicle.protocol import problems as e
from vda5050_vehicle.protocol.values import Edge, Node

PASSING = 0.5  # m: a node without a deviation of its own counts as passed within this


@dataclass(frozen=True)
class GoTo:
    """To be sent as a goal; `number` is its name when it ends."""

    number: int
    x: float
    y: float
    theta: float


@dataclass(frozen=True)
class CancelGoals:
    """Cancel every goal that is under way."""


PoseCommand = Union[GoTo, CancelGoals]


class PoseDriver(Driver):
    """See the module's text."""

    def __init__(self, abilities: Abilities, matching: Matching) -> None:
        super().__init__()
        self._abilities = abilities
        self._matching = matching
        self._legs: Dict[int, Leg] = {}
        self._goal = 0  # number of the goal that is under way; negative: being cancelled; 0: none
        self._numbers = 0
        self._pose: Optional[Pose] = None

    # --- planning ---------------------------------------------------------------------------------

    def plan(self, nodes: Sequence[Node], edges: Sequence[Edge], pose: Optional[Pose],
             ) -> Tuple[Leg, ...]:
        """See Driver."""
        check_headings(nodes, self._abilities, lambda index, node: True)
        places = [self._place(node) for node in nodes]
        return tuple(
            Leg(0, max(math.dist(start, end), 1e-3), *end, heading_of(node, self._abilities),
                _passing(node))
            for start, end, node in zip(places, places[1:], nodes[1:]))

    def is_at(self, node: Node, pose: Pose) -> bool:
        """See Driver."""
        return is_within(node, self._place(node), pose, self._matching.near)

    def node_at(self, pose: Pose) -> str:
        """See Driver: without a graph no node is known."""
        return ''

    def knows(self, node_id: str, pose: Pose) -> bool:
        """See Driver: without a graph every name is the master's own."""
        return True

    def _place(self, node: Node) -> Tuple[float, float]:
        if node.position is None:
            raise NotDrivable(e.NO_ROUTE, f'node {node.node_id!r} has no position, and the '
                              'vehicle has no graph to look it up in', 'nodePosition')
        return node.position.x, node.position.y

    # --- driving ----------------------------------------------------------------------------------

    def begin(self) -> None:
        """See Driver."""
        self._legs = {}
        self.progress = Progress(halted=self.progress.halted)

    def drive(self, first: int, legs: Sequence[Leg], now: float) -> None:
        """See Driver."""
        if self.progress.failure or not legs or self._goal < 0:
            return
        self._legs.update(enumerate(legs, first))
        if self._goal == 0:
            self._go_to(self.progress.passed)
        else:
            self._look()

    def _go_to(self, number: int) -> None:
        leg = self._legs[number]
        self._numbers += 1
        self._goal = self._numbers
        self.progress = replace(self.progress, along=0.0, halted=False, complete=False)
        self._commands.append(GoTo(self._goal, leg.x, leg.y, self._heading(leg)))

    def _heading(self, leg: Leg) -> float:
        if leg.heading is not None or self._pose is None:
            return leg.heading or 0.0
        return math.atan2(leg.y - self._pose.y, leg.x - self._pose.x)

    def halt(self, now: float) -> None:
        """See Driver."""
        if self._goal > 0:
            self._commands.append(CancelGoals())
            self._goal = -self._goal  # its end is awaited

    def forgive(self) -> None:
        """See Driver."""
        self.progress = replace(self.progress, failure='')

    def see(self, pose: Optional[Pose]) -> None:
        """Where the robot is; None where that is not known."""
        self._pose = pose
        self._look()

    def _look(self) -> None:
        """Passes nodes on the way."""
        pose, leg = self._pose, self._legs.get(self.progress.passed)
        if pose is None or leg is None or self._goal <= 0:
            return
        away = math.dist((pose.x, pose.y), (leg.x, leg.y))
        along = max(self.progress.along, min(leg.length, leg.length - away))
        self.progress = replace(self.progress, along=along)
        following = self.progress.passed + 1
        if following in self._legs and leg.heading is None and away <= leg.within:
            self._pass()
            self._go_to(following)

    def _pass(self) -> None:
        self._legs.pop(self.progress.passed, None)
        self.progress = replace(self.progress, passed=self.progress.passed + 1, along=0.0)

    def on_goal_ended(self, number: int, succeeded: bool, text: str) -> None:
        """A goal has ended; of one that a later goal replaced nothing is to be learned."""
        if number != abs(self._goal):
            return
        halting = self._goal < 0
        self._goal = 0
        if succeeded:
            self._pass()
            following = self.progress.passed
            if following in self._legs and not halting:
                self._go_to(following)
            else:
                self.progress = replace(self.progress, halted=True, complete=True)
        else:
            self.progress = replace(self.progress, halted=True,
                                    failure='' if halting else text or 'the goal was not reached')

    def tick(self, now: float) -> None:
        """See Driver: move_base has patience of its own."""

    # --- restarts ---------------------------------------------------------------------------------

    @property
    def record(self) -> Dict[str, Any]:
        """See Driver."""
        return {'passed': self.progress.passed, 'failure': self.progress.failure,
                'goal': self._goal != 0}

    def restore(self, record: Dict[str, Any], now: float) -> None:
        """See Driver. A goal that nobody follows any more is cancelled."""
        failure = str(record['failure'])
        if record['goal']:
            self._commands.append(CancelGoals())
            failure = failure or 'the adapter was restarted under way'
        self.progress = Progress(int(record['passed']), failure=failure)

    def know_legs(self, first: int, legs: Sequence[Leg]) -> None:
        """See Driver: they are told again before anything is driven."""


def _passing(node: Node) -> float:
    """Within how many metres a node counts as passed; a deviation of 0 is none."""
    deviation = node.position.allowed_deviation_xy if node.position else None
    return deviation.radius if deviation and deviation.radius > 0.0 else PASSING
