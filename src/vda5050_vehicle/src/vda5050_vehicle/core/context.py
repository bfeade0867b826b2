"""The context that the parts of a vehicle share: its state, robot, driver and pending effects."""
from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from typing import Any, Deque, List

from vda5050_protocol import values as v
from vda5050_protocol.action_queue import QueuedAction
from vda5050_protocol.codecs import Codec
from vda5050_protocol.order_state import OrderState
from vda5050_protocol.reporting import Reporter
from vda5050_vehicle.core import effects as fx
from vda5050_vehicle.core.action_table import ActionTable
from vda5050_vehicle.core.identity import Identity
from vda5050_vehicle.core.state import VdaVehicleState
from vda5050_vehicle.drivers.driver import Driver, NotDrivable
from vda5050_vehicle.drivers.robot_view import RobotSnapshot

HISTORY = 500        # number of events in a log report


@dataclass
class Context:
    """See the module's docstring. Only `state` is stored for a restart."""

    identity: Identity
    codec: Codec
    table: ActionTable
    driver: Driver[Any]
    state: VdaVehicleState
    robot: RobotSnapshot = RobotSnapshot()
    reporter: Reporter = field(default_factory=Reporter)
    history: Deque[str] = field(default_factory=lambda: deque(maxlen=HISTORY))
    effects: List[fx.Effect] = field(default_factory=list)

    def do(self, effect: fx.Effect) -> None:
        """Adds an effect that the caller must carry out."""
        self.effects.append(effect)

    def note(self, text: str) -> None:
        """Adds an event to the log report."""
        self.history.append(text)

    def update_action(self, action_id: str, status: v.ActionStatus, text: str = '') -> None:
        """Sets a new status of an action."""
        self.state.actions = self.state.actions.updated(action_id, status, text)

    def is_cancellable(self, entry: QueuedAction) -> bool:
        """Returns whether cancelOrder ends this action."""
        return self.table.specs[entry.action.action_type].cancellable

    # --- motion -----------------------------------------------------------------------------------

    @property
    def standing(self) -> bool:
        """Whether actions that require a standing vehicle may start.

        They may start if reports show that the robot stands. They may also start if the robot has
        driven everything that it was sent, and no report contradicts this.
        """
        drive, robot = self.state.drive, self.robot
        if not drive.at_rest:
            return False
        return robot.stands or self._is_told_to_stand or (
            drive.in_order and not robot.moves and robot.standing is None)

    @property
    def is_known_to_stand(self) -> bool:
        """Whether the robot has reported that it stands, after its drive ended."""
        drive, robot = self.state.drive, self.robot
        return drive.at_rest and (self._is_told_to_stand or (
            robot.stands and robot.seen_at >= drive.rest_since))

    @property
    def _is_told_to_stand(self) -> bool:
        """Whether the robot's newest report says that it stands, and nothing contradicts this."""
        robot = self.robot
        return self.state.drive.stands and not robot.moves and robot.standing is not False

    def stop(self, now: float) -> None:
        """Stops the robot because the master requires it.

        The robot is stopped in each state of its route, except in these cases:
        - the robot has completed its route and is known to stand
        - the robot has completed its route and an action controls it
        """
        drive = self.state.drive
        if not (drive.in_order and (self.is_known_to_stand
                                    or self.state.actions.hold_the_robot)):
            self.driver.stop(now)

    def forgive(self) -> None:
        """Clears a failure, after stopPause, a new order or the end of the order."""
        self.state.errors = self.state.errors.without_failures()
        self.driver.forgive()

    # --- the robot's node -------------------------------------------------------------------------

    def place_at(self, node_id: str) -> None:
        """Notes that the robot reached a node without an order."""
        order = self.state.order
        if order.is_driven and node_id and node_id != order.last_node[0]:
            node = v.OrderNode(node_id, 0, True)
            self.state.order = OrderState(order.order_id, order.order_update_id, (node,),
                                          cancelled=order.cancelled)
            self.driver.begin()
            self.state.legs = ()

    def update_last_node(self) -> None:
        """Updates the last node after the robot may have moved without an order."""
        pose, nodes = self.robot.pose, self.state.order.nodes
        if pose is None or not nodes:
            return
        try:
            if not self.driver.is_at(nodes[0], pose):
                self.place_at(self.driver.node_at(pose))
        except NotDrivable:
            self.place_at(self.driver.node_at(pose))
