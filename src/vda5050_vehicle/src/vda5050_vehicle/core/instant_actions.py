"""Instant actions: those that every vehicle has, and those in the vehicle's table.

This module executes cancelOrder, startPause, stopPause, stateRequest, factsheetRequest,
initPosition and logReport itself. It queues other actions like the actions of an order.
"""
from __future__ import annotations

from dataclasses import replace
from typing import Callable, Dict, FrozenSet, List, Tuple

from vda5050_protocol import problems as e
from vda5050_protocol.action_queue import MAX_INSTANT_ACTIONS, QueuedAction, Scope
from vda5050_protocol.values import (
    ActionStatus,
    EmergencyStop,
    ErrorReference,
    InstantActions,
    VdaAction,
)
from vda5050_vehicle.core import effects as fx
from vda5050_vehicle.core.action_runner import ActionRunner
from vda5050_vehicle.core.action_table import ActionSpec, Parameter, WrongAction
from vda5050_vehicle.core.context import Context
from vda5050_vehicle.core.inbox import Inbox, MessageRefused
from vda5050_vehicle.core.initial_pose import PoseWish
from vda5050_vehicle.drivers.robot_view import RobotPose

# These actions stop the vehicle or only report. A late copy of any other action is not executed.
STOPPING = frozenset({'cancelOrder', 'startPause'})
HARMLESS_AGAIN = STOPPING | {'stateRequest', 'factsheetRequest', 'logReport',
                             'clearInstantActions'}
# These are executed again even if their actionId is known: some masters use the same id for each
# action of a kind, or start their ids again after a restart.
DONE_AGAIN = frozenset({'stopPause', 'stateRequest', 'factsheetRequest', 'clearInstantActions'})
_INSTANT: FrozenSet[Scope] = frozenset({Scope.INSTANT})

BUILT_IN: Tuple[ActionSpec, ...] = (
    ActionSpec('cancelOrder', 'Stops the robot at once, and ends the order.', _INSTANT,
               parameters=(Parameter('orderId', 'STRING', 'order to cancel', optional=True),)),
    ActionSpec('startPause', 'Stops the robot at once; the order is kept.', _INSTANT),
    ActionSpec('stopPause', 'Drives on after a pause or a failure.', _INSTANT),
    ActionSpec('stateRequest', 'Sends a state.', _INSTANT),
    ActionSpec('factsheetRequest', 'Sends the factsheet.', _INSTANT),
    ActionSpec('initPosition', 'Sets the pose of the robot.', _INSTANT, moves=True, parameters=(
        Parameter('x', 'NUMBER', 'm', least=-1e6, most=1e6),
        Parameter('y', 'NUMBER', 'm', least=-1e6, most=1e6),
        Parameter('theta', 'NUMBER', 'rad', least=-7.0, most=7.0),
        Parameter('mapId', 'STRING', 'the map of x, y and theta'),
        Parameter('lastNodeId', 'STRING', 'the node at this pose', optional=True))),
    ActionSpec('logReport', 'Stores the last events in a file.', _INSTANT,
               result='name of the file', parameters=(
                   Parameter('reason', 'STRING', 'reason', optional=True),)),
)

BUILT_IN_3: Tuple[ActionSpec, ...] = (
    ActionSpec('clearInstantActions', 'Removes the instant actions that have ended.', _INSTANT),
    ActionSpec('retry', 'Retries a RETRIABLE action.', _INSTANT, parameters=(
        Parameter('actionId', 'STRING', 'the action'),)),
    ActionSpec('skipRetry', 'Ends a RETRIABLE action as FAILED.', _INSTANT, parameters=(
        Parameter('actionId', 'STRING', 'the action'),)),
)


class InstantActionHandler:
    """Receives the instant actions of a vehicle, and ends the actions that take time."""

    def __init__(self, context: Context, inbox: Inbox, runner: ActionRunner) -> None:
        self._context = context
        self._state = context.state
        self._inbox = inbox
        self._runner = runner
        self._handlers: Dict[str, Callable[[VdaAction, float], None]] = {
            'cancelOrder': self._cancel_order, 'startPause': self._start_pause,
            'stopPause': self._stop_pause, 'stateRequest': self._request_state,
            'factsheetRequest': self._request_factsheet, 'initPosition': self._init_position,
            'logReport': self._log_report, 'clearInstantActions': self._clear,
            'retry': self._retry, 'skipRetry': self._skip_retry}

    def receive(self, payload: bytes, now: float) -> None:
        """Processes a message on the topic `instantActions`."""
        context, state = self._context, self._state
        context.reporter.answer()
        try:
            message: InstantActions = self._inbox.read('instantActions', payload)
        except MessageRefused as refused:
            state.errors = state.errors.with_refused_action(refused.error)
            return
        is_copy = payload in state.received
        if not is_copy and any(action.action_type not in HARMLESS_AGAIN
                               for action in message.actions):
            state.received = state.received.with_message(payload)
        self._queue(message, is_copy, now)

    def _queue(self, message: InstantActions, is_copy: bool, now: float) -> None:
        state = self._state
        refused: List[Tuple[VdaAction, WrongAction]] = []
        taken = False
        for action in message.actions:
            known = state.actions.by_id.get(action.action_id)
            if known is not None and self._is_done(action, known, is_copy):
                continue  # a repeated action is executed once
            if known is not None and _is_replaceable(action, known):
                state.actions = state.actions.without_action(action.action_id)
                known = None
            self._context.note(f'instant action {action.action_id}, {action.action_type}')
            action = self._with_blocking_type(action)
            try:
                if known is not None:
                    self._do_beside(action, is_copy, now)
                state.actions = state.actions.with_entries(
                    QueuedAction(self._context.table.as_executed(action), Scope.INSTANT))
                self._do(action, is_copy, now)
                taken = True
            except WrongAction as wrong:
                refused.append((action, wrong))
                if known is None:  # the master would repeat an action that no state shows
                    self._end(action.action_id, ActionStatus.FAILED, str(wrong))
        if taken:
            state.errors = replace(state.errors, refused_actions=())
        for action, reason in refused:
            self._report_refusal(action, reason)

    def _is_done(self, action: VdaAction, known: QueuedAction, is_copy: bool) -> bool:
        """Returns whether an action with a known id only repeats the known action.

        A stop with the id of an ended stop is new if the vehicle does not obey such a stop now.
        """
        state, kind = self._state, action.action_type
        if known.belongs_to_order or known.action.action_type != kind:
            return False
        if kind in STOPPING:
            is_obeyed = (not state.busy or state.cancelling) if kind == 'cancelOrder' \
                else state.paused
            return is_obeyed or not known.status.has_ended
        return action.parameters == known.action.parameters and (
            is_copy or not _is_replaceable(action, known))

    def _do_beside(self, action: VdaAction, is_copy: bool, now: float) -> None:
        """Executes a stop although another action has its id; raises WrongAction in all cases.

        The state that is reported under this id remains the state of the other action.
        """
        if action.action_type not in STOPPING:
            raise WrongAction('actionId', 'another action has this id, so this action is not '
                              'executed; send it with a new actionId')
        self._do(replace(action, action_id=''), is_copy, now)
        raise WrongAction('actionId', 'another action has this id; this action is executed, but '
                          'its state is not reported')

    def _do(self, action: VdaAction, is_copy: bool, now: float) -> None:
        """Executes an action or queues it; raises WrongAction."""
        handler = self._handlers.get(action.action_type)
        if handler and action.action_type in STOPPING:  # an unknown parameter does not matter
            handler(action, now)
            return
        spec = self._context.table.check(action, Scope.INSTANT)
        if self._state.actions.instant_actions_under_way > MAX_INSTANT_ACTIONS:
            raise WrongAction('actionId', f'{MAX_INSTANT_ACTIONS} instant actions have not ended; '
                              'wait for the end of one')
        if spec.moves and self._state.busy:
            raise WrongAction('actionType', 'an order is active; cancel it or wait for its end')
        if is_copy and action.action_type not in HARMLESS_AGAIN:
            raise WrongAction('actionId', 'this message is a copy and is not executed again; send '
                              'it with a new header')
        if handler:
            handler(action, now)
        else:
            self._state.actions = self._state.actions.with_triggered(action.action_id)

    def _with_blocking_type(self, action: VdaAction) -> VdaAction:
        """Returns the action with a blocking type that its table entry allows.

        In 3.0 an instant action always has the blocking type NONE. The table has the true type.
        """
        spec = self._context.table.specs.get(action.action_type)
        if not self._context.codec.is_3 or spec is None or action.blocking_type in spec.blocking:
            return action
        return replace(action, blocking_type=spec.blocking[0])

    def _report_refusal(self, action: VdaAction, wrong: WrongAction) -> None:
        self._state.errors = self._state.errors.with_refused_action(e.INSTANT_ACTION_ERROR.error(
            f'action {action.action_type}: {wrong}', ErrorReference('topic', 'instantActions'),
            ErrorReference('actionId', action.action_id),
            ErrorReference('actionParameter', wrong.key)))

    def _end(self, action_id: str, status: ActionStatus, text: str = '') -> None:
        self._context.update_action(action_id, status, text)

    def _run(self, action: VdaAction) -> None:
        self._context.update_action(action.action_id, ActionStatus.RUNNING)

    def _finish(self, action: VdaAction, text: str = '') -> None:
        self._end(action.action_id, ActionStatus.FINISHED, text)

    # --- actions that end at once -----------------------------------------------------------------

    def _request_state(self, action: VdaAction, now: float) -> None:
        self._context.reporter.ask()
        self._finish(action)

    def _request_factsheet(self, action: VdaAction, now: float) -> None:
        self._context.do(fx.SendFactsheet())
        self._finish(action)

    def _log_report(self, action: VdaAction, now: float) -> None:
        self._run(action)
        self._context.do(fx.WriteLog(action.action_id, str(action.arguments.get('reason', '')),
                                     tuple(self._context.history)))

    def _clear(self, action: VdaAction, now: float) -> None:
        self._state.actions = self._state.actions.without_ended_instant_actions()
        self._finish(action)

    def _retry(self, action: VdaAction, now: float) -> None:
        self._context.update_action(self._retriable(action), ActionStatus.INITIALIZING)
        self._finish(action)

    def _skip_retry(self, action: VdaAction, now: float) -> None:
        self._runner.end(self._retriable(action), ActionStatus.FAILED,
                         'the master has decided not to retry the action')
        self._finish(action)

    def _retriable(self, action: VdaAction) -> str:
        """Returns the id of the action that `action` refers to; raises WrongAction."""
        action_id = str(action.arguments['actionId'])
        entry = self._state.actions.by_id.get(action_id)
        if entry is None or entry.status is not ActionStatus.RETRIABLE:
            raise WrongAction('actionId', f'action {action_id!r} is not RETRIABLE')
        return action_id

    def _stop_pause(self, action: VdaAction, now: float) -> None:
        robot = self._context.robot
        if robot.e_stop is not EmergencyStop.NONE:
            raise WrongAction('eStop', 'the emergency stop is not released')
        if robot.pose is None:
            raise WrongAction('errors', robot.lost or 'the robot has not reported yet')
        self._end_pauses(ActionStatus.FAILED, 'stopPause came before the robot stood still')
        self._state.paused = False
        self._context.forgive()
        self._finish(action)

    # --- actions that take time -------------------------------------------------------------------

    def _start_pause(self, action: VdaAction, now: float) -> None:
        self._state.paused = True
        self._state.pauses += (action.action_id,)
        self._run(action)
        self._context.stop(now)

    def _cancel_order(self, action: VdaAction, now: float) -> None:
        state = self._state
        wanted = action.arguments.get('orderId', state.order.order_id)
        if not state.busy or state.order.cancelled or wanted != state.order.order_id:
            self._end(action.action_id, ActionStatus.FAILED, 'there is no order to cancel')
            state.errors = state.errors.with_rejection(e.NO_ORDER_TO_CANCEL.error(
                'there is no order to cancel', ErrorReference('topic', 'instantActions'),
                ErrorReference('actionId', action.action_id)))
            return
        self._run(action)
        first = not state.cancels
        state.cancels += (action.action_id,)
        self._context.stop(now)
        if first:
            self._cancel_actions()

    def _cancel_actions(self) -> None:
        for entry in self._state.actions:
            if not entry.belongs_to_order or entry.status.has_ended:
                continue
            action_id = entry.action.action_id
            if not entry.is_active or entry.status is ActionStatus.RETRIABLE:
                self._end(action_id, ActionStatus.FAILED, 'the order was cancelled')
            elif self._context.is_cancellable(entry):
                self._context.do(fx.CancelAction(action_id))

    def _init_position(self, action: VdaAction, now: float) -> None:
        context, arguments = self._context, action.arguments
        map_id = context.identity.map_id
        if map_id and arguments['mapId'] != map_id:
            raise WrongAction('mapId', f'the vehicle has only map {map_id!r}; use this map')
        pose = RobotPose(float(arguments['x']), float(arguments['y']), float(arguments['theta']))
        last_node = str(arguments.get('lastNodeId', ''))
        if last_node and not context.driver.knows(last_node, pose):
            raise WrongAction('lastNodeId', f'there is no node {last_node[:40]!r}')
        if self._state.wish is not None:
            self._end(self._state.wish.action_id, ActionStatus.FAILED, 'another initPosition came')
        self._state.wish = PoseWish.told(action.action_id, pose, last_node, context.robot.pose,
                                         now)
        self._run(action)
        context.do(fx.SetPose(pose))

    def end_completed(self, now: float) -> None:
        """Ends cancellations, pauses and initPosition if their conditions are met."""
        context, state = self._context, self._state
        if (state.cancels and context.is_known_to_stand and state.actions.order_has_ended):
            state.order = state.order.emptied()
            state.legs = ()
            context.forgive()
            for action_id in state.cancels:
                self._end(action_id, ActionStatus.FINISHED)
            state.cancels = ()
        if context.is_known_to_stand:
            self._end_pauses(ActionStatus.FINISHED)
        if state.wish is not None:
            self._judge_pose(state.wish, now)

    def _end_pauses(self, status: ActionStatus, text: str = '') -> None:
        for action_id in self._state.pauses:
            self._end(action_id, status, text)
        self._state.pauses = ()

    def _judge_pose(self, wish: PoseWish, now: float) -> None:
        if wish.is_taken(self._context.robot):
            self._end(wish.action_id, ActionStatus.FINISHED)
            self._context.update_last_node()
            self._context.place_at(wish.last_node)
        elif now > wish.until:
            self._end(wish.action_id, ActionStatus.FAILED, 'the robot has not taken the pose')
        else:
            return
        self._state.wish = None

    def restart(self) -> None:
        """Ends the started actions and the instant actions as failed, because of a restart.

        Stops continue.
        """
        kept = {*self._state.cancels, *self._state.pauses}
        for entry in self._state.actions:
            was_started = entry.is_active or entry.status is ActionStatus.INITIALIZING
            if entry.action.action_id not in kept and (
                    was_started or not entry.belongs_to_order and not entry.status.has_ended):
                self._runner.fail(entry.action.action_id, 'the adapter was restarted and does not '
                                                          'repeat the action by itself')
        self._state.wish = None


def _is_replaceable(action: VdaAction, known: QueuedAction) -> bool:
    """Returns whether the action replaces an ended action with the same id."""
    return (action.action_type in DONE_AGAIN and not known.belongs_to_order
            and known.status.has_ended)
