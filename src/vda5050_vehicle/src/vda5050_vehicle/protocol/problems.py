"""The errors that a vehicle reports: one table of types and levels, for 2.x and for 3.0.

2.1.0 leaves the names of types open but for a few in its text; the others are ours.
"""
from __future__ import annotations

from typing import Tuple

from vda5050_vehicle.protocol.values import ErrorKind, ErrorLevel, Order, Reference

_W, _U, _C, _F = ErrorLevel.WARNING, ErrorLevel.URGENT, ErrorLevel.CRITICAL, ErrorLevel.FATAL

# --- an order or action that is not taken up ------------------------------------------------------
VALIDATION_ERROR = ErrorKind('validationError', _W, 'Mend the message.',
                             'VALIDATION_FAILURE', _W)
ORDER_ERROR = ErrorKind('orderError', _W, 'Send an order that the vehicle can execute.',
                        'INVALID_ORDER', _W)
OTHER_ORDER = ErrorKind('orderError', _W, 'Cancel the order that is under way, or wait for its '
                        'end.', 'OTHER_ORDER_ACTIVE', _W)
UNSUPPORTED = ErrorKind('orderError', _W, 'Leave the field out, or let the vehicle ignore it.',
                        'UNSUPPORTED_PARAMETER', _C)
UNKNOWN_MAP = ErrorKind('orderError', _W, 'Send an order on the map of the vehicle.',
                        'UNKNOWN_MAP_ID', _W)
ORDER_ACTION = ErrorKind('orderError', _W, 'The factsheet lists the actions.',
                         'INVALID_ORDER_ACTION', _W)
WRONG_UPDATE = ErrorKind('orderUpdateError', _W, 'Read the state, and send an update of it.',
                         'INVALID_ORDER_UPDATE', _W)
OLD_UPDATE = ErrorKind('orderUpdateError', _W, 'Read the state, and send an update of it.',
                       'OUTDATED_ORDER_UPDATE', _W)
SAME_UPDATE = ErrorKind('orderUpdateError', _W, 'Send a change with an orderUpdateId of its own.',
                        'SAME_ORDER_UPDATE_ID', _W)
UPDATE_AFTER_CANCEL = ErrorKind('orderUpdateError', _W, 'Send another order.',
                                'ORDER_UPDATE_FOLLOWING_CANCEL', _W)
NO_ROUTE = ErrorKind('noRouteError', _W, 'Send an order over nodes and edges that the vehicle has.',
                     'NO_ROUTE_TO_TARGET', _W)
START_TOO_FAR = ErrorKind('noRouteError', _W, 'Send an order that begins where the vehicle is.',
                          'START_NODE_OUT_OF_RANGE', _W)
NO_ORDER_TO_CANCEL = ErrorKind('noOrderToCancel', _W, 'There is nothing to cancel.',
                               'NO_ORDER_TO_CANCEL', _W)
INSTANT_ACTION_ERROR = ErrorKind('instantActionError', _W, 'The factsheet lists the actions.',
                                 'INVALID_INSTANT_ACTION', _W)
INSTANT_ACTIONS_FULL = ErrorKind('instantActionError', _W, 'Send clearInstantActions.',
                                 'INSTANT_ACTION_STATES_FULL', _U)

# --- what happens on the way ----------------------------------------------------------------------
ACTION_WARNING = ErrorKind('actionError', _W, 'The order goes on without it.',
                           'ACTION_FAILED', _W)
ACTION_ERROR = ErrorKind('actionError', _F, 'stopPause goes on without it, cancelOrder ends the '
                         'order.', 'ACTION_FAILED', _C)
DRIVE_ERROR = ErrorKind('driveError', _F, 'See to the vehicle; then stopPause drives on, or '
                        'cancelOrder ends the order.', 'DRIVE_FAILED', _C)
RESTARTED = ErrorKind('driveError', _F, 'stopPause drives on, cancelOrder ends the order.',
                      'DRIVE_FAILED', _C)

# --- how the vehicle is ---------------------------------------------------------------------------
EMERGENCY_STOP = ErrorKind('emergencyStop', _F, 'Release it at the vehicle.',
                           'EMERGENCY_STOP', _U)
VEHICLE_LOST = ErrorKind('vehicleConnectionError', _F, 'Look at the link between the vehicle and '
                         'its computer.', 'VEHICLE_CONNECTION_LOST', _C)
LOCALIZATION_ERROR = ErrorKind('localizationError', _F, 'Send initPosition.',
                               'LOCALIZATION_ERROR', _C)


def order_references(order: Order) -> Tuple[Reference, ...]:
    """What an error about an order refers to."""
    return (Reference('topic', 'order'), Reference('orderId', order.order_id),
            Reference('orderUpdateId', str(order.order_update_id)))
