"""The JSON encoding of the messages: one table per message, for 2.1.0 and 2.0.0.

Reading accepts the keys of both versions, and the keys of the drafts of 2.0. Writing uses the keys
of the chosen version. Source: VDA5050_EN.md and json_schemas of the versions 2.0.0 and 2.1.0.
"""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Callable, Dict, Mapping, Optional, Tuple

from vda5050_protocol import values as v
from vda5050_protocol.fields import (
    ANYTHING,
    BOOLEAN,
    NUMBER,
    OBJECT,
    TEXT,
    UINT,
    Choice,
    Field,
    Kind,
    ListOf,
    Malformed,
    Number,
    ObjectKind,
    read_json,
)


@dataclass(frozen=True)
class _Angle(Number):
    """An angle from -pi to pi, in rad."""

    least: float = -math.pi
    most: float = math.pi

    def read(self, value: Any, path: str) -> float:
        """See Kind; reads pi if the sender rounded pi up, to three decimals or more."""
        if (isinstance(value, (int, float)) and not isinstance(value, bool)
                and math.pi < abs(value) <= math.pi + 5e-4):
            return math.copysign(math.pi, value)
        return super().read(value, path)

    def write(self, value: float) -> float:
        """See Kind; rounds pi towards zero, because a reader rejects a larger value."""
        largest = math.floor(math.pi * 1e6) / 1e6
        return max(-largest, min(largest, super().write(value)))


ANGLE = _Angle()
POSITIVE = Number(0.0)


class _Circle(Kind):
    """A deviation that is equal in all directions: a radius in m."""

    def read(self, value: Any, path: str) -> v.Deviation:
        """See Kind."""
        radius = POSITIVE.read(value, path)
        return v.Deviation(radius, radius)

    def write(self, value: v.Deviation) -> float:
        """See Kind."""
        return POSITIVE.write(value.radius)


HEADER = ObjectKind(v.Header, [
    Field('header_id', 'headerId', UINT, True),
    Field('timestamp', 'timestamp', TEXT, True),
    Field('version', 'version', TEXT, True),
    Field('manufacturer', 'manufacturer', TEXT, True),
    Field('serial_number', 'serialNumber', TEXT, True)])

ACTION = ObjectKind(v.VdaAction, [
    Field('action_type', 'actionType', TEXT, True, ('actionName',)),
    Field('action_id', 'actionId', TEXT, True),
    Field('blocking_type', 'blockingType', Choice(
        v.BlockingType, unknown=(v.BlockingType.SINGLE,)), True),
    Field('description', 'actionDescription', TEXT),
    Field('parameters', 'actionParameters', ListOf(ObjectKind(v.ActionParameter, [
        Field('key', 'key', TEXT, True), Field('value', 'value', ANYTHING, True)])), omitted=())])

NODE_POSITION = ObjectKind(v.NodePosition, [
    Field('x', 'x', NUMBER, True), Field('y', 'y', NUMBER, True),
    Field('theta', 'theta', ANGLE),
    Field('allowed_deviation_xy', 'allowedDeviationXY', _Circle(),
          aliases=('allowedDeviationXy',)),
    Field('allowed_deviation_theta', 'allowedDeviationTheta', ANGLE),
    Field('map_id', 'mapId', TEXT, True),
    Field('map_description', 'mapDescription', TEXT)])

NODE = ObjectKind(v.OrderNode, [
    Field('node_id', 'nodeId', TEXT, True),
    Field('sequence_id', 'sequenceId', UINT, True),
    Field('description', 'nodeDescription', TEXT),
    Field('released', 'released', BOOLEAN, True),
    Field('position', 'nodePosition', NODE_POSITION),
    Field('actions', 'actions', ListOf(ACTION), True)])

CORRIDOR = ObjectKind(v.Corridor, [
    Field('left_width', 'leftWidth', POSITIVE, True),
    Field('right_width', 'rightWidth', POSITIVE, True),
    Field('reference_point', 'corridorRefPoint', TEXT)])

EDGE = ObjectKind(v.OrderEdge, [
    Field('edge_id', 'edgeId', TEXT, True),
    Field('sequence_id', 'sequenceId', UINT, True),
    Field('description', 'edgeDescription', TEXT),
    Field('released', 'released', BOOLEAN, True),
    Field('start_node_id', 'startNodeId', TEXT, True),
    Field('end_node_id', 'endNodeId', TEXT, True),
    Field('max_speed', 'maxSpeed', NUMBER),
    Field('max_height', 'maxHeight', NUMBER),
    Field('min_height', 'minHeight', NUMBER),
    Field('orientation', 'orientation', ANGLE),
    Field('orientation_type', 'orientationType', TEXT),
    Field('direction', 'direction', TEXT),
    Field('rotation_allowed', 'rotationAllowed', BOOLEAN),
    Field('max_rotation_speed', 'maxRotationSpeed', NUMBER),
    Field('length', 'length', NUMBER),
    Field('trajectory', 'trajectory', OBJECT),
    Field('corridor', 'corridor', CORRIDOR),
    Field('actions', 'actions', ListOf(ACTION), True)])

ORDER = ObjectKind(v.OrderMessage, [
    Field('order_id', 'orderId', TEXT, True),
    Field('order_update_id', 'orderUpdateId', UINT, True),
    Field('zone_set_id', 'zoneSetId', TEXT),
    Field('nodes', 'nodes', ListOf(NODE), True),
    Field('edges', 'edges', ListOf(EDGE), True)])

INSTANT_ACTIONS = ObjectKind(v.InstantActions, [
    Field('actions', 'actions', ListOf(ACTION), True, ('instantActions',))])

REFERENCES = ListOf(ObjectKind(v.ErrorReference, [
    Field('key', 'referenceKey', TEXT, True), Field('value', 'referenceValue', TEXT, True)]))

NODE_STATE = ObjectKind(v.OrderNode, [
    Field('node_id', 'nodeId', TEXT, True),
    Field('sequence_id', 'sequenceId', UINT, True),
    Field('description', 'nodeDescription', TEXT),
    Field('released', 'released', BOOLEAN, True),
    Field('position', 'nodePosition', NODE_POSITION)])

EDGE_STATE = ObjectKind(v.OrderEdge, [
    Field('edge_id', 'edgeId', TEXT, True),
    Field('sequence_id', 'sequenceId', UINT, True),
    Field('description', 'edgeDescription', TEXT),
    Field('released', 'released', BOOLEAN, True)])

ACTION_STATE = ObjectKind(v.ActionState, [
    Field('action_id', 'actionId', TEXT, True),
    Field('action_type', 'actionType', TEXT, True),
    Field('description', 'actionDescription', TEXT),
    Field('status', 'actionStatus', Choice(v.ActionStatus), True),
    Field('result_description', 'resultDescription', TEXT)])

AGV_POSITION = ObjectKind(v.AgvPosition, [
    Field('position_initialized', 'positionInitialized', BOOLEAN, True),
    Field('localization_score', 'localizationScore', Number(0.0, 1.0)),
    Field('x', 'x', NUMBER, True), Field('y', 'y', NUMBER, True),
    Field('theta', 'theta', ANGLE, True), Field('map_id', 'mapId', TEXT, True)])

VELOCITY = ObjectKind(v.Velocity, [
    Field('vx', 'vx', NUMBER), Field('vy', 'vy', NUMBER), Field('omega', 'omega', NUMBER)])

BATTERY = ObjectKind(v.BatteryState, [
    Field('charge', 'batteryCharge', NUMBER, True),
    Field('voltage', 'batteryVoltage', NUMBER),
    Field('charging', 'charging', BOOLEAN, True)])

ERROR = ObjectKind(v.Error, [
    Field('kind.name', 'errorType', TEXT, True),
    Field('references', 'errorReferences', REFERENCES, omitted=()),
    Field('description', 'errorDescription', TEXT),
    Field('kind.hint', 'errorHint', TEXT),
    Field('kind.level', 'errorLevel', Choice(v.ErrorLevel), True)])

SAFETY = ObjectKind(v.SafetyState, [
    Field('e_stop', 'eStop', Choice(v.EmergencyStop), True),
    Field('field_violation', 'fieldViolation', BOOLEAN, True)])

MAPS = Field('maps', 'maps', ListOf(ObjectKind(v.MapInformation, [
    Field('map_id', 'mapId', TEXT, True),
    Field('map_version', 'mapVersion', TEXT, True),
    Field('description', 'mapDescription', TEXT),
    Field('status', 'mapStatus', TEXT, True)])), omitted=())

STATE = ObjectKind(v.StateMessage, [
    MAPS,
    Field('order_id', 'orderId', TEXT, True),
    Field('order_update_id', 'orderUpdateId', UINT, True),
    Field('zone_set_id', 'zoneSetId', TEXT),
    Field('last_node_id', 'lastNodeId', TEXT, True),
    Field('last_node_sequence_id', 'lastNodeSequenceId', UINT, True),
    Field('driving', 'driving', BOOLEAN, True),
    Field('paused', 'paused', BOOLEAN),
    Field('new_base_request', 'newBaseRequest', BOOLEAN),
    Field('distance_since_last_node', 'distanceSinceLastNode', NUMBER),
    Field('operating_mode', 'operatingMode', Choice(v.OperatingMode), True),
    Field('node_states', 'nodeStates', ListOf(NODE_STATE), True),
    Field('edge_states', 'edgeStates', ListOf(EDGE_STATE), True),
    Field('position', 'agvPosition', AGV_POSITION),
    Field('velocity', 'velocity', VELOCITY),
    Field('action_states', 'actionStates', ListOf(ACTION_STATE), True),
    Field('battery', 'batteryState', BATTERY, True),
    Field('errors', 'errors', ListOf(ERROR), True),
    Field('information', 'information', ListOf(ANYTHING), True),
    Field('safety', 'safetyState', SAFETY, True)])

VISUALIZATION = ObjectKind(v.Visualization, [
    Field('position', 'agvPosition', AGV_POSITION), Field('velocity', 'velocity', VELOCITY)])

CONNECTION = ObjectKind(v.ConnectionMessage, [
    Field('state', 'connectionState', Choice(v.ConnectionState), True)])

_RECORDS: Mapping[str, ObjectKind] = {
    'order': ORDER, 'instantActions': INSTANT_ACTIONS, 'state': STATE,
    'visualization': VISUALIZATION, 'connection': CONNECTION}


@dataclass(frozen=True)
class Codec:
    """The messages of one version of the standard.

    records   -- the table of each message, by topic
    factsheet -- converts the vehicle's factsheet to the factsheet of this version
    is_3      -- whether the rules of 3.0 apply:
                 - instant actions do not block
                 - the state reports instant actions until the master clears them
                 - an action may be retried
                 - the same orderUpdateId with different contents is an error
    """

    version: str
    records: Mapping[str, ObjectKind]
    factsheet: Callable[[Dict[str, Any]], Dict[str, Any]]
    is_3: bool = False

    @property
    def major(self) -> str:
        """The major version as it appears in topic names, e.g. `v2`."""
        return 'v' + self.version.split('.')[0]

    def path(self, topic: str, path: str) -> Optional[str]:
        """Returns the path of a field in this version, e.g. `edges[0].maximumSpeed`.

        path -- the path in 2.1.0, e.g. `edges[0].maxSpeed`
        Returns None if 2.1.0 has no field at this path, or if this version does not have the field.
        """
        found = []
        ours: Optional[Kind] = self.records.get(topic)
        theirs: Optional[Kind] = _RECORDS.get(topic)
        for part in path.split('.'):
            key, bracket, index = part.partition('[')
            field = theirs.field(key) if isinstance(theirs, ObjectKind) else None
            other = (ours.field_of(field.attribute)
                     if field and isinstance(ours, ObjectKind) else None)
            if field is None or other is None:
                return None
            found.append(other.key + bracket + index)
            ours, theirs = _element(other.kind), _element(field.kind)
        return '.'.join(found)

    def read(self, topic: str, payload: bytes) -> Tuple[v.Header, Any]:
        """Returns the header and the message in a payload; raises Malformed."""
        json_object = read_json(payload)
        header = HEADER.read(json_object, '')
        if header.version.lstrip('v').split('.')[0] != self.version.split('.')[0]:
            raise Malformed('version', f'is {header.version[:20]!r}, but this vehicle speaks '
                                       f'{self.version}')
        return header, self.records[topic].read(json_object, '')

    def write(self, topic: str, header: v.Header, message: Any) -> Dict[str, Any]:
        """Returns the JSON object of a message; a factsheet is given as a JSON object."""
        body = (self.factsheet(self._with_paths(message)) if topic == 'factsheet'
                else self.records[topic].write(message))
        return {**HEADER.write(header), **body}


    def _with_paths(self, sheet: Dict[str, Any]) -> Dict[str, Any]:
        """Returns a factsheet whose optional parameters have the names of this version."""
        features, found = sheet['protocolFeatures'], []
        for line in features['optionalParameters']:
            topic, _, path = line['parameter'].partition('.')
            ours = self.path(topic, path)
            if ours is not None:
                found.append({**line, 'parameter': f'{topic}.{ours}'})
        return {**sheet, 'protocolFeatures': {**features, 'optionalParameters': found}}


def _element(kind: Kind) -> Kind:
    return kind.kind if isinstance(kind, ListOf) else kind


def _factsheet(sheet: Dict[str, Any]) -> Dict[str, Any]:
    """Removes the keys that 2.x cannot have.

    - blockingTypes: the schema of 2.1.0 requires a value that is both an array and a string
    - cancelAllowed: 3.0 introduced it
    """
    features = sheet['protocolFeatures']
    actions = [{key: value for key, value in action.items()
                if key not in ('blockingTypes', 'cancelAllowed')}
               for action in features['agvActions']]
    return {**sheet, 'protocolFeatures': {**features, 'agvActions': actions}}


def _version_2_0() -> Codec:
    """Returns the codec of 2.0.0.

    2.0.0 has no maps, and its errors have no hint. 2.0.0 requires a heading in the position of a
    node. Few nodes have a heading, so node states have no position.
    """
    errors = ListOf(ERROR.changed(**{'kind.hint': None}))
    nodes = ListOf(NODE_STATE.changed(position=None))
    state = STATE.changed(maps=None, node_states=Field('node_states', 'nodeStates', nodes, True),
                          errors=Field('errors', 'errors', errors, True))
    return Codec('2.0.0', {**_RECORDS, 'state': state}, _factsheet)


VERSION_2_1 = Codec('2.1.0', _RECORDS, _factsheet)
VERSION_2_0 = _version_2_0()
