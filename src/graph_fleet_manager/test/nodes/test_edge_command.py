"""The command `edge` repeats its message until graph_server has carried it out."""
from __future__ import annotations

from typing import List

import genpy
import pytest

from graph_fleet_manager.commands import edge, fleet_client
from graph_fleet_manager.commands.command_line import CommandProblem
from itrci_nav_msgs.msg import ClosedEdges, EdgeCommand
from trajectory_graph import CurveType, Edge, Graph, Vertex


class LossyGraphServer:
    """Loses the first messages, as if graph_server were not connected to the topic yet.

    It replaces the sender of the commands and the source of the closed edges.
    """

    def __init__(self, lost: int) -> None:
        self._lost = lost
        self.commands: List[EdgeCommand] = []
        self._told: List[ClosedEdges] = []

    def send(self, message: EdgeCommand) -> None:
        message.header.stamp = genpy.Time(1000)
        self.repeat(message)

    def repeat(self, message: EdgeCommand) -> None:
        self.commands.append(message)
        if len(self.commands) > self._lost:
            self._told.append(ClosedEdges(edges=message.edges))

    def wait(self, seconds: float) -> None:
        """Does not wait, because every message comes at once."""

    def unread(self) -> List[ClosedEdges]:
        told, self._told = self._told, []
        return told


@pytest.fixture(autouse=True)
def short_times(monkeypatch):
    monkeypatch.setattr(fleet_client, 'PATIENCE', 0.3)
    monkeypatch.setattr(fleet_client, 'REPEAT', 0.01)


@pytest.mark.parametrize('lost', [0, 1, 3])
def test_a_command_that_was_lost_is_sent_again_unchanged(monkeypatch, lost):
    server = LossyGraphServer(lost)
    monkeypatch.setattr(fleet_client, 'connected_sender', lambda kind: server)
    told = edge._carried_out(EdgeCommand(command=EdgeCommand.CLOSE, edges=[23]), server)
    assert told.edges == [23] and len(server.commands) == lost + 1
    assert {command.header.stamp for command in server.commands} == {genpy.Time(1000)}


def test_without_an_answer_the_command_tells_where_the_reason_is(monkeypatch):
    server = LossyGraphServer(10 ** 6)
    monkeypatch.setattr(fleet_client, 'connected_sender', lambda kind: server)
    with pytest.raises(CommandProblem, match='graph_server did not carry out .* its log'):
        edge._carried_out(EdgeCommand(command=EdgeCommand.CLOSE, edges=[23]), server)


AREAS = {'bay': (2, 3), 'press hall': (4,)}


def test_edges_are_named_by_id_and_by_area():
    assert edge.ids_of(['7', 'press hall', 'bay'], AREAS) == [7, 4, 2, 3]


@pytest.mark.parametrize('areas, told', [(AREAS, 'there are: bay, press hall'),
                                         ({}, 'does not run or has none')])
def test_a_word_that_names_nothing_is_refused_with_the_names_that_there_are(areas, told):
    with pytest.raises(CommandProblem, match=f"'hall' is neither an id nor an area; .*{told}"):
        edge.ids_of(['7', 'hall'], areas)


def test_the_areas_are_listed_below_the_closed_edges_with_their_state():
    graph = Graph([Vertex(1, 0.0, 0.0, 0.0), Vertex(2, 3.0, 0.0, 0.0), Vertex(3, 6.0, 0.0, 0.0)],
                  [Edge(k, k, k + 1, CurveType.LINE, 0.0, 0.0, 1.0, 1.0) for k in (1, 2)])
    areas = {'bay': (1, 2), 'gate': (1,), 'yard': (2,)}
    shown = edge._area_values(graph, areas, [1])
    lines = edge._listed(edge._closed(graph, [1]), shown).splitlines()
    assert lines[-3:] == ['bay   1 2    1 of 2 closed', 'gate  1      closed', 'yard  2      open']
    assert lines[2] == '' and lines[1].split() == ['1', '1', '2', '3.0', 'm']
