"""The vehicle: takes orders and instant actions, drives, acts, and tells its state.

One object that one thread uses. It is told what happens and the time (s, of a clock that never goes
back), and answers with effects. Order of business after every event: what was passed, what failed,
which actions may start, where to drive, what to remember, what to tell.
"""
from __future__ import annotations

from collections import deque
from typing import Any, Deque, Dict, List, Optional, Set, Tuple

from vda5050_vehicle.core import effects as fx
from vda5050_vehicle.core import journal
from vda5050_vehicle.core.action_runner import ActionRunner
from vda5050_vehicle.core.action_table import ActionTable
from vda5050_vehicle.core.error_list import Cause, ErrorList, Hold
from vda5050_vehicle.core.identity import Identity
from vda5050_vehicle.core.inbox import Inbox
from vda5050_vehicle.core.instant_actions import BUILT_IN, BUILT_IN_3, InstantActionHandler
from vda5050_vehicle.core.order_desk import OrderDesk
from vda5050_vehicle.core.robot_view import RobotView
from vda5050_vehicle.core.state_report import position_of, state_of
from vda5050_vehicle.drivers.driver import Driver, Leg, NotDrivable
from vda5050_vehicle.drivers.order_fields import Abilities
from vda5050_vehicle.protocol import problems as e
from vda5050_vehicle.protocol import values as v
from vda5050_vehicle.protocol.action_queue import ActionQueue
from vda5050_vehicle.protocol.codecs import Codec
from vda5050_vehicle.protocol.order_state import OrderState
from vda5050_vehicle.protocol.received import ReceivedMessages
from vda5050_vehicle.protocol.reporting import Reporter

HISTORY = 500        # events that a log report holds


class Vehicle:
    """See the module's text."""

    def __init__(self, identity: Identity, codec: Codec, table: ActionTable, driver: Driver,
                 abilities: Abilities) -> None:
        self.identity = identity
        self.driver = driver
        self.codec = codec
        self.table = ActionTable((*BUILT_IN, *(BUILT_IN_3 if codec.is_3 else ()),
                                  *table.specs.values()))
        self.order = OrderState()
        self.actions = ActionQueue()
        self.legs: Tuple[Leg, ...] = ()     # one per edge of the order
        self.errors = ErrorList()
        self.received = ReceivedMessages()
        self.holds: Set[Hold] = set()
        self.robot = RobotView()
        self.reporter = Reporter()
        self.history: Deque[str] = deque(maxlen=HISTORY)
        self._effects: List[fx.Effect] = []
        self._kept: Dict[str, Any] = {}
        self._away = False                  # nodes may have been passed while we were not there
        inbox = Inbox(identity, codec)
        self._desk = OrderDesk(self, inbox, abilities)
        self._instant = InstantActionHandler(self, inbox)
        self.runner = ActionRunner(self)

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
        self.robot = robot
        return self._go_on(now)

    def action_ended(self, action_id: str, succeeded: bool, text: str, now: float,
                     ) -> Tuple[fx.Effect, ...]:
        """An action that was started has ended."""
        if action_id not in self.actions:
            pass  # it was forgotten with its order
        elif succeeded:
            self.runner.end(action_id, v.ActionStatus.FINISHED, text)
        else:
            self.runner.fail(action_id, text)
        return self._go_on(now)

    def connected(self, now: float) -> Tuple[fx.Effect, ...]:
        """The broker is there, anew: it gets a fresh state, and nothing of what was missed."""
        self.reporter.ask()
        self._effects.append(fx.SendFactsheet())
        return self._go_on(now)

    def tick(self, now: float) -> Tuple[fx.Effect, ...]:
        """Time went by, or the driver was told something; several times a second."""
        self.driver.tick(now)
        return self._go_on(now)

    # --- restarts ---------------------------------------------------------------------------------

    def restore(self, record: Dict[str, Any], now: float) -> None:
        """Takes up the order where it was; raises journal.WrongRecord.

        What was started has failed: it is not run again.
        """
        kept = journal.read(record)
        try:
            self.driver.restore(kept.driver, now)
        except (KeyError, TypeError, ValueError) as error:
            raise journal.WrongRecord(f'driver: {error}') from None
        self.order, self.actions, self.legs = kept.order, kept.actions, kept.legs
        self.received = kept.received
        self.holds = {Hold(name) for name in kept.holds}
        self.driver.know_legs(self.order.passed, self.legs)
        if Hold.FAILURE in self.holds:
            self.errors.fail(Cause.DRIVE, e.RESTARTED.error(
                kept.failure or 'the adapter was restarted while the vehicle was held',
                v.Reference('orderId', self.order.order_id)))
        for entry in self.actions.entries:
            was_started = entry.is_active or entry.status is v.ActionStatus.INITIALIZING
            if was_started or (not entry.belongs_to_order and not entry.status.has_ended):
                self.runner.fail(entry.action.action_id, 'the adapter was restarted; the action '
                                                         'is not run again by itself')
        self._away = True

    # --- what is asked by others in this package --------------------------------------------------

    @property
    def busy(self) -> bool:
        """Whether an order is under way (question 3 of figure 8)."""
        return (not self.order.is_driven or not self.actions.order_has_ended
                or self.cancelling)

    @property
    def cancelling(self) -> bool:
        """Whether the order is being cancelled."""
        return self._instant.cancelling

    @property
    def standing(self) -> bool:
        """Whether the robot stands, and was not sent anywhere."""
        progress = self.driver.progress
        return (progress.halted or progress.complete) and not self.robot.moves

    def do(self, effect: fx.Effect) -> None:
        """Adds to what is to be done."""
        self._effects.append(effect)

    def note(self, text: str) -> None:
        """Adds to what a log report tells."""
        self.history.append(text)

    def pause(self) -> None:
        """startPause: stops, and drives on only after stopPause."""
        self.holds.add(Hold.PAUSE)

    def resume(self) -> None:
        """stopPause: drives on, whatever the vehicle was held for."""
        self.holds.discard(Hold.PAUSE)
        self.forgive()

    def forgive(self) -> None:
        """A failure was seen to: by stopPause, by another order, or because its order has ended."""
        self.holds.discard(Hold.FAILURE)
        self.errors.forgive()
        self.driver.forgive()

    def place_at(self, node_id: str) -> None:
        """The robot is at this node, though no order brought it there."""
        if self.order.is_driven and node_id and node_id != self.order.last_node[0]:
            node = v.Node(node_id, 0, True)
            self.order = OrderState(self.order.order_id, self.order.order_update_id, (node,),
                                    cancelled=self.order.cancelled)
            self.driver.begin()
            self.legs = ()

    def look_where_it_is(self) -> None:
        """The robot moved without an order: it may be at another node than the last one."""
        pose = self.robot.pose
        if pose is None or not self.order.nodes:
            return
        try:
            if not self.driver.is_at(self.order.nodes[0], pose):
                self.place_at(self.driver.node_at(pose))
        except NotDrivable:
            self.place_at(self.driver.node_at(pose))

    def end_order(self) -> None:
        """After a cancellation: nothing of the order is left but its ids."""
        self.order = self.order.emptied()
        self.legs = ()
        self.forgive()

    # --- order of business ------------------------------------------------------------------------

    def _go_on(self, now: float) -> Tuple[fx.Effect, ...]:
        self._pass_nodes()
        self._look_at_failure()
        self._instant.go_on(now)
        self._enter_edge()
        self.runner.start()
        self._drive(now)
        commands = self.driver.take_commands()
        self._keep()
        self._effects += [fx.Command(command) for command in commands]
        if not self.robot.is_awaited:  # a state is what tells a master that it may send orders
            state = self.state()
            if self.reporter.is_due(state, now):
                self._effects.append(fx.SendState(state))
        effects = tuple(self._effects)
        self._effects.clear()
        return effects

    def _pass_nodes(self) -> None:
        """Nodes that the robot has passed: their edges are left, their actions triggered."""
        count = min(self.driver.progress.passed - self.order.passed, self.order.base_end)
        for step in range(count):
            self.runner.leave_edge(self.order.edges[0])
            self.order = self.order.with_passed(1)
            self.legs = self.legs[1:]
            if self._away and step < count - 1:
                self.runner.miss(self.order.nodes[0].sequence_id)
            else:
                self.actions.trigger_element(self.order.nodes[0].sequence_id)
            self.note(f'passed node {self.order.last_node}')
        if count > 0:
            self._away = False

    def _look_at_failure(self) -> None:
        reason = self.driver.progress.failure
        if reason and Hold.FAILURE not in self.holds and not self.cancelling:
            self.holds.add(Hold.FAILURE)
            self.errors.fail(Cause.DRIVE, e.DRIVE_ERROR.error(
                reason, v.Reference('orderId', self.order.order_id),
                v.Reference('nodeId', self.order.last_node[0])))
            self.note(f'driving failed: {reason}')

    def _enter_edge(self) -> None:
        """The edge ahead is entered once the actions of its node let the vehicle drive."""
        if (self.order.edges and self.order.edges[0].released and not self.holds
                and not self.actions.forbid_driving):
            self.actions.trigger_element(self.order.edges[0].sequence_id)

    def _drive(self, now: float) -> None:
        """Up to the end of the base, or to the first node where the vehicle must stand before."""
        if self.cancelling:
            self.driver.halt(now)
            return
        if self.holds or (self.actions.forbid_driving and not self.standing):
            if Hold.PAUSE in self.holds or Hold.FAILURE in self.holds or self._must_stop_now():
                self.driver.halt(now)
            return
        limit = self._limit()
        if limit:
            self.driver.drive(self.order.passed, self.legs[:limit], now)

    def _must_stop_now(self) -> bool:
        """An instant action needs the vehicle to stand; those of nodes were driven up to."""
        return any(self.actions[action_id].forbids_driving
                   and not self.actions[action_id].belongs_to_order
                   for action_id in self.actions.triggered)

    def _limit(self) -> int:
        """How many legs may be driven now."""
        if self.actions.forbid_driving:
            return 0
        for index in range(self.order.base_end + 1):
            here = [self.order.nodes[index].sequence_id] if index else []
            ahead = [self.order.edges[index].sequence_id] if index < self.order.base_end else []
            if self.actions.stops_at(*here, *ahead):
                return index
        return self.order.base_end

    def _keep(self) -> None:
        """Stores what changed, before anything is done about it."""
        record = journal.write(self)
        if record != self._kept:
            self._kept = record
            self._effects.insert(0, fx.Keep(record))

    # --- what is told -----------------------------------------------------------------------------

    def state(self) -> v.State:
        """The state as it is now."""
        return state_of(self)

    def position(self) -> Optional[v.AgvPosition]:
        """Where the robot is; None where that is not known."""
        return position_of(self)
