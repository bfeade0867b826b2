"""The changes of the graph that a study proposes and simulates."""
from __future__ import annotations

import math
from dataclasses import replace

import pytest

from fleet_core.fleet import Fleet, Robot, RobotType
from fleet_simulation.proposals import Proposal, proposals
from fleet_simulation.site import with_docks
from trajectory_graph import Graph, load_graph, save_graph

ROOM = 1.0  # m
DOCK = 21


@pytest.fixture
def charging_yard(yard: Graph) -> Graph:
    """The yard with a dock at the end of a spur."""
    return Graph([replace(vertex, dock=vertex.id == DOCK) for vertex in yard.vertices.values()],
                 list(yard.edges.values()))


def dock_proposals(graph: Graph, docks_in_use: int) -> list:
    return [one for one in proposals(graph, [1], ROOM, docks_in_use) if one.docks]


def test_another_dock_is_proposed_where_all_docks_were_in_use(charging_yard: Graph) -> None:
    assert not dock_proposals(charging_yard, 0)
    proposal, = dock_proposals(charging_yard, 1)
    added, = proposal.docks
    vertex = proposal.graph.vertices[added]
    assert vertex.dock
    assert str(added) in proposal.what, 'the text must name the dock for the fleet file'
    others = [one.position for one in charging_yard.vertices.values()]
    assert min(math.dist(vertex.position, other) for other in others) >= ROOM


def test_robots_that_charge_use_a_dock_that_is_added() -> None:
    charging = RobotType('ld90', 0.43, 1.35, docks=frozenset((DOCK,)))
    other = RobotType('agv', 0.35, 1.0)
    fleet = with_docks(Fleet((charging, other), (Robot('one', charging, 1, 'ld90'),
                                                 Robot('two', other, 2, 'agv'))), frozenset((99,)))
    assert [kind.docks for kind in fleet.types] == [frozenset((DOCK, 99)), None]
    assert [robot.type.docks for robot in fleet.robots] == [frozenset((DOCK, 99)), None]


def test_every_proposal_is_a_graph_that_can_be_saved_and_read_again(charging_yard: Graph,
                                                                    tmp_path) -> None:
    made = proposals(charging_yard, list(charging_yard.edges), ROOM, 1)
    kinds = {one.name.split('_')[0] for one in made}
    assert kinds == {'cut', 'one', 'passing', 'no', 'dock'}
    for one in made:
        assert is_kept(one, tmp_path), one.what


def is_kept(proposal: Proposal, folder) -> bool:
    save_graph(proposal.graph, folder / 'changed.yaml')
    return load_graph(folder / 'changed.yaml').is_same(proposal.graph)
