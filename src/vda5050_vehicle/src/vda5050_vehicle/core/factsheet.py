"""The factsheet: what a master may know of the vehicle, made from its file and its actions."""
from __future__ import annotations

from typing import Any, Dict, List, Mapping, Tuple

from vda5050_vehicle.core.action_table import ActionSpec, ActionTable, Parameter
from vda5050_vehicle.drivers.order_fields import Abilities
from vda5050_vehicle.protocol.fields import MAX_ARRAY, MAX_MESSAGE, MAX_TEXT
from vda5050_vehicle.protocol.reporting import IDLE_PERIOD

SECTIONS = ('typeSpecification', 'physicalParameters', 'agvGeometry', 'loadSpecification')

_ARRAYS = ('order.nodes', 'order.edges', 'node.actions', 'edge.actions',
           'actions.actionsParameters', 'instantActions')

# Optional fields that are honoured, by their path in the messages.
_SUPPORTED: Tuple[Tuple[str, str], ...] = (
    ('order.nodes.nodePosition', 'matched with the vehicle\'s places within 0.3 m'),
    ('order.nodes.nodePosition.allowedDeviationXY',
     'of the first node of a new order; of others where the vehicle passes them so near'),
    ('order.edges.length', 'known without it'),
    ('order.edges.maxHeight', 'where the vehicle is not higher'),
    ('state.agvPosition', ''), ('state.velocity', ''), ('state.newBaseRequest', ''),
    ('state.paused', ''), ('state.distanceSinceLastNode', ''), ('state.maps', ''))


class WrongVehicle(Exception):
    """A `vehicle.yaml` that cannot be used; the text says which entry and what to do."""


def check_vehicle(document: Any) -> Mapping[str, Any]:
    """A `vehicle.yaml`, as YAML reads it; raises WrongVehicle."""
    if not isinstance(document, dict):
        raise WrongVehicle('it holds no entries')
    for section in SECTIONS:
        if not isinstance(document.get(section), dict):
            raise WrongVehicle(f'{section} is missing, or holds no entries')
    for key in ('speedMax', 'heightMax'):
        value = document['physicalParameters'].get(key)
        if not isinstance(value, (int, float)) or isinstance(value, bool):
            raise WrongVehicle(f'physicalParameters.{key} is {value!r}, but must be a number')
    return document


def abilities(document: Mapping[str, Any], map_id: str, ignored: Tuple[str, ...]) -> Abilities:
    """What the robot does by itself, of a `vehicle.yaml`; raises WrongVehicle."""
    physical, more = document['physicalParameters'], document.get('abilities', {})
    try:
        return Abilities(
            float(physical['speedMax']), float(more['top_rotation']), float(physical['heightMax']),
            float(more['corridor']), float(more.get('passing', Abilities.passing)), map_id,
            frozenset(ignored))
    except (KeyError, TypeError, ValueError) as error:
        raise WrongVehicle(f'abilities: {error} is missing, or no number') from None


def factsheet(document: Mapping[str, Any], table: ActionTable) -> Dict[str, Any]:
    """The body of the message, without header; codecs make of it what their version has."""
    return {
        **{section: document[section] for section in SECTIONS},
        'protocolLimits': {
            'maxStringLens': {'msgLen': MAX_MESSAGE, 'idLen': MAX_TEXT, 'enumLen': MAX_TEXT,
                              'idNumericalOnly': False},
            'maxArrayLens': dict.fromkeys(_ARRAYS, MAX_ARRAY),
            'timing': {'minOrderInterval': 0.0, 'minStateInterval': 0.0,
                       'defaultStateInterval': IDLE_PERIOD}},
        'protocolFeatures': {
            'optionalParameters': [
                {'parameter': parameter, 'support': 'SUPPORTED',
                 **({'description': text} if text else {})} for parameter, text in _SUPPORTED],
            'agvActions': [_action(spec) for spec in table.specs.values()]}}


def _action(spec: ActionSpec) -> Dict[str, Any]:
    result: Dict[str, Any] = {
        'actionType': spec.action_type, 'actionDescription': spec.description,
        'actionScopes': sorted(scope.value for scope in spec.scopes),
        'blockingTypes': [kind.value for kind in spec.blocking],
        'cancelAllowed': spec.cancellable}
    if spec.parameters:
        result['actionParameters'] = _parameters(spec.parameters)
    if spec.result:
        result['resultDescription'] = spec.result
    return result


def _parameters(parameters: Tuple[Parameter, ...]) -> List[Dict[str, Any]]:
    return [{'key': p.key, 'valueDataType': p.type, 'isOptional': p.optional,
             **({'description': p.description} if p.description else {})} for p in parameters]
