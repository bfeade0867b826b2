"""A skeleton stays connected while chains are removed from it."""
from __future__ import annotations

import numpy as np
import pytest
from floor_plans import Plan

from graph_editor.making.chains import ChainGraph


@pytest.fixture
def ring_on_a_way() -> ChainGraph:
    """Returns node 1 between nodes 2 and 3. A very short ring begins and ends at node 1."""
    graph = ChainGraph(Plan(10.0, 10.0, (), (1.0, 1.0)).site().floor)
    for node, place in ((1, (5.0, 5.0)), (2, (2.0, 5.0)), (3, (8.0, 5.0))):
        graph.add_node(node, np.array(place))
    for node in (2, 3):
        graph.add_chain(1, node, np.array((graph.position(1), graph.position(node))))
    graph.add_chain(1, 1, np.array(((5.0, 5.0), (5.0, 5.05), (5.0, 5.0))))
    return graph


def test_a_ring_that_is_cut_away_leaves_one_way(ring_on_a_way):
    ring, = (chain for chain in ring_on_a_way.chains if chain.is_ring)
    made = ring_on_a_way.cut_out(ring, 1, 1)
    assert [{chain.start, chain.end} for chain in made] == [{2, 3}]
    assert ring_on_a_way.chains == made
    assert ring_on_a_way.nodes == [2, 3]
