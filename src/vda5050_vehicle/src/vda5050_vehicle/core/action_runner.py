"""Runs the actions of an order and those that came at once: starts them, and ends each once."""
from __future__ import annotations

from typing import TYPE_CHECKING

from vda5050_vehicle.core import effects as fx
from vda5050_vehicle.core.action_table import WrongAction
from vda5050_vehicle.core.error_list import Cause, Hold
from vda5050_vehicle.protocol import problems as e
from vda5050_vehicle.protocol.action_queue import Entry
from vda5050_vehicle.protocol.values import ActionStatus, Edge, Reference

if TYPE_CHECKING:
    from vda5050_vehicle.core.vehicle import Vehicle

AWAY = 'the adapter was away when it was its turn'


class ActionRunner:
    """Runs actions for a vehicle."""

    def __init__(self, vehicle: Vehicle) -> None:
        self._vehicle = vehicle

    def start(self) -> None:
        """Starts those whose turn it is."""
        vehicle = self._vehicle
        if Hold.PAUSE in vehicle.holds or vehicle.cancelling:
            return
        for entry in vehicle.actions.startable(vehicle.standing):
            action_id, scope = entry.action.action_id, entry.scope
            try:
                spec = vehicle.table.check(entry.action, scope)
                if spec.call is None:
                    raise WrongAction('actionType', 'it is done at once or not at all')
            except WrongAction as wrong:
                self.end(action_id, ActionStatus.FAILED, str(wrong))
                continue
            vehicle.actions.update(action_id, ActionStatus.RUNNING)
            vehicle.do(fx.StartAction(action_id, spec, spec.arguments_of(entry.action)))

    def leave_edge(self, edge: Edge) -> None:
        """The edge was driven: its actions end with it."""
        for entry in self._vehicle.actions.of(edge.sequence_id):
            action_id = entry.action.action_id
            if entry.status is ActionStatus.RETRIABLE:
                self.end(action_id, ActionStatus.FAILED, 'the edge was left before it was retried')
            elif entry.is_active:
                self._vehicle.do(fx.CancelAction(action_id))
                self.end(action_id, ActionStatus.FINISHED, 'the edge was left')
            elif not entry.status.has_ended:
                self.end(action_id, ActionStatus.FAILED,
                         'the edge was left before the action could start')

    def miss(self, sequence_id: int) -> None:
        """Nobody was there when the node was passed."""
        for entry in self._vehicle.actions.of(sequence_id):
            self.end(entry.action.action_id, ActionStatus.FAILED, AWAY)

    def fail(self, action_id: str, text: str) -> None:
        """An action has failed; one that may be tried again waits until the master says so."""
        vehicle = self._vehicle
        entry = vehicle.actions[action_id]
        if entry.action.retriable and entry.belongs_to_order and not vehicle.cancelling:
            vehicle.actions.update(action_id, ActionStatus.RETRIABLE, text)
            vehicle.note(f'action {action_id}, {entry.action.action_type}: RETRIABLE {text}')
        else:
            self.end(action_id, ActionStatus.FAILED, text)

    def end(self, action_id: str, status: ActionStatus, text: str) -> None:
        """An action has ended for good; a failed one of the order, for which the vehicle was to
        stand, holds it."""
        vehicle = self._vehicle
        entry = vehicle.actions[action_id]
        if entry.status.has_ended:
            return
        vehicle.actions.update(action_id, status, text)
        vehicle.note(f'action {action_id}, {entry.action.action_type}: {status.value} {text}')
        if vehicle.table.moves(entry.action):
            vehicle.look_where_it_is()
        if status is ActionStatus.FAILED and entry.belongs_to_order and not vehicle.cancelling:
            self._tell_of_failure(entry, text)

    def _tell_of_failure(self, entry: Entry, text: str) -> None:
        action, vehicle = entry.action, self._vehicle
        references = (Reference('topic', 'order'), Reference('orderId', vehicle.order.order_id),
                      Reference('orderUpdateId', str(vehicle.order.order_update_id)),
                      Reference('actionId', action.action_id))
        description = f'action {action.action_type}: {text}'
        if action.blocking_type.forbids_driving:
            vehicle.holds.add(Hold.FAILURE)
            vehicle.errors.fail(Cause.ACTION, e.ACTION_ERROR.error(description, *references))
        else:
            vehicle.errors.reject(e.ACTION_WARNING.error(description, *references))
