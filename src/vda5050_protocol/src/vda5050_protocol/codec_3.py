"""The messages of VDA 5050 3.0.0: the tables of 2.1.0 with other keys and additional fields.

Source: VDA5050_EN.md of 3.0.0. The optional parts of 3.0.0 (zones, requests for zones, planned
paths, hibernation, certificates) are not implemented.
"""
from __future__ import annotations

from typing import Any, Dict, List, Mapping

from vda5050_protocol import codecs as two
from vda5050_protocol import values as v
from vda5050_protocol.codecs import Codec
from vda5050_protocol.fields import (
    BOOLEAN,
    NUMBER,
    TEXT,
    UINT,
    Choice,
    Field,
    Kind,
    ListOf,
    ObjectKind,
    TextKind,
)

_ACTION_NAMES: Mapping[str, str] = {'initializePosition': 'initPosition'}  # 3.0 -> 2.1


class _ActionType(TextKind):
    """The name of an action; 3.0 has renamed some actions."""

    def read(self, value: Any, path: str) -> str:
        """See Kind."""
        text = super().read(value, path)
        return _ACTION_NAMES.get(text, text)

    def write(self, value: str) -> str:
        """See Kind."""
        return _name_in_3(value)


class _Negated(Kind):
    """The negation of a boolean."""

    def read(self, value: Any, path: str) -> bool:
        """See Kind."""
        return not BOOLEAN.read(value, path)

    def write(self, value: bool) -> bool:
        """See Kind."""
        return not value


def _name_in_3(name: str) -> str:
    return next((new for new, old in _ACTION_NAMES.items() if old == name), name)


_ACTION = two.ACTION.renamed(description='actionDescriptor').changed(
    action_type=Field('action_type', 'actionType', _ActionType(), True),
    blocking_type=Field('blocking_type', 'blockingType', Choice(v.BlockingType), True),
    retriable=Field('retriable', 'retriable', BOOLEAN, omitted=False))
_ACTIONS = Field('actions', 'actions', ListOf(_ACTION), True)

DEVIATION = ObjectKind(v.Deviation, [
    Field('a', 'a', two.POSITIVE, True), Field('b', 'b', two.POSITIVE, True),
    Field('theta', 'theta', two.ANGLE, True)])
_POSITION = two.NODE_POSITION.changed(
    map_description=None,
    allowed_deviation_xy=Field('allowed_deviation_xy', 'allowedDeviationXY', DEVIATION))
_NODE = two.NODE.renamed(description='nodeDescriptor').changed(
    position=Field('position', 'nodePosition', _POSITION), actions=_ACTIONS)
_CORRIDOR = two.CORRIDOR.renamed(reference_point='corridorReferencePoint').changed(
    release_required=Field('release_required', 'releaseRequired', BOOLEAN, omitted=False))
_EDGE = two.EDGE.renamed(
    description='edgeDescriptor', max_speed='maximumSpeed',
    max_height='maximumMobileRobotHeight', min_height='minimumLoadHandlingDeviceHeight').changed(
    # 3.0 has neither startNodeId nor endNodeId: the ends of an edge follow from its sequenceId. If
    # a master sends these ids nevertheless, they must agree with the nodes.
    start_node_id=Field('start_node_id', 'startNodeId', TEXT),
    end_node_id=Field('end_node_id', 'endNodeId', TEXT),
    # the name in the text of 7.3, which has precedence, and the name in the schema
    max_rotation_speed=Field('max_rotation_speed', 'maximumRotationSpeed', NUMBER,
                             aliases=('maxRotationSpeed',)),
    rotation_allowed=Field('rotation_allowed', 'reachOrientationBeforeEntering', _Negated()),
    corridor=Field('corridor', 'corridor', _CORRIDOR),
    actions=_ACTIONS)
_ORDER = two.ORDER.changed(
    zone_set_id=None, nodes=Field('nodes', 'nodes', ListOf(_NODE), True),
    edges=Field('edges', 'edges', ListOf(_EDGE), True))

_STATE_POSITION = two.NODE_POSITION.changed(
    map_description=None, allowed_deviation_xy=None, allowed_deviation_theta=None)
_ACTION_STATES = ListOf(two.ACTION_STATE.renamed(
    description='actionDescriptor', result_description='actionResult').changed(
    action_type=Field('action_type', 'actionType', _ActionType(), True)))
_ERROR = two.ERROR.changed(**{
    'kind.name': Field('kind.name_3', 'errorType', TEXT, True),
    'kind.level': Field('kind.level_3', 'errorLevel', Choice(v.ErrorLevel), True)})
_E_STOP = Choice(v.EmergencyStop, spelling=((v.EmergencyStop.AUTOACK, 'MANUAL'),))
_MAP = ObjectKind(v.MapInformation, [
    Field('map_id', 'mapId', TEXT, True), Field('map_version', 'mapVersion', TEXT, True),
    Field('description', 'mapDescriptor', TEXT), Field('status', 'mapStatus', TEXT, True)])
_AGV_POSITION = Field('position', 'mobileRobotPosition',
                      two.AGV_POSITION.renamed(position_initialized='localized'))
_STATE = two.STATE.changed(
    zone_set_id=None,
    maps=Field('maps', 'maps', ListOf(_MAP), omitted=()),
    node_states=Field('node_states', 'nodeStates', ListOf(two.NODE_STATE.renamed(
        description='nodeDescriptor').changed(
        position=Field('position', 'nodePosition', _STATE_POSITION))), True),
    edge_states=Field('edge_states', 'edgeStates', ListOf(
        two.EDGE_STATE.renamed(description='edgeDescriptor')), True),
    action_states=Field('order_action_states', 'actionStates', _ACTION_STATES, True),
    instant_action_states=Field('instant_action_states', 'instantActionStates', _ACTION_STATES,
                                True),
    position=_AGV_POSITION,
    battery=Field('battery', 'powerSupply', two.BATTERY.renamed(charge='stateOfCharge'), True),
    operating_mode=Field('operating_mode', 'operatingMode', Choice(
        v.OperatingMode, ((v.OperatingMode.TEACHIN, 'TEACH_IN'),)), True),
    errors=Field('errors', 'errors', ListOf(_ERROR), True),
    safety=Field('safety', 'safetyState', two.SAFETY.changed(
        e_stop=Field('e_stop', 'activeEmergencyStop', _E_STOP, True)), True))

_VISUALIZATION = two.VISUALIZATION.changed(
    state_header_id=Field('state_header_id', 'referenceStateHeaderId', UINT, True),
    position=_AGV_POSITION)
_CONNECTION = ObjectKind(v.ConnectionMessage, [Field('state', 'connectionState', Choice(
    v.ConnectionState, ((v.ConnectionState.CONNECTION_BROKEN, 'CONNECTION_BROKEN'),)), True)])

_SHEET_KEYS: Mapping[str, str] = {
    'agvKinematic': 'mobileRobotKinematics', 'agvClass': 'mobileRobotClass',
    'maxLoadMass': 'maximumLoadMass', 'speedMin': 'minimumSpeed', 'speedMax': 'maximumSpeed',
    'accelerationMax': 'maximumAcceleration', 'decelerationMax': 'maximumDeceleration',
    'heightMin': 'minimumHeight', 'heightMax': 'maximumHeight',
    'maxStringLens': 'maximumStringLengths', 'maxArrayLens': 'maximumArrayLengths',
    'msgLen': 'maximumMessageLength', 'idLen': 'maximumIdLength',
    'minOrderInterval': 'minimumOrderInterval', 'minStateInterval': 'minimumStateInterval',
    'agvActions': 'mobileRobotActions', 'agvGeometry': 'mobileRobotGeometry',
    'set': 'envelope2dId', 'polygonPoints': 'vertices', 'resultDescription': 'actionResult'}


def _factsheet(sheet: Dict[str, Any]) -> Dict[str, Any]:
    """Converts the factsheet of 2.1.0 to the keys of 3.0."""
    found: Dict[str, Any] = _renamed(sheet)
    found['protocolLimits']['maximumStringLengths'].pop('enumLen', None)
    for action in found['protocolFeatures']['mobileRobotActions']:
        action.update(actionType=_name_in_3(action['actionType']), pauseAllowed=False)
    return found


def _renamed(value: Any) -> Any:
    if isinstance(value, dict):
        return {_SHEET_KEYS.get(key, key): _renamed(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        items: List[Any] = [_renamed(item) for item in value]
        return items
    return value


VERSION_3_0 = Codec('3.0.0', {
    'order': _ORDER,
    'instantActions': ObjectKind(v.InstantActions, [_ACTIONS]),
    'state': _STATE, 'visualization': _VISUALIZATION, 'connection': _CONNECTION},
    _factsheet, is_3=True)
CODECS: Dict[str, Codec] = {
    codec.version: codec for codec in (two.VERSION_2_1, two.VERSION_2_0, VERSION_3_0)}
