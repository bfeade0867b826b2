"""Checks every message of a vehicle for errors that the JSON schemas do not find.

The checker receives JSON and returns sentences about broken rules. Section numbers are those of
VDA 5050 2.1.0. A strange but permitted message causes a remark.
"""
from __future__ import annotations

import json
import math
import re
from typing import Any, Callable, Dict, Iterator, List, Mapping, Optional, Sequence, Tuple

from vda5050_bench.version_3 import in_2

_TIMESTAMP = re.compile(r'\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{2,9}Z')
_ENDED = ('FINISHED', 'FAILED')

# Figure 16: the statuses that may follow a status. A vehicle may skip a short status.
_FOLLOWING: Mapping[str, Sequence[str]] = {
    'WAITING': ('INITIALIZING', 'RUNNING', 'PAUSED', 'RETRIABLE', 'FINISHED', 'FAILED'),
    'INITIALIZING': ('RUNNING', 'PAUSED', 'RETRIABLE', 'FINISHED', 'FAILED'),
    'RUNNING': ('PAUSED', 'RETRIABLE', 'FINISHED', 'FAILED'),
    'RETRIABLE': ('INITIALIZING', 'RUNNING', 'FINISHED', 'FAILED'),  # of 3.0
    'PAUSED': ('INITIALIZING', 'RUNNING', 'FINISHED', 'FAILED'),
    'FINISHED': (), 'FAILED': ()}
_NEEDED = ('orderId', 'orderUpdateId', 'lastNodeId', 'lastNodeSequenceId', 'nodeStates',
           'edgeStates', 'driving', 'actionStates', 'batteryState', 'operatingMode', 'errors',
           'safetyState')
_STATE_KEYS = frozenset((
    'headerId', 'timestamp', 'version', 'manufacturer', 'serialNumber', 'maps', 'orderId',
    'orderUpdateId', 'zoneSetId', 'lastNodeId', 'lastNodeSequenceId', 'driving', 'paused',
    'newBaseRequest', 'distanceSinceLastNode', 'operatingMode', 'nodeStates', 'edgeStates',
    'agvPosition', 'velocity', 'loads', 'actionStates', 'batteryState', 'errors', 'information',
    'safetyState'))

State = Dict[str, Any]


class VehicleChecker:
    """Checks the messages of one vehicle.

    violations -- broken rules; each sentence is listed once
    remarks    -- strange but permitted messages; each sentence is listed once
    """

    def __init__(self, manufacturer: str, serial_number: str, version: str = '2.1.0') -> None:
        self._is_3 = version.startswith('3.')
        self._is_2_0 = version.startswith('2.0')
        self._identity = {'manufacturer': manufacturer, 'serialNumber': serial_number}
        self._last: Dict[str, Dict[str, Any]] = {}
        self._restarted: Dict[str, bool] = {}
        self._lost: Dict[str, bool] = {}
        self.violations: List[str] = []
        self.remarks: List[str] = []
        self.messages = 0

    def feed(self, topic: str, payload: bytes) -> Optional[Dict[str, Any]]:
        """Checks a message; returns its JSON object with the keys of 2.1, or None if malformed."""
        self.messages += 1
        message = self._read(topic, payload)
        if message is None:
            return None
        last = self._last.get(topic)
        if topic == 'connection' and last and last.get('connectionState') == 'CONNECTIONBROKEN':
            self._last = {}  # a vehicle that has died may come back as a new program
            last = None
        for problem in self._header_problems(topic, message, last):
            self._violate(topic, problem)
        if topic in ('state', 'visualization'):
            self._apply(topic, pose_problems, message)
        if topic == 'state':
            self._check_state(topic, message, last)
            self._remark(topic, message, last)
        self._last[topic] = message
        return message

    def _read(self, topic: str, payload: bytes) -> Optional[State]:
        """Returns the JSON object of a message with the keys of 2.1, or None if malformed."""
        try:
            message = json.loads(payload.decode('utf-8'), parse_constant=_refuse)
        except (ValueError, RecursionError) as error:
            self._violate(topic, f'not JSON in UTF-8: {error}')
            return None
        if not isinstance(message, dict):
            self._violate(topic, 'not a JSON object')
            return None
        return in_2(topic, message) if self._is_3 else message

    def _check_state(self, topic: str, state: State, last: Optional[State]) -> None:
        missing = [key for key in _NEEDED if key not in state]
        if missing:
            self._violate(topic, f'there is no {", ".join(missing)} (6.10.6)')
            return
        self._apply(topic, state_problems, state)
        if last and 'nodeStates' in last:
            if not self._is_2_0:
                self._apply(topic, order_problems, last, state)
            self._apply(topic, step_problems, last, state)

    def restarted(self) -> None:
        """Permits header ids to begin anew, because the vehicle's program was restarted."""
        self._restarted = dict.fromkeys(self._last, True)

    def broker_lost(self) -> None:
        """Permits one gap in the header ids, because the broker died and lost messages (QoS 0)."""
        self._lost = dict.fromkeys(self._last, True)

    def _apply(self, topic: str, problems: Callable[..., Iterator[str]], *states: State) -> None:
        try:
            for problem in problems(*states):
                self._violate(topic, problem)
        except (AttributeError, KeyError, TypeError, ValueError) as error:
            self._violate(topic, f'a field is missing or has another type: {error!r} (6.10.6)')

    def _remark(self, topic: str, state: State, last: Optional[State]) -> None:
        unknown = sorted(set(state) - _STATE_KEYS)
        stamps = [message.get('timestamp') for message in (last or state, state)]
        remarks = [f'{topic}: keys that are not in the standard: {unknown}'] if unknown else []
        if all(isinstance(stamp, str) for stamp in stamps) and stamps != sorted(map(str, stamps)):
            remarks.append(f'{topic}: timestamp goes back')
        self.remarks += [remark for remark in remarks if remark not in self.remarks]

    def _violate(self, topic: str, problem: str) -> None:
        text = f'{topic}: {problem}'
        if text not in self.violations:
            self.violations.append(text)

    def _header_problems(self, topic: str, message: State, last: Optional[State],
                         ) -> Iterator[str]:
        for key, value in self._identity.items():
            if message.get(key) != value:
                yield f'{key} is {message.get(key)!r}, not {value!r}'
        stamp, header_id = message.get('timestamp'), message.get('headerId')
        if not isinstance(stamp, str) or not _TIMESTAMP.fullmatch(stamp):
            yield f'timestamp {stamp!r} is not YYYY-MM-DDTHH:mm:ss.ffZ (6.4)'
        will = message.get('connectionState') == 'CONNECTIONBROKEN'  # a last will has an old header
        if last is None or will or last.get('connectionState') == 'CONNECTIONBROKEN':
            return
        before = last.get('headerId')
        if not isinstance(header_id, int) or not isinstance(before, int):
            yield f'headerId {header_id!r} is not a uint32 (6.4)'
            return
        expected = before + 1
        if header_id != expected and not self._restarted.pop(topic, False) and not (
                header_id > expected and self._lost.pop(topic, False)):
            yield 'headerId does not count by one (6.4)'


def pose_problems(message: State) -> Iterator[str]:
    """Yields the errors in the pose of a state or a visualization."""
    pose = message.get('agvPosition')
    if pose and not -math.pi <= pose['theta'] <= math.pi:
        yield f'theta {pose["theta"]!r} is not within [-Pi ... Pi] (6.10.6)'


def state_problems(state: State) -> Iterator[str]:
    """Yields the errors in a single state."""
    yield from _sequence_problems(state)
    action_ids = [action['actionId'] for action in state['actionStates']]
    if len(action_ids) != len(set(action_ids)):
        yield 'an action is in actionStates twice (6.11)'
    if not 0.0 <= state['batteryState']['batteryCharge'] <= 100.0:
        yield 'batteryCharge is not a percentage (6.10.6)'


def _sequence_problems(state: State) -> Iterator[str]:
    elements = _elements(state)
    ids = [element['sequenceId'] for element in elements]
    if ids and (ids != list(range(ids[0], ids[0] + len(ids))) or 'nodeId' not in elements[-1]):
        yield f'sequenceIds of edges and nodes are {ids}: they have gaps (6.6.2)'
    kinds = ['nodeId' in element for element in elements]
    if any(one == other for one, other in zip(kinds, kinds[1:])):
        yield 'nodes and edges do not alternate in sequenceId (6.6.2)'
    # The first node may be listed until the vehicle counts it as traversed (6.10.2).
    if ids and not kinds[0] and state['lastNodeSequenceId'] != ids[0] - 1:
        yield 'lastNodeSequenceId is not the sequenceId before the first edge (6.10.2)'
    released = [element['released'] for element in elements]
    if released != sorted(released, reverse=True):
        yield 'a released element follows an element that is not released (6.6.1)'


def order_problems(before: State, after: State) -> Iterator[str]:
    """Yields the errors in a change of the orderId; figure 8 of 2.0 is ambiguous about it."""
    if before['orderId'] != after['orderId'] and before['nodeStates']:
        yield 'orderId changes while nodeStates remain (figure 8)'


def step_problems(before: State, after: State) -> Iterator[str]:
    """Yields the errors in a state compared to the previous state."""
    same_order = before['orderId'] == after['orderId']
    if same_order:
        if after['orderUpdateId'] < before['orderUpdateId']:
            yield 'orderUpdateId decreases'
        yield from _element_problems(before, after)
    yield from _action_problems(before, after, same_order)


def _element_problems(before: State, after: State) -> Iterator[str]:
    same_update = before['orderUpdateId'] == after['orderUpdateId']
    old = _keys(before, only_base=not same_update)
    new = _keys(after)
    if not new:  # driven to the end, or cancelled
        return
    left = [old[passed:] for passed in range(len(old) + 1)]
    if same_update:
        if new not in left:
            yield 'nodeStates and edgeStates do more than shrink without an update (6.10.1)'
    elif not any(new[:len(rest)] == rest for rest in left):
        yield 'the base changes (6.6.2)'


def _elements(state: State) -> List[State]:
    return sorted([*state['nodeStates'], *state['edgeStates']], key=_sequence_id)


def _sequence_id(element: State) -> int:
    return int(element['sequenceId'])


def _keys(state: State, only_base: bool = False) -> List[Tuple[str, int, bool]]:
    return [(element.get('edgeId', element.get('nodeId')), element['sequenceId'],
             element['released'])
            for element in _elements(state) if element['released'] or not only_base]


def _action_problems(before: State, after: State, same_order: bool) -> Iterator[str]:
    statuses = {action['actionId']: action['actionStatus'] for action in after['actionStates']}
    for action in before['actionStates']:
        name, was, now = action['actionId'], action['actionStatus'], None
        now = statuses.get(action['actionId'])
        if now is None:
            replaced = after['orderUpdateId'] != before['orderUpdateId'] and was == 'WAITING'
            if same_order and not replaced and was not in _ENDED:
                yield f'action {name} disappears before it has ended (6.10.6)'
        elif now != was and now not in _FOLLOWING.get(was, ()):
            yield f'action {name} was {was} and is {now} (figure 16)'


def _refuse(constant: str) -> None:
    raise ValueError(f'{constant} is not a JSON number')
