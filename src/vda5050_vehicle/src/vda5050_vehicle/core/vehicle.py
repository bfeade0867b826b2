"""The vehicle: takes orders and instant actions, drives, acts, and tells its state.

One object that one thread uses. It is told what happens and the time (s, of a clock that never goes
back), and answers with effects. Order of business after every event: what was passed, what failed,
which actions may start, where to drive, what to remember, what to tell.
"""
from __future__ import annotations

from dataclasses import replace
from typing import Any, Callable, Optional, Tuple

from vda5050_vehicle.core import effects as fx
from vda5050_vehicle.core.action_runner import ActionRunner
from vda5050_vehicle.core.action_table import ActionTable
from vda5050_vehicle.core.context import Context
from vda5050_vehicle.core.identity import Identity
from vda5050_vehicle.core.inbox import Inbox
from vda5050_vehicle.core.instant_actions import BUILT_IN, BUILT_IN_3, InstantActionHandler
from vda5050_vehicle.core.order_desk import OrderDesk
from vda5050_vehicle.core.state import VehicleState
from vda5050_vehicle.core.state_report import position_of, state_of
from vda5050_vehicle.drivers.driver import Driver, Memory
from vda5050_vehicle.drivers.order_fields import Abilities
from vda5050_vehicle.drivers.robot_view import RobotView
from vda5050_vehicle.protocol import problems as e
from vda5050_vehicle.protocol import values as v
from vda5050_vehicle.protocol.codecs import Codec

MakeDriver = Callable[[Memory], Driver[Any]]


class Vehicle:
    """See the module's text."""

    def __init__(self, identity: Identity, codec: Codec, table: ActionTable,
                 make_driver: MakeDriver, abilities: Abilities) -> None:
        self.state = VehicleState()
        table = ActionTable((*BUILT_IN, *(BUILT_IN_3 if codec.is_3 else ()),
                             *table.specs.values()))
        self.context = Context(identity, codec, table, make_driver(self.state), self.state)
        self.driver = self.context.driver
        inbox = Inbox(identity, codec)
        self._runner = ActionRunner(self.context)
        self._desk = OrderDesk(self.context, inbox, abilities)
        self._instant = InstantActionHandler(self.context, inbox, self._runner)
        self._kept: Optional[VehicleState] = None

    # --- what happens -----------------------------------------------------------------------------

    def receive_order(self, payload: bytes, now: float) -> Tuple[fx.Effect, ...]:
        """A message on the topic `order`."""
        self._desk.receive(payload)
        return self._go_on(now)

    def receive_instant_actions(self, payload: bytes, now: float) -> Tuple[fx.Effect, ...]:
        """A message on the topic `instantActions`."""
        self._instant.receive(payload, now)
        return self._go_on(now)

    def see(self, robot: RobotView, now: float) -> Tuple[fx.Effect, ...]:
        """The robot was seen, or it was not for too long."""
        self.context.robot = robot
        self.driver.see(robot, now)
        self._look_at_epoch()
        return self._go_on(now)

    def action_ended(self, action_id: str, succeeded: bool, text: str, now: float,
                     ) -> Tuple[fx.Effect, ...]:
        """An action that was started has ended."""
        if action_id not in self.state.actions:
            pass  # it was forgotten with its order
        elif succeeded:
            self._runner.end(action_id, v.ActionStatus.FINISHED, text)
        else:
            self._runner.fail(action_id, text)
        return self._go_on(now)

    def connected(self, now: float) -> Tuple[fx.Effect, ...]:
        """The broker is there, anew: it gets a fresh state, and nothing of what was missed."""
        self.context.reporter.ask()
        self.context.do(fx.SendFactsheet())
        return self._go_on(now)

    def tick(self, now: float) -> Tuple[fx.Effect, ...]:
        """Time went by, or the driver was told something; several times a second."""
        self.driver.tick(now)
        return self._go_on(now)

    def restore(self, state: VehicleState, now: float) -> None:
        """Takes up the order where it was. What was started has failed: it is not run again."""
        self.state.become(state)
        self.driver.restart(now)
        self._instant.restart()
        self.state.away = True

    # --- order of business ------------------------------------------------------------------------

    def _go_on(self, now: float) -> Tuple[fx.Effect, ...]:
        context = self.context
        self._pass_nodes()
        self._look_at_failure()
        self._instant.go_on(now)
        self._enter_edge()
        self._runner.start()
        self._drive(now)
        commands = self.driver.take_commands()
        self._keep()
        context.effects += [fx.Command(command) for command in commands]
        if not context.robot.is_awaited:  # a state is what tells a master that it may send orders
            state = state_of(context)
            if context.reporter.is_due(state, now):
                context.do(fx.SendState(state))
        effects = tuple(context.effects)
        context.effects.clear()
        return effects

    def _look_at_epoch(self) -> None:
        """A new epoch while nothing is done for us is another's: it drove or stopped the robot, and
        only the master drives on after that. Where an action commands the motion, it is the
        action's."""
        state, epoch = self.state, self.context.robot.epoch
        if not epoch or epoch == state.epoch:
            return
        if (state.epoch and state.busy and not state.cancelling and not state.errors.failure
                and state.drive.at_rest and not self._action_commands_motion):
            self._fail_to_drive('another program or person has driven or stopped the robot')
        state.epoch = epoch

    @property
    def _action_commands_motion(self) -> bool:
        actions, table = self.state.actions, self.context.table
        return any(actions[name].is_active and table.commands_motion(actions[name].action)
                   for name in actions.triggered)

    def _pass_nodes(self) -> None:
        """Nodes that the robot has passed: their edges are left, their actions triggered."""
        state = self.state
        count = min(state.drive.passed - state.order.passed, state.order.base_end)
        for step in range(count):
            self._runner.leave_edge(state.order.edges[0])
            state.order, state.legs = state.order.with_passed(1), state.legs[1:]
            node, sequence_id = state.order.last_node
            if state.away and step < count - 1:
                self._runner.miss(sequence_id)
            else:
                state.actions = state.actions.with_element_triggered(sequence_id)
            self.context.note(f'passed node {node}')
        if count > 0:
            state.away = False

    def _look_at_failure(self) -> None:
        reason = self.state.drive.failure
        if reason and not self.state.errors.failure and not self.state.cancelling:
            self._fail_to_drive(reason)

    def _fail_to_drive(self, reason: str) -> None:
        order = self.state.order
        self.state.errors = replace(self.state.errors, drive=e.DRIVE_ERROR.error(
            reason, v.Reference('orderId', order.order_id),
            v.Reference('nodeId', order.last_node[0])))
        self.context.note(f'driving failed: {reason}')

    def _enter_edge(self) -> None:
        """The edge ahead is entered once the actions of its node let the vehicle drive."""
        state = self.state
        if (state.order.edges and state.order.edges[0].released and not state.held
                and not state.actions.forbid_driving):
            state.actions = state.actions.with_element_triggered(state.order.edges[0].sequence_id)

    def _drive(self, now: float) -> None:
        """Up to the end of the base, or to the first node where the vehicle must stand before."""
        state = self.state
        if state.cancelling or state.held or (
                state.actions.forbid_driving and not self.context.standing
                and self._must_stop_now()):
            self.driver.halt(now)
        elif not state.actions.forbid_driving:
            self.driver.drive(state.order.passed, state.legs[:self._limit()], now)

    def _must_stop_now(self) -> bool:
        """An instant action needs the vehicle to stand; those of nodes were driven up to."""
        actions = self.state.actions
        return any(actions[name].forbids_driving and not actions[name].belongs_to_order
                   for name in actions.triggered)

    def _limit(self) -> int:
        """How many legs may be driven now: node and edge number i of what is left have the
        sequence ids 2 i and 2 i + 1, counted from the last node that was passed."""
        order = self.state.order
        last = order.last_node[1]
        stop = self.state.actions.next_stop(last)
        return order.base_end if stop is None else min((stop - last) // 2, order.base_end)

    def _keep(self) -> None:
        """Stores what changed, before anything is done about it."""
        if self._kept is None or self.state.differs_from(self._kept):
            now = self.state.copy()
            self.context.effects.insert(0, fx.Keep(self._kept, now))
            self._kept = now

    # --- what is told -----------------------------------------------------------------------------

    def position(self) -> Optional[v.AgvPosition]:
        """Where the robot is; None where that is not known."""
        return position_of(self.context)
