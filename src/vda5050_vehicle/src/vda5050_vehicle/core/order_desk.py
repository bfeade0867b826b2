"""Where orders come in: read, judged by the standard's figure, planned, and taken up whole."""
from __future__ import annotations

from typing import TYPE_CHECKING, Optional, Set

from vda5050_vehicle.core.action_table import WrongAction
from vda5050_vehicle.core.inbox import Inbox, Refused
from vda5050_vehicle.drivers.driver import NotDrivable
from vda5050_vehicle.drivers.order_fields import Abilities, check_fields, check_start_heading
from vda5050_vehicle.protocol import problems as e
from vda5050_vehicle.protocol.acceptance import Acceptance, Held, Rejection, judge
from vda5050_vehicle.protocol.action_queue import Scope
from vda5050_vehicle.protocol.order_rules import actions_of
from vda5050_vehicle.protocol.order_state import OrderState
from vda5050_vehicle.protocol.values import Order, Reference

if TYPE_CHECKING:
    from vda5050_vehicle.core.vehicle import Vehicle


class OrderDesk:
    """Takes orders for a vehicle. An order that is not taken up changes nothing but the errors."""

    def __init__(self, vehicle: Vehicle, inbox: Inbox, abilities: Abilities) -> None:
        self._vehicle = vehicle
        self._inbox = inbox
        self._abilities = abilities
        self._taken: Optional[Order] = None  # since this program was started

    def receive(self, payload: bytes) -> None:
        """A message on the topic `order`."""
        vehicle = self._vehicle
        vehicle.reporter.ask()
        try:
            order: Order = self._inbox.read('order', payload)
        except Refused as refused:
            vehicle.note(f'order refused: {refused}')
            vehicle.errors.reject(refused.error)
            return
        rejection = self._consider(order, payload)
        vehicle.note(f'order {order.order_id}, update {order.order_update_id}: '
                     + (rejection.error.description if rejection else 'taken'))
        if rejection:
            vehicle.errors.reject(rejection.error)

    def _consider(self, order: Order, payload: bytes) -> Optional[Rejection]:
        """Takes the order up, or says why not."""
        vehicle = self._vehicle
        try:
            verdict = judge(self._held(), order, self._is_near(order), vehicle.codec.is_3)
            if isinstance(verdict, Rejection):
                return verdict
            if verdict is Acceptance.DUPLICATE:
                return self._compare(order)
            if payload in vehicle.received:
                raise NotDrivable(e.ORDER_ERROR, 'this message was taken before, and its order '
                                  'is not driven again; another one has a header of its own',
                                  'headerId')
            self._check_actions(order, verdict)
            check_fields(order, self._abilities)
            if verdict is Acceptance.NEW and vehicle.robot.pose is not None:
                check_start_heading(order.nodes[0], vehicle.robot.pose, self._abilities)
            legs = vehicle.driver.plan(order.nodes, order.edges, vehicle.robot.pose)
        except NotDrivable as problem:
            return Rejection(problem.kind.error(
                str(problem), *e.order_references(order), Reference('field', problem.field)))
        except WrongAction as wrong:
            return Rejection(e.ORDER_ACTION.error(
                str(wrong), *e.order_references(order), Reference('field', wrong.key)))
        vehicle.errors.order_taken(with_instant_actions=not vehicle.codec.is_3)
        vehicle.received.add(payload)
        self._taken = order
        if verdict is Acceptance.NEW:
            self._begin(order)
        else:
            self._extend(order)
        kept = len(vehicle.order.edges) - len(legs)
        vehicle.legs = vehicle.legs[:kept] + legs
        return None

    def _compare(self, order: Order) -> Optional[Rejection]:
        """A repeated orderUpdateId is ignored; in 3.0 only where nothing else was changed."""
        if not self._vehicle.codec.is_3 or self._taken is None or order == self._taken:
            return None
        return Rejection(e.SAME_UPDATE.error(
            f'orderUpdateId {order.order_update_id} came before with another content',
            *e.order_references(order)))

    def _held(self) -> Held:
        vehicle = self._vehicle
        order = vehicle.order
        instant = [entry.action for entry in vehicle.actions.entries
                   if not entry.belongs_to_order and not entry.status.has_ended]
        moving = [action for action in instant if vehicle.table.moves(action)]
        return Held(order.order_id, order.order_update_id, vehicle.busy,
                    order.cancelled or vehicle.cancelling, order.decision_point, order.last_node,
                    instant[0].action_id if instant and not vehicle.codec.is_3 else '',
                    moving[0].action_id if moving else '')

    def _is_near(self, order: Order) -> bool:
        """Question 4; asked of a new order to an idle vehicle only. Raises NotDrivable."""
        vehicle = self._vehicle
        if order.order_id == vehicle.order.order_id or vehicle.busy:
            return True
        if vehicle.robot.pose is None:
            raise NotDrivable(e.NO_ROUTE, 'nobody knows where the vehicle is', 'nodes')
        return vehicle.driver.is_at(order.nodes[0], vehicle.robot.pose)

    def _check_actions(self, order: Order, verdict: Acceptance) -> None:
        """Raises WrongAction where an action cannot be done, or has an id that another has."""
        vehicle = self._vehicle
        known: Set[str] = {
            entry.action.action_id for entry in vehicle.actions.entries
            if entry.sequence_id not in vehicle.order.horizon_sequence_ids
            and (verdict is not Acceptance.NEW or not entry.belongs_to_order
                 and not entry.status.has_ended)}
        first = order.nodes[0]
        if verdict is not Acceptance.NEW:  # the node at which they join stays as it was first sent
            known -= {action.action_id for action in first.actions}
        for action in actions_of(order):
            if action.action_id in known:
                raise WrongAction('actionId', f'action {action.action_id!r} is known already')
        for elements, scope in ((order.nodes, Scope.NODE), (order.edges, Scope.EDGE)):
            for element in elements:
                if element is first and verdict is not Acceptance.NEW:
                    continue
                for action in element.actions:
                    vehicle.table.check(action, scope)

    def _begin(self, order: Order) -> None:
        vehicle = self._vehicle
        vehicle.actions.begin_order(keep_instant=vehicle.codec.is_3)
        vehicle.order = OrderState.begin(order)
        vehicle.legs = ()
        vehicle.forgive()
        vehicle.driver.begin()
        self._add_actions(order, 0)
        vehicle.actions.trigger_element(order.nodes[0].sequence_id)

    def _extend(self, order: Order) -> None:
        vehicle = self._vehicle
        vehicle.actions.drop(vehicle.order.horizon_sequence_ids)
        vehicle.legs = vehicle.legs[:vehicle.order.base_end]
        vehicle.order = vehicle.order.extended(order)
        self._add_actions(order, 1)

    def _add_actions(self, order: Order, first_node: int) -> None:
        """In driving order: node, edge, node ..."""
        actions, as_executed = self._vehicle.actions, self._vehicle.table.as_executed
        for index, node in enumerate(order.nodes):
            if index >= first_node:
                actions.add(map(as_executed, node.actions), Scope.NODE, node.sequence_id)
            if index < len(order.edges):
                edge = order.edges[index]
                actions.add(map(as_executed, edge.actions), Scope.EDGE, edge.sequence_id)
