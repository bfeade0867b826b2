"""Runs the actions of orders and the instant actions: each action ends exactly once."""
from __future__ import annotations

from dataclasses import replace

from vda5050_protocol import problems as e
from vda5050_protocol.action_queue import QueuedAction
from vda5050_protocol.values import ActionStatus, ErrorReference, OrderEdge
from vda5050_vehicle.core import effects as fx
from vda5050_vehicle.core.action_table import WrongAction
from vda5050_vehicle.core.context import Context

AWAY = 'the adapter was not running when the action was due'


class ActionRunner:
    """Runs actions for a vehicle."""

    def __init__(self, context: Context) -> None:
        self._context = context
        self._state = context.state

    def start(self) -> None:
        """Starts the actions that are due."""
        context = self._context
        if self._state.paused or self._state.cancelling:
            return
        for entry in self._state.actions.startable(context.standing):
            action_id, scope = entry.action.action_id, entry.scope
            try:
                spec = context.table.check(entry.action, scope)
                if spec.call is None:
                    raise WrongAction('actionType', 'it is an instant action only')
            except WrongAction as wrong:
                self.end(action_id, ActionStatus.FAILED, str(wrong))
                continue
            context.update_action(action_id, ActionStatus.RUNNING)
            context.do(fx.StartAction(action_id, spec, spec.with_defaults(entry.action.arguments)))

    def leave_edge(self, edge: OrderEdge) -> None:
        """Ends the actions of an edge that the robot has left."""
        for entry in self._state.actions.of(edge.sequence_id):
            action_id = entry.action.action_id
            if entry.status is ActionStatus.RETRIABLE:
                self.end(action_id, ActionStatus.FAILED, 'the edge was left before it was retried')
            elif entry.is_active:
                self._context.do(fx.CancelAction(action_id))
                self.end(action_id, ActionStatus.FINISHED, 'the edge was left')
            elif not entry.status.has_ended:
                self.end(action_id, ActionStatus.FAILED,
                         'the edge was left before the action could start')

    def miss(self, sequence_id: int) -> None:
        """Fails the actions of a node that was passed while the adapter was not running."""
        for entry in self._state.actions.of(sequence_id):
            self.end(entry.action.action_id, ActionStatus.FAILED, AWAY)

    def fail(self, action_id: str, text: str) -> None:
        """Ends a failed action; a retriable action waits for the decision of the master."""
        entry = self._state.actions[action_id]
        if entry.action.retriable and entry.belongs_to_order and not self._state.cancelling:
            self._context.update_action(action_id, ActionStatus.RETRIABLE, text)
            self._note(entry, ActionStatus.RETRIABLE, text)
        else:
            self.end(action_id, ActionStatus.FAILED, text)

    def end(self, action_id: str, status: ActionStatus, text: str) -> None:
        """Ends an action for good.

        If a failed action of the order forbids driving, the vehicle does not drive on.
        """
        entry = self._state.actions[action_id]
        if entry.status.has_ended:
            return
        self._context.update_action(action_id, status, text)
        self._note(entry, status, text)
        if self._context.table.moves(entry.action):
            self._context.update_last_node()
        if (status is ActionStatus.FAILED and entry.belongs_to_order
                and not self._state.cancelling):
            self._report_failure(entry, text)

    def _note(self, entry: QueuedAction, status: ActionStatus, text: str) -> None:
        self._context.note(f'action {entry.action.action_id}, {entry.action.action_type}: '
                           f'{status.value} {text}')

    def _report_failure(self, entry: QueuedAction, text: str) -> None:
        action, state = entry.action, self._state
        references = (ErrorReference('topic', 'order'),
                      ErrorReference('orderId', state.order.order_id),
                      ErrorReference('orderUpdateId', str(state.order.order_update_id)),
                      ErrorReference('actionId', action.action_id))
        description = f'action {action.action_type}: {text}'
        if action.blocking_type.forbids_driving:
            state.errors = replace(state.errors,
                                   action=e.ACTION_ERROR.error(description, *references))
        else:
            state.errors = state.errors.with_rejection(
                e.ACTION_WARNING.error(description, *references))
