"""Receives orders: reads them, judges them (figure 8 of the standard), plans and accepts them."""
from __future__ import annotations

from dataclasses import replace
from typing import Optional, Set

from vda5050_protocol import problems as e
from vda5050_protocol.acceptance import Held, OrderAcceptance, Rejection, judge
from vda5050_protocol.action_queue import QueuedAction, Scope
from vda5050_protocol.order_rules import actions_of
from vda5050_protocol.order_state import OrderState
from vda5050_protocol.received import digest
from vda5050_protocol.values import ErrorReference, OrderMessage
from vda5050_vehicle.core.action_table import WrongAction
from vda5050_vehicle.core.context import Context
from vda5050_vehicle.core.inbox import Inbox, MessageRefused
from vda5050_vehicle.drivers.driver import NotDrivable
from vda5050_vehicle.drivers.order_fields import Abilities, check_fields, check_start_heading


class OrderDesk:
    """Receives the orders of a vehicle; a rejected order changes only the errors."""

    def __init__(self, context: Context, inbox: Inbox, abilities: Abilities) -> None:
        self._context = context
        self._state = context.state
        self._inbox = inbox
        self._abilities = abilities

    def receive(self, payload: bytes) -> None:
        """Processes a message on the topic `order`."""
        context, state = self._context, self._state
        context.reporter.answer()
        try:
            order: OrderMessage = self._inbox.read('order', payload)
        except MessageRefused as refused:
            context.note(f'order refused: {refused}')
            state.errors = state.errors.with_rejection(refused.error)
            return
        rejection = self._consider(order, payload)
        context.note(f'order {order.order_id}, update {order.order_update_id}: '
                     + (rejection.error.description if rejection else 'accepted'))
        if rejection:
            state.errors = state.errors.with_rejection(rejection.error)

    def _consider(self, order: OrderMessage, payload: bytes) -> Optional[Rejection]:
        """Accepts the order and returns None, or returns the reason of the rejection."""
        context, state = self._context, self._state
        try:
            self._check_first(order)
            verdict = judge(self._held(), order, self._is_near(order), context.codec.is_3)
            if isinstance(verdict, Rejection):
                return verdict
            if verdict is OrderAcceptance.DUPLICATE:
                return self._compare(order)
            if payload in state.received:
                raise NotDrivable(e.ORDER_ERROR, 'this message is a copy, and its order is not '
                                  'driven again; send the order with a new header', 'headerId')
            self._check_length(order, verdict)
            self._check_actions(order, verdict)
            check_fields(order, self._abilities)
            begins_at = context.robot.pose if verdict is OrderAcceptance.NEW else None
            if begins_at is not None:
                check_start_heading(order.nodes[0], begins_at, self._abilities)
            legs = context.driver.plan(order.nodes, order.edges, begins_at)
        except NotDrivable as problem:
            return Rejection(problem.kind.error(
                str(problem), *e.order_references(order),
                ErrorReference('field',
                               context.codec.path('order', problem.field) or problem.field)))
        except WrongAction as wrong:
            return Rejection(e.ORDER_ACTION.error(
                str(wrong), *e.order_references(order), ErrorReference('field', wrong.key)))
        state.errors = replace(
            state.errors, rejections=(),
            refused_actions=state.errors.refused_actions if context.codec.is_3 else ())
        state.received = state.received.with_message(payload)
        state.taken = _digest_of(order)
        if verdict is OrderAcceptance.NEW:
            self._begin(order)
        else:
            self._extend(order)
        kept = len(state.order.edges) - len(legs)
        state.legs = state.legs[:kept] + legs
        return None

    def _check_first(self, order: OrderMessage) -> None:
        """Raises NotDrivable if a new order does not begin with sequenceId 0 (3.0.0, 6.1.1)."""
        first = order.nodes[0].sequence_id
        if self._context.codec.is_3 and first and order.order_id != self._state.order.order_id:
            raise NotDrivable(e.ORDER_ERROR, 'the first node of a new order has sequenceId 0, not '
                              f'{first}', 'nodes[0].sequenceId')

    def _check_length(self, order: OrderMessage, verdict: OrderAcceptance) -> None:
        """Raises NotDrivable if the base has more edges than the robot can drive in one order."""
        longest, before = self._context.driver.longest, self._state.order
        driven = 0 if verdict is OrderAcceptance.NEW else before.passed + before.base_end
        length = driven + sum(edge.released for edge in order.edges)
        if longest is not None and length > longest:
            raise NotDrivable(
                e.ORDER_ERROR if verdict is OrderAcceptance.NEW else e.WRONG_UPDATE,
                f'the base would have {length} edges from its start on, but the vehicle drives at '
                f'most {longest} in one order; complete the order, then send another one', 'edges')

    def _compare(self, order: OrderMessage) -> Optional[Rejection]:
        """Returns the rejection of a repeated orderUpdateId; None if the order is ignored.

        In 3.0 the order must be the same as before; in 2.x it is always ignored.
        """
        if not self._context.codec.is_3 or _digest_of(order) == self._state.taken:
            return None
        return Rejection(e.SAME_UPDATE.error(
            f'orderUpdateId {order.order_update_id} came before with different contents',
            *e.order_references(order)))

    def _held(self) -> Held:
        context, state = self._context, self._state
        order = state.order
        instant = [entry.action for entry in state.actions
                   if not entry.belongs_to_order and not entry.status.has_ended]
        moving = [action for action in instant if context.table.moves(action)]
        return Held(order.order_id, order.order_update_id, state.busy,
                    order.cancelled or state.cancelling, order.decision_point, order.last_node,
                    instant[0].action_id if instant and not context.codec.is_3 else '',
                    moving[0].action_id if moving else '')

    def _is_near(self, order: OrderMessage) -> bool:
        """Returns whether the robot is at the first node (question 4 of figure 8).

        Only a new order to an idle vehicle is checked. Raises NotDrivable.
        """
        pose = self._context.robot.pose
        if order.order_id == self._state.order.order_id or self._state.busy:
            return True
        if pose is None:
            raise NotDrivable(e.NO_ROUTE, 'the position of the vehicle is unknown', 'nodes')
        return self._context.driver.is_at(order.nodes[0], pose)

    def _check_actions(self, order: OrderMessage, verdict: OrderAcceptance) -> None:
        """Raises WrongAction if an action cannot be executed, or another action has its id."""
        state = self._state
        horizon = state.order.horizon_sequence_ids
        known: Set[str] = {
            entry.action.action_id for entry in state.actions
            if entry.sequence_id not in horizon
            and (verdict is not OrderAcceptance.NEW or not entry.belongs_to_order
                 and not entry.status.has_ended)}
        first = order.nodes[0]
        if verdict is not OrderAcceptance.NEW:
            # the node at which order and update join keeps its first definition
            known -= {action.action_id for action in first.actions}
        for action in actions_of(order):
            if action.action_id in known:
                raise WrongAction('actionId', f'action {action.action_id!r} is known already')
        for elements, scope in ((order.nodes, Scope.NODE), (order.edges, Scope.EDGE)):
            for element in elements:
                if element is first and verdict is not OrderAcceptance.NEW:
                    continue
                for action in element.actions:
                    self._context.table.check(action, scope)

    def _begin(self, order: OrderMessage) -> None:
        state = self._state
        state.actions = state.actions.without_order(keep_instant=self._context.codec.is_3)
        state.order = OrderState.begin(order)
        state.legs = ()
        self._context.forgive()
        self._context.driver.begin()
        self._add_actions(order, 0)
        state.actions = state.actions.with_element_triggered(order.nodes[0].sequence_id)

    def _extend(self, order: OrderMessage) -> None:
        state = self._state
        state.actions = state.actions.without(state.order.horizon_sequence_ids)
        state.legs = state.legs[:state.order.base_end]
        state.order = state.order.extended(order)
        self._add_actions(order, 1)

    def _add_actions(self, order: OrderMessage, first_node: int) -> None:
        """Adds the actions in the sequence of driving: node, edge, node ..."""
        entries = [
            QueuedAction(self._context.table.as_executed(action), scope, element.sequence_id)
            for elements, scope in ((order.nodes[first_node:], Scope.NODE),
                                    (order.edges, Scope.EDGE))
            for element in elements for action in element.actions]
        entries.sort(key=lambda entry: entry.sequence_id)
        self._state.actions = self._state.actions.with_entries(*entries)


def _digest_of(order: OrderMessage) -> str:
    return digest(repr(order).encode())
