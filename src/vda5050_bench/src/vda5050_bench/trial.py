"""The steps that rules use: bring the vehicle back, give it orders, and check its refusals."""
from __future__ import annotations

import json
import math
import uuid
from dataclasses import dataclass, field
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, TypeVar

from vda5050_bench.master import BenchMaster, Message, TooLate
from vda5050_bench.track import Track, action
from vda5050_bench.verdicts import Broken, NotTried, expect
from vda5050_mqtt.own_broker import OwnBroker

ANSWER = 5.0       # s within which a state must follow an event (6.10)
QUIET = 1.0        # s during which the bench checks that a vehicle does nothing forbidden
INTERVAL = 30.0    # s; the longest time between two states (6.10)
AGAIN = 5.0        # s for another attempt to bring a vehicle back after a failed attempt
NEAR = 0.2         # m; a vehicle stands at a node within this distance
REACH = 1000.0     # m; a deviation that includes each position on the track
REJECTIONS = ('validationError', 'orderError', 'orderUpdateError', 'noRouteError')
ENDED = ('FINISHED', 'FAILED')


@dataclass(frozen=True)
class SlowAction:
    """An action of the vehicle that takes some seconds and does no harm."""

    kind: str
    parameters: Mapping[str, Any] = field(default_factory=dict)

    def with_id(self, action_id: str, blocking: str = 'NONE') -> Dict[str, Any]:
        """Returns the action in JSON."""
        return action(self.kind, action_id, blocking, **self.parameters)


T = TypeVar('T')


class Trial:
    """The test of one vehicle.

    track    -- the whole track that the vehicle may drive
    ahead    -- the track, starting at the end at which the vehicle stands
    patience -- s that the drive from one node to the next may take

    The class has one method for each step that rules use.
    """

    def __init__(self, master: BenchMaster, track: Track, patience: float,
                 own_broker: Optional[OwnBroker] = None, slow: Optional[SlowAction] = None) -> None:
        self.master = master
        self.track = self.ahead = track
        self.patience = patience
        self.own_broker = own_broker
        self._slow = slow
        self._was_stuck = False

    def new_id(self) -> str:
        """Returns an id that was not used before."""
        return uuid.uuid4().hex[:12]

    def slow_action(self, blocking: str = 'NONE') -> Dict[str, Any]:
        """Returns the action of --slow-action; raises NotTried if it was not given."""
        if self._slow is None:
            raise NotTried('needs --slow-action')
        return self._slow.with_id(self.new_id(), blocking)

    # --- before a rule ----------------------------------------------------------------------------

    def fetch(self) -> Message:
        """Requests and returns a new state; raises TooLate if none comes within INTERVAL."""
        before = self.master.count()
        self.master.act('stateRequest')
        return self.master.wait(lambda s: True, INTERVAL + 1.0, 'a state', after=before)

    @property
    def deaths(self) -> List[float]:
        """The times (s) at which the broker published the last will of the vehicle."""
        master = self.master
        return [moment for told, moment in zip(master.messages.get('connection', ()),
                                               master.arrivals.get('connection', ()))
                if told.get('connectionState') == 'CONNECTIONBROKEN']

    @property
    def is_dead(self) -> bool:
        """Whether the newest message on `connection` is the last will of the vehicle."""
        moments = self.master.arrivals.get('connection', [])
        return bool(moments) and moments[-1:] == self.deaths[-1:]

    def comes_back(self, states: int) -> bool:
        """Returns whether another state follows the first `states` states within the patience."""
        try:
            self.master.wait(lambda s: True, self.patience, 'a state', after=states)
        except TooLate:
            return False
        return True

    def bring_back(self) -> None:
        """Cancels the order, ends a pause and drives the vehicle to an end of the track.

        Raises TooLate or NotTried.
        """
        patience = AGAIN if self._was_stuck else self.patience
        self._was_stuck = True
        self._become_idle(patience)
        self._drive_to_an_end(patience)
        self._was_stuck = False

    def _become_idle(self, patience: float) -> None:
        master = self.master
        if master.is_3:  # otherwise the vehicle keeps every instant action of the whole run
            master.act('clearInstantActions')
        if not is_idle(self.fetch()):
            master.act('cancelOrder')
            try:
                master.wait(lambda s: not has_order(s), patience, 'no order after cancelOrder')
            except TooLate:
                self._release_the_rest(patience)
        if master.state.get('paused'):
            master.act('stopPause')
            master.wait(lambda s: not s.get('paused'), patience, 'no pause after stopPause')
        try:
            master.wait(is_idle, patience, 'an end of all actions')
        except TooLate:
            return  # the next order shows whether the vehicle still accepts orders

    def _release_the_rest(self, patience: float) -> None:
        """Releases the rest of the order after a failed cancelOrder, so the vehicle can end it."""
        state = self.master.state
        base = [(node['nodeId'], node['sequenceId']) for node in state['nodeStates']
                if node['released']]
        last, sequence = base[-1] if base else (state['lastNodeId'], state['lastNodeSequenceId'])
        ids = [stop.node_id for stop in self.ahead.stops]
        if last not in ids:
            raise NotTried(f'cancelOrder does not end an order to {last!r}')
        if state.get('paused'):
            self.master.act('stopPause')
        self.master.send('order', self.ahead.part(ids.index(last)).order(
            state['orderId'], state['orderUpdateId'] + 1, first_sequence=sequence))
        self.master.wait(lambda s: not has_order(s), patience,
                         'an end of the order, after cancelOrder and an update that releases it')

    def _drive_to_an_end(self, patience: float) -> None:
        state, last = self.master.state, len(self.track.stops) - 1
        index = self._index_of(state)
        is_there = self._is_near(state, index)
        if not (is_there and index in (0, last)):
            self._drive(self._way_from(index, is_there), index, is_there, patience)
            return
        self.ahead = self.track if index == 0 else self.track.reversed()

    def _way_from(self, index: int, is_there: bool) -> Track:
        """Returns the track in the direction in which the vehicle is to drive to an end.

        A vehicle at a stop drives to the nearer end. A vehicle on an edge keeps its direction.
        """
        last, back = len(self.track.stops) - 1, self.track.reversed()
        if index in (0, last):
            return self.track if index == 0 else back
        if is_there:
            return back if index <= last - index else self.track
        return self.ahead

    def _drive(self, way: Track, index: int, is_there: bool, patience: float) -> None:
        self.ahead = way
        rest = way.part(index if way == self.track else len(self.track.stops) - 1 - index)
        self.ordered(rest, start_deviation=0.0 if is_there else REACH)
        self.at_end_of(rest, patience)
        self.ahead = way.reversed()

    def bring_home(self) -> None:
        """Brings the vehicle, without an order, to the start of the track.

        Raises TooLate or NotTried.
        """
        self.bring_back()
        if self.ahead != self.track:
            self._drive(self.ahead, len(self.track.stops) - 1, True, self.patience)

    def _index_of(self, state: Message) -> int:
        """Returns the index of the last stop that the vehicle passed.

        If the state names no stop of the track, returns the index of the nearest stop.
        """
        ids = [stop.node_id for stop in self.track.stops]
        if state['lastNodeId'] in ids:
            return ids.index(state['lastNodeId'])
        distances = [self._distance(state, index) for index in range(len(ids))]
        if None in distances:
            raise NotTried(f'lastNodeId {state["lastNodeId"]!r} is not on the track, and there is '
                           'no agvPosition')
        return distances.index(min(distances, key=lambda found: found or 0.0))

    def _distance(self, state: Message, index: int) -> Optional[float]:
        pose, stop = state.get('agvPosition'), self.track.stops[index]
        return None if not pose else math.hypot(pose['x'] - stop.x, pose['y'] - stop.y)

    def nearest(self, state: Message) -> float:
        """Returns the distance (m) of the nearest stop; raises NotTried without agvPosition."""
        found = [distance for distance in (self._distance(state, index) for index
                                           in range(len(self.track.stops)))
                 if distance is not None]
        if not found:
            raise NotTried('its states have no agvPosition')
        return min(found)

    def _is_near(self, state: Message, index: int) -> bool:
        distance = self._distance(state, index)
        return distance is None or distance <= NEAR

    def clear_rejections(self) -> None:
        """Clears earlier rejections with an order of one node at the vehicle's position."""
        if self.master.state['errors'] and is_idle(self.master.state):
            self.ordered(self.ahead.part(0, 0), ANSWER)
            self.master.wait(is_idle, self.patience, 'an end of an order of one node')

    def needed(self, step: Callable[[], T]) -> T:
        """Does a step that is the subject of another rule; raises NotTried if it fails.

        Thus a fault of the vehicle in this step breaks only that other rule.
        """
        try:
            return step()
        except (Broken, TooLate) as problem:
            raise NotTried(f'a step that this rule needs: {problem}') from None

    # --- orders -----------------------------------------------------------------------------------

    def ordered(self, track: Track, seconds: float = ANSWER, **order: Any) -> str:
        """Sends an order over a track and returns its id; raises NotTried if it is refused."""
        order_id = self.new_id()
        self.accepted(track.order(order_id, **order), seconds)
        return order_id

    def accepted(self, order: Mapping[str, Any], seconds: float = ANSWER) -> Message:
        """Sends an order or update; returns the first state that has it; raises NotTried."""
        return self.needed(lambda: self.taken(order, seconds))

    def taken(self, order: Mapping[str, Any], seconds: float = ANSWER) -> Message:
        """Does the same as `accepted`, for a rule about the acceptance itself.

        Raises TooLate instead of NotTried.
        """
        before = self.master.send('order', order)
        return self.master.wait(lambda s: has(s, order), seconds, 'the order in the state',
                                after=before)

    def at_end_of(self, track: Track, seconds: Optional[float] = None) -> Message:
        """Waits for the state in which the vehicle has driven a track to its end."""
        last = track.stops[-1].node_id
        return self.master.wait(
            lambda s: s['lastNodeId'] == last and not has_order(s), seconds or self.patience,
            f'standing at {last}, without remaining nodes')

    def refused(self, order: Mapping[str, Any], what: str) -> Dict[str, Any]:
        """Sends an order that the vehicle must refuse; returns the error.

        The refusal must not change the orderId or the orderUpdateId.
        """
        return self.refused_bytes(lambda: self.master.send('order', order), what, order)

    def refused_bytes(self, send: Callable[[], int], what: str,
                      order: Optional[Mapping[str, Any]] = None) -> Dict[str, Any]:
        """Does the same as `refused`, for a payload that is not an order."""
        was = self.master.state
        before = send()

        def is_answer(state: Message) -> bool:
            return bool(new_errors(was, state)) or (order is not None and has(state, order))

        try:
            state = self.master.wait(is_answer, ANSWER, 'a new error', after=before)
        except TooLate as error:
            if any(found['errorType'] in REJECTIONS for found in was['errors']):
                raise NotTried(f'{what}: a new error cannot be distinguished from an earlier one'
                               ) from None
            raise Broken(f'{what}: {error}') from None
        if order is not None:
            expect(not has(state, order), f'{what}: it is accepted')
        for key in ('orderId', 'orderUpdateId'):
            expect(state[key] == was[key], f'{what}: {key} changes from {was[key]!r}')
        return new_errors(was, state)[0]

    def stays(self, predicate: Callable[[Message], bool], what: str) -> None:
        """Checks that all states within QUIET, and one that is requested afterwards, satisfy
        `predicate`.

        Raises Broken.
        """
        before = self.master.count()
        try:
            self.master.wait(lambda s: not predicate(s), QUIET, what, after=before)
        except TooLate:
            if predicate(self.fetch()):
                return
        raise Broken(f'it does not stay so: {what}')

    def let_pass(self, seconds: float) -> None:
        """Waits for the given seconds, regardless of the vehicle."""
        try:
            self.master.wait(lambda s: False, seconds, 'nothing')
        except TooLate:
            return

    def close(self) -> None:
        """Closes the connection of the master."""
        self.master.close()


def has(state: Message, order: Mapping[str, Any]) -> bool:
    """Returns whether a state shows that the vehicle has this order or update."""
    return bool(state['orderId'] == order.get('orderId')
                and state['orderUpdateId'] == order.get('orderUpdateId'))


def has_order(state: Message) -> bool:
    """Returns whether nodes or edges remain, or the vehicle drives."""
    return bool(state['nodeStates'] or state['edgeStates'] or state['driving'])


def is_idle(state: Message) -> bool:
    """Returns whether the vehicle may accept a new order: figure 8 (3)."""
    return not has_order(state) and all(found['actionStatus'] in ENDED
                                        for found in state['actionStates'])


def new_errors(was: Message, state: Message) -> List[Dict[str, Any]]:
    """Returns the errors of a state that an earlier state did not have."""
    rest = list(was['errors'])
    found = []
    for error in state['errors']:
        if error in rest:
            rest.remove(error)
        else:
            found.append(error)
    return found


def references(error: Mapping[str, Any]) -> Dict[str, str]:
    """Returns the errorReferences of an error by key."""
    found: Sequence[Mapping[str, Any]] = error.get('errorReferences') or ()
    return {str(item.get('referenceKey')): str(item.get('referenceValue')) for item in found}


def changed(order: Mapping[str, Any], **changes: Any) -> Dict[str, Any]:
    """Returns a changed copy of an order: `nodes__1__released=True` sets nodes[1].released."""
    copy: Dict[str, Any] = json.loads(json.dumps(order))
    for path, value in changes.items():
        *parents, last = [int(part) if part.isdigit() else part for part in path.split('__')]
        target: Any = copy
        for parent in parents:
            target = target[parent]
        target[last] = value
    return copy
