"""The factsheet: the description of the vehicle for masters, from its file and its actions."""
from __future__ import annotations

from typing import Any, Dict, List, Mapping, Optional, Tuple

from vda5050_protocol.action_queue import MAX_INSTANT_ACTIONS
from vda5050_protocol.fields import MAX_ARRAY, MAX_MESSAGE, MAX_TEXT
from vda5050_protocol.reporting import IDLE_PERIOD
from vda5050_vehicle.core.action_table import ActionSpec, ActionTable, Parameter
from vda5050_vehicle.drivers.order_fields import Abilities

SECTIONS = ('typeSpecification', 'physicalParameters', 'agvGeometry', 'loadSpecification')

_ARRAYS = ('node.actions', 'edge.actions', 'actions.actionsParameters')

# The optional fields that the vehicle honours: for each its path in 2.1.0, and a description.
_SUPPORTED: Tuple[Tuple[str, str], ...] = (
    ('order.nodes.nodePosition', 'must be within 0.3 m of a node that the vehicle knows'),
    ('order.nodes.nodePosition.allowedDeviationXY',
     'of the first node of a new order; of other nodes if the vehicle passes them near enough'),
    ('order.edges.length', 'accepted; the vehicle uses its own value'),
    ('order.edges.maxHeight', 'if the vehicle is not higher'),
    ('state.agvPosition', ''), ('state.velocity', ''), ('state.newBaseRequest', ''),
    ('state.paused', ''), ('state.distanceSinceLastNode', ''), ('state.maps', ''))


class WrongVehicle(Exception):
    """A `vehicle.yaml` that cannot be used; the text names the entry and the remedy."""


def check_vehicle(document: Any) -> Mapping[str, Any]:
    """Returns a parsed `vehicle.yaml` after checking it; raises WrongVehicle."""
    if not isinstance(document, dict):
        raise WrongVehicle('it has no entries')
    for section in SECTIONS:
        if not isinstance(document.get(section), dict):
            raise WrongVehicle(f'{section} is missing, or has no entries')
    for key in ('speedMax', 'heightMax'):
        value = document['physicalParameters'].get(key)
        if not isinstance(value, (int, float)) or isinstance(value, bool):
            raise WrongVehicle(f'physicalParameters.{key} is {value!r}, but must be a number')
    return document


def abilities(document: Mapping[str, Any], map_id: str, ignored: Tuple[str, ...]) -> Abilities:
    """Returns the abilities of the robot from a `vehicle.yaml`; raises WrongVehicle."""
    physical, more = document['physicalParameters'], document.get('abilities', {})
    try:
        return Abilities(
            float(physical['speedMax']), float(more['top_rotation']), float(physical['heightMax']),
            float(more['corridor']), float(more.get('passing', Abilities.passing)), map_id,
            frozenset(ignored))
    except (KeyError, TypeError, ValueError) as error:
        raise WrongVehicle(f'abilities: {error} is missing, or not a number') from None


def factsheet(document: Mapping[str, Any], table: ActionTable, longest: Optional[int],
              ) -> Dict[str, Any]:
    """Returns the factsheet message without header; each codec converts it to its version.

    longest -- the largest number of edges of an order that the driver can drive; None: any number
    """
    edges = MAX_ARRAY - 1 if longest is None else longest
    arrays = {'order.nodes': edges + 1, 'order.edges': edges,
              **dict.fromkeys(_ARRAYS, MAX_ARRAY), 'instantActions': MAX_INSTANT_ACTIONS}
    return {
        **{section: document[section] for section in SECTIONS},
        'protocolLimits': {
            'maxStringLens': {'msgLen': MAX_MESSAGE, 'idLen': MAX_TEXT, 'enumLen': MAX_TEXT,
                              'idNumericalOnly': False},
            'maxArrayLens': arrays,
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
