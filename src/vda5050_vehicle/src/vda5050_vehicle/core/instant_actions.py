"""Instant actions: those that every vehicle has, and those of its table.

cancelOrder, startPause, stopPause, stateRequest, factsheetRequest, initPosition and logReport are
done here; others are queued like the actions of an order.
"""
from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Callable, Dict, FrozenSet, List, Optional, Tuple

from vda5050_vehicle.core import effects as fx
from vda5050_vehicle.core.action_table import ActionSpec, Parameter, WrongAction
from vda5050_vehicle.core.inbox import Inbox, Refused
from vda5050_vehicle.core.initial_pose import PoseWish
from vda5050_vehicle.drivers.driver import Pose
from vda5050_vehicle.protocol import problems as e
from vda5050_vehicle.protocol.action_queue import Scope
from vda5050_vehicle.protocol.values import Action, ActionStatus, EStop, InstantActions, Reference

if TYPE_CHECKING:
    from vda5050_vehicle.core.vehicle import Vehicle

# They stop or tell; a late copy of any other one is not done again.
STOPPING = frozenset({'cancelOrder', 'startPause'})
HARMLESS_AGAIN = STOPPING | {'stateRequest', 'factsheetRequest', 'logReport',
                             'clearInstantActions'}
_INSTANT: FrozenSet[Scope] = frozenset({Scope.INSTANT})

BUILT_IN: Tuple[ActionSpec, ...] = (
    ActionSpec('cancelOrder', 'Stops where the robot is, and ends the order.', _INSTANT,
               parameters=(Parameter('orderId', 'STRING', 'the order meant', optional=True),)),
    ActionSpec('startPause', 'Stops where the robot is; the order is kept.', _INSTANT),
    ActionSpec('stopPause', 'Drives on after a pause or a failure.', _INSTANT),
    ActionSpec('stateRequest', 'Sends a state.', _INSTANT),
    ActionSpec('factsheetRequest', 'Sends the factsheet.', _INSTANT),
    ActionSpec('initPosition', 'Tells the robot where it is.', _INSTANT, moves=True, parameters=(
        Parameter('x', 'NUMBER', 'm', least=-1e6, most=1e6),
        Parameter('y', 'NUMBER', 'm', least=-1e6, most=1e6),
        Parameter('theta', 'NUMBER', 'rad', least=-7.0, most=7.0),
        Parameter('mapId', 'STRING', 'the map of x, y and theta'),
        Parameter('lastNodeId', 'STRING', 'the node there', optional=True))),
    ActionSpec('logReport', 'Stores what happened last in a file.', _INSTANT,
               result='name of the file', parameters=(
                   Parameter('reason', 'STRING', 'why', optional=True),)),
)

BUILT_IN_3: Tuple[ActionSpec, ...] = (
    ActionSpec('clearInstantActions', 'Forgets the instant actions that have ended.', _INSTANT),
    ActionSpec('retry', 'Tries an action again that is RETRIABLE.', _INSTANT, parameters=(
        Parameter('actionId', 'STRING', 'the action'),)),
    ActionSpec('skipRetry', 'Ends an action as FAILED that is RETRIABLE.', _INSTANT, parameters=(
        Parameter('actionId', 'STRING', 'the action'),)),
)


class InstantActionHandler:
    """Takes instant actions for a vehicle, and brings those that take time to their end."""

    def __init__(self, vehicle: Vehicle, inbox: Inbox) -> None:
        self._vehicle = vehicle
        self._inbox = inbox
        self._cancels: List[str] = []          # ids of cancelOrder under way
        self._pauses: List[str] = []           # and of startPause
        self._wish: Optional[PoseWish] = None
        self._handlers: Dict[str, Callable[[Action, float], None]] = {
            'cancelOrder': self._cancel_order, 'startPause': self._start_pause,
            'stopPause': self._stop_pause, 'stateRequest': self._request_state,
            'factsheetRequest': self._request_factsheet, 'initPosition': self._init_position,
            'logReport': self._log_report, 'clearInstantActions': self._clear,
            'retry': self._retry, 'skipRetry': self._skip_retry}

    @property
    def cancelling(self) -> bool:
        """Whether an order is being cancelled."""
        return bool(self._cancels)

    def receive(self, payload: bytes, now: float) -> None:
        """A message on the topic `instantActions`."""
        vehicle = self._vehicle
        vehicle.reporter.ask()
        try:
            message: InstantActions = self._inbox.read('instantActions', payload)
        except Refused as refused:
            vehicle.errors.refuse_action(refused.error)
            return
        is_copy = payload in vehicle.received
        if not is_copy and any(action.action_type not in HARMLESS_AGAIN
                               for action in message.actions):
            vehicle.received.add(payload)
        self._take(message, is_copy, now)

    def _take(self, message: InstantActions, is_copy: bool, now: float) -> None:
        vehicle = self._vehicle
        new = [action for action in message.actions
               if action.action_id not in vehicle.actions]  # one that is sent again is done once
        refused: List[Tuple[Action, WrongAction]] = []
        for action in new:
            vehicle.note(f'instant action {action.action_id}, {action.action_type}')
            action = self._with_blocking_type(action)
            vehicle.actions.add((vehicle.table.as_executed(action),), Scope.INSTANT)
            try:
                self._do(action, is_copy, now)
            except WrongAction as wrong:
                refused.append((action, wrong))
        if len(refused) < len(new):
            vehicle.errors.instant_action_taken()
        for action, reason in refused:
            self._fail(action, reason)

    def _do(self, action: Action, is_copy: bool, now: float) -> None:
        """Does an action, or queues it. Raises WrongAction."""
        handler = self._handlers.get(action.action_type)
        if handler and action.action_type in STOPPING:  # never refused for a parameter too many
            handler(action, now)
            return
        spec = self._vehicle.table.check(action, Scope.INSTANT)
        if spec.moves and self._vehicle.busy:
            raise WrongAction('actionType', 'an order is under way')
        if is_copy and action.action_type not in HARMLESS_AGAIN:
            raise WrongAction('actionId', 'this message came before, and is not done '
                              'again; another one has a header of its own')
        if handler:
            handler(action, now)
        else:
            self._vehicle.actions.trigger(action.action_id)

    def _with_blocking_type(self, action: Action) -> Action:
        """In 3.0 it is always NONE; what the vehicle must not do meanwhile is in its table."""
        spec = self._vehicle.table.specs.get(action.action_type)
        if not self._vehicle.codec.is_3 or spec is None or action.blocking_type in spec.blocking:
            return action
        return replace(action, blocking_type=spec.blocking[0])

    def _fail(self, action: Action, wrong: WrongAction) -> None:
        """An action that cannot be done is told as FAILED: a master repeats what is ignored."""
        self._end(action.action_id, ActionStatus.FAILED, str(wrong))
        self._vehicle.errors.refuse_action(e.INSTANT_ACTION_ERROR.error(
            f'action {action.action_type}: {wrong}', Reference('topic', 'instantActions'),
            Reference('actionId', action.action_id), Reference('actionParameter', wrong.key)))

    def _end(self, action_id: str, status: ActionStatus, text: str = '') -> None:
        self._vehicle.actions.update(action_id, status, text)

    def _finish(self, action: Action, text: str = '') -> None:
        self._end(action.action_id, ActionStatus.FINISHED, text)

    # --- those that are done at once --------------------------------------------------------------

    def _request_state(self, action: Action, now: float) -> None:
        self._vehicle.reporter.ask()
        self._finish(action)

    def _request_factsheet(self, action: Action, now: float) -> None:
        self._vehicle.do(fx.SendFactsheet())
        self._finish(action)

    def _log_report(self, action: Action, now: float) -> None:
        self._vehicle.actions.update(action.action_id, ActionStatus.RUNNING)
        self._vehicle.do(fx.WriteLog(action.action_id, str(action.arguments.get('reason', '')),
                                     tuple(self._vehicle.history)))

    def _clear(self, action: Action, now: float) -> None:
        self._vehicle.actions.clear_instant_actions()
        self._finish(action)

    def _retry(self, action: Action, now: float) -> None:
        self._vehicle.actions.update(self._retriable(action), ActionStatus.INITIALIZING)
        self._finish(action)

    def _skip_retry(self, action: Action, now: float) -> None:
        self._vehicle.runner.end(self._retriable(action), ActionStatus.FAILED,
                                 'the master does not want it tried again')
        self._finish(action)

    def _retriable(self, action: Action) -> str:
        """Id of the action that is meant."""
        action_id = str(action.arguments['actionId'])
        actions = self._vehicle.actions
        if action_id not in actions or actions[action_id].status is not ActionStatus.RETRIABLE:
            raise WrongAction('actionId', f'action {action_id!r} is not RETRIABLE')
        return action_id

    def _stop_pause(self, action: Action, now: float) -> None:
        robot = self._vehicle.robot
        if robot.e_stop is not EStop.NONE:
            raise WrongAction('eStop', 'the emergency stop is not released')
        if robot.pose is None:
            raise WrongAction('errors', robot.lost or 'nothing was heard of the robot yet')
        for action_id in self._pauses:
            self._end(action_id, ActionStatus.FAILED, 'stopPause came before the robot stood')
        self._pauses.clear()
        self._vehicle.resume()
        self._finish(action)

    # --- those that take time ---------------------------------------------------------------------

    def _start_pause(self, action: Action, now: float) -> None:
        self._vehicle.pause()
        self._pauses.append(action.action_id)
        self._vehicle.actions.update(action.action_id, ActionStatus.RUNNING)

    def _cancel_order(self, action: Action, now: float) -> None:
        vehicle = self._vehicle
        wanted = action.arguments.get('orderId', vehicle.order.order_id)
        if not vehicle.busy or vehicle.order.cancelled or wanted != vehicle.order.order_id:
            self._end(action.action_id, ActionStatus.FAILED, 'there is no order to cancel')
            vehicle.errors.reject(e.NO_ORDER_TO_CANCEL.error(
                'there is no order to cancel', Reference('topic', 'instantActions'),
                Reference('actionId', action.action_id)))
            return
        vehicle.actions.update(action.action_id, ActionStatus.RUNNING)
        first = not self._cancels
        self._cancels.append(action.action_id)
        if first:
            self._cancel_actions()

    def _cancel_actions(self) -> None:
        vehicle = self._vehicle
        for entry in vehicle.actions.entries:
            if not entry.belongs_to_order or entry.status.has_ended:
                continue
            action_id = entry.action.action_id
            if not entry.is_active or entry.status is ActionStatus.RETRIABLE:
                self._end(action_id, ActionStatus.FAILED, 'the order was cancelled')
            elif vehicle.table.specs[entry.action.action_type].cancellable:
                vehicle.do(fx.CancelAction(action_id))

    def _init_position(self, action: Action, now: float) -> None:
        vehicle, arguments = self._vehicle, action.arguments
        map_id = vehicle.identity.map_id
        if map_id and arguments['mapId'] != map_id:
            raise WrongAction('mapId', f'the vehicle has map {map_id!r} only')
        pose = Pose(float(arguments['x']), float(arguments['y']), float(arguments['theta']))
        last_node = str(arguments.get('lastNodeId', ''))
        if last_node and not vehicle.driver.knows(last_node, pose):
            raise WrongAction('lastNodeId', f'there is no node {last_node[:40]!r}')
        if self._wish is not None:
            self._end(self._wish.action_id, ActionStatus.FAILED, 'another initPosition came')
        self._wish = PoseWish.told(action.action_id, pose, last_node, vehicle.robot.pose, now)
        vehicle.actions.update(action.action_id, ActionStatus.RUNNING)
        vehicle.do(fx.SetPose(pose))

    def go_on(self, now: float) -> None:
        """Ends what has come to its end."""
        vehicle = self._vehicle
        if self._cancels and vehicle.standing and vehicle.actions.order_has_ended:
            vehicle.end_order()
            for action_id in self._cancels:
                self._end(action_id, ActionStatus.FINISHED)
            self._cancels.clear()
        if self._pauses and vehicle.standing:
            for action_id in self._pauses:
                self._end(action_id, ActionStatus.FINISHED)
            self._pauses.clear()
        if self._wish is not None:
            self._look_at_pose(self._wish, now)

    def _look_at_pose(self, wish: PoseWish, now: float) -> None:
        if wish.is_taken(self._vehicle.robot):
            self._end(wish.action_id, ActionStatus.FINISHED)
            self._vehicle.look_where_it_is()
            self._vehicle.place_at(wish.last_node)
        elif now > wish.until:
            self._end(wish.action_id, ActionStatus.FAILED, 'the robot does not take the pose')
        else:
            return
        self._wish = None
