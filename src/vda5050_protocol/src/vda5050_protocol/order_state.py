"""The progress of an order: its remaining nodes and edges, its base and its horizon."""
from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Set, Tuple

from vda5050_protocol.acceptance import Place
from vda5050_protocol.values import Element, OrderEdge, OrderMessage, OrderNode


@dataclass(frozen=True)
class OrderState:
    """The part of an order that remains; it begins with the last passed node.

    nodes[0] is the last node that was passed; nodes[1:] and edges are still to be driven.
    passed -- how many nodes were passed before nodes[0] since the last `Driver.begin`; so edges[i]
              is the driver's leg number passed + i
    """

    order_id: str = ''
    order_update_id: int = 0
    nodes: Tuple[OrderNode, ...] = ()
    edges: Tuple[OrderEdge, ...] = ()
    passed: int = 0
    cancelled: bool = False

    @staticmethod
    def begin(order: OrderMessage) -> OrderState:
        """Returns the state of a new order; the vehicle is at its first node."""
        return OrderState(order.order_id, order.order_update_id, order.nodes, order.edges)

    def extended(self, order: OrderMessage) -> OrderState:
        """Returns the state in which the nodes and edges of an update replace the horizon.

        The update begins with the last node of the base; this node stays as the base defines it.
        """
        end = self.base_end
        return replace(self, order_update_id=order.order_update_id,
                       nodes=self.nodes[:end + 1] + order.nodes[1:],
                       edges=self.edges[:end] + order.edges)

    def with_passed(self, count: int) -> OrderState:
        """Returns the state after `count` more nodes, all released, were passed."""
        if not 0 <= count <= self.base_end:
            raise ValueError(f'{count} nodes cannot have been passed: the base has {self.base_end}')
        return replace(self, nodes=self.nodes[count:], edges=self.edges[count:],
                       passed=self.passed + count)

    def with_stood(self) -> OrderState:
        """Returns the state after one more node was passed at the place of the last node.

        The driver begins anew at this node, so `passed` is 0.
        """
        return replace(self.with_passed(1), passed=0)

    def emptied(self) -> OrderState:
        """Returns the state after a cancellation: the ids and the last node remain."""
        return replace(self, nodes=self.nodes[:1], edges=(), cancelled=True)

    @cached_property
    def base_end(self) -> int:
        """The index of the last released node, the decision point."""
        return sum(node.released for node in self.nodes) - 1 if self.nodes else 0

    @property
    def has_horizon(self) -> bool:
        """Whether nodes remain that are not released."""
        return self.base_end < len(self.nodes) - 1

    @property
    def is_driven(self) -> bool:
        """Whether no nodes remain."""
        return len(self.nodes) <= 1

    @property
    def last_node(self) -> Place:
        """The last node passed."""
        return _place(self.nodes[0]) if self.nodes else ('', 0)

    @property
    def decision_point(self) -> Place:
        """The node at which an update must begin."""
        return _place(self.nodes[self.base_end]) if self.nodes else ('', 0)

    @property
    def horizon_sequence_ids(self) -> Set[int]:
        """The sequenceIds of the nodes and edges that an update replaces."""
        elements: Tuple[Element, ...] = (*self.nodes, *self.edges)
        return {element.sequence_id for element in elements if not element.released}


def _place(node: OrderNode) -> Place:
    return node.node_id, node.sequence_id
