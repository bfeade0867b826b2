"""What a restarted vehicle must know, as JSON: order, actions, where it drives, why it does not."""
from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, Dict, Tuple

from vda5050_vehicle.drivers.driver import Leg
from vda5050_vehicle.protocol.action_queue import ActionQueue, Entry, Scope
from vda5050_vehicle.protocol.codec_3 import DEVIATION
from vda5050_vehicle.protocol.codecs import ACTION, EDGE, NODE, NODE_POSITION
from vda5050_vehicle.protocol.fields import BOOLEAN, Choice, Field, ListOf, Malformed
from vda5050_vehicle.protocol.order_state import OrderState
from vda5050_vehicle.protocol.received import ReceivedMessages
from vda5050_vehicle.protocol.values import ActionStatus, BlockingType

if TYPE_CHECKING:
    from vda5050_vehicle.core.vehicle import Vehicle

VERSION = 2

# What any version of the standard may have brought.
_ACTION = ACTION.changed(
    blocking_type=Field('blocking_type', 'blockingType', Choice(BlockingType), True),
    retriable=Field('retriable', 'retriable', BOOLEAN, omitted=False))
_ACTIONS = Field('actions', 'actions', ListOf(_ACTION), True)
_NODE = NODE.changed(actions=_ACTIONS, position=Field(
    'position', 'nodePosition', NODE_POSITION.changed(allowed_deviation_xy=Field(
        'allowed_deviation_xy', 'allowedDeviationXY', DEVIATION))))
_EDGE = EDGE.changed(actions=_ACTIONS)


class WrongRecord(Exception):
    """A record that cannot be used; the text says why."""


@dataclass(frozen=True)
class Kept:
    """What a record holds."""

    order: OrderState
    actions: ActionQueue
    legs: Tuple[Leg, ...]
    holds: Tuple[str, ...]
    failure: str
    received: ReceivedMessages
    driver: Dict[str, Any]


def write(vehicle: Vehicle) -> Dict[str, Any]:
    """The record of a vehicle."""
    order, failure = vehicle.order, vehicle.errors.failure
    return {
        'version': VERSION,
        'order': {'orderId': order.order_id, 'orderUpdateId': order.order_update_id,
                  'passed': order.passed, 'cancelled': order.cancelled,
                  'nodes': [_NODE.write(node) for node in order.nodes],
                  'edges': [_EDGE.write(edge) for edge in order.edges]},
        'actions': [{'action': _ACTION.write(entry.action), 'scope': entry.scope.value,
                     'sequenceId': entry.sequence_id, 'status': entry.status.value,
                     'triggered': entry.triggered, 'result': entry.result}
                    for entry in vehicle.actions.entries],
        'triggered': list(vehicle.actions.triggered),
        'legs': [asdict(leg) for leg in vehicle.legs],
        'holds': sorted(hold.value for hold in vehicle.holds),
        'failure': failure.description if failure else '',
        'received': list(vehicle.received.digests),
        'driver': vehicle.driver.record,
    }


def read(record: Dict[str, Any]) -> Kept:
    """What a record holds; raises WrongRecord."""
    try:
        if record['version'] != VERSION:
            raise WrongRecord(f'it is of version {record["version"]}, not {VERSION}')
        order = record['order']
        return Kept(
            OrderState(order['orderId'], order['orderUpdateId'],
                       tuple(_NODE.read(node, 'nodes') for node in order['nodes']),
                       tuple(_EDGE.read(edge, 'edges') for edge in order['edges']),
                       order['passed'], order['cancelled']),
            ActionQueue([_entry(entry) for entry in record['actions']], record['triggered']),
            tuple(Leg(**leg) for leg in record['legs']), tuple(record['holds']),
            record['failure'], ReceivedMessages(map(str, record['received'])), record['driver'])
    except (KeyError, TypeError, ValueError, Malformed) as error:
        raise WrongRecord(f'{type(error).__name__}: {error}') from None


def _entry(entry: Dict[str, Any]) -> Entry:
    return Entry(_ACTION.read(entry['action'], 'action'), Scope(entry['scope']),
                 entry['sequenceId'], ActionStatus(entry['status']), entry['triggered'],
                 entry['result'])
