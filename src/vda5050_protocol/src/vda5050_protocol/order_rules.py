"""The rules of a valid order that JSON schemas cannot express (VDA 5050 2.1.0, 6.6.1, 6.6.2)."""
from __future__ import annotations

from typing import Iterator, Optional, Sequence, Set, Tuple

from vda5050_protocol.fields import Malformed
from vda5050_protocol.values import Element, OrderMessage, VdaAction


def check_order(order: OrderMessage) -> None:
    """Raises Malformed for the first rule that the order breaks."""
    for problem in _problems(order):
        if problem is not None:
            raise problem


def _problems(order: OrderMessage) -> Iterator[Optional[Malformed]]:
    yield _wrong_id(order.order_id)
    yield _wrong_count(order)
    yield _wrong_sequence(order)
    yield _wrong_ends(order)
    yield _wrong_release(order)
    yield _repeated_action(order)


def _wrong_id(order_id: str) -> Optional[Malformed]:
    return None if order_id else Malformed('orderId', 'is empty')


def _wrong_count(order: OrderMessage) -> Optional[Malformed]:
    if not order.nodes:
        return Malformed('nodes', 'is empty; an order has at least one node')
    if len(order.edges) != len(order.nodes) - 1:
        return Malformed('edges', f'has {len(order.edges)} elements, but {len(order.nodes)} nodes '
                                  f'need {len(order.nodes) - 1}')
    return None


def _wrong_sequence(order: OrderMessage) -> Optional[Malformed]:
    """Checks that sequence ids count nodes and edges alternately, beginning with a node, without
    gaps.
    """
    first = order.nodes[0].sequence_id
    if first % 2:
        return Malformed('nodes[0].sequenceId', f'is {first}, but the sequenceIds of nodes are '
                                                'even')
    rows: Tuple[Tuple[str, Sequence[Element], int], ...] = (
        ('nodes', order.nodes, first), ('edges', order.edges, first + 1))
    for kind, elements, start in rows:
        for index, element in enumerate(elements):
            if element.sequence_id != start + 2 * index:
                return Malformed(f'{kind}[{index}].sequenceId', f'is {element.sequence_id}, but '
                                                                f'must be {start + 2 * index}')
    return None


def _wrong_ends(order: OrderMessage) -> Optional[Malformed]:
    for index, edge in enumerate(order.edges):
        for key, is_id, node in (('startNodeId', edge.start_node_id, order.nodes[index]),
                                 ('endNodeId', edge.end_node_id, order.nodes[index + 1])):
            if is_id is not None and is_id != node.node_id:
                return Malformed(f'edges[{index}].{key}', f'is {is_id!r}, but the node there is '
                                                          f'{node.node_id!r}')
    return None


def _wrong_release(order: OrderMessage) -> Optional[Malformed]:
    """Checks that the base is the first part of the order and ends with a node."""
    if not order.nodes[0].released:
        return Malformed('nodes[0].released', 'is false; an order begins with its base')
    released = True
    for index, (edge, node) in enumerate(zip(order.edges, order.nodes[1:])):
        if edge.released and not released:
            return Malformed(f'edges[{index}].released', 'is true after an element that is not')
        if edge.released != node.released:
            return Malformed(
                f'edges[{index}].released', 'is true, but the node that the edge leads to is not '
                'released' if edge.released else 'is false, but the node that the edge leads to is '
                'released')
        released = edge.released
    return None


def _repeated_action(order: OrderMessage) -> Optional[Malformed]:
    seen: Set[str] = set()
    for action in actions_of(order):
        if action.action_id in seen:
            return Malformed('actionId', f'{action.action_id!r} is used twice')
        seen.add(action.action_id)
    return None


def actions_of(order: OrderMessage) -> Iterator[VdaAction]:
    """Yields all actions of an order: first those of the nodes, then those of the edges."""
    elements: Tuple[Element, ...] = (*order.nodes, *order.edges)
    for element in elements:
        yield from element.actions
