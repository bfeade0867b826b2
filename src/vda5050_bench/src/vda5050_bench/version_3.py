"""Converts messages between VDA 5050 3.0 and 2.1, so that the bench needs only one set of rules.

Input and output are JSON. A converted state does not have the fields that only 3.0 has. A message
that does not conform to the standard is not converted, so that the checker finds its errors.
"""
from __future__ import annotations

from typing import Any, Callable, Dict, Iterator, Mapping

Json = Dict[str, Any]

_ONLY_IN_3 = ('zoneSets', 'plannedPath', 'intermediatePath', 'zoneRequests', 'edgeRequests',
              'instantActionStates', 'zoneActionStates')
_STATE_KEYS = {'mobileRobotPosition': 'agvPosition', 'powerSupply': 'batteryState'}
_POSITION_KEYS = {'localized': 'positionInitialized'}
_BATTERY_KEYS = {'stateOfCharge': 'batteryCharge'}
_SAFETY_KEYS = {'activeEmergencyStop': 'eStop'}
_LEVELS = {'URGENT': 'WARNING', 'CRITICAL': 'FATAL'}
_REFUSED_FIELD = 'UNSUPPORTED_PARAMETER'  # CRITICAL in 3.0, a WARNING in 2.x
_ERRORS = {
    'VALIDATION_FAILURE': 'validationError', 'NO_ORDER_TO_CANCEL': 'noOrderToCancel',
    'OTHER_ORDER_ACTIVE': 'orderError', 'INVALID_ORDER_ACTION': 'orderError',
    'INVALID_ORDER': 'orderError', 'UNKNOWN_MAP_ID': 'orderError', _REFUSED_FIELD: 'orderError',
    'OUTDATED_ORDER_UPDATE': 'orderUpdateError', 'SAME_ORDER_UPDATE_ID': 'orderUpdateError',
    'ORDER_UPDATE_FOLLOWING_CANCEL': 'orderUpdateError',
    'INVALID_ORDER_UPDATE': 'orderUpdateError', 'NO_ROUTE_TO_TARGET': 'noRouteError',
    'START_NODE_OUT_OF_RANGE': 'noRouteError'}
_ACTIONS = {'initializePosition': 'initPosition'}
_EDGE_ENDS = ('startNodeId', 'endNodeId')  # 3.0: they follow from the sequenceId (6.1.1, 7.3)


def in_2(topic: str, message: Json) -> Json:
    """Converts a message of a vehicle from 3.0 to 2.1."""
    translate = _TO_2.get(topic)
    try:
        return translate(message) if translate else message
    except (AttributeError, KeyError, TypeError):
        return message


def in_3(topic: str, body: Mapping[str, Any]) -> Mapping[str, Any]:
    """Converts a message of a master, without header, from 2.1 to 3.0."""
    if topic == 'instantActions':
        return {**body, 'actions': [_action_in_3(action) for action in body['actions']]}
    elements = {'nodes': _node_in_3, 'edges': _edge_in_3}
    return {key: [elements[key](item) for item in value]
            if key in elements and isinstance(value, list) else value
            for key, value in body.items()}


def _renamed(value: Json, keys: Mapping[str, str]) -> Json:
    return {keys.get(key, key): item for key, item in value.items()}


def _state(state: Json) -> Json:
    found = _renamed(state, _STATE_KEYS)
    for key, keys in (('agvPosition', _POSITION_KEYS), ('batteryState', _BATTERY_KEYS),
                      ('safetyState', _SAFETY_KEYS)):
        if key in found:
            found[key] = _renamed(found[key], keys)
    found['actionStates'] = [
        {**action, 'actionType': _ACTIONS.get(action['actionType'], action['actionType'])}
        for action in _all_actions(state)]
    found['errors'] = [_error(error) for error in state['errors']]
    return {key: value for key, value in found.items() if key not in _ONLY_IN_3}


def _all_actions(state: Json) -> Iterator[Json]:
    yield from state['actionStates']
    yield from state['instantActionStates']


def _error(error: Json) -> Json:
    kind, level = error['errorType'], error['errorLevel']
    return {**error, 'errorType': _ERRORS.get(kind, kind), 'typeOf3': kind,
            'errorLevel': 'WARNING' if kind == _REFUSED_FIELD else _LEVELS.get(level, level)}


def _connection(connection: Json) -> Json:
    state = connection['connectionState']
    return {**connection, 'connectionState': 'CONNECTIONBROKEN' if state == 'CONNECTION_BROKEN'
            else state}


def _factsheet(factsheet: Json) -> Json:
    features = _renamed(factsheet['protocolFeatures'], {'mobileRobotActions': 'agvActions'})
    return {**factsheet, 'protocolFeatures': features}


_TO_2: Mapping[str, Callable[[Json], Json]] = {
    'state': _state, 'connection': _connection, 'factsheet': _factsheet}


def _action_in_3(action: Json) -> Json:
    """Converts an action to 3.0, in which instant actions never block."""
    names = {old: new for new, old in _ACTIONS.items()}
    kind = action['actionType']
    return {**action, 'actionType': names.get(kind, kind), 'blockingType': 'NONE'}


def _edge_in_3(edge: Any) -> Any:
    if not isinstance(edge, dict):
        return edge
    return {key: value for key, value in edge.items() if key not in _EDGE_ENDS}


def _node_in_3(node: Any) -> Any:
    position = node.get('nodePosition') if isinstance(node, dict) else None
    if not isinstance(position, dict) or 'allowedDeviationXY' not in position:
        return node
    radius = position['allowedDeviationXY']
    if not isinstance(radius, (int, float)):
        return node
    ellipse = {'a': radius, 'b': radius, 'theta': 0.0}
    return {**node, 'nodePosition': {**position, 'allowedDeviationXY': ellipse}}
