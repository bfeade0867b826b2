"""The errors that a vehicle reports: a table of types and levels, for 2.x and for 3.0.

The text of 2.1.0 names only a few types. The other names are defined here.
"""
from __future__ import annotations

from typing import Tuple

from vda5050_protocol.values import ErrorKind, ErrorLevel, ErrorReference, OrderMessage

_W, _U, _C, _F = ErrorLevel.WARNING, ErrorLevel.URGENT, ErrorLevel.CRITICAL, ErrorLevel.FATAL

# --- an order or action that is rejected ----------------------------------------------------------
VALIDATION_ERROR = ErrorKind('validationError', _W, 'Correct the message.',
                             'VALIDATION_FAILURE', _W)
ORDER_ERROR = ErrorKind('orderError', _W, 'Send an order that the vehicle can execute.',
                        'INVALID_ORDER', _W)
OTHER_ORDER = ErrorKind('orderError', _W, 'Cancel the active order, or wait for its end.',
                        'OTHER_ORDER_ACTIVE', _W)
UNSUPPORTED = ErrorKind('orderError', _W, 'Omit the field, or let the vehicle ignore it.',
                        'UNSUPPORTED_PARAMETER', _C)
UNKNOWN_MAP = ErrorKind('orderError', _W, 'Send an order on the map of the vehicle.',
                        'UNKNOWN_MAP_ID', _W)
ORDER_ACTION = ErrorKind('orderError', _W, 'Send an action that the factsheet lists.',
                         'INVALID_ORDER_ACTION', _W)
WRONG_UPDATE = ErrorKind('orderUpdateError', _W, 'Read the state, and send a matching update.',
                         'INVALID_ORDER_UPDATE', _W)
OLD_UPDATE = ErrorKind('orderUpdateError', _W, 'Read the state, and send a matching update.',
                       'OUTDATED_ORDER_UPDATE', _W)
SAME_UPDATE = ErrorKind('orderUpdateError', _W, 'Send each change with a new orderUpdateId.',
                        'SAME_ORDER_UPDATE_ID', _W)
UPDATE_AFTER_CANCEL = ErrorKind('orderUpdateError', _W, 'Send another order.',
                                'ORDER_UPDATE_FOLLOWING_CANCEL', _W)
NO_ROUTE = ErrorKind('noRouteError', _W, 'Send an order with nodes and edges that the vehicle has.',
                     'NO_ROUTE_TO_TARGET', _W)
START_TOO_FAR = ErrorKind('noRouteError', _W, 'Send an order that starts at the vehicle.',
                          'START_NODE_OUT_OF_RANGE', _W)
NO_ORDER_TO_CANCEL = ErrorKind('noOrderToCancel', _W, 'There is nothing to cancel.',
                               'NO_ORDER_TO_CANCEL', _W)
INSTANT_ACTION_ERROR = ErrorKind('instantActionError', _W, 'Send an action that the factsheet '
                                 'lists.', 'INVALID_INSTANT_ACTION', _W)
INSTANT_ACTIONS_FULL = ErrorKind('instantActionError', _W, 'Send clearInstantActions.',
                                 'INSTANT_ACTION_STATES_FULL', _U)

# --- errors during an order -----------------------------------------------------------------------
ACTION_WARNING = ErrorKind('actionError', _W, 'The order continues without the action.',
                           'ACTION_FAILED', _W)
ACTION_ERROR = ErrorKind('actionError', _F, 'Send stopPause to continue without the action, or '
                         'cancelOrder to end the order.', 'ACTION_FAILED', _C)
DRIVE_ERROR = ErrorKind('driveError', _F, 'Check the vehicle. Then send stopPause to drive on, or '
                        'cancelOrder to end the order.', 'DRIVE_FAILED', _C)
RESTARTED = ErrorKind('driveError', _F, 'Send stopPause to drive on, or cancelOrder to end the '
                      'order.', 'DRIVE_FAILED', _C)

# --- the condition of the vehicle -----------------------------------------------------------------
EMERGENCY_STOP = ErrorKind('emergencyStop', _F, 'Release the emergency stop at the vehicle.',
                           'EMERGENCY_STOP', _U)
VEHICLE_LOST = ErrorKind('vehicleConnectionError', _F, 'Check the connection between the vehicle '
                         'and its computer.', 'VEHICLE_CONNECTION_LOST', _C)
LOCALIZATION_ERROR = ErrorKind('localizationError', _F, 'Send initPosition.',
                               'LOCALIZATION_ERROR', _C)


def order_references(order: OrderMessage) -> Tuple[ErrorReference, ...]:
    """Returns the references of an error about an order."""
    return (ErrorReference('topic', 'order'), ErrorReference('orderId', order.order_id),
            ErrorReference('orderUpdateId', str(order.order_update_id)))
