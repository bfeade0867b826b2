"""The vehicle: it receives orders and instant actions, drives, runs actions and reports its state.

One thread uses this object. Its methods receive an event and the time (s, of a clock that never
goes back), and return effects. The steps after each event:
1. evaluate the nodes that were passed, and failures
2. end the instant actions that are complete, and start the actions that are due
3. drive
4. store the state for a restart
5. send the commands and the state

Instant actions that wait for the vehicle are processed together: steps 1 to 3 follow each message,
and steps 4 and 5 follow the last message. So a stop does not wait until the vehicle has sent a
state for each message before it.
"""
from __future__ import annotations

from dataclasses import replace
from typing import Any, Callable, Optional, Sequence, Tuple

from vda5050_protocol import problems as e
from vda5050_protocol import values as v
from vda5050_protocol.codecs import Codec
from vda5050_vehicle.core import effects as fx
from vda5050_vehicle.core.action_runner import ActionRunner
from vda5050_vehicle.core.action_table import ActionTable
from vda5050_vehicle.core.context import Context
from vda5050_vehicle.core.identity import Identity
from vda5050_vehicle.core.inbox import Inbox
from vda5050_vehicle.core.instant_actions import BUILT_IN, BUILT_IN_3, InstantActionHandler
from vda5050_vehicle.core.order_desk import OrderDesk
from vda5050_vehicle.core.state import VdaVehicleState
from vda5050_vehicle.core.state_report import position_of, state_of
from vda5050_vehicle.drivers.driver import Driver, DriverMemory
from vda5050_vehicle.drivers.order_fields import Abilities
from vda5050_vehicle.drivers.robot_view import RobotSnapshot

MakeDriver = Callable[[DriverMemory], Driver[Any]]


class VdaVehicle:
    """See the module's docstring."""

    def __init__(self, identity: Identity, codec: Codec, table: ActionTable,
                 make_driver: MakeDriver, abilities: Abilities) -> None:
        self.state = VdaVehicleState()
        table = ActionTable((*BUILT_IN, *(BUILT_IN_3 if codec.is_3 else ()),
                             *table.specs.values()))
        self.context = Context(identity, codec, table, make_driver(self.state), self.state)
        self.driver = self.context.driver
        inbox = Inbox(identity, codec)
        self._runner = ActionRunner(self.context)
        self._desk = OrderDesk(self.context, inbox, abilities)
        self._instant = InstantActionHandler(self.context, inbox, self._runner)
        self._kept: Optional[VdaVehicleState] = None

    # --- events -----------------------------------------------------------------------------------

    def receive(self, messages: Sequence[Tuple[str, bytes]], now: float) -> Tuple[fx.Effect, ...]:
        """Processes messages, each with its topic: `order` or `instantActions`."""
        effects: Tuple[fx.Effect, ...] = ()
        is_reported = True
        for topic, payload in messages:
            before = self.state.order
            if topic == 'order':
                if not is_reported:  # an order removes earlier instant actions from the state
                    effects += self._report(now)
                self._desk.receive(payload)
            else:
                self._instant.receive(payload, now)
            self._settle(now)
            is_reported = topic == 'order' or self.state.order is not before
            if is_reported:
                effects += self._report(now)
        return effects if is_reported else effects + self._report(now)

    def robot_seen(self, robot: RobotSnapshot, now: float) -> Tuple[fx.Effect, ...]:
        """Processes a new view of the robot, which may show that the robot was silent too long."""
        self.context.robot = robot
        self.driver.robot_seen(robot, now)
        return self._handle_events(now)

    def action_ended(self, action_id: str, succeeded: bool, text: str, now: float,
                     ) -> Tuple[fx.Effect, ...]:
        """Processes the end of an action that was started."""
        if action_id not in self.state.actions:
            pass  # the action was removed together with its order
        elif succeeded:
            self._runner.end(action_id, v.ActionStatus.FINISHED, text)
        else:
            self._runner.fail(action_id, text)
        return self._handle_events(now)

    def connected(self, now: float) -> Tuple[fx.Effect, ...]:
        """Sends factsheet and state after a connection to the broker; missed messages are lost."""
        self.context.reporter.ask()
        self.context.do(fx.SendFactsheet())
        return self._handle_events(now)

    def tick(self, now: float) -> Tuple[fx.Effect, ...]:
        """Continues after some time, or after an event of the driver. The caller calls it several
        times a second.
        """
        self.driver.tick(now)
        return self._handle_events(now)

    def restore(self, state: VdaVehicleState, is_newest: bool, now: float) -> None:
        """Continues the order after a restart; actions that were started count as failed.

        is_newest -- whether no later state can have been lost. Otherwise the order may have been
                     cancelled: the robot is stopped, and only a master may continue the order
        """
        self.state.become(state)
        self.driver.restart(now)
        self._instant.restart()
        self.state.away = True
        if not is_newest and not state.order.is_driven:
            self.driver.stop(now)
            self._fail_to_drive('the computer of the adapter was restarted, and its journal may '
                                'be an older one')

    # --- the steps after each event ---------------------------------------------------------------

    def _handle_events(self, now: float) -> Tuple[fx.Effect, ...]:
        self._settle(now)
        return self._report(now)

    def _settle(self, now: float) -> None:
        self._pass_nodes()
        self._judge_failure()
        self._judge_epoch()
        self._instant.end_completed(now)
        self._enter_edge()
        self._pass_nodes_at_a_stand()
        self._runner.start()
        self._drive(now)

    def _report(self, now: float) -> Tuple[fx.Effect, ...]:
        context = self.context
        commands = self.driver.pop_commands()
        self._keep()
        context.effects += [fx.DriverCommand(command) for command in commands]
        if not context.robot.is_awaited:  # after the first state the master may send orders
            state = state_of(context)
            if context.reporter.is_due(state, now):
                context.do(fx.SendState(state))
        effects = tuple(context.effects)
        context.effects.clear()
        return effects

    def _judge_epoch(self) -> None:
        """Reports a failure if another program or person has driven or stopped the robot.

        A new epoch shows this if neither the drive nor an action of this vehicle commands motion.
        After this failure, only the master may continue the drive.
        """
        state, epoch = self.state, self.state.drive.epoch
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
        """Evaluates the passed nodes: ends the actions of edges, and triggers actions of nodes."""
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

    def _pass_nodes_at_a_stand(self) -> None:
        """Passes further nodes at the place of the last node. Masters add actions at such nodes."""
        state = self.state
        while (state.legs and state.legs[0].stands and state.order.base_end
               and state.drive.in_order and self._may_leave_node
               and all(entry.status.has_ended
                       for entry in state.actions.of(state.order.edges[0].sequence_id))):
            state.order, state.legs = state.order.with_stood(), state.legs[1:]
            self.driver.begin()
            node, sequence_id = state.order.last_node
            state.actions = state.actions.with_element_triggered(sequence_id)
            self.context.note(f'passed node {node}, where it stands')
            self._enter_edge()

    @property
    def _may_leave_node(self) -> bool:
        state = self.state
        return not state.held and not state.cancelling and not state.actions.forbid_driving

    def _judge_failure(self) -> None:
        reason = self.state.drive.failure
        if reason and not self.state.errors.failure and not self.state.cancelling:
            self._fail_to_drive(reason)

    def _fail_to_drive(self, reason: str) -> None:
        order = self.state.order
        self.state.errors = replace(self.state.errors, drive=e.DRIVE_ERROR.error(
            reason, v.ErrorReference('orderId', order.order_id),
            v.ErrorReference('nodeId', order.last_node[0])))
        self.context.note(f'driving failed: {reason}')

    def _enter_edge(self) -> None:
        """Enters the next edge when the actions of the node permit driving."""
        state = self.state
        if state.order.edges and state.order.edges[0].released and self._may_leave_node:
            state.actions = state.actions.with_element_triggered(state.order.edges[0].sequence_id)

    def _drive(self, now: float) -> None:
        """Drives to the end of the base, or to an earlier node at which the vehicle must stand."""
        state = self.state
        if state.cancelling or state.held or (
                state.actions.forbid_driving and not self.context.standing
                and self._must_stop_now()):
            self.driver.halt(now)
        elif not state.actions.forbid_driving:
            self.driver.drive(state.order.passed, state.legs[:self._limit()], now)

    def _must_stop_now(self) -> bool:
        """Returns whether an instant action requires a stop now.

        For the actions of a node, the vehicle drives on to the node and stands there.
        """
        actions = self.state.actions
        return any(actions[name].forbids_driving and not actions[name].belongs_to_order
                   for name in actions.triggered)

    def _limit(self) -> int:
        """Returns the number of legs that may be driven now.

        Remaining node i has the sequence id 2 i, and remaining edge i has 2 i + 1, counted from
        the last node that was passed.
        """
        order = self.state.order
        last = order.last_node[1]
        stop = self.state.actions.next_stop(last)
        limit = order.base_end if stop is None else min((stop - last) // 2, order.base_end)
        return next((index for index, leg in enumerate(self.state.legs[:limit]) if leg.stands),
                    limit)

    def _keep(self) -> None:
        """Stores a changed state before the effects of the change are carried out."""
        if self._kept is None or self.state.differs_from(self._kept):
            now = self.state.copy()
            self.context.effects.insert(0, fx.Keep(self._kept, now))
            self._kept = now

    # --- reports ----------------------------------------------------------------------------------

    def position(self) -> Optional[v.AgvPosition]:
        """Returns the position of the robot; None if it is unknown."""
        return position_of(self.context)
