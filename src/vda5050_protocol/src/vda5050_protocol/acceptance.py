"""Decides whether an order is accepted: figure 8 of VDA 5050 2.1.0 and 3.0.0 as a pure function.

Module `order_rules` answers question 1 of the figure, whether the order is valid. The questions
have the numbers of 2.1.0.
"""
from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Tuple, Union

from vda5050_protocol import problems as e
from vda5050_protocol.values import Error, ErrorKind, ErrorReference, OrderMessage

Place = Tuple[str, int]  # nodeId and sequenceId


class OrderAcceptance(Enum):
    """The way in which an accepted order is used."""

    NEW = 'new'              # replaces the present order
    APPEND = 'append'        # extends the active order
    CONTINUE = 'continue'    # extends the completed order
    DUPLICATE = 'duplicate'  # the vehicle has this order already and ignores it


@dataclass(frozen=True)
class Rejection:
    """The reason why an order is rejected."""

    error: Error


Verdict = Union[OrderAcceptance, Rejection]


@dataclass(frozen=True)
class Held:
    """The situation of the vehicle when an order comes.

    busy            -- whether nodes remain to be reached, or actions of the order have not ended
    acting          -- id of an instant action that has not ended; always '' in 3.0, in which
                       instant actions do not block orders
    moving          -- id of an instant action that moves the robot to another place, or ''
    cancelled       -- whether the order was cancelled or is being cancelled
    decision_point  -- the last node of the base
    last_node       -- the last node that the vehicle passed
    """

    order_id: str = ''
    order_update_id: int = 0
    busy: bool = False
    cancelled: bool = False
    decision_point: Place = ('', 0)
    last_node: Place = ('', 0)
    acting: str = ''
    moving: str = ''


def judge(held: Held, order: OrderMessage, start_is_near: bool, is_3: bool = False) -> Verdict:
    """Returns the verdict on a valid order; `start_is_near` answers question 4 of the figure."""
    if order.order_id != held.order_id:                                       # question 2
        return _judge_new(held, order, start_is_near, is_3)
    return _judge_update(held, order, is_3)


def _judge_new(held: Held, order: OrderMessage, start_is_near: bool, is_3: bool) -> Verdict:
    if held.busy:                                                             # question 3
        return _reject(e.OTHER_ORDER, order,
                       f'order {held.order_id!r} is still active; cancel it first')
    under_way = held.moving or held.acting
    if under_way:
        return _reject(e.OTHER_ORDER, order,
                       f'the instant action {under_way!r} has not ended; wait for its end')
    if is_3 and order.order_update_id != 0:                                   # question 4 of 3.0.0
        return _reject(e.ORDER_ERROR, order,
                       f'a new order has orderUpdateId 0, not {order.order_update_id}')
    if not start_is_near:                                                     # question 4
        return _reject(e.START_TOO_FAR, order,
                       f'the vehicle is outside the allowed deviation of the first node, '
                       f'{order.nodes[0].node_id!r}',
                       ErrorReference('nodeId', order.nodes[0].node_id))
    return OrderAcceptance.NEW


def _judge_update(held: Held, order: OrderMessage, is_3: bool) -> Verdict:
    if order.order_update_id < held.order_update_id:                          # question 5
        return _reject(e.OLD_UPDATE, order,
                       f'orderUpdateId {order.order_update_id} is older than '
                       f'{held.order_update_id}, which the vehicle has')
    is_copy = order.order_update_id == held.order_update_id                   # question 6
    if held.cancelled and (is_3 or not is_copy):
        # Question 7 of 3.0.0. Here it comes before the question whether the order is a copy. The
        # figure of 2.1.0 does not have it.
        return _reject(e.UPDATE_AFTER_CANCEL, order, 'the order was cancelled; send another one')
    if is_copy:
        return OrderAcceptance.DUPLICATE
    if held.moving:
        return _reject(e.WRONG_UPDATE, order,
                       f'the instant action {held.moving!r} moves the vehicle away from its last '
                       'node; wait for its end')
    expected = held.decision_point if held.busy else held.last_node           # questions 3, 7, 8
    first = (order.nodes[0].node_id, order.nodes[0].sequence_id)
    if first != expected:
        return _reject(e.WRONG_UPDATE, order,
                       f'the update begins with node {first[0]!r}, sequenceId {first[1]}, but must '
                       f'begin with {expected[0]!r}, sequenceId {expected[1]}, '
                       + ('the last node of the base' if held.busy else 'the last node passed'),
                       ErrorReference('nodeId', first[0]))
    return OrderAcceptance.APPEND if held.busy else OrderAcceptance.CONTINUE


def _reject(kind: ErrorKind, order: OrderMessage, description: str,
            *more: ErrorReference) -> Rejection:
    return Rejection(kind.error(description, *e.order_references(order), *more))
