"""What the parts of a vehicle share: its state, its robot and driver, and what is to be done."""
from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from typing import Any, Deque, List

from vda5050_vehicle.core import effects as fx
from vda5050_vehicle.core.action_table import ActionTable
from vda5050_vehicle.core.identity import Identity
from vda5050_vehicle.core.state import VehicleState
from vda5050_vehicle.drivers.driver import Driver, NotDrivable
from vda5050_vehicle.drivers.robot_view import RobotView
from vda5050_vehicle.protocol import values as v
from vda5050_vehicle.protocol.action_queue import Entry
from vda5050_vehicle.protocol.codecs import Codec
from vda5050_vehicle.protocol.order_state import OrderState
from vda5050_vehicle.protocol.reporting import Reporter

HISTORY = 500        # events that a log report holds


@dataclass
class Context:
    """See the module's text. Only `state` is to be remembered."""

    identity: Identity
    codec: Codec
    table: ActionTable
    driver: Driver[Any]
    state: VehicleState
    robot: RobotView = RobotView()
    reporter: Reporter = field(default_factory=Reporter)
    history: Deque[str] = field(default_factory=lambda: deque(maxlen=HISTORY))
    effects: List[fx.Effect] = field(default_factory=list)

    def do(self, effect: fx.Effect) -> None:
        """Adds to what is to be done."""
        self.effects.append(effect)

    def note(self, text: str) -> None:
        """Adds to what a log report tells."""
        self.history.append(text)

    def update_action(self, action_id: str, status: v.ActionStatus, text: str = '') -> None:
        """An action is farther."""
        self.state.actions = self.state.actions.updated(action_id, status, text)

    def is_cancellable(self, entry: Entry) -> bool:
        """Whether cancelOrder ends this action."""
        return self.table.specs[entry.action.action_type].cancellable

    # --- motion -----------------------------------------------------------------------------------

    @property
    def standing(self) -> bool:
        """Whether the vehicle stands as far as actions are concerned: it is seen not to drive, or
        has driven what it was sent to."""
        drive, robot = self.state.drive, self.robot
        if not drive.at_rest:
            return False
        return robot.stands or (drive.in_order and not robot.moves and robot.standing is None)

    @property
    def is_known_to_stand(self) -> bool:
        """Whether the robot has told that it stands, since it was to."""
        drive, robot = self.state.drive, self.robot
        return drive.at_rest and robot.stands and robot.seen_at >= drive.rest_since

    def stop(self, now: float) -> None:
        """The master stops the robot: in each state of its route, unless it is known to stand, or
        an action has it."""
        drive = self.state.drive
        if not (drive.in_order and (self.is_known_to_stand
                                    or self.state.actions.hold_the_robot)):
            self.driver.stop(now)

    def forgive(self) -> None:
        """A failure was seen to: by stopPause, by another order, or because its order has ended."""
        self.state.errors = self.state.errors.without_failures()
        self.driver.forgive()

    # --- where it is ------------------------------------------------------------------------------

    def place_at(self, node_id: str) -> None:
        """The robot is at this node, though no order brought it there."""
        order = self.state.order
        if order.is_driven and node_id and node_id != order.last_node[0]:
            node = v.Node(node_id, 0, True)
            self.state.order = OrderState(order.order_id, order.order_update_id, (node,),
                                          cancelled=order.cancelled)
            self.driver.begin()
            self.state.legs = ()

    def look_where_it_is(self) -> None:
        """The robot moved without an order: it may be at another node than the last one."""
        pose, nodes = self.robot.pose, self.state.order.nodes
        if pose is None or not nodes:
            return
        try:
            if not self.driver.is_at(nodes[0], pose):
                self.place_at(self.driver.node_at(pose))
        except NotDrivable:
            self.place_at(self.driver.node_at(pose))
